/* RGB9_E5 encode against an exact implementation in integers. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_rgb9e5.h"
#include "rgb9e5.h"

/* round(c * 2^(24-e)), ties up, exactly: c = m * 2^q with integers m, q from the double's bits. 2^40 stands for more. */
static uint64_t exact_mantissa(double c, int e)
{
    uint64_t bits;
    memcpy(&bits, &c, 8);
    uint64_t m = bits & ((1ull << 52) - 1);
    int q = (int)(bits >> 52 & 2047);
    m |= q ? 1ull << 52 : 0;
    q = (q ? q : 1) - 1075 + 24 - e;
    if (m == 0)
        return 0;
    if (q >= 0)
        return q < 11 ? m << q : 1ull << 40;
    if (q < -63)
        return 0; /* m * 2^q < 2^53 * 2^-64: below one half */
    return (m >> -q) + (m >> (-q - 1) & 1);
}

/* The smallest exponent whose three rounded mantissas fit nine bits. */
static uint32_t exact_encode(const double rgb[3])
{
    double c[3];
    for (int i = 0; i < 3; i++)
        c[i] = isnan(rgb[i]) || rgb[i] <= 0 ? 0 : rgb[i] > 65408 ? 65408 : rgb[i];
    for (int e = 0; e < 32; e++) {
        uint64_t m[3];
        for (int i = 0; i < 3; i++)
            m[i] = exact_mantissa(c[i], e);
        if (m[0] < 512 && m[1] < 512 && m[2] < 512)
            return (uint32_t)(m[0] | m[1] << 9 | m[2] << 18 | (uint64_t)e << 27);
    }
    fail_msg("no exponent fits %g %g %g", c[0], c[1], c[2]);
    return 0;
}

static uint32_t word(uint32_t r, uint32_t g, uint32_t b, uint32_t e)
{
    return r | g << 9 | b << 18 | e << 27;
}

static uint32_t encode(double r, double g, double b)
{
    double rgb[3] = {r, g, b};
    uint32_t w = rgb9e5_encode(rgb);
    assert_int_equal(w, exact_encode(rgb));
    return w;
}

static void encode_rounds_ties_up(void **state)
{
    (void)state;
    assert_int_equal(encode(256.5 / 512, 0.5 / 512, 1.5 / 512), word(257, 1, 2, 15));
    double below = nextafter(0.5 / 512, 0);
    assert_int_equal(encode(256.0 / 512, below, nextafter(256.5 / 512, 0)), word(256, 0, 256, 15));
    /* The largest double below a tie, where adding one half in floating point would round to the next whole number. */
    assert_int_equal(encode(nextafter(0x1p-25, 0), 0, 0), 0);
}

static void encode_carries_a_mantissa_of_512_into_the_exponent(void **state)
{
    (void)state;
    for (int e = 0; e < 31; e++) {
        double tie = ldexp(511.5, e - 24);
        assert_int_equal(encode(tie, tie / 2, 0), word(256, 128, 0, (uint32_t)e + 1));
        assert_int_equal(encode(nextafter(tie, 0), 0, 0), word(511, 0, 0, (uint32_t)e));
        assert_int_equal(encode(ldexp(512, e - 24), 0, 0), word(256, 0, 0, (uint32_t)e + 1));
    }
}

static void encode_handles_the_smallest_values(void **state)
{
    (void)state;
    assert_int_equal(encode(0, 0, 0), 0);
    assert_int_equal(encode(0x1p-24, 0x1p-25, 0x1.8p-24), word(1, 1, 2, 0));
    assert_int_equal(encode(0x1p-26, 0x1p-1074, 0x1p-1022), 0);
    assert_int_equal(encode(0x1p-16, 0, 0), word(256, 0, 0, 0));
    assert_int_equal(encode(0x1p-15, 0, 0), word(256, 0, 0, 1));
}

static void encode_clamps_the_largest_values(void **state)
{
    (void)state;
    assert_int_equal(encode(65408, 65408.001, 1e300), word(511, 511, 511, 31));
    assert_int_equal(encode(INFINITY, 1, 128), word(511, 0, 1, 31));
    assert_int_equal(encode(65407.99, 64, 63.99), word(511, 1, 0, 31));
}

static void encode_turns_nan_and_negative_into_zero(void **state)
{
    (void)state;
    assert_int_equal(encode(NAN, -1, -INFINITY), 0);
    assert_int_equal(encode(-0.0, NAN, 1), word(0, 0, 256, 16));
    assert_int_equal(encode(-1e-300, 2, -65409), word(0, 256, 0, 17));
}

static void encode_keeps_what_decode_gives(void **state)
{
    (void)state;
    for (uint32_t e = 0; e < 32; e++)
        for (uint32_t m = e ? 256 : 0; m < 512; m++) {
            uint32_t w = word(m * 7 % (m + 1), m, m / 3, e);
            struct lut_rgb t = lut_rgb9e5_decode(w);
            double rgb[3] = {ldexp(t.c[0], t.e), ldexp(t.c[1], t.e), ldexp(t.c[2], t.e)};
            assert_int_equal(rgb9e5_encode(rgb), m ? w : 0);
        }
}

static uint64_t random_bits(uint64_t *s)
{
    *s ^= *s << 13;
    *s ^= *s >> 7;
    *s ^= *s << 17;
    return *s;
}

/* Exponents from below the smallest word to above the largest, mantissas with every number of trailing zeros, so that exact
 * ties and carries are common. */
static double random_channel(uint64_t *s)
{
    uint64_t r = random_bits(s);
    double m = (double)(((r & 0x1fffff) | 0x100000) >> (r >> 21 & 15) << (r >> 21 & 15));
    return ldexp(m, (int)(r >> 32) % 46 - 48);
}

static void encode_agrees_with_exact_arithmetic_on_ten_million_random_texels(void **state)
{
    (void)state;
    uint64_t s = 88172645463325252u;
    for (int i = 0; i < 10000000; i++) {
        double a = random_channel(&s);
        double rgb[3] = {a, random_channel(&s), a * (double)(random_bits(&s) >> 40) * 0x1p-24};
        uint32_t w = rgb9e5_encode(rgb), want = exact_encode(rgb);
        if (w != want)
            fail_msg("%a %a %a: %08x, want %08x", rgb[0], rgb[1], rgb[2], w, want);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(encode_rounds_ties_up),
        cmocka_unit_test(encode_carries_a_mantissa_of_512_into_the_exponent),
        cmocka_unit_test(encode_handles_the_smallest_values),
        cmocka_unit_test(encode_clamps_the_largest_values),
        cmocka_unit_test(encode_turns_nan_and_negative_into_zero),
        cmocka_unit_test(encode_keeps_what_decode_gives),
        cmocka_unit_test(encode_agrees_with_exact_arithmetic_on_ten_million_random_texels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
