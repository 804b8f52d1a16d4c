/*
 * The six models: the product's frame against the double-precision reference, from the same snapped vertices.
 *
 * Environment: GONIOTILE_SIX_MODELS (scene blob), GONIOTILE_DEMO (folder of its tables), B (build folder). The two pictures
 * and ten times their difference (128 = none) are left in $B/golden as PPM, to be looked at.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common.h"
#include "internal.h"
#include "ref_render.h"

static const char *const materials[] = {"matte_white",        "plastic_red",  "gold",
                                        "plastic_blue_rough", "copper_satin", "satin_green"};
enum { MATERIALS = sizeof materials / sizeof *materials };

static struct scene scene;
static struct ref_scene *reference;
static struct lut_table tables[MATERIALS];
static const struct lut_table *slots[RASTER_MAX_SLOTS];
static const struct ref_table *ref_slots[RASTER_MAX_SLOTS];
static struct scene_material lafortune[SCENE_MAX_MATERIALS], blinn[SCENE_MAX_MATERIALS];

static int load(void **state)
{
    (void)state;
    const char *path = getenv("GONIOTILE_SIX_MODELS"), *folder = getenv("GONIOTILE_DEMO");
    if (!path || !folder) {
        print_message("# GONIOTILE_SIX_MODELS and GONIOTILE_DEMO are not set; run through tests/run.sh\n");
        return -1;
    }
    size_t bytes;
    struct scene_header *blob = read_file(path, SCENE_MAX_BYTES, &bytes);
    blob->lod_error = 0; /* the reference draws the finest levels */
    reference = ref_scene_open(blob, bytes);
    if (scene_open(&scene, blob, bytes) != SCENE_OK || !reference)
        return -1;
    for (int i = 0; i < MATERIALS; i++) {
        char *name = xasprintf("%s/%s.ktx2", folder, materials[i]);
        void *file = read_file(name, 64u << 20, &bytes);
        free(name);
        ref_slots[i] = ref_table_open(file, bytes);
        if (lut_open(&tables[i], file, bytes) != LUT_OK || !ref_slots[i])
            return -1;
        slots[i] = &tables[i];
    }
    memcpy(lafortune, scene.materials, scene.header->materials.count * sizeof *lafortune);
    for (uint32_t i = 0; i < scene.header->materials.count; i++)
        lafortune[i].kind = SCENE_MATERIAL_LAFORTUNE_PHONG;
    memcpy(blinn, lafortune, sizeof blinn);
    for (uint32_t i = 0; i < scene.header->materials.count; i++)
        blinn[i].kind = SCENE_MATERIAL_BLINN_PHONG;
    return 0;
}

static struct raster_frame make_frame(int width, int height, enum ref_model model, const struct scene_output *output,
                                      enum raster_format format)
{
    return (struct raster_frame){.parts = &raster_all_parts,
                                 .scene = &scene,
                                 .camera = &scene.header->camera,
                                 .output = output,
                                 .lights = scene.lights,
                                 .materials = model == REF_MODEL_LAFORTUNE_PHONG ? lafortune
                                              : model == REF_MODEL_BLINN_PHONG   ? blinn
                                                                                 : scene.materials,
                                 .tables = slots,
                                 .width = (uint16_t)width,
                                 .height = (uint16_t)height,
                                 .light_count = (uint8_t)scene.header->lights.count,
                                 .format = (uint8_t)format};
}

/* The product's picture (free it), and how many pixels it says are covered. */
static uint8_t *product_render(const struct raster_frame *f, uint32_t *covered)
{
    static struct raster_tile work;
    struct raster r;
    size_t pixel = f->format == RASTER_RGB565 ? 2 : 3, bytes = raster_arena_bytes(f);
    void *arena = xmalloc(bytes);
    uint8_t *picture = xmalloc(pixel * f->width * f->height);
    assert_int_equal(raster_begin(&r, f, arena, bytes), RASTER_OK);
    *covered = 0;
    for (uint32_t t = 0; t < raster_tile_count(&r); t++) {
        struct raster_rect rect;
        struct raster_stats stats;
        raster_render_tile(&r, t, &work, &rect, &stats);
        *covered += stats.covered;
        for (unsigned y = 0; y < rect.height; y++)
            memcpy(picture + pixel * ((size_t)(rect.y + y) * f->width + rect.x),
                   raster_tile_pixels(&work) + pixel * y * rect.width, pixel * rect.width);
    }
    free(arena);
    return picture;
}

