/*
 * What shades eight pixels at once against the portable loops, bit by bit. Lives here because programs with sanitizers
 * are built for any processor.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "display.h"
#include "half_vector.h"

enum { ROUNDS = 40000 };

/* Null where the library was not built for AVX2, which this file is not either; a weak name does not bring what it stands for out of a
 * library, but these do. */
void (*const users[])(void) = {(void (*)(void))raster_shade_tile, (void (*)(void))raster_finish_pixels};
extern raster_half_vector raster_half_vector_wide __attribute__((weak));
extern __typeof__(raster_gather_wide) raster_gather_wide __attribute__((weak));
extern __typeof__(raster_srgb_wide) raster_srgb_wide __attribute__((weak));

static uint64_t seed = 1;

static uint32_t random32(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    uint32_t x = (uint32_t)(seed >> 33);
    return x * 2654435761u ^ x >> 15;
}

static int32_t between(int32_t low, int32_t high)
{
    return low + (int32_t)(random32() % (uint32_t)(high - low + 1));
}

/* As often small as large. */
static uint32_t any_size(unsigned bits)
{
    return random32() >> (32 - bits) >> random32() % bits;
}

static struct {
    uint32_t texels[1 << 16];
    uint8_t cells[1 << 16];
    uint16_t warp_h[LUT_WARP_H_NODES + 1];
    uint32_t slabs[(1 << 16) * 7];
    struct lut_table table;
} k;

/* Exponents in cells are what the format asks for; slabs hold words of any 15-bit mantissas. */
static void make_table(void)
{
    struct lut_table *t = &k.table;
    do {
        t->width = (uint32_t)between(2, LUT_MAX_T);
        t->height = (uint32_t)between(2, LUT_MAX_H);
        t->depth = (uint32_t)between(2, LUT_MAX_D);
    } while (t->width * t->height * t->depth > 1 << 16);
    t->kind = LUT_HALF_VECTOR;
    t->scale = between(-16, 16);
    t->texels = k.texels;
    t->cells = k.cells;
    t->warp_h = k.warp_h;
    const uint32_t least = random32() % 24, span = 1 + random32() % 8;
    for (uint32_t i = 0; i < t->width * t->height * t->depth; i++)
        k.texels[i] = random32() >> 5 | (least + random32() % span) << 27;
    const uint32_t cells_h = t->height - 1, count = cells_h * (t->depth - 1);
    for (uint32_t d = 0; d + 1 < t->depth; d++)
        for (uint32_t h = 0; h < cells_h; h++) {
            uint32_t largest = 0;
            for (uint32_t i = 0; i < 4 * t->width; i++) {
                uint32_t x = k.texels[((d + (i & 1)) * t->height + h + (i >> 1 & 1)) * t->width + i / 4] >> 27;
                largest = x > largest ? x : largest;
            }
            k.cells[d * cells_h + h] = (uint8_t)largest;
        }
    for (uint32_t i = 0, u = 0; i < LUT_WARP_H_NODES; i++) {
        k.warp_h[i] = (uint16_t)u;
        u += random32() % (2 * 512 * (t->height - 1) / (LUT_WARP_H_NODES - 1) + 1);
        u = u < 512 * (t->height - 1) ? u : 512 * (t->height - 1) - 1; /* only the last node reaches the last row */
    }
    k.warp_h[LUT_WARP_H_NODES - 1] = (uint16_t)(512 * (t->height - 1));
    t->slabs = NULL;
    const uint32_t rows = 200, words = rows * 3 * t->width;
    if (random32() % 2 && count + words < sizeof k.slabs / 4) {
        t->slabs = k.slabs;
        for (uint32_t i = 0; i < count; i++)
            k.slabs[i] = (count + random32() % (rows - 1) * 3 * t->width) * 4 << 8 | (least + random32() % span);
        for (uint32_t i = 0; i < words; i++)
            k.slabs[count + i] = random32() & 0x7fff7fff;
    }
}

/* Within the bounds that block.h states for n.l, n.a and n.b, but for any directions. */
static void random_vector(int32_t v[3])
{
    const int32_t longest = 18918; /* 32767 / sqrt(3) */
    for (int i = 0; i < 3; i++)
        v[i] = between(-longest, longest);
    if (random32() % 4 == 0) {
        const int axis = (int)(random32() % 3);
        for (int i = 0; i < 3; i++)
            v[i] = i == axis ? (random32() % 2 ? 32767 : -32767) : between(-2, 2);
    }
}

static uint32_t word(int32_t low, int32_t high)
{
    return ((uint32_t)low & 0xffff) | (uint32_t)high << 16;
}

