/* lut/func.c against double precision: every table entry, then dense sweeps, random and corner values. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>

#include "display.h"
#include "func.h"

static const double pi = 3.14159265358979323846;

static uint32_t random32(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    uint32_t x = (uint32_t)(*state >> 33), r = (uint32_t)(*state >> 59);
    return x * 2654435761u ^ (x >> r);
}

/* A random word with a random number of bits, so that every octave is visited equally. */
static uint32_t random_octave(uint64_t *state)
{
    uint32_t x = random32(state) | 0x80000000u;
    return x >> (random32(state) & 31);
}

static double aces_curve(double v)
{
    double y = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
    return y < 0 ? 0 : y;
}

static double angle_ratio(double u)
{
    double r = sqrt(fabs(u));
    return u == 0 ? 2 / pi : 2 * (u > 0 ? asin(r) : asinh(r)) / (pi * r);
}

static double aces_node(int i)
{
    return exp2(i / 16 - 4) * (1 + i % 16 / 16.0) - 0x1p-4;
}

/* A node's value, the nearest with this slope, rounded down, in its 12 low bits. */
static uint32_t node_word(double value, double slope)
{
    const double low = fmax(floor(slope), 0);
    return (uint32_t)(fmax(floor((value - low) / 4096 + 0.5), 0) * 4096 + low);
}

#define COUNT(t) ((int)(sizeof(t) / sizeof *(t)))
#define CHECK_TABLE(t, formula)                                                                                        \
    for (int i = 0; i < COUNT(t); i++) {                                                                               \
        assert_true((t)[i] == (int64_t)floor((formula) + 0.5));                                                        \
    }

static void every_table_entry_is_its_formula_rounded(void **state)
{
    (void)state;
    CHECK_TABLE(func_rsqrt, 0x1p15 / sqrt(1 + i / 16.0));
    CHECK_TABLE(func_log2, 0x1p25 * log2(1 + (i - 1) / 64.0));
    CHECK_TABLE(func_exp2, 0x1p30 * exp2(-(i - 1) / 16.0));
    CHECK_TABLE(func_angle, 0x1p31 * angle_ratio((i - 1) / 16.0));
    CHECK_TABLE(func_atan, 0x1p28 * atan((i - 1) / 16.0) / (2 * pi));
    CHECK_TABLE(func_srgb_octave, 0x1p23 * 255 * 1.055 * exp2(-(i + 1) / 2.4));
    for (int i = 0; i < COUNT(func_srgb_power); i++) {
        const double node = 0x1p31 * pow(1 + i / 64.0, 1 / 2.4), next = 0x1p31 * pow(1 + (i + 1) / 64.0, 1 / 2.4);
        assert_true(func_srgb_power[i] == node_word(node, (next - node) / 4096 + 0.5));
    }
    for (int i = 0; i < COUNT(func_aces); i++) {
        const double node = aces_curve(aces_node(i)), next = aces_curve(aces_node(i + 1)),
                     middle = aces_curve((aces_node(i) + aces_node(i + 1)) / 2);
        assert_true(func_aces[i] ==
                    node_word(0x1p30 * (node + (middle - (node + next) / 2) / 2), 0x1p15 * (next - node) - 0.125));
    }
}

static double rsqrt_error(uint32_t x)
{
    unsigned shift = 99;
    uint32_t m = lut_rsqrt(x, &shift);
    assert_in_range(m, 1u << 30, 1u << 31);
    assert_in_range(shift, 1, 16);
    return fabs(ldexp(m, -(30 + (int)shift)) * sqrt(x) - 1);
}

static void rsqrt_is_within_2_to_minus_22(void **state)
{
    uint64_t seed = 1;
    double worst = 0;
    (void)state;
    for (uint32_t x = 1; x < 1u << 20; x++) {
        worst = fmax(worst, rsqrt_error(x));
    }
    for (uint32_t i = 0; i < 1u << 20; i++) {
        worst = fmax(worst, rsqrt_error(random_octave(&seed)));
        worst = fmax(worst, rsqrt_error((1u << 30) + i * 3071));
    }
    for (int i = 0; i < 32; i++) {
        worst = fmax(worst, fmax(rsqrt_error(1u << i), rsqrt_error(UINT32_MAX >> i)));
    }
    print_message("# rsqrt: largest relative error 2^%.2f\n", log2(worst));
    assert_true(worst <= 0x1p-22);
    unsigned shift;
    assert_int_equal(lut_rsqrt(1u << 30, &shift), 1u << 31);
    assert_int_equal(shift, 16);
}