struct snapper {
    struct raster_frame frame;
    struct raster_object objects[64];
};

/* The product's own transform and projection, relative to the picture's corner. */
static void snapped(int32_t xy[2], void *context, unsigned object, unsigned vertex)
{
    const struct snapper *s = context;
    struct raster_clip_vertex c;
    struct raster_vertex p;
    raster_transform(&c, &s->objects[object], &scene.vertices[vertex]);
    assert_int_equal(raster_clip_code(&s->objects[object], &c), 0); /* the reference does not clip */
    raster_project(&p, &s->objects[object], &c, s->frame.width * 256 + 1, s->frame.height * 256 + 1);
    xy[0] = p.x;
    xy[1] = p.y;
}

static struct ref_picture reference_render(const struct raster_frame *f, enum ref_model model, enum ref_normals normals)
{
    struct snapper s = {.frame = *f};
    struct ref_picture p;
    assert_true(scene.header->objects.count <= sizeof s.objects / sizeof *s.objects);
    for (uint32_t i = 0; i < scene.header->objects.count; i++)
        raster_object_setup(&s.objects[i], f, &scene.objects[i]);
    reference->aces = f->output->tone_curve == SCENE_TONE_ACES;
    memcpy(reference->background, f->output->background, 3);
    ref_render(&p, &(struct ref_view){reference, ref_slots, f->width, f->height, model, normals, snapped, &s});
    return p;
}

/* The 3 x 3 pixels around show one object. */
static bool is_inner(const struct ref_picture *p, int width, int height, int at)
{
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) {
            int x = at % width + dx, y = at / width + dy;
            if (x >= 0 && y >= 0 && x < width && y < height && p->object[y * width + x] != p->object[at])
                return false;
        }
    return p->object[at] >= 0;
}

struct difference {
    double squares, worst;
    long count, within_one;
};

static void difference_add(struct difference *d, const uint8_t *a, const uint8_t *b)
{
    for (int i = 0; i < 3; i++) {
        double e = fabs((double)a[i] - b[i]);
        d->squares += e * e;
        d->worst = fmax(d->worst, e);
        d->count++;
        d->within_one += e <= 1;
    }
}

static double psnr(const struct difference *d)
{
    return 10 * log10(255.0 * 255.0 * (double)d->count / fmax(d->squares, 1e-9));
}

/* Product pixels moved right by `shift` against the reference, inner pixels of all objects or of one. */
static struct difference compare(const uint8_t *product, const struct ref_picture *p, int width, int height, int object,
                                 int shift)
{
    struct difference d = {0, 0, 0, 0};
    for (int at = 0; at < width * height; at++)
        if (is_inner(p, width, height, at) && at >= shift && (object < 0 || p->object[at] == object))
            difference_add(&d, product + 3 * (at - shift), p->rgb + 3 * at);
    return d;
}

static void write_ppm(const char *name, const char *what, const uint8_t *rgb, int width, int height)
{
    const char *build = getenv("B");
    char *folder = xasprintf("%s/golden", build ? build : "build");
    char *path = xasprintf("%s/%s_%s.ppm", folder, name, what), *header = xasprintf("P6\n%d %d\n255\n", width, height);
    size_t head = strlen(header), pixels = 3u * (unsigned)width * (unsigned)height;
    char *file = xmalloc(head + pixels);
    memcpy(file, header, head);
    memcpy(file + head, rgb, pixels);
    mkdir(folder, 0777);
    write_file(path, file, head + pixels);
    free(folder);
    free(path);
    free(header);
    free(file);
}

static void write_pictures(const char *name, const uint8_t *product, const uint8_t *ref, int width, int height)
{
    uint8_t *difference = xmalloc(3u * (unsigned)width * (unsigned)height);
    for (int i = 0; i < 3 * width * height; i++)
        difference[i] = (uint8_t)fx_clamp(128 + 10 * (product[i] - ref[i]), 0, 255);
    write_ppm(name, "product", product, width, height);
    write_ppm(name, "reference", ref, width, height);
    write_ppm(name, "difference", difference, width, height);
    free(difference);
}

