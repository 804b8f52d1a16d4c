/* ktx2_open, ktx2_find and lut_open: what is accepted, and that nothing else is. Every damaged file lies in a heap
 * block of exactly its size, so that the sanitizer sees any read beyond it. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "lut.h"
#include "ref_table.h"

enum { WIDTH = 5, HEIGHT = 4, DEPTH = 3, TEXELS = WIDTH * HEIGHT * DEPTH, KVD = 228 };

static uint8_t *file_make(size_t *bytes)
{
    uint32_t texels[TEXELS];
    for (uint32_t i = 0; i < TEXELS; i++) {
        texels[i] = i * 0x01010101u;
    }
    return ref_ktx2_make(WIDTH, HEIGHT, DEPTH, texels, 60000, bytes);
}

static void put32(uint8_t *p, uint32_t x)
{
    for (int i = 0; i < 4; i++) {
        p[i] = (uint8_t)(x >> (8 * i));
    }
}

static uint32_t get32(const uint8_t *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

/* A file with other key/value data, everything else consistent. */
static uint8_t *file_with_keys(const void *kvd, uint32_t kvd_bytes, size_t *bytes)
{
    size_t n;
    uint8_t *old = file_make(&n), *file = malloc(KVD + kvd_bytes + 4 * TEXELS);
    memcpy(file, old, KVD);
    memcpy(file + KVD, kvd, kvd_bytes);
    memcpy(file + KVD + kvd_bytes, old + n - 4 * TEXELS, 4 * TEXELS);
    put32(file + 56, kvd_bytes ? KVD : 0);
    put32(file + 60, kvd_bytes);
    put32(file + 80, KVD + kvd_bytes);
    *bytes = KVD + kvd_bytes + 4 * TEXELS;
    free(old);
    return file;
}

/* Appends one entry, `value` taken with its NUL. */
static uint32_t put_entry(uint8_t *p, const char *key, const char *value)
{
    uint32_t k = (uint32_t)strlen(key) + 1, n = k + (uint32_t)strlen(value) + 1;
    memset(p, 0, 8 + n);
    put32(p, n);
    memcpy(p + 4, key, k);
    memcpy(p + 4 + k, value, n - k);
    return 4 + (n + 3) / 4 * 4;
}

static void a_well_formed_file_opens(void **state)
{
    size_t n;
    struct ktx2_view v;
    struct lut_table t;
    uint8_t *file = file_make(&n);
    (void)state;
    assert_int_equal(ktx2_open(&v, file, n), LUT_OK);
    assert_ptr_equal(v.texels, file + n - 4 * TEXELS);
    assert_int_equal(v.width, WIDTH);
    assert_int_equal(v.height, HEIGHT);
    assert_int_equal(v.depth, DEPTH);
    assert_int_equal(v.texels[TEXELS - 1], (TEXELS - 1) * 0x01010101u);
    assert_ptr_equal(v.kvd, file + KVD);
    assert_int_equal(v.kvd_bytes, n - 4 * TEXELS - KVD);
    assert_int_equal(lut_open(&t, file, n), LUT_OK);
    assert_int_equal(t.kind, LUT_SPECULAR_FRAME);
    assert_ptr_equal(t.texels, v.texels);
    assert_int_equal(t.width, WIDTH);
    assert_int_equal(t.height, HEIGHT);
    assert_int_equal(t.depth, DEPTH);
    assert_int_equal(t.slice_scale, 2 * 4096ull * (1ull << 32) * 3 >> 28); /* two steps in a third of 2^28 */
    free(file);
}

static void keys_are_found_by_their_whole_name(void **state)
{
    size_t n;
    uint32_t bytes = 99;
    struct ktx2_view v;
    uint8_t *file = file_make(&n);
    (void)state;
    assert_int_equal(ktx2_open(&v, file, n), LUT_OK);
    assert_memory_equal(ktx2_find(&v, "goniotile.theta_max", &bytes), "60000", 6);
    assert_int_equal(bytes, 5);
    assert_memory_equal(ktx2_find(&v, "KTXwriter", &bytes), "reference", 10);
    assert_null(ktx2_find(&v, "goniotile.theta", &bytes));
    assert_null(ktx2_find(&v, "goniotile.theta_max2", &bytes));
    assert_null(ktx2_find(&v, "", &bytes));
    free(file);

    uint8_t kvd[64] = {0};
    put32(kvd, 4);
    memcpy(kvd + 4, "a\0xy", 4); /* a value without NUL */
    put32(kvd + 8, 2);
    memcpy(kvd + 12, "b", 2); /* no value */
    uint32_t length = 16 + put_entry(kvd + 16, "a", "second");
    file = file_with_keys(kvd, length, &n);
    assert_int_equal(ktx2_open(&v, file, n), LUT_OK);
    assert_memory_equal(ktx2_find(&v, "a", &bytes), "xy", 2);
    assert_int_equal(bytes, 2);
    assert_non_null(ktx2_find(&v, "b", &bytes));
    assert_int_equal(bytes, 0);
    free(file);
}

