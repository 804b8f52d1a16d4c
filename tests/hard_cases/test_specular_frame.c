/* The specular-frame table where its coordinates degenerate or its inputs are extreme. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lut.h"
#include "ref_table.h"

static const double degree = 3.14159265358979323846 / 180;
static const struct vec3 up = {0, 0, 32768};
static uint64_t seed = 1;

static uint32_t random32(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    uint32_t x = (uint32_t)(seed >> 33);
    return x * 2654435761u ^ x >> 15;
}

/* Polar angle from n = up, azimuth from x. */
static struct vec3 direction(double theta, double phi)
{
    double s = 32768 * sin(theta * degree);
    return (struct vec3){(int32_t)lrint(s * cos(phi * degree)), (int32_t)lrint(s * sin(phi * degree)),
                         (int32_t)lrint(32768 * cos(theta * degree))};
}

/* The direction `theta` off the mirror direction of direction(theta_in, 0), at phi_d = `phi`: the rows of S. */
static struct vec3 around_mirror(double theta_in, double theta, double phi)
{
    double c = cos(theta_in * degree), s = sin(theta_in * degree);
    double x = sin(theta * degree) * cos(phi * degree), y = sin(theta * degree) * sin(phi * degree);
    double z = cos(theta * degree);
    return (struct vec3){(int32_t)lrint(32768 * (-c * x - s * z)), (int32_t)lrint(32768 * -y),
                         (int32_t)lrint(32768 * (-s * x + c * z))};
}

struct table {
    void *file;
    struct lut_table lut;
    struct ref_table *ref;
};

/* The file lies in a heap block of its size that ends with the last texel. */
static struct table table_open(unsigned width, unsigned height, unsigned depth, const uint32_t *texels,
                               unsigned theta_max)
{
    struct table t;
    size_t bytes;
    t.file = ref_ktx2_make(width, height, depth, texels, theta_max, &bytes);
    assert_int_equal(lut_open(&t.lut, t.file, bytes), LUT_OK);
    t.ref = ref_table_open(t.file, bytes);
    assert_non_null(t.ref);
    return t;
}

static void table_close(struct table *t)
{
    free(t->file);
    ref_table_free(t->ref);
}

static double channel(struct lut_rgb a, int c)
{
    return ldexp(a.c[c], a.e);
}

/* Error in units of the largest node around, beyond the result's last place. */
static double error_of(const struct table *t, struct vec3 n, struct vec3 l, struct vec3 v)
{
    struct lut_rgb out;
    double exact[3], worst = 0;
    double dn[3] = {n.x, n.y, n.z}, dl[3] = {l.x, l.y, l.z}, dv[3] = {v.x, v.y, v.z};
    double largest = ref_table_eval(exact, t->ref, dn, dl, dv);
    assert_int_equal(lut_eval(&out, &t->lut, n, l, v), 8);
    for (int c = 0; c < 3; c++) {
        worst = fmax(worst, fabs(channel(out, c) - exact[c]) - 0x1p-21 * largest);
    }
    return worst / largest;
}

/* 361 x 181 x 4 texels whose channels are phi_d, theta_d and theta_in in degrees. */
static struct table angle_table(void)
{
    uint32_t *texels = malloc(sizeof *texels * 361 * 181 * 4);
    for (uint32_t z = 0, i = 0; z < 4; z++) {
        for (uint32_t y = 0; y < 181; y++) {
            for (uint32_t x = 0; x < 361; x++) {
                texels[i++] = x | y << 9 | (20 * z) << 18 | 24u << 27;
            }
        }
    }
    struct table t = table_open(361, 181, 4, texels, 60000);
    free(texels);
    return t;
}

/* Noise, constant over phi_d in the first slice and at both poles, equal first and last columns. */
static struct table noise_table(unsigned width, unsigned height, unsigned depth, unsigned theta_max)
{
    uint32_t *texels = malloc(sizeof *texels * width * height * depth), *p = texels;
    for (unsigned z = 0; z < depth; z++) {
        for (unsigned y = 0; y < height; y++, p += width) {
            for (unsigned x = 0; x < width; x++) {
                bool constant = z == 0 || y == 0 || y == height - 1 || x == width - 1;
                p[x] = x > 0 && constant ? p[0] : (random32() & 0x7ffffff) | 0x100 | 15u << 27;
            }
        }
    }
    struct table t = table_open(width, height, depth, texels, theta_max);
    free(texels);
    return t;
}

