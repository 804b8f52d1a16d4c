/* gtlut fit: known parameters are found again, within their bounds, whatever the seed. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "host_fit.h"
#include "importer_fixture.h"

/* The models as SPEC.md has them, written from there. Angles in radians. */
static void model(double rgb[3], enum fit_model which, const double *p, double ti, double to, double phi)
{
    double l[3] = {sin(ti), 0, cos(ti)}, v[3] = {sin(to) * cos(phi), sin(to) * sin(phi), cos(to)};
    double h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]}, length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    double nh = h[2] / length, lh = length / 2, vr = -l[0] * v[0] - l[1] * v[1] + l[2] * v[2];
    double alpha = p[4] * p[4], d = alpha / (nh * nh * (alpha * alpha - 1) + 1);
    double visible = 0.5 / ((1 - alpha) * 2 * l[2] * v[2] + alpha * (l[2] + v[2]));
    for (int c = 0; c < 3; c++) {
        if (which == FIT_LAFORTUNE_PHONG)
            rgb[c] = p[c] / fixture_pi + p[3 + c] * (p[6] + 2) / (2 * fixture_pi) * pow(fmax(vr, 0), p[6]);
        else if (which == FIT_BLINN_PHONG)
            rgb[c] = (p[c] + p[3 + c] * pow(nh, p[6]) / l[2]) / fixture_pi;
        else {
            double f0 = 0.04 * (1 - p[3]) + p[c] * p[3], f = f0 + (1 - f0) * pow(1 - lh, 5);
            rgb[c] = d * d / fixture_pi * visible * f + (1 - f) * (1 - p[3]) * p[c] / fixture_pi;
        }
    }
}

/* theta_in 0, 20, 40, 60; theta_out in steps of 4, phi_out of 15 degrees; relative noise. */
static void measure(struct measurement_grid *g, enum fit_model which, const double *p, double noise, double scale)
{
    struct measurement m;
    uint32_t random = 5;
    measurement_init(&m, "model");
    for (int i = 0; i <= 60; i += 20)
        for (int j = 0; j <= 76; j += 4)
            for (int k = 0; k < 360; k += 15) {
                double rgb[3];
                const double d = fixture_pi / 180;
                struct measurement_point point = {(float)i, (float)j, (float)k, {0}, MEASURED};
                model(rgb, which, p, i * d, j * d, k * d);
                for (int c = 0; c < 3; c++) {
                    random = random * 1664525 + 1013904223;
                    point.rgb[c] = (float)(scale * rgb[c] * (1 + noise * ((random >> 8) * 0x1p-23 - 1)));
                }
                measurement_add(&m, &point);
            }
    measurement_grid_make(g, &m, "model");
    measurement_free(&m);
}

static const double known[][FIT_PARAMETERS] = {
    {0.3, 0.1, 0.02, 0.2, 0.25, 0.3, 40},
    {0.05, 0.5, 0.4, 0.02, 0.6, 0.9, 7},
    {0.2, 0.2, 0.2, 0.5, 0.1, 0.05, 300},
};
static const double known_ggx[][FIT_PARAMETERS] = {
    {0.6, 0.3, 0.1, 0.0, 0.45}, {0.9, 0.7, 0.3, 1.0, 0.3}, {0.4, 0.5, 0.6, 0.5, 0.8}};

static void expect_found(enum fit_model which, const double *p, double noise, double tolerance, uint64_t seed)
{
    struct measurement_grid g;
    struct fit fit;
    measure(&g, which, p, noise, 1);
    fit_make(&fit, which, &g, seed, "model");
    for (int i = 0; i < fit.count; i++)
        if (!(fabs(fit.parameter[i] - p[i]) <= tolerance * fmax(p[i], 0.1)))
            fail_msg("model %d parameter %d: %g, want %g (error %g)", which, i, fit.parameter[i], p[i], fit.error);
    assert_true(fit.error <= noise + 0.01 * tolerance);
    assert_int_equal(fit.samples, 4 * 20 * 24);
    assert_in_range(fit.agreed, 1, FIT_STARTS);
    measurement_grid_free(&g);
}

static void known_parameters_are_found(void **state)
{
    (void)state;
    for (int i = 0; i < 3; i++) {
        expect_found(FIT_LAFORTUNE_PHONG, known[i], 0, 1e-3, 1);
        expect_found(FIT_BLINN_PHONG, known[i], 0, 1e-3, 1);
    }
    /* At a bound the sine of the search is flat and the end is reached in small steps. */
    for (int i = 0; i < 3; i++)
        expect_found(FIT_GGX, known_ggx[i], 0, 0.01, 1);
}

static void known_parameters_are_found_under_noise_from_any_seed(void **state)
{
    (void)state;
    for (uint64_t seed = 2; seed < 4; seed++) {
        expect_found(FIT_LAFORTUNE_PHONG, known[0], 0.05, 0.05, seed);
        expect_found(FIT_GGX, known_ggx[0], 0.05, 0.05, seed);
    }
}

