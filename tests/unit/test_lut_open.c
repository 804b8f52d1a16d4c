/*
 * What lut_open refuses, and with which error: one damage at a time to a file that it accepts. The container itself is
 * test_ktx2.c's subject.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "lut.h"
#include "ref_table.h"

enum { T = 4, H = 6, D = 5, CELLS = (H - 1) * (D - 1), ROW = 12 * T };

static uint32_t texels[1 << 17];
static struct ref_half half = {.t = T, .h = H, .d = D, .texels = texels, .slabs = 1};

static int make_texels(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < sizeof texels / sizeof *texels; i++)
        texels[i] = (i * 2654435761u & 0x7ffffff) | (12 + i % 5) << 27;
    ref_half_warp(&half, 0.1);
    return 0;
}

/* Opens a file of these keys and dimensions; frees the keys. The descriptor must be filled, or left alone. */
static void expect_of(struct ref_keys *k, unsigned t, unsigned h, unsigned d, enum lut_status wanted)
{
    size_t bytes;
    struct lut_table out, untouched;
    void *file = ref_ktx2_write(t, h, d, texels, k, &bytes);
    memset(&out, 0xa5, sizeof out);
    memset(&untouched, 0xa5, sizeof out);
    assert_string_equal(lut_status_text(lut_open(&out, file, bytes)), lut_status_text(wanted));
    if (wanted != LUT_OK)
        assert_memory_equal(&out, &untouched, sizeof out);
    free(file);
    ref_keys_free(k);
}

static void expect(struct ref_keys *k, enum lut_status wanted)
{
    expect_of(k, T, H, D, wanted);
}

/* The good file's keys; every test damages some. */
static struct ref_keys good_keys(void)
{
    struct ref_keys k;
    ref_half_keys(&k, &half);
    return k;
}

static struct ref_keys frame_keys(void)
{
    struct ref_keys k = {.count = 0};
    ref_key_set_text(&k, "goniotile.kind", "specular_frame");
    ref_key_set_text(&k, "goniotile.theta_max", "60000");
    ref_key_set_text(&k, "goniotile.version", "1");
    return k;
}

static void with_text(const char *name, const char *text, enum lut_status wanted)
{
    struct ref_keys k = good_keys();
    ref_key_set_text(&k, name, text);
    expect(&k, wanted);
}

static void without(const char *name, enum lut_status wanted)
{
    struct ref_keys k = good_keys();
    ref_key_remove(&k, name);
    expect(&k, wanted);
}

static struct ref_key *key_of(struct ref_keys *k, const char *name)
{
    for (unsigned i = 0; i < k->count; i++)
        if (!strcmp(k->key[i].name, name))
            return &k->key[i];
    fail_msg("no key %s", name);
    return NULL;
}

/* The same value, longer (by zeros) or shorter. */
static void with_length(const char *name, int difference, enum lut_status wanted)
{
    struct ref_keys k = good_keys();
    uint8_t value[4096] = {0};
    struct ref_key *key = key_of(&k, name);
    size_t bytes = key->bytes + difference;
    assert_true(bytes <= sizeof value);
    memcpy(value, key->value, bytes < key->bytes ? bytes : key->bytes);
    ref_key_set(&k, name, value, bytes);
    expect(&k, wanted);
}

static void with_byte(const char *name, size_t at, uint8_t value, enum lut_status wanted)
{
    struct ref_keys k = good_keys();
    key_of(&k, name)->value[at] = value;
    expect(&k, wanted);
}

static void with_word(const char *name, size_t at, uint32_t value, enum lut_status wanted)
{
    struct ref_keys k = good_keys();
    for (int i = 0; i < 4; i++)
        key_of(&k, name)->value[4 * at + i] = (uint8_t)(value >> (8 * i));
    expect(&k, wanted);
}

static void opens_what_is_well_formed(void **state)
{
    (void)state;
    size_t bytes;
    struct lut_table t;
    void *file = ref_half_make(&half, &bytes);
    assert_int_equal(lut_open(&t, file, bytes), LUT_OK);
    assert_int_equal(t.kind, LUT_HALF_VECTOR);
    assert_true(t.width == T && t.height == H && t.depth == D && t.scale == 0);
    assert_memory_equal(t.texels, texels, 4 * T * H * D);
    assert_int_equal(t.brightest, 16);
    assert_memory_equal(t.warp_h, half.warp_h, sizeof half.warp_h);
    assert_memory_equal(t.warp_d, half.warp_d, sizeof half.warp_d);
    assert_non_null(t.cells);
    assert_non_null(t.slabs);
    free(file);
    without("goniotile.slabs", LUT_OK);
    with_text("goniotile.scale", "16", LUT_OK);
    with_text("goniotile.scale", "-16", LUT_OK);
    with_text("goniotile.scale", "0", LUT_OK);
}