static void every_truncation_is_refused(void **state)
{
    size_t n;
    uint8_t *file = file_make(&n);
    (void)state;
    for (size_t k = 0; k < n; k++) {
        struct lut_table t, untouched;
        memset(&t, 0x5a, sizeof t);
        untouched = t;
        uint8_t *cut = malloc(k ? k : 1);
        memcpy(cut, file, k);
        assert_int_equal(lut_open(&t, cut, k), LUT_ERR_TRUNCATED);
        assert_memory_equal(&t, &untouched, sizeof t);
        free(cut);
    }
    uint8_t *longer = malloc(n + 4);
    memcpy(longer, file, n);
    memset(longer + n, 0, 4);
    struct lut_table t;
    assert_int_equal(lut_open(&t, longer, n + 1), LUT_ERR_TRUNCATED);
    assert_int_equal(lut_open(&t, longer, n + 4), LUT_ERR_TRUNCATED);
    free(longer);
    free(file);
}

static void every_misalignment_is_refused(void **state)
{
    size_t n;
    uint8_t *file = file_make(&n), *moved = malloc(n + 3);
    struct ktx2_view v;
    (void)state;
    for (size_t k = 1; k < 4; k++) {
        memcpy(moved + k, file, n);
        assert_int_equal(ktx2_open(&v, moved + k, n), LUT_ERR_ALIGNMENT);
    }
    free(moved);
    free(file);
}

/* Every value of every byte before the texels: header, level index and descriptor admit no change; with damaged
 * keys the file is refused or the same table, but for a digit of theta_max that became another digit. */
static void every_damaged_byte_is_refused_or_harmless(void **state)
{
    size_t n, digits = 0;
    uint8_t *file = file_make(&n);
    struct lut_table good, t;
    unsigned accepted = 0;
    (void)state;
    while (memcmp(file + digits, "60000", 6) != 0) {
        digits++;
    }
    assert_int_equal(lut_open(&good, file, n), LUT_OK);
    for (size_t at = 0; at < n - 4 * TEXELS; at++) {
        for (unsigned flip = 1; flip < 256; flip++) {
            file[at] ^= (uint8_t)flip;
            if (lut_open(&t, file, n) == LUT_OK) {
                assert_true(at >= KVD);
                if (at >= digits && at < digits + 5) {
                    assert_in_range(file[at], '0', '9');
                    t.slice_scale = good.slice_scale;
                }
                assert_ptr_equal(t.texels, good.texels);
                assert_true(t.kind == good.kind && t.width == good.width && t.height == good.height &&
                            t.depth == good.depth && t.slice_scale == good.slice_scale);
                accepted++;
            }
            file[at] ^= (uint8_t)flip;
        }
    }
    assert_true(accepted > 5 * 9);
    free(file);
}