static void assert_angles(const struct table *t, struct vec3 l, struct vec3 v, double phi_d, double theta_d,
                          double theta_in)
{
    struct lut_rgb out;
    double expected[3] = {phi_d, theta_d, theta_in};
    assert_int_equal(lut_eval(&out, &t->lut, up, l, v), 8);
    for (int c = 0; c < 3; c++) {
        double tolerance = c == 0 ? 0.01 / sin(theta_d * degree) : 0.006;
        assert_true(fabs(remainder(channel(out, c) - expected[c], 360)) <= tolerance);
    }
}

/* By hand: the mirror direction of theta_in 40 is theta_out 40, phi_out 180. */
static void axes_and_the_sign_of_phi_are_those_of_the_specification(void **state)
{
    struct table t = angle_table();
    (void)state;
    assert_angles(&t, direction(40, 0), direction(60, 180), 0, 20, 40);   /* away from n */
    assert_angles(&t, direction(40, 0), direction(20, 180), 180, 20, 40); /* towards n */
    assert_angles(&t, direction(40, 0), direction(0, 0), 180, 40, 40);
    assert_angles(&t, direction(40, 0), direction(50, 0), 180, 90, 40);
    assert_angles(&t, direction(40, 0), around_mirror(40, 30, 90), 90, 30, 40);
    assert_angles(&t, direction(40, 0), around_mirror(40, 30, 270), 270, 30, 40);
    assert_true(around_mirror(40, 30, 270).y > 0); /* phi_d = 270 lies on the side of n x l */
    assert_angles(&t, direction(40, 77), direction(60, 257), 0, 20, 40);
    assert_angles(&t, direction(10, -123), direction(40, 57), 0, 30, 10);
    table_close(&t);
}

static void theta_in_beyond_the_last_slice_is_the_last_slice(void **state)
{
    enum { WIDTH = 19, HEIGHT = 10, DEPTH = 4 };
    uint32_t texels[WIDTH * HEIGHT * DEPTH];
    (void)state;
    for (unsigned i = 0; i < WIDTH * HEIGHT * DEPTH; i++) {
        texels[i] = (random32() & 0x7ffffff) | 15u << 27;
    }
    struct table all = table_open(WIDTH, HEIGHT, DEPTH, texels, 60000);
    struct table last = table_open(WIDTH, HEIGHT, 1, texels + WIDTH * HEIGHT * (DEPTH - 1), 60000);
    for (int i = 0; i < 20000; i++) {
        double theta_in = 60.01 + 29.9 * (random32() * 0x1p-32);
        struct lut_rgb a, b;
        struct vec3 l = direction(theta_in, random32() % 360), v = direction(random32() % 90, random32() % 360);
        assert_int_equal(lut_eval(&a, &all.lut, up, l, v), 8);
        assert_int_equal(lut_eval(&b, &last.lut, up, l, v), 8);
        for (int c = 0; c < 3; c++) {
            assert_true(channel(a, c) == channel(b, c));
        }
    }
    table_close(&all);
    table_close(&last);
}

static void l_parallel_to_n_does_not_depend_on_the_azimuth(void **state)
{
    struct table t = noise_table(361, 181, 4, 60000);
    double worst = 0;
    (void)state;
    for (int theta = 0; theta < 90; theta++) {
        for (int phi = 0; phi < 360; phi += 7) {
            worst = fmax(worst, error_of(&t, up, up, direction(theta + 0.37, phi)));
            /* and within a few LSB of parallel, where t = n x l is all rounding */
            struct vec3 l = {(int32_t)(random32() % 5) - 2, (int32_t)(random32() % 5) - 2, 32768};
            worst = fmax(worst, error_of(&t, up, l, direction(theta + 0.37, phi)));
        }
    }
    print_message("# l parallel to n: error max %.5f\n", worst);
    assert_true(worst <= 0.002);
    table_close(&t);
}

static void the_mirror_direction_and_its_opposite_agree(void **state)
{
    struct table t = noise_table(361, 181, 4, 60000);
    double pole = 0, opposite = 0;
    (void)state;
    for (int i = 0; i < 20000; i++) {
        double theta_in = 89.9 * (random32() * 0x1p-32), off = 0.05 * (random32() * 0x1p-32);
        pole =
            fmax(pole, error_of(&t, up, direction(theta_in, 0), around_mirror(theta_in, i < 1000 ? 0 : off, i % 360)));
        /* theta_d near 180: l = v near the horizon */
        struct vec3 l = direction(89.99 - 0.5 * (random32() * 0x1p-32), 0), v = l;
        v.y += (int32_t)(random32() % 200) - 100;
        opposite = fmax(opposite, error_of(&t, up, l, v));
    }
    print_message("# theta_d near 0: error max %.5f, near 180: %.5f\n", pole, opposite);
    assert_true(pole <= 0.004);
    assert_true(opposite <= 0.002);
    table_close(&t);
}

