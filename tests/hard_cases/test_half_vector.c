/*
 * The half-vector table where its coordinates degenerate or its inputs are extreme. Errors are in units of the largest node
 * around, on identical quantised vectors; noise is the steepest table there is.
 */
#include "half_fixture.h"

enum { COUNT = 20000 };
static const double bound = 1.0 / 512;

static void assert_bound(const char *name, double worst, double limit)
{
    print_message("# %s: error max %.6f\n", name, worst);
    assert_true(worst <= limit);
}

/* sin^2 theta_h = 0. */
static void the_half_vector_along_the_normal_agrees(void **state)
{
    (void)state;
    struct half_table t = half_noise(64, 32, 8, 15, 1, 0.003);
    double exact = 0, near = 0;
    for (int i = 0; i < COUNT; i++) {
        struct vec3 l = half_direction(half_uniform(0, 89.9), half_uniform(0, 360)), v = {-l.x, -l.y, l.z};
        exact = fmax(exact, half_error(&t, up, l, v));
        v.x += (int32_t)(half_random() % 7) - 3;
        v.y += (int32_t)(half_random() % 7) - 3;
        near = fmax(near, half_error(&t, up, l, v));
    }
    assert_bound("h = n", exact, bound);
    assert_bound("h within a few units of n", near, bound);
    half_close(&t);
}

/* l = v, where the azimuth is undefined, and l - v of one unit and more, where it is rounding. */
static void the_light_at_the_camera_agrees(void **state)
{
    (void)state;
    struct half_table t = half_noise(64, 32, 8, 15, 1, 0.05);
    double same = 0;
    for (int i = 0; i < COUNT; i++) {
        struct vec3 l = half_direction(half_uniform(0, 89.99), half_uniform(0, 360));
        same = fmax(same, half_error(&t, up, l, l));
    }
    assert_bound("l = v", same, bound);
    for (int spread = 1; spread <= 8192; spread *= 8) {
        double worst = 0;
        for (int i = 0; i < COUNT; i++) {
            struct vec3 n = half_any(), l = half_any(), v = l;
            v.x += (int32_t)(half_random() % (2 * spread + 1)) - spread;
            v.y += (int32_t)(half_random() % (2 * spread + 1)) - spread;
            v.z += (int32_t)(half_random() % (2 * spread + 1)) - spread;
            v = half_quantise(v.x, v.y, v.z);
            if (fx_dot(n, l) > 0 && fx_dot(n, v) > 0)
                worst = fmax(worst, half_error(&t, n, l, v));
        }
        print_message("# l within %d of v: error max %.6f\n", spread, worst);
        assert_true(worst <= bound);
    }
    half_close(&t);
}

/* sin^2 theta_h near 1: both directions together at the horizon. */
static void the_half_vector_at_the_horizon_agrees(void **state)
{
    (void)state;
    struct half_table t = half_noise(64, 32, 8, 15, 1, 0.05);
    double worst = 0;
    for (int i = 0; i < COUNT; i++) {
        struct vec3 l = half_direction(half_uniform(89, 89.998), 0), v = half_direction(half_uniform(89, 89.998), 0);
        v.y += (int32_t)(half_random() % 2001) - 1000;
        if (l.z > 0 && v.z > 0)
            worst = fmax(worst, half_error(&t, up, l, v));
    }
    assert_bound("theta_h near 90", worst, bound);
    half_close(&t);
}