static void limits_of_the_dimensions_are_accepted(void **state)
{
    (void)state;
    static const unsigned size[][3] = {{2, 2, 2}, {32, 128, 16}, {4, 128, 128}, {32, 16, 128}};
    for (size_t i = 0; i < sizeof size / sizeof *size; i++) {
        struct ref_half f = {.t = size[i][0], .h = size[i][1], .d = size[i][2], .texels = texels};
        struct ref_keys k;
        ref_half_warp(&f, 0.1);
        ref_half_keys(&k, &f);
        expect_of(&k, f.t, f.h, f.d, LUT_OK);
    }
}

static void dimensions_beyond_the_limits_are_refused(void **state)
{
    (void)state;
    static const unsigned size[][3] = {{1, H, D},   {T, 1, D},   {T, H, 1},     {33, H, D},
                                       {T, 129, D}, {T, H, 129}, {32, 128, 17}, {32, 17, 128}};
    for (size_t i = 0; i < sizeof size / sizeof *size; i++) {
        struct ref_keys k = good_keys();
        expect_of(&k, size[i][0], size[i][1], size[i][2], LUT_ERR_AXES);
    }
}

/* Whatever depends on the dimensions no longer fits them: the first that is looked at is named. */
static void dimensions_of_another_table_are_refused(void **state)
{
    (void)state;
    struct ref_keys k = good_keys();
    expect_of(&k, T, H + 1, D, LUT_ERR_WARP);
    k = good_keys();
    expect_of(&k, T, H, D - 1, LUT_ERR_WARP);
    k = good_keys();
    expect_of(&k, 32, H, D, LUT_ERR_SLABS); /* rows of eight times the length */
}

static void missing_warps_are_refused(void **state)
{
    (void)state;
    without("goniotile.warph", LUT_ERR_WARP);
    without("goniotile.warpd", LUT_ERR_WARP);
}

static void warps_of_the_wrong_length_are_refused(void **state)
{
    (void)state;
    with_length("goniotile.warph", -2, LUT_ERR_WARP);
    with_length("goniotile.warph", 2, LUT_ERR_WARP);
    with_length("goniotile.warph", -258, LUT_ERR_WARP);
    with_length("goniotile.warpd", -1, LUT_ERR_WARP);
    with_length("goniotile.warpd", 1, LUT_ERR_WARP);
}

static void warps_that_start_above_the_first_node_are_refused(void **state)
{
    (void)state;
    with_byte("goniotile.warph", 0, 1, LUT_ERR_WARP);
    with_byte("goniotile.warpd", 1, 1, LUT_ERR_WARP);
}

static void warps_that_end_elsewhere_than_at_the_last_node_are_refused(void **state)
{
    (void)state;
    with_byte("goniotile.warph", 256, 1, LUT_ERR_WARP);
    with_byte("goniotile.warpd", 129, 2 * (D - 1) - 2, LUT_ERR_WARP);
    with_byte("goniotile.warpd", 129, 255, LUT_ERR_WARP);
}

/* Each node in turn above the one after it. */
static void warps_that_decrease_are_refused(void **state)
{
    (void)state;
    for (unsigned i = 1; i + 1 < REF_WARP_H; i++) {
        struct ref_half f = half;
        struct ref_keys k;
        f.warp_h[i] = (uint16_t)(f.warp_h[i + 1] + 1);
        ref_half_keys(&k, &f);
        expect(&k, LUT_ERR_WARP);
    }
    for (unsigned i = 1; i + 1 < REF_WARP_D; i++) {
        struct ref_half f = half;
        struct ref_keys k;
        f.warp_d[i] = (uint16_t)(f.warp_d[i - 1] - (i > 1));
        f.warp_d[i - 1] = (uint16_t)(f.warp_d[i - 1] + (i == 1));
        ref_half_keys(&k, &f);
        expect(&k, LUT_ERR_WARP);
    }
}

static void warps_flat_in_between_are_accepted(void **state)
{
    (void)state;
    struct ref_half f = half;
    struct ref_keys k;
    for (unsigned i = 1; i < 100; i++)
        f.warp_h[i] = 0;
    ref_half_keys(&k, &f);
    expect(&k, LUT_OK);
}

static void warps_flat_at_the_end_are_refused(void **state)
{
    (void)state;
    struct ref_half f = half;
    struct ref_keys k;
    f.warp_h[REF_WARP_H - 2] = f.warp_h[REF_WARP_H - 1];
    ref_half_keys(&k, &f);
    expect(&k, LUT_ERR_WARP);
}

