/*
 * Point lights, metallic-roughness and two other models: the product's frame of scenes/points.json against the double-precision
 * reference, from the same snapped vertices and with the same interpolant for normals, so that only arithmetic differs.
 *
 * Environment: GONIOTILE_DEMO (folder of points.blob and the tables).
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "internal.h"
#include "ref_render.h"

enum { WIDTH = 320, HEIGHT = 240, PIXELS = WIDTH * HEIGHT, MAX_OBJECTS = 16 };

static struct scene scene;
static struct ref_scene *reference;
static struct lut_table tables[2];
static const struct lut_table *slots[RASTER_MAX_SLOTS];
static const struct ref_table *ref_slots[RASTER_MAX_SLOTS];
static struct raster_object objects[MAX_OBJECTS];

static void *load_file(const char *name, size_t *bytes)
{
    const char *folder = getenv("GONIOTILE_DEMO");
    char *path = xasprintf("%s/%s", folder ? folder : ".", name);
    void *file = read_file(path, 64u << 20, bytes);
    free(path);
    return file;
}

static int load(void **state)
{
    (void)state;
    static const char *const names[2] = {"plastic_red.ktx2", "copper_satin.ktx2"};
    static const int slot[2] = {1, 4};
    size_t bytes;
    struct scene_header *blob = load_file("points.blob", &bytes);
    blob->lod_error = 0; /* the reference draws the finest levels */
    reference = ref_scene_open(blob, bytes);
    if (!reference || scene_open(&scene, blob, bytes) != SCENE_OK || scene.header->objects.count > MAX_OBJECTS)
        return -1;
    for (int i = 0; i < 2; i++) {
        void *file = load_file(names[i], &bytes);
        ref_slots[slot[i]] = ref_table_open(file, bytes);
        if (lut_open(&tables[i], file, bytes) != LUT_OK || !ref_slots[slot[i]])
            return -1;
        slots[slot[i]] = &tables[i];
    }
    return 0;
}

static struct raster_frame make_frame(uint8_t light_count)
{
    return (struct raster_frame){.parts = &raster_all_parts,
                                 .scene = &scene,
                                 .camera = &scene.header->camera,
                                 .output = &scene.header->output,
                                 .lights = scene.lights,
                                 .materials = scene.materials,
                                 .tables = slots,
                                 .width = WIDTH,
                                 .height = HEIGHT,
                                 .light_count = light_count,
                                 .format = RASTER_RGB888};
}

static void product_render(uint8_t *picture, const struct raster_frame *f)
{
    static struct raster_tile work;
    struct raster r;
    size_t bytes = raster_arena_bytes(f);
    void *arena = xmalloc(bytes);
    assert_int_equal(raster_begin(&r, f, arena, bytes), RASTER_OK);
    for (uint32_t t = 0; t < raster_tile_count(&r); t++) {
        struct raster_rect rect;
        struct raster_stats stats;
        raster_render_tile(&r, t, &work, &rect, &stats);
        for (unsigned y = 0; y < rect.height; y++)
            memcpy(picture + 3 * ((size_t)(rect.y + y) * WIDTH + rect.x),
                   raster_tile_pixels(&work) + 3u * y * rect.width, 3u * rect.width);
    }
    free(arena);
}

static void snapped(int32_t xy[2], void *context, unsigned object, unsigned vertex)
{
    struct raster_clip_vertex c;
    struct raster_vertex p;
    (void)context;
    raster_transform(&c, &objects[object], &scene.vertices[vertex]);
    assert_int_equal(raster_clip_code(&objects[object], &c), 0); /* the reference does not clip */
    raster_project(&p, &objects[object], &c, WIDTH * 256 + 1, HEIGHT * 256 + 1);
    xy[0] = p.x;
    xy[1] = p.y;
}

static struct ref_picture reference_render(const struct raster_frame *f)
{
    struct ref_picture p;
    for (uint32_t i = 0; i < scene.header->objects.count; i++)
        raster_object_setup(&objects[i], f, &scene.objects[i]);
    ref_render(&p, &(struct ref_view){reference, ref_slots, WIDTH, HEIGHT, REF_MODEL_AS_SCENE,
                                      REF_NORMALS_STEREOGRAPHIC, snapped, NULL});
    return p;
}

/* All four neighbours show the same object: coverage and edges have tests of their own. */
static bool is_inner(const struct ref_picture *p, int at)
{
    int x = at % WIDTH, y = at / WIDTH;
    return p->object[at] >= 0 && x > 0 && y > 0 && x < WIDTH - 1 && y < HEIGHT - 1 &&
           p->object[at - 1] == p->object[at] && p->object[at + 1] == p->object[at] &&
           p->object[at - WIDTH] == p->object[at] && p->object[at + WIDTH] == p->object[at];
}

/* PSNR over inner pixels of one object, or of all for -1; in *within_one the share of channels that differ by at most a step. */
static double compare(double *within_one, const uint8_t *product, const struct ref_picture *p, int object)
{
    double squares = 1e-9;
    long count = 0, close = 0;
    for (int at = 0; at < PIXELS; at++)
        for (int k = 0; k < 3 && is_inner(p, at) && (object < 0 || p->object[at] == object); k++) {
            int e = product[3 * at + k] - p->rgb[3 * at + k];
            squares += e * e;
            close += e >= -1 && e <= 1;
            count++;
        }
    assert_true(count > 1000);
    *within_one = (double)close / (double)count;
    return 10 * log10(255.0 * 255.0 * (double)count / squares);
}

static void frame_with_point_lights_equals_the_reference(void **state)
{
    (void)state;
    static uint8_t product[3 * PIXELS];
    double within_one;
    struct raster_frame f = make_frame((uint8_t)scene.header->lights.count);
    product_render(product, &f);
    struct ref_picture p = reference_render(&f);
    for (int i = -1; i < (int)reference->object_count; i++) {
        double psnr = compare(&within_one, product, &p, i);
        print_message("# object %d (-1: all): PSNR %.2f dB, %.3f %% within one step\n", i, psnr, 100 * within_one);
        assert_true(psnr >= (i < 0 ? 60 : 55));
        assert_true(within_one >= (i < 0 ? 0.999 : 0.998));
    }
    ref_picture_free(&p);
}

/* The comparison must be able to fail: without the last light, which is one of seven. */
static void comparison_sees_a_missing_light(void **state)
{
    (void)state;
    static uint8_t product[3 * PIXELS];
    double within_one;
    struct raster_frame f = make_frame((uint8_t)(scene.header->lights.count - 1));
    product_render(product, &f);
    struct ref_picture p = reference_render(&f); /* with all of the scene's */
    assert_true(compare(&within_one, product, &p, -1) < 50);
    ref_picture_free(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frame_with_point_lights_equals_the_reference),
        cmocka_unit_test(comparison_sees_a_missing_light),
    };
    common_set_name("test_points", NULL);
    return cmocka_run_group_tests(tests, load, NULL);
}