/* theta_d near 90 degrees: l and v opposite each other at the horizon. For l = -v itself one of them is below. */
static void opposite_directions_agree(void **state)
{
    (void)state;
    struct half_table t = half_noise(64, 32, 8, 15, 1, 0.05);
    double worst = 0;
    for (int i = 0; i < COUNT; i++) {
        struct vec3 l = half_direction(90, 360.0 * i / COUNT), v = {-l.x, -l.y, 1 + (int32_t)(half_random() % 4)};
        l.z = 1 + (int32_t)(half_random() % 4);
        if (i % 2)
            v.y += (int32_t)(half_random() % 201) - 100;
        v = half_quantise(v.x, v.y, v.z);
        worst = fmax(worst, half_error(&t, up, l, v));
    }
    assert_bound("theta_d near 90", worst, 1.0 / 128); /* h has few units */
    for (int i = 0; i < 1000; i++) {
        struct lut_rgb out;
        struct vec3 n = half_any(), l = half_any(), v = {-l.x, -l.y, -l.z};
        assert_int_equal(lut_eval(&out, &t.lut, n, l, v), 0);
        assert_true(!out.c[0] && !out.c[1] && !out.c[2]);
    }
    half_close(&t);
}

/* Where theta_h + theta_d = 90 degrees the azimuth's coordinate changes its form. */
static void the_two_forms_of_the_azimuth_meet(void **state)
{
    (void)state;
    struct half_table t = half_noise(64, 32, 32, 15, 1, 0.05);
    double worst = 0;
    for (int i = 0; i < COUNT; i++) {
        /* in the frame of h: n at 90 - theta_d degrees from it, within a few units */
        double theta_d = half_uniform(0.5, 89.5), phi = half_uniform(0, 90);
        struct vec3 n = half_direction(90 - theta_d, phi), l = half_direction(theta_d, 0),
                    v = half_direction(theta_d, 180);
        n.x += (int32_t)(half_random() % 5) - 2;
        n.z += (int32_t)(half_random() % 5) - 2;
        if (fx_dot(n, l) > 0 && fx_dot(n, v) > 0)
            worst = fmax(worst, half_error(&t, n, l, v));
    }
    assert_bound("theta_h + theta_d near 90", worst, bound);
    half_close(&t);
}

static void cosines_of_one_step_agree(void **state)
{
    (void)state;
    struct half_table t = half_noise(64, 32, 8, 15, 1, 0.05);
    double worst = 0;
    for (int phi = 0; phi < 3600; phi++) {
        struct vec3 grazing = half_direction(90, 0), other = half_direction(phi % 90, phi * 0.1);
        grazing.z = 1;
        worst = fmax(worst, half_error(&t, up, grazing, other));
        worst = fmax(worst, half_error(&t, up, other, grazing));
        struct vec3 both = half_direction(90, phi * 0.1);
        both.z = 1;
        worst = fmax(worst, half_error(&t, up, grazing, both));
    }
    assert_bound("n.l or n.v of one step", worst, bound);
    half_close(&t);
}

/* n.l or n.v of single units of the product, 2^-30: the normal is not along an axis. */
static void cosines_of_one_unit_of_the_product_agree(void **state)
{
    (void)state;
    struct half_table t = half_noise(64, 32, 8, 15, 1, 0.05);
    double worst = 0;
    int found = 0;
    for (int i = 0; i < 4000000 && found < 2000; i++) {
        struct vec3 n = half_any(), l = half_any(), v = half_any();
        /* turn l until n.l is a unit or a few */
        int32_t nl = fx_dot(n, l) >> 15;
        l = half_quantise(l.x - nl * 0x1p-15 * n.x, l.y - nl * 0x1p-15 * n.y, l.z - nl * 0x1p-15 * n.z);
        if (fx_dot(n, l) > 0 && fx_dot(n, l) < 512 && fx_dot(n, v) > 0) {
            found++;
            worst = fmax(worst, half_error(&t, n, l, v));
        }
    }
    assert_int_equal(found, 2000);
    assert_bound("n.l below 2^-21", worst, bound);
    half_close(&t);
}