/* Renders both ways and checks the PSNR over inner pixels: 50 dB against the reference, 60 against the same with the
 * product's own interpolant for normals, which leaves the product's arithmetic alone. */
static void check_frame(const char *name, int width, int height, enum ref_model model, enum scene_tone_curve tone)
{
    struct scene_output output = scene.header->output;
    output.tone_curve = (uint8_t)tone;
    struct raster_frame f = make_frame(width, height, model, &output, RASTER_RGB888);
    uint32_t covered;
    uint8_t *product = product_render(&f, &covered);
    static const double least[] = {[REF_NORMALS_LINEAR] = 50, [REF_NORMALS_STEREOGRAPHIC] = 60};
    for (enum ref_normals normals = REF_NORMALS_LINEAR; normals <= REF_NORMALS_STEREOGRAPHIC; normals++) {
        struct ref_picture p = reference_render(&f, model, normals);
        if (normals == REF_NORMALS_LINEAR)
            write_pictures(name, product, p.rgb, width, height);
        struct difference d = compare(product, &p, width, height, -1, 0);
        print_message("# %s%s: %ld inner pixels, PSNR %.2f dB, largest difference %.0f, %.3f %% within one step; "
                      "per object",
                      name, normals == REF_NORMALS_LINEAR ? "" : ", same interpolant", d.count / 3, psnr(&d), d.worst,
                      100.0 * (double)d.within_one / (double)d.count);
        for (unsigned i = 0; i < reference->object_count; i++) {
            struct difference one = compare(product, &p, width, height, (int)i, 0);
            print_message(" %.1f", psnr(&one));
        }
        print_message(" dB\n");
        assert_true(d.count / 3 > width * height / 4);
        assert_true(psnr(&d) >= least[normals]);
        ref_picture_free(&p);
    }
    free(product);
}

static void measured_frame_equals_the_reference(void **state)
{
    (void)state;
    check_frame("measured", 320, 240, REF_MODEL_AS_SCENE, scene.header->output.tone_curve);
    check_frame("measured_none", 320, 240, REF_MODEL_AS_SCENE, SCENE_TONE_NONE);
    check_frame("measured_aces", 320, 240, REF_MODEL_AS_SCENE, SCENE_TONE_ACES);
    check_frame("measured_odd", 97, 61, REF_MODEL_AS_SCENE, SCENE_TONE_ACES);
}

static void lafortune_frame_equals_the_reference(void **state)
{
    (void)state;
    check_frame("lafortune", 320, 240, REF_MODEL_LAFORTUNE_PHONG, scene.header->output.tone_curve);
    check_frame("lafortune_none", 320, 240, REF_MODEL_LAFORTUNE_PHONG, SCENE_TONE_NONE);
    check_frame("lafortune_aces", 320, 240, REF_MODEL_LAFORTUNE_PHONG, SCENE_TONE_ACES);
    check_frame("lafortune_odd", 97, 61, REF_MODEL_LAFORTUNE_PHONG, SCENE_TONE_ACES);
}

/* As the scene's exponents are, and with the one that the benchmark has. */
static void blinn_phong_frame_equals_the_reference(void **state)
{
    (void)state;
    check_frame("blinn_phong", 320, 240, REF_MODEL_BLINN_PHONG, scene.header->output.tone_curve);
    check_frame("blinn_phong_none", 320, 240, REF_MODEL_BLINN_PHONG, SCENE_TONE_NONE);
    check_frame("blinn_phong_odd", 97, 61, REF_MODEL_BLINN_PHONG, SCENE_TONE_ACES);
    for (uint32_t i = 0; i < scene.header->materials.count; i++) {
        blinn[i].exponent = 32 << 16;
        reference->materials[i].exponent = 32;
    }
    check_frame("blinn_phong_32", 320, 240, REF_MODEL_BLINN_PHONG, SCENE_TONE_NONE);
    check_frame("blinn_phong_32_odd", 97, 61, REF_MODEL_BLINN_PHONG, SCENE_TONE_ACES);
    for (uint32_t i = 0; i < scene.header->materials.count; i++) {
        blinn[i].exponent = scene.materials[i].exponent;
        reference->materials[i].exponent = scene.materials[i].exponent / 65536.0;
    }
}

