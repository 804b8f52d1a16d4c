/*
 * Damaged scene blobs and absurd cameras: refused by validation, or a complete picture without reading outside of the blob, of the arena
 * or of the tile (ASan) and without undefined arithmetic (UBSan), in bounded time. GONIOTILE_LONG=1 tries every byte with every bit.
 */
#include "scene_fixture.h"

#include <unistd.h>

enum { WIDTH = 48, HEIGHT = 40, TIME_LIMIT = 20 };

static long refused, rendered, pixels_shown;

static bool is_long(void)
{
    return getenv("GONIOTILE_LONG") != NULL;
}

static uint32_t random32(void)
{
    return (uint32_t)(random_unit() * 65536) << 16 | (uint32_t)(random_unit() * 65536);
}

/* Tables of equal texels, one of each kind, so that measured materials can be shaded. */
static const struct lut_table *const *tables_make(void)
{
    static const uint32_t texels[8] = {0x80402010, 0x80402010, 0x80402010, 0x80402010,
                                       0x80402010, 0x80402010, 0x80402010, 0x80402010};
    static const struct lut_table frame = {
        .kind = LUT_SPECULAR_FRAME, .texels = texels, .width = 2, .height = 2, .depth = 1};
    static uint16_t warp_h[LUT_WARP_H_NODES], warp_d[LUT_WARP_D_NODES];
    static const uint8_t cells[1] = {16};
    static const struct lut_table half = {.kind = LUT_HALF_VECTOR,
                                          .texels = texels,
                                          .width = 2,
                                          .height = 2,
                                          .depth = 2,
                                          .warp_h = warp_h,
                                          .warp_d = warp_d,
                                          .cells = cells};
    static const struct lut_table *tables[RASTER_MAX_SLOTS];
    for (uint32_t i = 0; i < LUT_WARP_H_NODES; i++)
        warp_h[i] = (uint16_t)(i << LUT_WARP_BITS >> 7);
    for (uint32_t i = 0; i < LUT_WARP_D_NODES; i++)
        warp_d[i] = (uint16_t)(i << LUT_WARP_BITS >> 6);
    tables[0] = &frame;
    tables[5] = &half;
    return tables;
}

/* Renders into memory of exactly the size that is asked for. A hang ends the program. */
static void frame_try(struct raster_frame *f)
{
    alarm(TIME_LIMIT);
    struct raster r;
    size_t bytes = raster_arena_bytes(f);
    void *arena = malloc(bytes);
    struct raster_tile *work = malloc(sizeof *work);
    enum raster_status status = raster_begin(&r, f, arena, bytes);
    if (status == RASTER_OK) {
        uint32_t pixels = 0;
        for (uint32_t t = 0; t < raster_tile_count(&r); t++) {
            struct raster_rect rect;
            struct raster_stats stats;
            raster_render_tile(&r, t, work, &rect, &stats);
            pixels += (uint32_t)rect.width * rect.height;
            pixels_shown += stats.covered;
        }
        assert_int_equal(pixels, (uint32_t)f->width * f->height);
        rendered++;
    } else {
        assert_true(status == RASTER_ERR_TABLE || status == RASTER_ERR_LIMIT);
        refused++;
    }
    free(work);
    free(arena);
    alarm(0);
}

/* Opens a copy that ends where the blob ends. */
static void blob_try(const uint8_t *blob, size_t bytes)
{
    struct scene s;
    void *copy = malloc(bytes ? bytes : 1);
    memcpy(copy, blob, bytes);
    alarm(TIME_LIMIT);
    if (scene_open(&s, copy, bytes) != SCENE_OK) {
        refused++;
    } else {
        struct raster_frame f = {.parts = &raster_all_parts,
                                 .scene = &s,
                                 .camera = &s.header->camera,
                                 .output = &s.header->output,
                                 .lights = s.lights,
                                 .materials = s.materials,
                                 .tables = tables_make(),
                                 .width = WIDTH,
                                 .height = HEIGHT,
                                 .samples = rendered % 4 ? 1 : 4,
                                 .light_count = (uint8_t)s.header->lights.count,
                                 .format = rendered & 1 ? RASTER_RGB888 : RASTER_RGB565};
        frame_try(&f);
    }
    free(copy);
}