static void surfaces_facing_away_are_black_and_fetch_nothing(void **state)
{
    (void)state;
    struct half_table t = half_noise(8, 8, 8, 15, 1, 0.05);
    struct vec3 in = half_direction(30, 0), horizon = half_direction(90, 0);
    for (int i = 0; i < 1000; i++) {
        struct vec3 below = half_direction(90.01 + i * 0.08, i), above = half_direction(i * 0.08, i);
        struct vec3 opposite = {-above.x, -above.y, -above.z};
        const struct vec3 pairs[][2] = {{below, in},   {in, below},        {below, below},    {horizon, in},
                                        {in, horizon}, {horizon, horizon}, {opposite, above}, {above, opposite}};
        for (size_t k = 0; k < sizeof pairs / sizeof *pairs; k++) {
            struct lut_rgb out = {{1, 1, 1}, 1}, black = {{0, 0, 0}, 0};
            assert_int_equal(lut_eval(&out, &t.lut, up, pairs[k][0], pairs[k][1]), 0);
            assert_memory_equal(&out, &black, sizeof out);
        }
    }
    half_close(&t);
}

static void the_light_along_the_normal_does_not_depend_on_the_azimuth(void **state)
{
    (void)state;
    struct ref_material m = {.kind = REF_METALLIC_ROUGHNESS, .kd = {0.9, 0.5, 0.1}, .metalness = 1, .roughness = 0.3};
    struct half_table t = half_sampled(64, 32, 8, 0.09, ref_brdf_of_material, &m);
    double worst = 0;
    for (int theta = 1; theta < 89; theta++) {
        double least = 1e9, most = 0;
        for (int phi = 0; phi < 360; phi += 5) {
            double rgb[3], n[3] = {0, 0, 1};
            double v[3] = {sin(theta * degree) * cos(phi * degree), sin(theta * degree) * sin(phi * degree),
                           cos(theta * degree)};
            half_product(rgb, &t, n, n, v);
            least = fmin(least, rgb[0]);
            most = fmax(most, rgb[0]);
        }
        worst = fmax(worst, most / least - 1);
    }
    assert_bound("l = n, over azimuths", worst, 1.0 / 256); /* v is quantised */
    half_close(&t);
}

/* 1 - (n.h)^2 from 15-bit vectors is wrong by 0.16 degrees here. A table whose rows count 4, 8, 12 ... tells the half angle. */
static void half_angles_of_a_quarter_degree_keep_their_bits(void **state)
{
    (void)state;
    struct ref_half f = {.t = 2, .h = 128, .d = 2};
    uint32_t *texels = malloc(sizeof *texels * 2 * 128 * 2);
    for (uint32_t i = 0; i < 2 * 128 * 2; i++)
        texels[i] = (i / 2 % 128 * 4) | 24u << 27;
    f.texels = texels;
    ref_half_warp(&f, 0.002);
    struct half_table t = half_open(&f);
    double worst = 0, square = 0;
    for (int i = 0; i < COUNT; i++) {
        /* n at 0.25 degrees from h, in a frame turned at random */
        struct vec3 l = half_any(), v = half_any(), n;
        double h[3] = {l.x + v.x, l.y + v.y, l.z + v.z}, length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
        if (length < 32768) { /* theta_d below 60 degrees */
            i--;
            continue;
        }
        struct vec3 side = half_any();
        double s = (side.x * h[0] + side.y * h[1] + side.z * h[2]) / (length * length);
        double across[3] = {side.x - s * h[0], side.y - s * h[1], side.z - s * h[2]};
        double a = sqrt(across[0] * across[0] + across[1] * across[1] + across[2] * across[2]);
        double tangent = tan(0.25 * degree);
        n = half_quantise(h[0] / length + tangent * across[0] / a, h[1] / length + tangent * across[1] / a,
                          h[2] / length + tangent * across[2] / a);
        double dn[3] = {n.x, n.y, n.z}, dl[3] = {l.x, l.y, l.z}, dv[3] = {v.x, v.y, v.z}, rgb[3];
        struct lut_rgb out;
        ref_table_eval(rgb, t.ref, dn, dl, dv);
        assert_int_equal(lut_eval(&out, &t.lut, n, l, v), 8);
        /* one row is 4 / (n.l + n.v); rows per degree there, from the warp */
        double sum = (fx_dot(n, l) + (double)fx_dot(n, v)) * 0x1p-30,
               rows = asinh(sin(0.26 * degree) / 0.002) - asinh(sin(0.24 * degree) / 0.002);
        rows *= 127 / asinh(1 / 0.002) / 0.02;
        double off = fabs(ldexp(out.c[0], out.e) - rgb[0]) * sum / 4 / rows;
        worst = fmax(worst, off);
        square += off * off;
    }
    print_message("# at a half angle of 0.25 degrees: off by %.7f degrees rms, %.7f at most\n", sqrt(square / COUNT),
                  worst);
    assert_true(sqrt(square / COUNT) <= 0.0001 && worst <= 0.0005);
    half_close(&t);
}