/* What changes with the background is background. */
static void check_coverage(int width, int height)
{
    struct scene_output output = scene.header->output;
    struct raster_frame f = make_frame(width, height, REF_MODEL_LAFORTUNE_PHONG, &output, RASTER_RGB888);
    uint32_t covered, again, expected = 0;
    memset(output.background, 0, 3);
    uint8_t *a = product_render(&f, &covered);
    memset(output.background, 255, 3);
    uint8_t *b = product_render(&f, &again);
    struct ref_picture p = reference_render(&f, REF_MODEL_LAFORTUNE_PHONG, REF_NORMALS_LINEAR);
    for (int at = 0; at < width * height; at++) {
        bool surface = !memcmp(a + 3 * at, b + 3 * at, 3);
        expected += p.object[at] >= 0;
        if (surface != (p.object[at] >= 0))
            fail_msg("pixel (%d, %d) is %scovered", at % width, at / width, surface ? "" : "not ");
    }
    print_message("# %d x %d: %u pixels covered\n", width, height, expected);
    assert_int_equal(covered, expected);
    assert_int_equal(again, expected);
    assert_true(expected > (uint32_t)(width * height / 50));
    free(a);
    free(b);
    ref_picture_free(&p);
}

static void coverage_is_exact_pixel_by_pixel(void **state)
{
    (void)state;
    check_coverage(320, 240);
    check_coverage(97, 61);
    check_coverage(1000, 701);
    check_coverage(640, 33);
}

static void rgb565_is_rgb888_rounded(void **state)
{
    (void)state;
    struct raster_frame f = make_frame(97, 61, REF_MODEL_AS_SCENE, &scene.header->output, RASTER_RGB888);
    uint32_t covered;
    uint8_t *rgb = product_render(&f, &covered);
    f.format = RASTER_RGB565;
    uint16_t *packed = (uint16_t *)product_render(&f, &covered);
    for (int at = 0; at < 97 * 61; at++) {
        const uint8_t *c = rgb + 3 * at;
        int r = (int)floor(c[0] * 31 / 255.0 + 0.5), g = (int)floor(c[1] * 63 / 255.0 + 0.5);
        int b = (int)floor(c[2] * 31 / 255.0 + 0.5);
        assert_int_equal(packed[at], r << 11 | g << 5 | b);
    }
    free(rgb);
    free(packed);
}

/* The comparison above must be able to fail: lights 2 % brighter, or the picture one pixel off. */
static void comparison_sees_small_errors(void **state)
{
    (void)state;
    struct raster_frame f = make_frame(320, 240, REF_MODEL_AS_SCENE, &scene.header->output, RASTER_RGB888);
    uint32_t covered;
    uint8_t *product = product_render(&f, &covered);
    struct ref_picture p = reference_render(&f, REF_MODEL_AS_SCENE, REF_NORMALS_LINEAR);
    struct difference shifted = compare(product, &p, 320, 240, -1, 1);
    ref_picture_free(&p);
    reference->exposure *= 1.02;
    p = reference_render(&f, REF_MODEL_AS_SCENE, REF_NORMALS_LINEAR);
    struct difference brighter = compare(product, &p, 320, 240, -1, 0);
    reference->exposure /= 1.02;
    ref_picture_free(&p);
    free(product);
    print_message("# lights 2 %% brighter: PSNR %.2f dB; one pixel off: %.2f dB\n", psnr(&brighter), psnr(&shifted));
    assert_true(psnr(&brighter) < 50);
    assert_true(psnr(&shifted) < 50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(measured_frame_equals_the_reference),
        cmocka_unit_test(lafortune_frame_equals_the_reference),
        cmocka_unit_test(blinn_phong_frame_equals_the_reference),
        cmocka_unit_test(coverage_is_exact_pixel_by_pixel),
        cmocka_unit_test(rgb565_is_rgb888_rounded),
        cmocka_unit_test(comparison_sees_small_errors),
    };
    common_set_name("test_frame", NULL);
    return cmocka_run_group_tests(tests, load, NULL);
}