static void each_field_is_refused_with_its_own_status(void **state)
{
    static const struct {
        unsigned offset;
        uint32_t value;
        enum lut_status status;
    } cases[] = {
        {0, 0x474e5089, LUT_ERR_IDENTIFIER},
        {4, 0xbb313120, LUT_ERR_IDENTIFIER}, /* KTX 1.1 */
        {12, 0, LUT_ERR_FORMAT},
        {12, 37, LUT_ERR_FORMAT},
        {16, 1, LUT_ERR_FORMAT},
        {44, 2, LUT_ERR_FORMAT}, /* Zstandard */
        {64, 8, LUT_ERR_FORMAT},
        {72, 8, LUT_ERR_FORMAT},
        {76, 1, LUT_ERR_FORMAT},
        {20, 0, LUT_ERR_DIMENSIONS},
        {20, 4097, LUT_ERR_DIMENSIONS},
        {20, UINT32_MAX, LUT_ERR_DIMENSIONS},
        {24, 0, LUT_ERR_DIMENSIONS},
        {24, 1u << 31, LUT_ERR_DIMENSIONS},
        {28, 0, LUT_ERR_DIMENSIONS},
        {28, 4097, LUT_ERR_DIMENSIONS},
        {32, 1, LUT_ERR_DIMENSIONS},
        {36, 6, LUT_ERR_DIMENSIONS},
        {36, 0, LUT_ERR_DIMENSIONS},
        {40, 0, LUT_ERR_DIMENSIONS},
        {40, 2, LUT_ERR_DIMENSIONS},
        {20, 4096, LUT_ERR_TRUNCATED},
        {48, 0, LUT_ERR_DESCRIPTOR},
        {48, UINT32_MAX, LUT_ERR_DESCRIPTOR},
        {52, 44, LUT_ERR_DESCRIPTOR},
        {104, 0, LUT_ERR_DESCRIPTOR},
        {116, 0x00010101, LUT_OK},
        {116, 0x01010101, LUT_ERR_DESCRIPTOR}, /* premultiplied */
        {56, 0, LUT_ERR_KEY_VALUES},
        {56, UINT32_MAX, LUT_ERR_KEY_VALUES},
        {60, 0, LUT_ERR_KEY_VALUES},
        {60, UINT32_MAX, LUT_ERR_TRUNCATED},
        {60, 8, LUT_ERR_KEY_VALUES},
        {80, KVD, LUT_ERR_TRUNCATED},
        {80, UINT32_MAX, LUT_ERR_TRUNCATED},
        {84, 1, LUT_ERR_TRUNCATED},
        {88, 4 * TEXELS - 4, LUT_ERR_TRUNCATED},
        {92, 1, LUT_ERR_TRUNCATED},
        {96, 0, LUT_ERR_TRUNCATED},
        {100, 1, LUT_ERR_TRUNCATED},
        {KVD, 0, LUT_ERR_KEY_VALUES},
        {KVD, 1, LUT_ERR_KEY_VALUES},
        {KVD, UINT32_MAX, LUT_ERR_KEY_VALUES},
        {KVD, UINT32_MAX - 3, LUT_ERR_KEY_VALUES},
        {KVD, 9, LUT_ERR_KEY_VALUES},     /* the key's NUL lies outside */
        {KVD + 4, 0, LUT_ERR_KEY_VALUES}, /* empty key */
    };
    size_t n;
    uint8_t *file = file_make(&n);
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct ktx2_view v;
        uint32_t old = get32(file + cases[i].offset);
        put32(file + cases[i].offset, cases[i].value);
        assert_int_equal(ktx2_open(&v, file, n), cases[i].status);
        put32(file + cases[i].offset, old);
    }
    free(file);
}

static void too_many_texels_are_refused_without_overflow(void **state)
{
    static const uint32_t size[][3] = {{4096, 4096, 2}, {4096, 4096, 4096}, {4096, 4095, 2}, {4096, 2049, 2}};
    size_t n;
    uint8_t *file = file_make(&n);
    struct ktx2_view v;
    (void)state;
    for (size_t i = 0; i < sizeof size / sizeof *size; i++) {
        for (unsigned axis = 0; axis < 3; axis++) {
            put32(file + 20 + 4 * axis, size[i][axis]);
        }
        assert_int_equal(ktx2_open(&v, file, n), LUT_ERR_DIMENSIONS);
    }
    put32(file + 24, 2048);
    assert_int_equal(ktx2_open(&v, file, n), LUT_ERR_TRUNCATED); /* 2^24 texels are allowed */
    free(file);
}

static enum lut_status open_with(const char *version, const char *kind, const char *theta_max)
{
    uint8_t kvd[256];
    uint32_t length = put_entry(kvd, "KTXorientation", "rdo");
    length += kind ? put_entry(kvd + length, "goniotile.kind", kind) : 0;
    length += put_entry(kvd + length, "goniotile.note", "a reader ignores it");
    length += theta_max ? put_entry(kvd + length, "goniotile.theta_max", theta_max) : 0;
    length += version ? put_entry(kvd + length, "goniotile.version", version) : 0;
    size_t n;
    uint8_t *file = file_with_keys(kvd, length, &n);
    struct lut_table t;
    enum lut_status s = lut_open(&t, file, n);
    free(file);
    return s;
}