/* Every node g: f (n.l + n.v) = g, and the albedo for a light of cosine c is 2 pi g (1 - c ln((1+c)/c)). */
static void a_constant_table_is_reproduced_exactly(void **state)
{
    static const uint32_t words[] = {0xffffffff,    0x00000000, 0x00000001, 15u << 27 | 0x00804020 | 256,
                                     31u << 27 | 1, 0x7d05f417};
    (void)state;
    for (size_t w = 0; w < sizeof words / sizeof *words; w++) {
        struct ref_half f = {.t = 5, .h = 7, .d = 3, .scale = (int)w - 2};
        uint32_t *texels = malloc(sizeof *texels * 5 * 7 * 3);
        double g[3], albedo[3];
        for (size_t i = 0; i < 5 * 7 * 3; i++)
            texels[i] = words[w];
        f.texels = texels;
        ref_half_warp(&f, 0.1);
        struct half_table t = half_open(&f);
        ref_rgb9e5_decode(g, words[w]);
        for (int i = 0; i < COUNT; i++) {
            struct lut_rgb out;
            struct vec3 l = half_direction(half_uniform(0, 89.99), half_uniform(0, 360));
            struct vec3 v = half_direction(half_uniform(0, 89.99), half_uniform(0, 360));
            double sum = (l.z + v.z) / 32768.0;
            assert_int_equal(lut_eval(&out, &t.lut, up, l, v), 8);
            for (int c = 0; c < 3; c++) {
                /* lengths of l and v are not quite one, the product knows their cosines to 2^-29, and rounds */
                double most =
                    fmax(g[0], fmax(g[1], g[2])) * (0x1p-14 + 0x1p-28 / sum) + ldexp(0.51, out.e - f.scale) * sum;
                assert_true(fabs(ldexp(out.c[c], out.e - f.scale) * sum - g[c]) <= most);
            }
        }
        for (int angle = 0; angle < 90; angle += 20) {
            double cosine = cos(angle * degree);
            double whole = 2 * 3.14159265358979323846 * (1 - cosine * log((1 + cosine) / cosine));
            ref_albedo(albedo, half_product, &t, angle * degree, 192);
            for (int c = 0; c < 3; c++)
                assert_true(fabs(ldexp(albedo[c], -f.scale) - g[c] * whole) <= 0.003 * g[c] * whole);
        }
        half_close(&t);
    }
}

static void the_largest_texels_next_to_the_smallest_agree(void **state)
{
    (void)state;
    struct ref_half f = {.t = 8, .h = 32, .d = 16};
    uint32_t *texels = malloc(sizeof *texels * 8 * 32 * 16);
    double worst = 0;
    for (unsigned i = 0; i < 8 * 32 * 16; i++) {
        uint32_t row = i / 8 % 32;
        texels[i] = row & 1 ? 0xffffffff : row % 4 ? 0x00040201 : 0; /* 65408, 2^-24, 0 */
    }
    f.texels = texels;
    ref_half_warp(&f, 0.1);
    struct half_table t = half_open(&f);
    for (int i = 0; i < COUNT; i++)
        worst = fmax(worst, half_error(&t, up, half_direction(half_uniform(0, 89.9), half_uniform(0, 360)),
                                       half_direction(half_uniform(0, 89.9), half_uniform(0, 360))));
    assert_bound("65408 next to 2^-24", worst, bound);
    half_close(&t);
}