static void phi_wraps_without_a_seam(void **state)
{
    struct table t = noise_table(361, 181, 4, 60000);
    double worst = 0;
    (void)state;
    for (int i = 0; i < 20000; i++) {
        double theta_in = 5 + 60 * (random32() * 0x1p-32), theta_d = 20 * (random32() * 0x1p-32) + 5;
        double phi = (random32() * 0x1p-32 - 0.5) * 0.2;
        struct vec3 v = around_mirror(theta_in, theta_d, phi);
        if (v.z > 0) {
            worst = fmax(worst, error_of(&t, up, direction(theta_in, 0), v));
        }
        v.y = 0; /* exactly on the seam */
        if (v.z > 0) {
            worst = fmax(worst, error_of(&t, up, direction(theta_in, 0), v));
        }
    }
    print_message("# phi wrap: error max %.5f\n", worst);
    assert_true(worst <= 0.002);
    table_close(&t);
}

static void cosines_of_one_step_agree(void **state)
{
    struct table t = noise_table(91, 46, 4, 60000);
    double worst = 0;
    (void)state;
    for (int phi = 0; phi < 360; phi++) {
        struct vec3 grazing = direction(90, 0), other = direction(30 + phi % 60, phi);
        grazing.z = 1;
        worst = fmax(worst, error_of(&t, up, grazing, other));
        worst = fmax(worst, error_of(&t, up, other, grazing));
        struct vec3 both = direction(90, phi);
        both.z = 1;
        worst = fmax(worst, error_of(&t, up, grazing, both));
    }
    print_message("# n.l or n.v of one step: error max %.5f\n", worst);
    assert_true(worst <= 0.001);
    table_close(&t);
}

static void surfaces_facing_away_are_black_and_fetch_nothing(void **state)
{
    struct table t = angle_table();
    struct vec3 in = direction(30, 0), horizon = direction(90, 0);
    (void)state;
    for (int i = 0; i < 1000; i++) {
        struct vec3 below = direction(90 + 0.01 + i * 0.08, i), opposite = direction(i * 0.08, i);
        opposite = (struct vec3){-opposite.x, -opposite.y, -opposite.z};
        const struct vec3 pairs[][2] = {{below, in},
                                        {in, below},
                                        {below, below},
                                        {horizon, in},
                                        {in, horizon},
                                        {horizon, horizon},
                                        {opposite, direction(i * 0.08, i)},
                                        {direction(i * 0.08, i), opposite}};
        for (size_t k = 0; k < sizeof pairs / sizeof *pairs; k++) {
            struct lut_rgb out = {{1, 1, 1}, 1}, black = {{0, 0, 0}, 0};
            assert_int_equal(lut_eval(&out, &t.lut, up, pairs[k][0], pairs[k][1]), 0);
            assert_memory_equal(&out, &black, sizeof out);
        }
    }
    /* l = -v in the tangent plane: H = 0 */
    struct lut_rgb out;
    assert_int_equal(lut_eval(&out, &t.lut, up, horizon, direction(90, 180)), 0);
    table_close(&t);
}

/* So an albedo integrates to that of f exactly. */
static void a_constant_table_is_reproduced_exactly(void **state)
{
    static const uint32_t words[] = {0xffffffff,           0x00000000, 0x00000001, 0x08000000u * 15 + 0x00804020 + 256,
                                     0x08000000u * 31 + 1, 0x7d05f417};
    (void)state;
    for (size_t w = 0; w < sizeof words / sizeof *words; w++) {
        uint32_t texels[7 * 5 * 3];
        double f[3];
        for (size_t i = 0; i < 7 * 5 * 3; i++) {
            texels[i] = words[w];
        }
        struct table t = table_open(7, 5, 3, texels, 45000);
        ref_rgb9e5_decode(f, words[w]);
        for (int i = 0; i < 20000; i++) {
            struct vec3 l = direction(89.9 * (random32() * 0x1p-32), random32() % 360);
            struct vec3 v = direction(89.9 * (random32() * 0x1p-32), random32() % 360);
            struct lut_rgb out;
            assert_int_equal(lut_eval(&out, &t.lut, up, l, v), 8);
            for (int c = 0; c < 3; c++) {
                assert_true(channel(out, c) == f[c]);
            }
        }
        table_close(&t);
    }
}