static void missing_exponents_are_refused(void **state)
{
    (void)state;
    without("goniotile.cells", LUT_ERR_EXPONENT);
}

static void exponents_of_the_wrong_number_are_refused(void **state)
{
    (void)state;
    with_length("goniotile.cells", -1, LUT_ERR_EXPONENT);
    with_length("goniotile.cells", 1, LUT_ERR_EXPONENT);
    with_length("goniotile.cells", -CELLS, LUT_ERR_EXPONENT);
}

static void exponents_above_31_are_refused(void **state)
{
    (void)state;
    for (size_t i = 0; i < CELLS; i++)
        with_byte("goniotile.cells", i, i % 2 ? 32 : 255, LUT_ERR_EXPONENT);
    struct ref_keys k = good_keys();
    ref_key_remove(&k, "goniotile.slabs");
    key_of(&k, "goniotile.cells")->value[CELLS - 1] = 31;
    expect(&k, LUT_OK);
}

static void scales_out_of_range_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"17", "-17", "999999999", "-999999999", "4294967296", "18446744073709551616"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        with_text("goniotile.scale", bad[i], LUT_ERR_EXPONENT);
}

static void scales_that_are_not_numbers_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"", "-", "--1", "+1", " 1", "1 ", "1.5", "0x1", "one"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        with_text("goniotile.scale", bad[i], LUT_ERR_EXPONENT);
}

static void slabs_cut_short_are_refused(void **state)
{
    (void)state;
    for (int less = 1; less <= 2 * ROW; less += less < 8 ? 1 : 4)
        with_length("goniotile.slabs", -less, LUT_ERR_SLABS);
    struct ref_keys k = good_keys();
    ref_key_set(&k, "goniotile.slabs", "", 0);
    expect(&k, LUT_ERR_SLABS);
    k = good_keys();
    ref_key_set(&k, "goniotile.slabs", texels, 4 * CELLS + 2 * ROW - 4); /* not even one row pair */
    expect(&k, LUT_ERR_SLABS);
}

static void slabs_that_point_outside_are_refused(void **state)
{
    (void)state;
    struct ref_keys k = good_keys();
    uint32_t bytes = (uint32_t)key_of(&k, "goniotile.slabs")->bytes, last = bytes - 2 * ROW;
    for (size_t i = 0; i < CELLS; i++) {
        const uint32_t exponent = key_of(&k, "goniotile.cells")->value[i];
        with_word("goniotile.slabs", i, last << 8 | exponent, LUT_OK);
        with_word("goniotile.slabs", i, (last + 4) << 8 | exponent, LUT_ERR_SLABS);
        with_word("goniotile.slabs", i, bytes << 8 | exponent, LUT_ERR_SLABS);
        with_word("goniotile.slabs", i, 0xfffffc00u | exponent, LUT_ERR_SLABS);
    }
    ref_keys_free(&k);
}

static void slabs_that_point_into_their_records_are_refused(void **state)
{
    (void)state;
    with_word("goniotile.slabs", 0, (4 * CELLS - 4) << 8, LUT_ERR_SLABS);
    with_word("goniotile.slabs", CELLS - 1, 0, LUT_ERR_SLABS);
}

static void slabs_at_odd_places_are_refused(void **state)
{
    (void)state;
    for (uint32_t odd = 1; odd < 4; odd++)
        with_word("goniotile.slabs", 3, (4 * CELLS + odd) << 8, LUT_ERR_SLABS);
}

static void slabs_with_other_exponents_than_their_cells_are_refused(void **state)
{
    (void)state;
    struct ref_keys k = good_keys();
    const uint32_t exponent = key_of(&k, "goniotile.cells")->value[7];
    ref_keys_free(&k);
    for (uint32_t other = 0; other < 256; other++)
        with_word("goniotile.slabs", 7, 4 * CELLS << 8 | other, other == exponent ? LUT_OK : LUT_ERR_SLABS);
}

static void kinds_unknown_or_missing_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"", "half_vecto", "half_vector2", "HALF_VECTOR", "half-vector"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        with_text("goniotile.kind", bad[i], LUT_ERR_KIND);
    without("goniotile.kind", LUT_ERR_KIND);
}

static void versions_newer_or_missing_are_refused(void **state)
{
    (void)state;
    with_text("goniotile.version", "2", LUT_ERR_VERSION);
    with_text("goniotile.version", "0", LUT_ERR_VERSION);
    with_text("goniotile.version", "", LUT_ERR_VERSION);
    without("goniotile.version", LUT_ERR_VERSION);
}

