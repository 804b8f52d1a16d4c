/*
 * What rates of shading, tables and models err: whole frames of a scene against its materials in double precision.
 *
 *   report_rates SCENE.blob SOURCE... / OTHER.blob [TABLE.ktx2...] [/ ...]
 *
 * The truth is the scene (its finest levels of detail, tests/reference) with material i reflecting as SOURCE i, which gtlut build takes. Compared with it is each OTHER, the same scene with other materials, its tables in slots 0, 1, ..., all surfaces at each
 * rate and, of half-vector tables, with all taps and fewer. A line for each: `N rate R taps A hash H ns T de_mean D psnr P largest E`: N from 0 on, A as enum raster_taps, H of the picture as tests/board/budget/main.c prints it;
 * errors of 8-bit colours over the pixels that show a surface away from its object's edge; T: of shading on this machine, per pixel-light
 * that is lit, the fastest of some frames.
 */
#define _GNU_SOURCE
#include "common.h"
#include "host_metrics.h"
#include "internal.h"
#include "quality.h"
#include "ref_render.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { WIDTH = 320, HEIGHT = 240, PIXELS = WIDTH * HEIGHT, OBJECTS = 64, REPEATS = 5 };

struct picture_scene {
    struct scene scene;
    struct scene_header *blob;
    size_t bytes;
    struct lut_table tables[RASTER_MAX_SLOTS];
    const struct lut_table *slots[RASTER_MAX_SLOTS];
};

static struct ref_picture truth;

static void scene_read(struct picture_scene *s, const char *path)
{
    memset(s, 0, sizeof *s);
    s->blob = read_file(path, SCENE_MAX_BYTES, &s->bytes);
    const enum scene_status status = scene_open(&s->scene, s->blob, s->bytes);
    if (status != SCENE_OK)
        die(EXIT_BAD_INPUT, "%s: %s; build it with gtscene", path, scene_status_text(status));
}

static struct raster_frame frame_of(const struct picture_scene *s)
{
    return (struct raster_frame){.parts = &raster_all_parts,
                                 .scene = &s->scene,
                                 .camera = &s->scene.header->camera,
                                 .output = &s->scene.header->output,
                                 .lights = s->scene.lights,
                                 .materials = s->scene.materials,
                                 .tables = s->slots,
                                 .width = WIDTH,
                                 .height = HEIGHT,
                                 .light_count = (uint8_t)s->scene.header->lights.count,
                                 .format = RASTER_RGB888};
}

/* --- the truth --- */

struct snapper {
    const struct scene *scene;
    struct raster_object objects[OBJECTS];
};

static void snapped(int32_t xy[2], void *context, unsigned object, unsigned vertex)
{
    const struct snapper *s = context;
    struct raster_clip_vertex c;
    struct raster_vertex p;
    raster_transform(&c, &s->objects[object], &s->scene->vertices[vertex]);
    raster_project(&p, &s->objects[object], &c, WIDTH * 256 + 1, HEIGHT * 256 + 1);
    xy[0] = p.x;
    xy[1] = p.y;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normalise(double v[3])
{
    const double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++)
        v[i] /= length;
}

/* Two tangents of n. */
static void tangents(double t[2][3], const double n[3])
{
    const double a[3] = {fabs(n[0]) < 0.5, fabs(n[0]) >= 0.5, 0};
    for (int i = 0; i < 3; i++)
        t[0][i] = a[i] - dot(a, n) * n[i];
    normalise(t[0]);
    for (int i = 0; i < 3; i++)
        t[1][i] = n[(i + 1) % 3] * t[0][(i + 2) % 3] - n[(i + 2) % 3] * t[0][(i + 1) % 3];
}

static void to_frame(double out[3], double t[2][3], const double n[3], const double v[3])
{
    out[0] = dot(t[0], v);
    out[1] = dot(t[1], v);
    out[2] = fmax(dot(n, v), 1.0 / 128); /* as the renderer, which turns such normals back */
    normalise(out);
}