static void log2_is_within_2_to_minus_22(void **state)
{
    uint64_t seed = 2;
    double worst = 0;
    uint32_t last = 0;
    (void)state;
    for (uint32_t x = 1; x < 1u << 20; x++) {
        uint32_t y = lut_log2(x);
        assert_true(y >= last);
        last = y;
        worst = fmax(worst, fabs(y * 0x1p-25 - log2(x)));
    }
    for (uint32_t i = 0; i < 1u << 20; i++) {
        uint32_t x = random_octave(&seed);
        worst = fmax(worst, fabs(lut_log2(x) * 0x1p-25 - log2(x)));
        assert_true(x == UINT32_MAX || lut_log2(x + 1) + 1 >= lut_log2(x));
    }
    for (uint32_t i = 0; i < 32; i++) {
        assert_int_equal(lut_log2(1u << i), i << 25);
    }
    assert_in_range(lut_log2(UINT32_MAX), (1u << 30) - 1, 1u << 30);
    print_message("# log2: largest error 2^%.2f\n", log2(worst));
    assert_true(worst <= 0x1p-22);
}

static void exp2_neg_is_within_2_to_minus_18_down_to_2_to_minus_12(void **state)
{
    double worst = 0, absolute = 0;
    uint32_t last = 1u << 30;
    (void)state;
    for (uint32_t y = 0; y < 12u << 25; y += 97) {
        uint32_t m = lut_exp2_neg(y);
        double exact = exp2(-(y * 0x1p-25));
        assert_true(m <= last);
        last = m;
        worst = fmax(worst, fabs(m * 0x1p-30 / exact - 1));
    }
    for (uint32_t y = 12u << 25; y < 31u << 25; y += 101) {
        absolute = fmax(absolute, fabs(lut_exp2_neg(y) - exp2(30 - y * 0x1p-25)));
    }
    print_message("# exp2_neg: largest relative error 2^%.2f, below 2^-12 %.3f units of 2^-30\n", log2(worst),
                  absolute);
    assert_true(worst <= 0x1p-18);
    assert_true(absolute <= 1);
    assert_int_equal(lut_exp2_neg(0), 1u << 30);
    assert_int_equal(lut_exp2_neg(1u << 25), 1u << 29);
    assert_int_equal(lut_exp2_neg(30u << 25), 1);
    assert_int_equal(lut_exp2_neg(31u << 25), 0);
    assert_int_equal(lut_exp2_neg(UINT32_MAX), 0);
}

/* A cosine lobe x^n with x as a Q30 cosine. */
static void powers_up_to_4096_are_within_2_to_minus_10(void **state)
{
    uint64_t seed = 3;
    double worst = 0;
    (void)state;
    for (int i = 0; i < 2000000; i++) {
        uint32_t n = 1 + (random_octave(&seed) >> 20);
        double target = -12.0 * random32(&seed) * 0x1p-32;
        uint32_t x = (uint32_t)(exp2(30 + target / n));
        double exact = pow(x * 0x1p-30, n);
        if (x == 0 || exact <= 0x1p-12) {
            continue;
        }
        uint64_t y = (uint64_t)n * ((30u << 25) - lut_log2(x));
        worst = fmax(worst, fabs(lut_exp2_neg(y > UINT32_MAX ? UINT32_MAX : (uint32_t)y) * 0x1p-30 / exact - 1));
    }
    print_message("# power: largest relative error 2^%.2f\n", log2(worst));
    assert_true(worst <= 0x1p-10);
}

static void angle_is_within_half_a_thousandth_of_a_degree(void **state)
{
    const double unit = 180 / 0x1p28;
    double worst = 0;
    uint32_t last = 0;
    (void)state;
    for (uint32_t s2 = 0; s2 <= 1u << 29; s2 += s2 < 1u << 20 ? 1 : 509) {
        uint32_t a = lut_angle_from_sin2_half(s2);
        double exact = 2 * asin(sqrt(s2 * 0x1p-30)) / pi * 180;
        assert_true(a + 64 >= last); /* 4e-5 degrees */
        last = a;
        worst = fmax(worst, (fabs(a * unit - exact) - unit) / fmax(exact, unit));
    }
    print_message("# angle: largest error %.1e of the angle, beyond one unit\n", worst);
    assert_true(worst <= 5e-6); /* 4.5e-4 degrees at 90 */
    assert_int_equal(lut_angle_from_sin2_half(0), 0);
    assert_in_range(lut_angle_from_sin2_half(1u << 29), (1u << 27) - 64, 1u << 27);
    assert_int_equal(lut_angle_from_sin2_half(1u << 29), lut_angle_from_sin2_half(UINT32_MAX));
    assert_in_range(lut_angle_from_sin2_half(1u << 28), (1u << 28) / 3 - 700, (1u << 28) / 3 + 700); /* 60 degrees */
}

static double turn_error(int32_t y, int32_t x)
{
    uint32_t t = lut_turn(y, x);
    assert_true(t < 1u << 28);
    double e = t * (360 / 0x1p28) - atan2(y, x) / pi * 180;
    return fabs(remainder(e, 360));
}