static void make_light(struct raster_block_light *light)
{
    int32_t a[3], b[3], l[3];
    memset(light, 0, sizeof *light);
    random_vector(a);
    random_vector(l);
    b[0] = a[1], b[1] = -a[0], b[2] = between(-300, 300); /* orthogonal, as s2 is at most 2 */
    light->plane[PLANE_A_XY].base = word(a[0], a[1]);
    light->plane[PLANE_B_XY].base = word(b[0], b[1]);
    light->plane[PLANE_AB_Z].base = word(a[2], b[2]);
    for (int i = 0; i < PLANE_TERM; i++) {
        light->plane[i].dx = random32() % 2 ? word(between(-40, 40), between(-40, 40)) : 0;
        light->plane[i].dy = random32() % 2 ? word(between(-40, 40), between(-40, 40)) : 0;
    }
    const uint32_t most = (k.table.depth - 1) << TERM_D_BITS;
    light->plane[PLANE_TERM].base = random32() % 4 ? random32() % (most - 480) : most - 481;
    light->plane[PLANE_TERM].dx = random32() % 16;
    light->plane[PLANE_TERM].dy = random32() % 16;
    light->l_xy = word(l[0], l[1]);
    light->l_z = l[2];
    for (int i = 0; i < 3; i++)
        light->colour[i] = any_size(32);
}

static void make_batch(struct raster_batch *b)
{
    memset(b, 0, sizeof *b);
    b->count = (uint32_t)between(1, RASTER_BATCH);
    for (uint32_t i = 0; i < b->count; i++) {
        int32_t n[3];
        random_vector(n);
        b->pixel[i] =
            (struct raster_batch_pixel){word(n[0], n[1]), n[2], between(1 << 22, 1 << 30), i % 16 | i / 16 << 8};
        if (random32() % 4 == 0)
            b->pixel[i].nv = 1 << 22 | (int32_t)any_size(24);
        for (int c = 0; c < 3; c++)
            b->radiance[i][c] = any_size(27);
    }
}

static raster_half_vector *narrow(uint32_t taps)
{
    if (taps == RASTER_TAPS_8)
        return k.table.slabs ? raster_half_vector_packed : raster_half_vector_plain;
    return k.table.slabs ? raster_half_vector_fewer_packed : raster_half_vector_fewer_plain;
}

static void half_vectors_of_eight_pixels_give_the_same_bits(void **state)
{
    (void)state;
    if (!raster_half_vector_wide) {
        print_message("# the library was not built for AVX2\n");
        skip();
    }
    static struct raster_batch b, want;
    struct raster_block_light light;
    uint32_t lit = 0, packed = 0, of_taps[RASTER_TAPS_COUNT] = {0};
    for (unsigned i = 0; i < ROUNDS; i++) {
        if (i % 50 == 0)
            make_table();
        make_light(&light);
        make_batch(&b);
        b.taps = random32() % RASTER_TAPS_COUNT;
        want = b;
        const uint32_t first = i % 8 ? 0 : random32() % b.count;
        const uint32_t count = narrow(b.taps)(&want, first, b.count, &k.table, &light);
        assert_int_equal(raster_half_vector_wide(&b, first, b.count, &k.table, &light), count);
        assert_memory_equal(&b, &want, sizeof b);
        lit += count;
        packed += k.table.slabs != NULL;
        of_taps[b.taps]++;
    }
    for (int i = 0; i < RASTER_TAPS_COUNT; i++)
        assert_in_range(of_taps[i], ROUNDS / 4, ROUNDS / 2);
    assert_in_range(lit, ROUNDS * 8, ROUNDS * 32);
    assert_in_range(packed, ROUNDS / 10, ROUNDS * 9 / 10);
}

/* A batch of fewer than eight pixels takes the portable loop. */
static void specular_frames_of_eight_pixels_give_the_same_bits(void **state)
{
    (void)state;
    if (!raster_half_vector_wide)
        skip();
    static struct raster_batch b, want;
    static struct raster r;
    static const struct lut_table *tables[1] = {&k.table};
    static const struct scene_material material = {.kind = SCENE_MATERIAL_MEASURED};
    struct raster_block_light light;
    struct lut_table *t = &k.table;
    r.frame.tables = tables;
    r.frame.materials = &material;
    uint32_t lit = 0;
    for (unsigned i = 0; i < ROUNDS; i++) {
        if (i % 50 == 0) {
            make_table(); /* for its texels */
            t->kind = LUT_SPECULAR_FRAME;
            t->swap = random32() % 2;
            t->width = (uint32_t)between(2, 180);
            t->height = (uint32_t)between(2, 90);
            t->depth = (uint32_t)between(1, 4);
            t->slice_scale = t->depth > 1 ? (t->depth - 1) * (1u << 16) * (uint32_t)between(2, 9) : 0;
        }
        make_light(&light);
        light.plane[PLANE_TERM] = (struct raster_plane){(uint32_t)between(0, 1 << 27), 0, 0};
        make_batch(&b);
        b.count = b.count < 8 ? 8 : b.count;
        want = b;
        uint32_t count = 0;
        for (uint32_t j = 0; j < b.count; j++)
            count += raster_specular_frame_model.shade(&want, j, j + 1, &r, &light);
        assert_int_equal(raster_specular_frame_model.shade(&b, 0, b.count, &r, &light), count);
        assert_memory_equal(&b, &want, sizeof b);
        lit += count;
    }
    assert_in_range(lit, ROUNDS * 8, ROUNDS * 32);
}