/* Something of each array, each material and both triangle paths: near the eye, around it and far away. */
static uint8_t *small_scene(size_t *bytes)
{
    struct ref_blob b = new_scene();
    random_state = 11;
    unsigned cube = add_cube(&b, 1000, 1, false), room = add_cube(&b, 1000, 1, true),
             wall = add_wall(&b, -900, -900, 900, 900);
    unsigned measured = ref_blob_material(&b, 0, 5, 0.5, "measured"),
             blinn = ref_blob_material(&b, SCENE_MATERIAL_BLINN_PHONG, 0, 0.5, "blinn");
    ref_blob_object(&b, cube, measured, (const double[3]){0.3, 0.2, -3}, 1 / 1500.0);
    ref_blob_object(&b, room, 0, origin, 1 / 100.0);
    ref_blob_object(&b, wall, blinn, (const double[3]){-0.5, 0, -2}, 1 / 1100.0);
    turn_camera(&b);
    uint8_t *blob = ref_blob_finish(&b, bytes);
    ref_blob_free(&b);
    return blob;
}

static void begin(void)
{
    refused = rendered = pixels_shown = 0;
}

static void end(const char *what)
{
    print_message("# %s: %ld refused, %ld rendered, %ld pixels of surfaces\n", what, refused, rendered, pixels_shown);
}

static void every_truncation_is_refused(void **state)
{
    (void)state;
    size_t bytes;
    uint8_t *blob = small_scene(&bytes);
    begin();
    blob_try(blob, bytes);
    assert_int_equal(rendered, 1);
    assert_true(pixels_shown > 0);
    for (size_t n = 0; n < bytes; n++)
        blob_try(blob, n);
    assert_int_equal(rendered, 1);
    assert_int_equal(refused, bytes);
    end("truncations");
    free(blob);
}

static void every_header_field_may_hold_anything(void **state)
{
    (void)state;
    size_t bytes;
    uint8_t *blob = small_scene(&bytes);
    begin();
    for (size_t at = 0; at < sizeof(struct scene_header); at += 4) {
        uint32_t old, values[48];
        int n = 0;
        memcpy(&old, blob + at, 4);
        for (int bit = 0; bit < 32; bit++)
            values[n++] = old ^ 1u << bit;
        for (int k = 1; k <= 4; k += 3) {
            values[n++] = old + k;
            values[n++] = old - k;
        }
        const uint32_t extremes[] = {0, 1, INT32_MAX, 1u << 31, UINT32_MAX, (uint32_t)bytes, 1u << 8, 1u << 24};
        for (unsigned i = 0; i < sizeof extremes / sizeof *extremes; i++)
            values[n++] = extremes[i];
        for (int i = 0; i < n; i++) {
            memcpy(blob + at, &values[i], 4);
            blob_try(blob, bytes);
        }
        memcpy(blob + at, &old, 4);
    }
    end("header fields");
    assert_true(refused > 500 && rendered > 500);
    free(blob);
}

static void every_byte_may_be_damaged(void **state)
{
    (void)state;
    static const uint8_t flips[] = {0x01, 0x80, 0xff, 0x10, 0x02, 0x04, 0x08, 0x20, 0x40, 0x7f, 0x55, 0xfe};
    const unsigned each = is_long() ? sizeof flips : 3;
    size_t bytes;
    uint8_t *blob = small_scene(&bytes);
    begin();
    for (size_t at = 0; at < bytes; at++)
        for (unsigned i = 0; i < each; i++) {
            blob[at] ^= flips[i];
            blob_try(blob, bytes);
            blob[at] ^= flips[i];
        }
    end("damaged bytes");
    assert_true(refused > 100 && rendered > 100);
    free(blob);
}