/* Lengths off by up to 64 units: directions count, not lengths. */
static void vectors_of_wrong_length_change_little(void **state)
{
    (void)state;
    struct half_table t = half_noise(64, 32, 8, 15, 1, 0.05);
    double worst = 0;
    for (int i = 0; i < COUNT; i++) {
        struct vec3 v[3];
        for (int k = 0; k < 3; k++) {
            double length = 1 + (half_random() % 3 - 1.0) * 64 / 32768;
            v[k] = half_any();
            v[k] = (struct vec3){(int32_t)lrint(v[k].x * length), (int32_t)lrint(v[k].y * length),
                                 (int32_t)lrint(v[k].z * length)};
        }
        if (fx_dot(v[0], v[1]) > 0 && fx_dot(v[0], v[2]) > 0)
            worst = fmax(worst, half_error(&t, v[0], v[1], v[2]));
    }
    assert_bound("lengths off by 64 units", worst, 1.0 / 64);
    half_close(&t);
}

static int32_t any_component(void)
{
    static const int32_t extreme[] = {-32832, -32768, -1, 0, 1, 32768, 32832};
    uint32_t r = half_random();
    return r % 3 == 0 ? extreme[r / 3 % 7] : (int32_t)(r / 3 % (2 * 32832 + 1)) - 32832;
}

/* Any warp that lut_open accepts: steps anywhere. */
static void random_warp(uint16_t *warp, unsigned nodes, unsigned last)
{
    unsigned at = 0;
    for (unsigned i = 0; i < nodes; i++) {
        warp[i] = (uint16_t)at;
        if (half_random() % 4 == 0 && at < last)
            at += half_random() % (last - at);
    }
    warp[nodes - 1] = (uint16_t)last;
}

/* The sanitizers see an overflow or a read outside the texels, which end where the heap block ends. */
static void vectors_of_any_length_stay_inside_the_table(void **state)
{
    static const unsigned size[][3] = {{2, 2, 2}, {32, 2, 2}, {2, 128, 2}, {2, 2, 128}, {4, 128, 128}, {5, 7, 3}};
    unsigned lit = 0;
    (void)state;
    for (size_t s = 0; s < sizeof size / sizeof *size; s++) {
        struct ref_half f = {.t = size[s][0], .h = size[s][1], .d = size[s][2], .scale = s & 1 ? 16 : -16};
        uint32_t *texels = malloc(sizeof *texels * f.t * f.h * f.d);
        for (unsigned i = 0; i < f.t * f.h * f.d; i++)
            texels[i] = half_random();
        f.texels = texels;
        random_warp(f.warp_h, REF_WARP_H, 512 * (f.h - 1));
        random_warp(f.warp_d, REF_WARP_D, 512 * (f.d - 1));
        struct half_table t = half_open(&f);
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
        half_close(&t);
    }
    assert_in_range(lit, 200000, 600000);
}

/* --- whole materials --- */

/* The table, evaluated by the product, keeps the model's albedo up to grazing incidence. */
static void albedo_at_grazing_incidence_is_that_of_the_model(void **state)
{
    (void)state;
    struct ref_material m = {.kind = REF_METALLIC_ROUGHNESS, .kd = {0.8, 0.4, 0.1}, .metalness = 0, .roughness = 0.4};
    struct half_table t = half_sampled(96, 48, 8, 0.16, ref_brdf_of_material, &m);
    static const double angles[] = {0, 40, 60, 75, 85};
    for (size_t i = 0; i < sizeof angles / sizeof *angles; i++) {
        double got[3], want[3];
        ref_albedo(got, half_product, &t, angles[i] * degree, 160);
        ref_albedo(want, ref_brdf_of_material, &m, angles[i] * degree, 160);
        print_message("# albedo at %g degrees: %.4f, model %.4f\n", angles[i], got[0], want[0]);
        for (int c = 0; c < 3; c++)
            assert_true(fabs(got[c] - want[c]) <= 0.02 * want[0]);
    }
    half_close(&t);
}