static void the_largest_texels_next_to_the_smallest_agree(void **state)
{
    uint32_t texels[91 * 46 * 4];
    double worst = 0;
    (void)state;
    for (unsigned i = 0; i < 91 * 46 * 4; i++) {
        uint32_t y = i / 91 % 46;
        texels[i] = y & 1 ? 0xffffffff : y % 4 ? 0x00040201 : 0; /* 65408, 2^-24, 0 */
    }
    struct table t = table_open(91, 46, 4, texels, 60000);
    for (int i = 0; i < 50000; i++) {
        struct vec3 l = direction(89.9 * (random32() * 0x1p-32), random32() % 360);
        struct vec3 v = direction(89.9 * (random32() * 0x1p-32), random32() % 360);
        worst = fmax(worst, error_of(&t, up, l, v));
    }
    print_message("# 65408 next to 2^-24: error max %.5f\n", worst);
    assert_true(worst <= 0.002);
    table_close(&t);
}

/* Lengths off by up to 64 LSB: directions count, not lengths. */
static void normals_of_wrong_length_change_little(void **state)
{
    struct table t = noise_table(91, 46, 4, 60000);
    double worst = 0;
    (void)state;
    for (int i = 0; i < 20000; i++) {
        double length = i % 2 ? 1 - 64 / 32768.0 : 1 + 64 / 32768.0;
        struct vec3 n = direction(90 * (random32() * 0x1p-32), random32() % 360);
        struct vec3 l = direction(90 * (random32() * 0x1p-32), random32() % 360);
        struct vec3 v = direction(90 * (random32() * 0x1p-32), random32() % 360);
        struct vec3 m = {(int32_t)(n.x * length), (int32_t)(n.y * length), (int32_t)(n.z * length)};
        if (fx_dot(m, l) > 0 && fx_dot(m, v) > 0) {
            worst = fmax(worst, error_of(&t, m, l, v));
        }
    }
    print_message("# normals 64 LSB too long or short: error max %.5f\n", worst);
    assert_true(worst <= 0.008);
    table_close(&t);
}

static int32_t any_component(void)
{
    static const int32_t extreme[] = {-32832, -32768, -1, 0, 1, 32768, 32832};
    uint32_t r = random32();
    return r % 3 == 0 ? extreme[r / 3 % 7] : (int32_t)(r / 3 % (2 * 32832 + 1)) - 32832;
}

/* The sanitizers see an overflow or a read outside the texels, which end where the heap block ends. */
static void vectors_of_any_length_stay_inside_the_table(void **state)
{
    static const unsigned size[][3] = {{2, 2, 1}, {3, 2, 2}, {2, 5, 7}, {4096, 2, 2}, {2, 4096, 1}, {2, 2, 4096}};
    unsigned lit = 0;
    (void)state;
    for (size_t s = 0; s < sizeof size / sizeof *size; s++) {
        struct table t = noise_table(size[s][0], size[s][1], size[s][2], 30000);
        for (int i = 0; i < 200000; i++) {
            struct vec3 n = {any_component(), any_component(), any_component()};
            struct vec3 l = {any_component(), any_component(), any_component()};
            struct vec3 v = {any_component(), any_component(), any_component()};
            struct lut_rgb out;
            unsigned fetched = lut_eval(&out, &t.lut, n, l, v);
            assert_true(fetched == 0 || fetched == 8);
            assert_true(out.c[0] < 1u << 21 && out.c[1] < 1u << 21 && out.c[2] < 1u << 21);
            lit += fetched / 8;
        }
        table_close(&t);
    }
    assert_in_range(lit, 200000, 600000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(axes_and_the_sign_of_phi_are_those_of_the_specification),
        cmocka_unit_test(theta_in_beyond_the_last_slice_is_the_last_slice),
        cmocka_unit_test(l_parallel_to_n_does_not_depend_on_the_azimuth),
        cmocka_unit_test(the_mirror_direction_and_its_opposite_agree),
        cmocka_unit_test(phi_wraps_without_a_seam),
        cmocka_unit_test(cosines_of_one_step_agree),
        cmocka_unit_test(surfaces_facing_away_are_black_and_fetch_nothing),
        cmocka_unit_test(a_constant_table_is_reproduced_exactly),
        cmocka_unit_test(the_largest_texels_next_to_the_smallest_agree),
        cmocka_unit_test(normals_of_wrong_length_change_little),
        cmocka_unit_test(vectors_of_any_length_stay_inside_the_table),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