static void normals_of_eight_surfaces_give_the_same_bits(void **state)
{
    (void)state;
    if (!raster_gather_wide)
        skip();
    for (unsigned i = 0; i < 200000; i++) {
        struct raster_surface s[8];
        struct raster_batch_pixel p[8];
        int32_t axis[3], view[3];
        struct raster_plane plane[3];
        const unsigned shift = random32() % 11;
        struct raster_slot slot = {.normal_shift = (uint8_t)shift};
        const uint32_t at = random32() % 9 | random32() % 16 << 8;
        for (int j = 0; j < 8; j++) {
            int32_t d = (int32_t)(any_size(14) << shift) + DEPTH_BIAS + between(0, 1 << shift >> 1);
            s[j].depth_slot = (uint32_t)(d < 1 << 24 ? d : (1 << 24) - 1) << 8 | (random32() & 255);
            s[j].normal = word((int32_t)any_size(14) * between(-1, 1), (int32_t)any_size(14) * between(-1, 1));
        }
        for (int j = 0; j < 9; j++) {
            if (j % 3 == 0)
                random_vector(axis);
            slot.frame[j] = (int16_t)(axis[j % 3] / 2);
        }
        random_vector(view);
        for (int j = 0; j < 3; j++) {
            view[j] = (view[j] - view[j] / 64) * (1 << VIEW_PLANE_BITS);
            plane[j].dx = (uint32_t)between(-30000, 30000);
        }
        const uint32_t away = raster_gather_wide(p, s, &slot, view, plane, at);
        for (uint32_t j = 0; j < 8; j++) {
            int32_t nv = 0;
            struct vec3 n = raster_eye_normal(slot.frame, shift, &s[j]);
            const int32_t c[3] = {n.x, n.y, n.z};
            for (int m = 0; m < 3; m++)
                nv += c[m] * ((view[m] + (int32_t)(j * plane[m].dx)) >> VIEW_PLANE_BITS);
            assert_int_equal(p[j].normal_xy, word(fx_clamp(n.x, -32768, 32767), fx_clamp(n.y, -32768, 32767)));
            assert_int_equal(p[j].normal_z, fx_clamp(n.z, -32768, 32767));
            assert_int_equal(p[j].nv, nv);
            assert_int_equal(p[j].at, at + j);
            assert_int_equal(away >> 4 * j & 15, nv < 1 << 23 ? 15 : 0);
        }
    }
}

static void srgb_of_eight_values_is_the_same(void **state)
{
    (void)state;
    if (!raster_half_vector_wide)
        skip();
    enum { COUNT = 3 * RASTER_BATCH };
    for (uint32_t x = 0; x < 1 << 21; x += COUNT) {
        uint32_t linear[COUNT];
        uint8_t code[COUNT];
        for (uint32_t i = 0; i < COUNT; i++)
            linear[i] = i % 16 ? x + i : i % 32 ? INT32_MAX - x / COUNT : 0 - x;
        raster_srgb_wide(code, linear, COUNT);
        for (uint32_t i = 0; i < COUNT; i++)
            assert_int_equal(code[i], lut_srgb8((int32_t)linear[i]));
        for (uint32_t i = 0; i < COUNT; i++)
            linear[i] = x + i;
        raster_srgb_wide(code, linear, COUNT);
        for (uint32_t i = 0; i < COUNT; i++)
            assert_int_equal(code[i], lut_srgb8((int32_t)linear[i]));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(half_vectors_of_eight_pixels_give_the_same_bits),
                                       cmocka_unit_test(specular_frames_of_eight_pixels_give_the_same_bits),
                                       cmocka_unit_test(srgb_of_eight_values_is_the_same),
                                       cmocka_unit_test(normals_of_eight_surfaces_give_the_same_bits)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