/* A pixel's radiance under the scene's directional lights. */
static void shade(double radiance[3], const struct ref_scene *s, const struct brdf_source *f, const double n[3],
                  const double v[3])
{
    double t[2][3], view[3];
    tangents(t, n);
    to_frame(view, t, n, v);
    memset(radiance, 0, 3 * sizeof *radiance);
    for (unsigned i = 0; i < s->light_count; i++) {
        double to_light[3], l[3], rgb[3];
        for (int k = 0; k < 3; k++)
            to_light[k] = dot(s->camera.rotation[k], s->lights[i].direction);
        if (dot(n, to_light) <= 0)
            continue;
        to_frame(l, t, n, to_light);
        f->value(rgb, f->ctx, l, view);
        for (int k = 0; k < 3; k++)
            radiance[k] += s->exposure * s->lights[i].irradiance[k] * rgb[k] * dot(n, to_light);
    }
}

static void truth_render(struct picture_scene *s, const struct brdf_source *sources)
{
    struct snapper snap = {.scene = &s->scene};
    s->blob->lod_error = 0; /* the finest levels */
    struct ref_scene *reference = ref_scene_open(s->blob, s->bytes);
    const struct raster_frame f = frame_of(s);
    if (!reference || reference->object_count > OBJECTS)
        die(EXIT_BAD_INPUT, "the scene is not one for the reference renderer");
    for (uint32_t i = 0; i < reference->object_count; i++)
        raster_object_setup(&snap.objects[i], &f, &s->scene.objects[i]);
    ref_render(&truth, &(struct ref_view){.scene = reference,
                                          .width = WIDTH,
                                          .height = HEIGHT,
                                          .model = REF_MODEL_LAFORTUNE_PHONG,
                                          .snapped = snapped,
                                          .context = &snap});
    for (int at = 0; at < PIXELS; at++) {
        const double scale = HEIGHT * reference->camera.focal;
        double v[3] = {-(2 * (at % WIDTH) + 1 - WIDTH) / scale, (2 * (at / WIDTH) + 1 - HEIGHT) / scale, 1},
               radiance[3];
        if (truth.object[at] < 0)
            continue;
        normalise(v);
        shade(radiance, reference, &sources[reference->objects[truth.object[at]].material], truth.normal[at], v);
        ref_tone(truth.display[at], radiance, reference->aces);
    }
    ref_scene_close(reference);
}

/* --- what is compared with it --- */

/* A frame, all surfaces at a rate. Returns nanoseconds of shading; *lit: pixel-lights. */
static double render(uint8_t *rgb, uint32_t *lit, const struct raster *r, enum raster_rate rate, enum raster_taps taps)
{
    static struct raster_tile work;
    struct raster_quality q = {.lights = RASTER_ALL_LIGHTS, .taps = (uint8_t)taps};
    struct timespec a, b;
    double ns = 0;
    memset(q.rate, (int)rate, sizeof q.rate);
    *lit = 0;
    for (uint32_t t = 0; t < raster_tile_count(r); t++) {
        struct raster_rect rect;
        struct raster_stats stats;
        raster_tile_begin(r, t, &work, &rect, &stats);
        for (bool more = true; more;) {
            more = raster_tile_draw(r, &work, UINT32_MAX, &stats) == RASTER_NO_SLOT;
            const struct raster_survey *survey = raster_tile_survey(r, &work, &rect);
            clock_gettime(CLOCK_THREAD_CPUTIME_ID, &a);
            for (uint32_t region = 0; region < survey->regions; region++)
                raster_tile_shade(r, &work, &rect, region, &q, &stats);
            if (more)
                raster_tile_free_slots(r, &work, &rect, &stats);
            else
                raster_tile_finish(r, &work, &rect, &stats);
            clock_gettime(CLOCK_THREAD_CPUTIME_ID, &b);
            ns += 1e9 * (double)(b.tv_sec - a.tv_sec) + (double)(b.tv_nsec - a.tv_nsec);
        }
        *lit += stats.shaded;
        for (unsigned y = 0; y < rect.height; y++)
            memcpy(rgb + 3 * ((rect.y + y) * WIDTH + rect.x), raster_tile_pixels(&work) + 3 * y * rect.width,
                   3 * rect.width);
    }
    return ns;
}