static void turn_is_within_a_thousandth_of_a_degree(void **state)
{
    static const int64_t corner[] = {
        0, 1, 2, 3, 181, 32768, 65535, 1 << 30, (1 << 30) + 1, INT32_MAX - 1, INT32_MAX, INT32_MIN};
    uint64_t seed = 4;
    double worst = 0;
    (void)state;
    for (int i = 0; i < 3000000; i++) {
        int32_t x = (int32_t)(random_octave(&seed) >> 1), y = (int32_t)(random_octave(&seed) >> 1);
        uint32_t s = random32(&seed);
        y = i % 4 == 0 ? (int32_t)(x * (s * 0x1p-32)) : y;
        worst = fmax(worst, turn_error(s & 1 ? -y : y, s & 2 ? -x : x));
    }
    for (int i = 0; i < COUNT(corner); i++) {
        for (int j = 0; j < COUNT(corner); j++) {
            for (int s = 0; s < 4 && (i | j); s++) {
                int64_t y = s & 1 ? -corner[i] : corner[i], x = s & 2 ? -corner[j] : corner[j];
                if (x <= INT32_MAX && y <= INT32_MAX) {
                    worst = fmax(worst, turn_error((int32_t)y, (int32_t)x));
                }
            }
        }
    }
    print_message("# turn: largest error %.5f degrees\n", worst);
    assert_true(worst <= 0.001);
    assert_int_equal(lut_turn(0, 0), 0);
    for (int i = 1; i + 1 < COUNT(corner); i++) {
        assert_int_equal(lut_turn(0, (int32_t)corner[i]), 0);
        assert_int_equal(lut_turn((int32_t)corner[i], 0), 1u << 26);
        assert_int_equal(lut_turn(0, (int32_t)-corner[i]), 1u << 27);
        assert_int_equal(lut_turn((int32_t)-corner[i], 0), 3u << 26);
    }
}

static void srgb8_is_the_rounded_curve_for_every_input(void **state)
{
    double worst = 0;
    int last = 0;
    (void)state;
    for (uint32_t i = 0; i <= 1u << 20; i++) {
        double v = i * 0x1p-20;
        double exact = 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055);
        int y = (int)lut_srgb8((int32_t)i);
        assert_true(y >= last);
        last = y;
        worst = fmax(worst, fabs(y - exact) - 0.5);
    }
    print_message("# srgb8: wrong only within %.4f of a tie\n", worst);
    assert_true(worst <= 0.002);
    assert_int_equal(lut_srgb8(INT32_MIN), 0);
    assert_int_equal(lut_srgb8(-1), 0);
    assert_int_equal(lut_srgb8((1 << 20) - 1), 255);
    assert_int_equal(lut_srgb8(INT32_MAX), 255);
}

static void aces_curve_is_within_1_4e_minus_4_and_monotone(void **state)
{
    uint64_t seed = 5;
    double worst = 0;
    uint32_t last = 0;
    (void)state;
    for (uint32_t v = 0; v < 1u << 25; v += v < 4u << 20 ? 1 : 61) {
        uint32_t y = lut_aces_curve(v);
        assert_true(y >= last);
        last = y;
        worst = fmax(worst, fabs(y * 0x1p-30 - aces_curve(v * 0x1p-20)));
    }
    for (int i = 0; i < 1000000; i++) {
        uint32_t v = random_octave(&seed);
        if (v < 1u << 25)
            worst = fmax(worst, fabs(lut_aces_curve(v) * 0x1p-30 - aces_curve(v * 0x1p-20)));
    }
    print_message("# aces_curve: largest error %.1e\n", worst);
    assert_true(worst <= 1.4e-4);
    assert_true(lut_aces_curve(0) < 16);
    assert_int_equal(lut_aces_curve(1u << 25), lut_aces_curve((1u << 25) - 1));
    assert_int_equal(lut_aces_curve(INT32_MAX), lut_aces_curve((1u << 25) - 1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_table_entry_is_its_formula_rounded),
        cmocka_unit_test(rsqrt_is_within_2_to_minus_22),
        cmocka_unit_test(log2_is_within_2_to_minus_22),
        cmocka_unit_test(exp2_neg_is_within_2_to_minus_18_down_to_2_to_minus_12),
        cmocka_unit_test(powers_up_to_4096_are_within_2_to_minus_10),
        cmocka_unit_test(angle_is_within_half_a_thousandth_of_a_degree),
        cmocka_unit_test(turn_is_within_a_thousandth_of_a_degree),
        cmocka_unit_test(srgb8_is_the_rounded_curve_for_every_input),
        cmocka_unit_test(aces_curve_is_within_1_4e_minus_4_and_monotone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