static void metadata_is_required_and_checked(void **state)
{
    (void)state;
    assert_int_equal(open_with("1", "specular_frame", "60000"), LUT_OK);
    assert_int_equal(open_with("1", "specular_frame", "90000"), LUT_OK);
    assert_int_equal(open_with("1", "specular_frame", "6"), LUT_OK);
    assert_int_equal(open_with(NULL, "specular_frame", "60000"), LUT_ERR_VERSION);
    assert_int_equal(open_with("2", "specular_frame", "60000"), LUT_ERR_VERSION);
    assert_int_equal(open_with("0", "specular_frame", "60000"), LUT_ERR_VERSION);
    assert_int_equal(open_with("", "specular_frame", "60000"), LUT_ERR_VERSION);
    assert_int_equal(open_with("1x", "specular_frame", "60000"), LUT_ERR_VERSION);
    assert_int_equal(open_with("1", NULL, "60000"), LUT_ERR_KIND);
    assert_int_equal(open_with("1", "specular", "60000"), LUT_ERR_KIND);
    assert_int_equal(open_with("1", "specular_frames", "60000"), LUT_ERR_KIND);
    assert_int_equal(open_with("1", "", "60000"), LUT_ERR_KIND);
    assert_int_equal(open_with("1", "specular_frame", NULL), LUT_ERR_AXES);
    assert_int_equal(open_with("1", "specular_frame", "0"), LUT_ERR_AXES);
    assert_int_equal(open_with("1", "specular_frame", "90001"), LUT_ERR_AXES);
    assert_int_equal(open_with("1", "specular_frame", "-60000"), LUT_ERR_AXES);
    assert_int_equal(open_with("1", "specular_frame", "60.0"), LUT_ERR_AXES);
    assert_int_equal(open_with("1", "specular_frame", "4294967297"), LUT_ERR_AXES);
    assert_int_equal(open_with("1", "specular_frame", "5"), LUT_ERR_AXES); /* slices 2.5 apart */
}

static void tables_without_keys_or_with_single_nodes_are_refused(void **state)
{
    size_t n;
    struct ktx2_view v;
    struct lut_table t;
    uint32_t one = 0, *texels = &one;
    (void)state;
    uint8_t *file = file_with_keys("", 0, &n);
    assert_int_equal(ktx2_open(&v, file, n), LUT_OK);
    assert_int_equal(lut_open(&t, file, n), LUT_ERR_VERSION);
    free(file);
    file = ref_ktx2_make(1, 1, 1, texels, 60000, &n);
    assert_int_equal(ktx2_open(&v, file, n), LUT_OK);
    assert_int_equal(lut_open(&t, file, n), LUT_ERR_AXES);
    free(file);
}

static void padding_must_be_zero_and_complete(void **state)
{
    uint8_t kvd[16] = {5, 0, 0, 0, 'k', 'e', 'y', 0, 'v', 0, 0, 0};
    size_t n;
    struct ktx2_view v;
    (void)state;
    for (unsigned length = 12; length >= 9; length--) {
        uint8_t *file = file_with_keys(kvd, length, &n);
        assert_int_equal(ktx2_open(&v, file, n), length == 12 ? LUT_OK : LUT_ERR_KEY_VALUES);
        free(file);
    }
    for (unsigned i = 9; i < 12; i++) {
        kvd[i] = 1;
        uint8_t *file = file_with_keys(kvd, 12, &n);
        assert_int_equal(ktx2_open(&v, file, n), LUT_ERR_KEY_VALUES);
        free(file);
        kvd[i] = 0;
    }
}

static void every_status_has_its_own_text(void **state)
{
    (void)state;
    for (int i = 0; i < LUT_STATUS_COUNT; i++) {
        for (int j = 0; j < i; j++) {
            assert_string_not_equal(lut_status_text((enum lut_status)i), lut_status_text((enum lut_status)j));
        }
    }
    assert_string_equal(lut_status_text(LUT_STATUS_COUNT), "unknown status");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_well_formed_file_opens),
        cmocka_unit_test(keys_are_found_by_their_whole_name),
        cmocka_unit_test(every_truncation_is_refused),
        cmocka_unit_test(every_misalignment_is_refused),
        cmocka_unit_test(every_damaged_byte_is_refused_or_harmless),
        cmocka_unit_test(each_field_is_refused_with_its_own_status),
        cmocka_unit_test(too_many_texels_are_refused_without_overflow),
        cmocka_unit_test(metadata_is_required_and_checked),
        cmocka_unit_test(tables_without_keys_or_with_single_nodes_are_refused),
        cmocka_unit_test(padding_must_be_zero_and_complete),
        cmocka_unit_test(every_status_has_its_own_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
