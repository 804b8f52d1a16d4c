/*
 * Measures shading alone, on the sphere of tests/board/shade/sphere.h, without tone curve and packing.
 *
 *   bench_shade count INPUT           lit pixel-lights and covered pixels; the functions picture_lit and picture_dark run
 *                                     once each: their difference under callgrind is the lights
 *   bench_shade time INPUT REPEATS    processor time in nanoseconds by which lights make sphere_shade dearer, per lit and per covered
 *                                     pixel-light: the difference of the medians with and without lights
 *   bench_shade error INPUT           against double precision from the same table or material and normals, in steps of 8-bit sRGB before
 *                                     rounding, over all covered pixels and channels; and the hash of all radiances
 * INPUT: as tests/board/shade.sh makes it.
 */
#define _GNU_SOURCE
#include "common.h"
#include "ref_table.h"
#include "sphere.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { PIXELS = SPHERE_WIDTH * SPHERE_HEIGHT, MAX_REPEATS = 1000 };

static struct sphere sphere;
static struct raster_tile filled[SPHERE_TILES];
static struct raster_rect place[SPHERE_TILES];
static uint32_t radiances[PIXELS][3];
static uint32_t radiance_count; /* kept: index + 1 is what the pixel gets, 24 bits */
static bool keeping;

void sphere_radiance(uint32_t *out, uq12_20_t radiance[][3], uint32_t count)
{
    for (uint32_t i = 0; keeping && i < count; i++) {
        if (radiance_count == PIXELS)
            die(EXIT_INTERNAL, "more pixels are shaded than the picture has");
        memcpy(radiances[radiance_count++], radiance[i], sizeof *radiances);
        out[i] = radiance_count;
    }
}

static double nanoseconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static double shade(uint32_t tile)
{
    struct raster_stats stats = {0};
    memcpy(sphere.tile.surface, filled[tile].surface, sizeof sphere.tile.surface);
    sphere.rect = place[tile];
    const double start = nanoseconds();
    sphere_shade(&sphere, &stats);
    return nanoseconds() - start;
}

/* Out of line: callgrind finds them by name. */
__attribute__((noinline)) static double picture_lit(void)
{
    double ns = 0;
    for (uint32_t i = 0; i < SPHERE_TILES; i++)
        ns += shade(i);
    return ns;
}

__attribute__((noinline)) static double picture_dark(void)
{
    double ns = 0;
    for (uint32_t i = SPHERE_TILES; i-- > 0;) /* unlike the other, or they would be one */
        ns += shade(i);
    return ns;
}

static int compare_double(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *x, size_t n)
{
    qsort(x, n, sizeof *x, compare_double);
    return x[n / 2];
}

static void begin(bool lights)
{
    const char *wrong = sphere_begin(&sphere, lights);
    if (wrong)
        die(EXIT_INTERNAL, "sphere: %s", wrong);
}

static void bench_count(uint32_t covered, uint32_t lit)
{
    picture_lit();
    begin(false);
    picture_dark();
    printf("lit %u covered %u\n", lit, covered);
}

static void bench_time(uint32_t covered, uint32_t lit, size_t repeats)
{
    static double with[MAX_REPEATS], without[MAX_REPEATS];
    const uint32_t lights = sphere.raster.frame.light_count;
    for (size_t i = 0; i < repeats; i++) { /* in turn, so that both meet the machine alike */
        begin(true);
        with[i] = picture_lit();
        begin(false);
        without[i] = picture_dark();
    }
    const double ns = median(with, repeats) - median(without, repeats);
    printf("ns_per_pixel_light %.3f ns_per_covered_pixel_light %.3f\n", ns / lit, ns / (covered * lights));
}

/* --- error --- */

static double to_srgb(double x)
{
    x = fmin(fmax(x, 0), 1);
    return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055);
}

struct reference {
    struct ref_table *table; /* NULL: the material is none */
    struct ref_material material;
    double ambient;
};

static void reference_open(struct reference *o, const uint8_t *input, size_t bytes)
{
    const struct scene_material *m = &sphere.scene.materials[0];
    const uint32_t table_bytes = *(const uint32_t *)(const void *)input;
    static const enum ref_model_kind kinds[SCENE_MATERIAL_KIND_COUNT] = {REF_LAMBERT, REF_LAFORTUNE_PHONG,
                                                                         REF_BLINN_PHONG, REF_METALLIC_ROUGHNESS};
    *o = (struct reference){.material.kind = kinds[m->kind]};
    if (table_bytes && !(o->table = ref_table_open(input + bytes - table_bytes, table_bytes)))
        die(EXIT_BAD_INPUT, "the reference does not read the table");
    for (int k = 0; k < 3; k++) {
        o->material.kd[k] = m->kd[k] / 65536.0;
        o->material.ks[k] = m->ks[k] / 65536.0;
    }
    o->material.exponent = m->exponent / 65536.0;
    o->material.metalness = m->metalness / 65536.0;
    o->material.roughness = m->roughness / 65536.0;
    o->ambient = m->kind == SCENE_MATERIAL_BLINN_PHONG ? 0.02 : m->kind == SCENE_MATERIAL_METALLIC_ROUGHNESS ? 0.05 : 0;
}