/* A lobe of 4 degrees back to the light on a diffuse base. */
static void retroreflector(double rgb[3], const void *context, const double n[3], const double l[3], const double v[3])
{
    double width = *(const double *)context, square = 0;
    (void)n;
    for (int i = 0; i < 3; i++)
        square += (l[i] - v[i]) * (l[i] - v[i]);
    double lobe = exp(-square / (width * width));
    for (int c = 0; c < 3; c++)
        rgb[c] = 0.1 + lobe * (20 - 5 * c);
}

static void a_retroreflector_of_4_degrees_agrees(void **state)
{
    (void)state;
    const double width = 4 * degree;
    struct ref_half f = {.t = 4, .h = 24, .d = 64};
    ref_half_warp(&f, 1);
    for (unsigned k = 0; k < REF_WARP_D; k++) /* planes close together at theta_d = 0 */
        f.warp_d[k] = (uint16_t)lrint(512 * 63 * asinh(k / 64.0 / 0.005) / asinh(1 / 0.005));
    ref_half_sample(&f, retroreflector, &width);
    struct half_table t = half_open(&f);
    double square = 0, whole = 0;
    const double n[3] = {0, 0, 1};
    for (int i = 0; i < COUNT; i++) {
        double l[3], v[3], got[3], want[3];
        struct vec3 a = half_direction(half_uniform(0, 80), half_uniform(0, 360)), b = a;
        double spread = half_uniform(0, 12 * degree) * 32768;
        b.x += (int32_t)half_uniform(-spread, spread);
        b.y += (int32_t)half_uniform(-spread, spread);
        b = half_quantise(b.x, b.y, b.z);
        double la = sqrt((double)a.x * a.x + (double)a.y * a.y + (double)a.z * a.z),
               lb = sqrt((double)b.x * b.x + (double)b.y * b.y + (double)b.z * b.z);
        l[0] = a.x / la, l[1] = a.y / la, l[2] = a.z / la;
        v[0] = b.x / lb, v[1] = b.y / lb, v[2] = b.z / lb;
        half_product(got, &t, n, l, v);
        retroreflector(want, &width, n, l, v);
        square += (got[0] - want[0]) * (got[0] - want[0]) * l[2];
        whole += want[0] * want[0] * l[2];
    }
    print_message("# retroreflector: relative rms error %.4f\n", sqrt(square / whole));
    assert_true(sqrt(square / whole) <= 0.015);
    half_close(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_half_vector_along_the_normal_agrees),
        cmocka_unit_test(the_light_at_the_camera_agrees),
        cmocka_unit_test(the_half_vector_at_the_horizon_agrees),
        cmocka_unit_test(opposite_directions_agree),
        cmocka_unit_test(the_two_forms_of_the_azimuth_meet),
        cmocka_unit_test(cosines_of_one_step_agree),
        cmocka_unit_test(cosines_of_one_unit_of_the_product_agree),
        cmocka_unit_test(surfaces_facing_away_are_black_and_fetch_nothing),
        cmocka_unit_test(the_light_along_the_normal_does_not_depend_on_the_azimuth),
        cmocka_unit_test(half_angles_of_a_quarter_degree_keep_their_bits),
        cmocka_unit_test(a_constant_table_is_reproduced_exactly),
        cmocka_unit_test(the_largest_texels_next_to_the_smallest_agree),
        cmocka_unit_test(vectors_of_wrong_length_change_little),
        cmocka_unit_test(vectors_of_any_length_stay_inside_the_table),
        cmocka_unit_test(albedo_at_grazing_incidence_is_that_of_the_model),
        cmocka_unit_test(a_retroreflector_of_4_degrees_agrees),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