/* Another program's texture, and one table's axes under the name of the other kind. */
static void foreign_metadata_is_refused(void **state)
{
    (void)state;
    struct ref_keys k = {.count = 0};
    ref_key_set_text(&k, "KTXorientation", "rdi");
    ref_key_set_text(&k, "KTXwriter", "toktx v4.1");
    expect(&k, LUT_ERR_VERSION);
    k = frame_keys();
    ref_key_set_text(&k, "goniotile.kind", "half_vector");
    expect(&k, LUT_ERR_WARP);
    k = good_keys();
    ref_key_set_text(&k, "goniotile.kind", "specular_frame");
    expect(&k, LUT_ERR_AXES);
}

static void keys_of_others_are_ignored(void **state)
{
    (void)state;
    struct ref_keys k = good_keys();
    ref_key_set_text(&k, "KTXorientation", "rdi");
    ref_key_set(&k, "goniotile.source", "\1\2\3", 3); /* no text, no NUL */
    expect(&k, LUT_OK);
}

static void swaps_other_than_0_and_1_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"2", "", "-1", "yes"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct ref_keys k = frame_keys();
        ref_key_set_text(&k, "goniotile.swap", bad[i]);
        expect(&k, LUT_ERR_AXES);
    }
    for (int i = 0; i < 2; i++) {
        struct ref_keys k = frame_keys();
        ref_key_set_text(&k, "goniotile.swap", i ? "1" : "0");
        expect(&k, LUT_OK);
    }
}

/* The texels lie where nothing can be read. */
static void no_texel_is_read(void **state)
{
    (void)state;
    const size_t page = 4096, room = 8 * page;
    size_t bytes, texel_bytes = 4 * T * H * D;
    uint8_t *area = mmap(NULL, room + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(area != MAP_FAILED && texel_bytes <= page);
    void *file = ref_half_make(&half, &bytes);
    size_t head = bytes - texel_bytes;
    assert_true(head <= room);
    memcpy(area + room - head, file, head);
    assert_int_equal(mprotect(area + room, page, PROT_NONE), 0);
    struct lut_table t;
    assert_int_equal(lut_open(&t, area + room - head, bytes), LUT_OK);
    assert_ptr_equal(t.texels, area + room);
    munmap(area, room + page);
    free(file);
}

static void every_error_says_something_else(void **state)
{
    (void)state;
    for (int i = 0; i < LUT_STATUS_COUNT; i++)
        for (int j = 0; j < i; j++)
            assert_string_not_equal(lut_status_text((enum lut_status)i), lut_status_text((enum lut_status)j));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(opens_what_is_well_formed),
        cmocka_unit_test(limits_of_the_dimensions_are_accepted),
        cmocka_unit_test(dimensions_beyond_the_limits_are_refused),
        cmocka_unit_test(dimensions_of_another_table_are_refused),
        cmocka_unit_test(missing_warps_are_refused),
        cmocka_unit_test(warps_of_the_wrong_length_are_refused),
        cmocka_unit_test(warps_that_start_above_the_first_node_are_refused),
        cmocka_unit_test(warps_that_end_elsewhere_than_at_the_last_node_are_refused),
        cmocka_unit_test(warps_that_decrease_are_refused),
        cmocka_unit_test(warps_flat_in_between_are_accepted),
        cmocka_unit_test(warps_flat_at_the_end_are_refused),
        cmocka_unit_test(missing_exponents_are_refused),
        cmocka_unit_test(exponents_of_the_wrong_number_are_refused),
        cmocka_unit_test(exponents_above_31_are_refused),
        cmocka_unit_test(scales_out_of_range_are_refused),
        cmocka_unit_test(scales_that_are_not_numbers_are_refused),
        cmocka_unit_test(slabs_cut_short_are_refused),
        cmocka_unit_test(slabs_that_point_outside_are_refused),
        cmocka_unit_test(slabs_that_point_into_their_records_are_refused),
        cmocka_unit_test(slabs_at_odd_places_are_refused),
        cmocka_unit_test(slabs_with_other_exponents_than_their_cells_are_refused),
        cmocka_unit_test(kinds_unknown_or_missing_are_refused),
        cmocka_unit_test(versions_newer_or_missing_are_refused),
        cmocka_unit_test(foreign_metadata_is_refused),
        cmocka_unit_test(keys_of_others_are_ignored),
        cmocka_unit_test(swaps_other_than_0_and_1_are_refused),
        cmocka_unit_test(no_texel_is_read),
        cmocka_unit_test(every_error_says_something_else),
    };
    return cmocka_run_group_tests(tests, make_texels, NULL);
}