static void several_bytes_may_be_damaged(void **state)
{
    (void)state;
    size_t bytes;
    uint8_t *blob = small_scene(&bytes), *copy = malloc(bytes);
    begin();
    for (int n = 0; n < (is_long() ? 200000 : 4000); n++) {
        memcpy(copy, blob, bytes);
        for (uint32_t k = 2 + random32() % 8; k; k--)
            if (n % 2) /* low bits, mostly of vertices: seldom refused */
                copy[bytes / 2 + random32() % (bytes / 2)] ^= (uint8_t)(1 << random32() % 3);
            else
                copy[random32() % bytes] = (uint8_t)random32();
        blob_try(copy, bytes);
    }
    end("several damaged bytes");
    assert_true(refused > 100 && rendered > 100);
    free(copy);
    free(blob);
}

static int32_t extreme_position(void)
{
    static const int32_t at[] = {0, 1, -1, 65536, -65536, INT32_MAX, INT32_MIN, 1 << 30, 600, -(1 << 20)};
    uint32_t i = random32() % 14;
    return i < 10 ? at[i] : (int32_t)random32() >> (random32() % 31);
}

/* Random, often extreme; a rotation out of a random blob. */
static struct scene_camera random_camera(const struct scene_camera *valid)
{
    static const uint32_t focal[] = {0, 1, 255, 256, 65536, 1 << 24, (1 << 24) + 1, UINT32_MAX};
    static const uint32_t near[] = {0, 1, 2, 65536, 1u << 31, UINT32_MAX, 655, 1 << 20};
    struct scene_camera c = *valid;
    for (int i = 0; i < 3; i++)
        c.eye[i] = extreme_position();
    uint32_t k = random32();
    c.focal = k & 8 ? focal[k % 8] : 256 + random32() % ((1 << 24) - 256);
    c.near = k & 16 ? near[k / 32 % 8] : 1 + (random32() >> (k / 1024 % 32));
    if (k % 64 == 0)
        memset(c.rotation, (int)(k >> 8 & 255), sizeof c.rotation);
    return c;
}

static void absurd_cameras_give_a_picture_or_an_error(void **state)
{
    (void)state;
    static const uint16_t sizes[][2] = {{64, 48}, {1, 1}, {33, 31}, {4096, 1}, {1, 4096}, {65, 33}};
    begin();
    random_state = 12;
    for (int n = 0; n < (is_long() ? 100000 : 3000); n++) {
        struct ref_blob b = new_scene();
        struct opened o;
        unsigned mesh =
            n % 3 ? add_cube(&b, n % 2 ? 32767 : 500, 2, n % 4 < 2) : add_wall(&b, -32768, -32768, 32767, 32767);
        for (int i = 0; i < 3; i++)
            ref_blob_object(&b, mesh, 0,
                            (const double[3]){extreme_position() / 65536.0, extreme_position() / 65536.0,
                                              extreme_position() / 65536.0},
                            exp2(random_between(-39.9, 0.99)));
        turn_camera(&b);
        const uint16_t *size = sizes[random32() % 6];
        open_scene(&o, &b, size[0], size[1]);
        struct scene_camera camera = random_camera(o.frame.camera);
        if (scene_check_camera(&camera) == SCENE_OK) {
            o.frame.camera = &camera;
            o.frame.format = (uint8_t)(n & 1);
            o.frame.samples = n % 5 ? 1 : size[0] <= 2048 && size[1] <= 2048 ? 4 : 1;
            frame_try(&o.frame);
        } else {
            refused++;
        }
        free(o.blob);
        ref_blob_free(&b);
    }
    end("cameras");
    assert_true(refused > 100 && rendered > 100 && pixels_shown > 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_truncation_is_refused),
        cmocka_unit_test(every_header_field_may_hold_anything),
        cmocka_unit_test(every_byte_may_be_damaged),
        cmocka_unit_test(several_bytes_may_be_damaged),
        cmocka_unit_test(absurd_cameras_give_a_picture_or_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