static void the_same_seed_gives_the_same_fit(void **state)
{
    (void)state;
    struct measurement_grid g;
    struct fit a, b;
    measure(&g, FIT_GGX, known_ggx[0], 0.1, 1);
    fit_make(&a, FIT_LAFORTUNE_PHONG, &g, 9, "model");
    fit_make(&b, FIT_LAFORTUNE_PHONG, &g, 9, "model");
    assert_memory_equal(a.parameter, b.parameter, sizeof a.parameter);
    assert_true(a.error == b.error && a.agreed == b.agreed);
    measurement_grid_free(&g);
}

/* A material four times as bright as any: parameters stay where a scene file allows them. */
static void parameters_stay_in_their_bounds(void **state)
{
    (void)state;
    for (int which = 0; which < FIT_MODELS; which++) {
        struct measurement_grid g;
        struct fit fit;
        measure(&g, (enum fit_model)which, which == FIT_GGX ? known_ggx[1] : known[1], 0, 8);
        fit_make(&fit, (enum fit_model)which, &g, 1, "model");
        for (int i = 0; i < fit.count; i++)
            assert_true(fit.parameter[i] >= 0 && fit.parameter[i] <= (i == 6 ? 4096.001 : 1));
        assert_true(fit.error > 0.3 && fit.error < 1);
        measurement_grid_free(&g);
    }
}

/* A mirror's peak beyond what a scene file allows: what can be fitted, the colour besides it, is not given up for it. */
static void a_peak_out_of_reach_leaves_the_rest_as_it_is(void **state)
{
    static const double p[] = {0.2, 0.1, 0.05, 8, 8, 8, 60};
    (void)state;
    struct measurement_grid g;
    struct fit fit;
    measure(&g, FIT_BLINN_PHONG, p, 0, 1);
    fit_make(&fit, FIT_BLINN_PHONG, &g, 1, "model");
    for (int i = 0; i < 3; i++)
        if (!(fabs(fit.parameter[i] - p[i]) < 0.35 * p[i]))
            fail_msg("kd %d: %g, want %g", i, fit.parameter[i], p[i]);
    measurement_grid_free(&g);
}

static void extrapolated_samples_do_not_count(void **state)
{
    (void)state;
    struct measurement_grid g;
    struct fit fit;
    measure(&g, FIT_LAFORTUNE_PHONG, known[0], 0, 1);
    for (size_t i = 0; i < g.slices[3].theta_count * g.slices[3].phi_count; i++) {
        g.slices[3].mark[i] = MEASUREMENT_EXTRAPOLATED;
        g.slices[3].rgb[3 * i] = 1000;
    }
    fit_make(&fit, FIT_LAFORTUNE_PHONG, &g, 1, "model");
    assert_int_equal(fit.samples, 3 * 20 * 24);
    assert_true(fabs(fit.parameter[0] - 0.3) < 1e-3);
    measurement_grid_free(&g);
}

static void fit_black(const struct bytes *b)
{
    (void)b;
    struct measurement_grid g;
    struct fit fit;
    measure(&g, FIT_GGX, known_ggx[0], 0, 0);
    fit_make(&fit, FIT_GGX, &g, 1, "black.gtm");
}

static void black_is_refused(void **state)
{
    (void)state;
    assert_int_equal(exit_code_of(fit_black, NULL), EXIT_BAD_INPUT);
    assert_non_null(strstr(child_message, "nothing to fit"));
}

/* fit_value is the model of the specification, too. */
static void fit_value_is_the_model(void **state)
{
    (void)state;
    for (int which = 0; which < FIT_MODELS; which++) {
        struct fit fit = {.model = (enum fit_model)which};
        struct brdf_source source;
        memcpy(fit.parameter, which == FIT_GGX ? known_ggx[2] : known[0], sizeof fit.parameter);
        fit_source(&source, &fit);
        for (int i = 0; i < 200; i++) {
            double ti = 0.007 * i, to = fmod(0.31 * i, 1.5), phi = 0.9 * i, want[3], rgb[3];
            const double l[3] = {sin(ti), 0, cos(ti)}, v[3] = {sin(to) * cos(phi), sin(to) * sin(phi), cos(to)};
            model(want, (enum fit_model)which, fit.parameter, ti, to, phi);
            source.value(rgb, source.ctx, l, v);
            for (int c = 0; c < 3; c++)
                assert_true(fabs(rgb[c] - want[c]) <= 1e-9 * (1 + want[c]));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_parameters_are_found),
        cmocka_unit_test(known_parameters_are_found_under_noise_from_any_seed),
        cmocka_unit_test(the_same_seed_gives_the_same_fit),
        cmocka_unit_test(parameters_stay_in_their_bounds),
        cmocka_unit_test(a_peak_out_of_reach_leaves_the_rest_as_it_is),
        cmocka_unit_test(extrapolated_samples_do_not_count),
        cmocka_unit_test(black_is_refused),
        cmocka_unit_test(fit_value_is_the_model),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