static double linear(double x)
{
    x /= 255;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

static bool is_inner(int at)
{
    for (int y = -1; y <= 1; y++)
        for (int x = -1; x <= 1; x++) {
            const int column = at % WIDTH + x, row = at / WIDTH + y;
            if (column >= 0 && column < WIDTH && row >= 0 && row < HEIGHT &&
                truth.object[row * WIDTH + column] != truth.object[at])
                return false;
        }
    return truth.object[at] >= 0;
}

static void print_errors(const uint8_t *rgb)
{
    double de = 0, squares = 0, largest = 0, count = 0;
    for (int at = 0; at < PIXELS; at++) {
        double a[3], b[3];
        if (!is_inner(at))
            continue;
        for (int i = 0; i < 3; i++) {
            const double error = rgb[3 * at + i] - floor(truth.display[at][i] + 0.5);
            squares += error * error;
            largest = fmax(largest, fabs(error));
            a[i] = linear(rgb[3 * at + i]);
            b[i] = linear(floor(truth.display[at][i] + 0.5));
        }
        de += metrics_difference(a, b);
        count++;
    }
    printf(" de_mean %.4f psnr %.2f largest %.0f\n", de / count, 10 * log10(255 * 255 * 3 * count / squares), largest);
}

static void compare(int number, const struct picture_scene *s)
{
    static uint8_t rgb[3 * PIXELS];
    static struct raster r;
    const struct raster_frame f = frame_of(s);
    const size_t bytes = raster_arena_bytes(&f);
    void *arena = xmalloc(bytes);
    const enum raster_status status = raster_begin(&r, &f, arena, bytes);
    if (status != RASTER_OK)
        die(EXIT_BAD_INPUT, "scene %d: %s", number, raster_status_text(status));
    const bool table = s->slots[0] && s->slots[0]->kind == LUT_HALF_VECTOR;
    double lit_at_full = 0;
    for (int rung = 0; rung < (table ? RASTER_TAPS_COUNT : 1) * RASTER_RATE_COUNT; rung++) {
        const enum raster_rate rate = (enum raster_rate)(rung % RASTER_RATE_COUNT);
        const enum raster_taps taps = (enum raster_taps)(rung / RASTER_RATE_COUNT);
        double ns = INFINITY;
        uint32_t lit, hash = 2166136261u; /* FNV-1a */
        for (int i = 0; i < REPEATS; i++)
            ns = fmin(ns, render(rgb, &lit, &r, rate, taps));
        for (int i = 0; i < 3 * PIXELS; i++)
            hash = (hash ^ rgb[i]) * 16777619u;
        lit_at_full = rung ? lit_at_full : lit;
        printf("%d rate %d taps %d hash %08x ns %.2f", number, (int)rate, (int)taps, hash, ns / lit_at_full);
        print_errors(rgb);
    }
    free(arena);
}

int main(int argc, char **argv)
{
    static struct picture_scene s;
    struct brdf_source sources[SCENE_MAX_MATERIALS];
    int at = 2;
    common_set_name("report_rates", NULL);
    if (argc < 5)
        die(EXIT_USAGE, "usage: report_rates SCENE.blob SOURCE... / OTHER.blob [TABLE.ktx2...] [/ ...]");
    scene_read(&s, argv[1]);
    for (; at < argc && strcmp(argv[at], "/"); at++)
        source_open(&sources[at - 2], argv[at]);
    if ((uint32_t)at - 2 != s.scene.header->materials.count)
        die(EXIT_USAGE, "%d sources for %u materials", at - 2, s.scene.header->materials.count);
    truth_render(&s, sources);
    for (int number = 0; at + 1 < argc; number++) {
        scene_read(&s, argv[at + 1]);
        for (at += 2; at < argc && strcmp(argv[at], "/"); at++) {
            size_t bytes;
            const void *file = read_file(argv[at], 64u << 20, &bytes);
            int slot = 0;
            while (s.slots[slot])
                slot++;
            const enum lut_status status = lut_open(&s.tables[slot], file, bytes);
            if (status != LUT_OK)
                die(EXIT_BAD_INPUT, "%s: %s; build it with gtlut", argv[at], lut_status_text(status));
            s.slots[slot] = &s.tables[slot];
        }
        compare(number, &s);
    }
    return EXIT_OK;
}