/* Radiance of the pixel at (x, y). */
static void reference_pixel(double out[3], const struct reference *r, const double n[3], uint32_t x, uint32_t y)
{
    const struct scene_header *h = sphere.scene.header;
    const double pixel = 2.0 / SPHERE_HEIGHT / (h->camera.focal / 65536.0);
    double v[3] = {-(x + 0.5 - SPHERE_WIDTH / 2.0) * pixel, (y + 0.5 - SPHERE_HEIGHT / 2.0) * pixel, 1};
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++) {
        v[k] /= length;
        out[k] = r->ambient * r->material.kd[k];
    }
    for (uint32_t i = 0; i < h->lights.count; i++) { /* eye space is the world's, moved: the camera looks along -z */
        const struct scene_light *light = &sphere.scene.lights[i];
        double l[3], f[3], nl = 0;
        for (int k = 0; k < 3; k++) {
            l[k] = ldexp(light->direction[k], -30);
            nl += l[k] * n[k];
        }
        if (nl <= 0)
            continue;
        if (r->table)
            ref_table_eval(f, r->table, n, l, v);
        else
            ref_model_value(f, &r->material, n, l, v);
        for (int k = 0; k < 3; k++)
            out[k] += f[k] * nl * light->irradiance[k] / 65536.0;
    }
}

/* Errors of a tile's pixels; returns how many. */
static size_t tile_errors(double *out, const struct reference *r, uint32_t tile)
{
    double *const start = out;
    shade(tile);
    for (uint32_t y = 0; y < place[tile].height; y++)
        for (uint32_t x = 0; x < place[tile].width; x++) {
            const uint32_t at = y * RASTER_TILE_WIDTH + x;
            if (!filled[tile].surface[at].depth_slot)
                continue;
            const uint8_t *p = raster_tile_pixels(&sphere.tile) + 3 * (y * place[tile].width + x);
            const uint32_t number = p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16;
            if (number < 1 || number > radiance_count)
                die(EXIT_INTERNAL, "a covered pixel was not shaded");
            const struct vec3 q = sphere_normal(&filled[tile], at);
            const double length = sqrt((double)q.x * q.x + (double)q.y * q.y + (double)q.z * q.z);
            const double n[3] = {q.x / length, q.y / length, q.z / length};
            double want[3];
            reference_pixel(want, r, n, place[tile].x + x, place[tile].y + y);
            for (int k = 0; k < 3; k++)
                *out++ = fabs(to_srgb(ldexp(radiances[number - 1][k], -20)) - to_srgb(want[k]));
        }
    return (size_t)(out - start);
}

static void bench_error(const uint8_t *input, size_t bytes)
{
    struct reference r;
    size_t n = 0, within = 0;
    double *errors = xmalloc(sizeof *errors * 3 * PIXELS);
    reference_open(&r, input, bytes);
    keeping = true;
    for (uint32_t i = 0; i < SPHERE_TILES; i++)
        n += tile_errors(errors + n, &r, i);
    qsort(errors, n, sizeof *errors, compare_double);
    while (within < n && errors[within] <= 1)
        within++;
    uint32_t hash = 2166136261u;
    for (size_t i = 0; i < radiance_count * sizeof *radiances; i++)
        hash = (hash ^ ((const uint8_t *)radiances)[i]) * 16777619u;
    printf("hash %08x steps_p99 %.4f steps_p999 %.4f steps_max %.4f within_1_step %.6f\n", hash, errors[n * 99 / 100],
           errors[n * 999 / 1000], errors[n - 1], (double)within / (double)n);
    ref_table_free(r.table);
    free(errors);
}

int main(int argc, char **argv)
{
    common_set_name("bench_shade", NULL);
    const bool time = argc == 4 && !strcmp(argv[1], "time");
    if (!time && (argc != 3 || (strcmp(argv[1], "count") && strcmp(argv[1], "error"))))
        die(EXIT_USAGE, "usage: bench_shade count INPUT | time INPUT REPEATS | error INPUT");
    size_t bytes;
    uint8_t *input = read_file(argv[2], 64u << 20, &bytes);
    const char *wrong = sphere_open(&sphere, input);
    if (wrong)
        die(EXIT_BAD_INPUT, "%s: %s", argv[2], wrong);
    uint32_t covered = 0, lit = 0;
    for (uint32_t i = 0; i < SPHERE_TILES; i++) {
        sphere_fill(&sphere, i);
        sphere_count(&sphere, &covered, &lit);
        filled[i] = sphere.tile;
        place[i] = sphere.rect;
    }
    if (time)
        bench_time(covered, lit, (size_t)parse_long("REPEATS", argv[3], 1, MAX_REPEATS));
    else if (!strcmp(argv[1], "count"))
        bench_count(covered, lit);
    else
        bench_error(input, bytes);
    free(input);
    return EXIT_OK;
}
