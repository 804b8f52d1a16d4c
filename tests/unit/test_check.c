/* gtlut check: each thing that can be wrong with a measurement is found, nothing else is, and the repair is marked. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "host_check.h"
#include "host_import.h"
#include "importer_fixture.h"

/* theta_in 0, 20, 40, 60; theta_out 0..75 in steps of 3, phi_out in steps of 5 degrees. */
enum { ROWS = 26, COLUMNS = 72, SLICES = 4, CELLS = ROWS * COLUMNS };

typedef double brdf(double theta_in, double theta_out, double phi);

static double times_cosine(double theta_in, double theta_out, double phi)
{
    return fixture_brdf(theta_in, theta_out, phi) * cos(theta_out * fixture_pi / 180);
}

static double over_cosine(double theta_in, double theta_out, double phi)
{
    return fixture_brdf(theta_in, theta_out, phi) / cos(theta_out * fixture_pi / 180);
}

static double white(double theta_in, double theta_out, double phi)
{
    (void)theta_in;
    (void)theta_out;
    (void)phi;
    return 1 / fixture_pi;
}

static double bright(double theta_in, double theta_out, double phi)
{
    return 1.2 * white(theta_in, theta_out, phi);
}

static double skewed(double theta_in, double theta_out, double phi)
{
    return fixture_brdf(theta_in, theta_out, phi) * (1 + theta_in / 60);
}

static void make(struct measurement *m, brdf *f)
{
    measurement_init(m, "made");
    for (int i = 0; i < SLICES; i++)
        for (int j = 0; j < ROWS; j++)
            for (int k = 0; k < COLUMNS; k++) {
                float x = (float)f(20 * i, 3 * j, 5 * k);
                measurement_add(m, &(struct measurement_point){
                                       20.0f * (float)i, 3.0f * (float)j, 5.0f * (float)k, {x, x, x}, MEASURED});
            }
}

static struct measurement_point *at(struct measurement *m, int slice, int row, int column)
{
    return &m->points[(slice * ROWS + row) * COLUMNS + column];
}

static const struct measurement_geometry *geometry(void)
{
    return measurement_geometry_find("minidiff");
}

static void check_of(struct check *c, brdf *f)
{
    struct measurement m;
    make(&m, f);
    check_make(c, &m, geometry());
    measurement_free(&m);
}

static void a_sound_measurement_has_no_faults(void **state)
{
    (void)state;
    struct check c;
    check_of(&c, fixture_brdf);
    assert_int_equal(c.points, SLICES * CELLS);
    assert_int_equal(c.nan + c.infinite + c.negative + c.doubled + c.missing + c.blind + c.outliers + c.irregular, 0);
    assert_null(c.grid_problem);
    assert_int_equal(c.quantity, CHECK_BRDF);
    assert_true(c.reciprocity[0] < 0.02 && c.reciprocity[1] > 0.2 && c.reciprocity[2] > 0.2);
    assert_int_equal(c.count, SLICES);
    for (int i = 0; i < SLICES; i++)
        assert_true(fabs(c.slices[i].covered - 0.933) < 1e-3); /* sin^2 75 */
    check_free(&c);
}

static void one_plane_is_not_the_hemisphere(void **state)
{
    (void)state;
    static const int steps[] = {36, 18, 6}; /* columns apart: 180, 90, 30 degrees */
    for (int n = 0; n < 3; n++) {
        struct measurement all, m;
        struct check c;
        make(&all, fixture_brdf);
        measurement_init(&m, "made");
        for (size_t i = 0; i < all.count; i++)
            if (i % COLUMNS % (size_t)steps[n] == 0)
                measurement_add(&m, &all.points[i]);
        check_make(&c, &m, geometry());
        assert_true(fabs(c.phi_gap - 5 * steps[n]) < 1e-6);
        assert_int_equal(c.coverage_problem != NULL, n < 2);
        /* Light along the normal needs one azimuth; off it, each stands for 30 degrees. */
        assert_true(fabs(c.slices[0].covered - 0.933) < 1e-3);
        assert_true(fabs(c.slices[1].covered - 0.933 * (COLUMNS / steps[n]) * 30 / 360) < 1e-3);
        assert_true(fabs(c.covered_least - c.slices[1].covered) < 1e-9);
        check_free(&c);
        measurement_free(&m);
        measurement_free(&all);
    }
}

static void a_cap_around_the_normal_is_not_the_hemisphere(void **state)
{
    (void)state;
    struct measurement all, m;
    struct check c;
    make(&all, fixture_brdf);
    measurement_init(&m, "made");
    for (size_t i = 0; i < all.count; i++)
        if (all.points[i].theta_out < 25)
            measurement_add(&m, &all.points[i]);
    check_make(&c, &m, geometry());
    assert_non_null(c.coverage_problem);
    assert_true(c.covered_least < 0.2);
    check_free(&c);
    measurement_free(&m);
    measurement_free(&all);
}

static void albedo_is_exact_for_a_constant_and_above_1_is_seen(void **state)
{
    (void)state;
    struct check c;
    check_of(&c, white);
    for (int i = 0; i < SLICES; i++)
        for (int k = 0; k < 3; k++) {
            assert_true(fabs(c.slices[i].albedo[k] - 0.9330127) < 1e-5);
            assert_true(fabs(c.slices[i].albedo_carried[k] - 1) < 1e-6);
        }
    check_free(&c);
    check_of(&c, bright);
    assert_true(fabs(check_albedo_max(&c) - 1.2) < 1e-5);
    check_free(&c);
}

static void a_cosine_too_much_or_too_little_is_told_and_undone(void **state)
{
    (void)state;
    static brdf *const stored[] = {fixture_brdf, times_cosine, over_cosine};
    static const enum check_quantity want[] = {CHECK_BRDF, CHECK_TIMES_COSINE, CHECK_OVER_COSINE};
    for (int i = 0; i < 3; i++) {
        struct check c;
        struct measurement back;
        check_of(&c, stored[i]);
        assert_int_equal(c.quantity, want[i]);
        assert_int_equal(check_repair(&c, false), 0);
        check_measurement(&back, &c, "made");
        for (size_t k = 0; k < back.count; k++) {
            const struct measurement_point *p = &back.points[k];
            double f = fixture_brdf((double)p->theta_in, (double)p->theta_out, (double)p->phi_out);
            assert_true(fabs((double)p->rgb[1] - f) < 1e-5 * f && p->mark == MEASURED);
        }
        check_free(&c);
        measurement_free(&back);
    }
}

/* Without pairs of angles of incidence only the trend is left: of a diffuse surface it says as much. */
static void a_single_angle_of_incidence_is_judged_by_its_trend(void **state)
{
    (void)state;
    static brdf *const stored[] = {fixture_brdf, times_cosine, over_cosine};
    static const enum check_quantity want[] = {CHECK_BRDF, CHECK_TIMES_COSINE, CHECK_OVER_COSINE};
    for (int i = 0; i < 3; i++) {
        struct check c;
        struct measurement m;
        measurement_init(&m, "made");
        for (int j = 0; j < ROWS; j++)
            for (int k = 0; k < 8; k++) {
                /* a third of the mixture's lobe is left out: nearly diffuse */
                double f = stored[i](0, 3 * j, 45 * k) / fixture_brdf(0, 3 * j, 45 * k);
                measurement_add(&m,
                                &(struct measurement_point){0, 3.0f * (float)j, 45.0f * (float)k, {(float)f, 1, 1}, 0});
                m.points[m.count - 1].rgb[1] = m.points[m.count - 1].rgb[2] = (float)f;
            }
        check_make(&c, &m, geometry());
        assert_int_equal(c.reciprocal_pairs, 0);
        assert_int_equal(c.quantity, want[i]);
        check_free(&c);
        measurement_free(&m);
    }
}

static void a_broken_reciprocity_is_measured(void **state)
{
    (void)state;
    struct check c;
    check_of(&c, skewed);
    assert_true(c.reciprocity[0] > 0.15 && c.reciprocity[0] < 0.6);
    check_free(&c);
}

static void single_bad_samples_are_counted_filled_and_marked(void **state)
{
    (void)state;
    struct measurement m, back;
    struct check c;
    make(&m, fixture_brdf);
    at(&m, 1, 10, 20)->rgb[0] = NAN;
    at(&m, 2, 25, 0)->rgb[1] = INFINITY;
    at(&m, 0, 5, 5)->rgb[2] = -0.5f;
    for (int c3 = 0; c3 < 3; c3++) {
        at(&m, 3, 15, 60)->rgb[c3] *= 3;
        at(&m, 3, 5, 71)->rgb[c3] *= 0.3f;
    }
    *at(&m, 1, 0, 0) = *at(&m, 1, 0, 1); /* one doubled; the pole's own is one of many */
    *at(&m, 2, 12, 12) = m.points[--m.count];
    check_make(&c, &m, geometry());
    assert_int_equal(c.nan, 1);
    assert_int_equal(c.infinite, 1);
    assert_int_equal(c.negative, 1);
    assert_int_equal(c.outliers, 2);
    assert_int_equal(c.doubled, 1);
    assert_int_equal(c.missing, 1);
    assert_int_equal(c.blind, 0);
    assert_non_null(c.grid_problem);
    assert_int_equal(check_repair(&c, false), 5);
    check_measurement(&back, &c, "made");
    char *problem = measurement_grid_problem(&back);
    assert_null(problem);
    assert_int_equal(back.count, SLICES * CELLS);
    size_t filled = 0;
    for (size_t i = 0; i < back.count; i++) {
        const struct measurement_point *p = &back.points[i];
        double f = fixture_brdf((double)p->theta_in, (double)p->theta_out, (double)p->phi_out);
        filled += p->mark == MEASUREMENT_FILLED;
        /* the sample whose blue was negative keeps its red and green */
        if (!(fabs((double)p->rgb[0] - f) < (p->mark ? 0.1 : 1e-6) * f))
            fail_msg("%g %g %g: %g, want %g", p->theta_in, p->theta_out, p->phi_out, p->rgb[0], f);
    }
    assert_int_equal(filled, 5);
    check_free(&c);
    measurement_free(&m);
    measurement_free(&back);
}

static bool hidden(const struct measurement_point *p, double radius)
{
    return check_distance((double)p->theta_in, (double)p->theta_out, (double)p->phi_out, false) < radius;
}

/* What the light's own arm hides, as gaps, as zeros and as NaN; at the normal, too. */
static void the_blind_spot_is_found_and_interpolated_across(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        struct measurement m, whole;
        struct check c;
        make(&whole, fixture_brdf);
        measurement_init(&m, "made");
        size_t gone = 0;
        for (size_t i = 0; i < whole.count; i++) {
            struct measurement_point p = whole.points[i];
            bool blind = hidden(&p, 7) && p.theta_in > 0;
            gone += blind;
            for (int c3 = 0; c3 < 3 && blind; c3++)
                p.rgb[c3] = kind == 1 ? 0 : NAN;
            if (kind || !blind)
                measurement_add(&m, &p);
        }
        check_make(&c, &m, geometry());
        assert_true(gone > 50);
        assert_int_equal(c.blind, gone);
        assert_true(c.blind_radius > 5 && c.blind_radius < 7);
        assert_int_equal(c.missing, 0);
        check_free(&c);
        check_fill_blind_spot(&m, "made");
        size_t filled = 0;
        for (size_t i = 0; i < m.count; i++) {
            const struct measurement_point *p = &m.points[i];
            double f = fixture_brdf((double)p->theta_in, (double)p->theta_out, (double)p->phi_out);
            assert_int_equal(p->mark, hidden(p, 7) && p->theta_in > 0 ? MEASUREMENT_FILLED : MEASURED);
            filled += p->mark == MEASUREMENT_FILLED;
            if (!(fabs((double)p->rgb[2] - f) < (p->mark ? 0.03 : 1e-6) * f))
                fail_msg("%g %g %g: %g, want %g", p->theta_in, p->theta_out, p->phi_out, p->rgb[2], f);
        }
        assert_int_equal(filled, gone);
        check_make(&c, &m, geometry());
        assert_int_equal(c.blind, 0);
        assert_int_equal(c.filled, gone);
        assert_null(c.grid_problem);
        check_free(&c);
        measurement_free(&m);
        measurement_free(&whole);
    }
}

/* A material that is black towards the light from some angle on has no blind spot. */
static double fading(double theta_in, double theta_out, double phi)
{
    return check_distance(theta_in, theta_out, phi, false) < 40 && theta_in > 0 ? 1e-6 : 0.3;
}

static void darkness_that_goes_on_is_no_blind_spot(void **state)
{
    (void)state;
    struct check c;
    check_of(&c, fading);
    assert_int_equal(c.blind, 0);
    check_free(&c);
}

static double sharp(double theta_in, double theta_out, double phi)
{
    double d = check_distance(theta_in, theta_out, phi, true);
    return 0.1 + 500 * exp(-d * d / 2);
}

static void a_lobe_narrower_than_the_grid_is_no_outlier(void **state)
{
    (void)state;
    struct check c;
    check_of(&c, sharp);
    assert_int_equal(c.outliers, 0);
    check_free(&c);
}

static void noise_is_no_outlier_but_a_spike_in_it_is(void **state)
{
    (void)state;
    for (int percent = 1; percent <= 10; percent += 9) {
        struct measurement m;
        struct check c;
        uint32_t random = 3;
        make(&m, fixture_brdf);
        for (size_t i = 0; i < m.count; i++) {
            double gauss = 0; /* of twelve */
            for (int k = 0; k < 12; k++) {
                random = random * 1664525 + 1013904223;
                gauss += (random >> 8) * 0x1p-24 - 0.5;
            }
            for (int k = 0; k < 3; k++)
                m.points[i].rgb[k] *= (float)(1 + 0.01 * percent * gauss);
        }
        check_make(&c, &m, geometry());
        assert_int_equal(c.outliers, 0);
        check_free(&c);
        for (int k = 0; k < 3; k++)
            at(&m, 2, 12, 50)->rgb[k] *= 4;
        check_make(&c, &m, geometry());
        assert_int_equal(c.outliers, 1);
        check_free(&c);
        measurement_free(&m);
    }
}

/* The files hold BRDFs; times and over the cosine they would be told, although their reciprocity is off by up to 0.8. */
static void real_materials_are_judged_right_in_all_three_forms(void **state)
{
    (void)state;
    static const char *const names[] = {"paper_white", "cc_ibiza_sunset", "satin_rosaline", "colodur_napoli_4f"};
    const char *data = getenv("GONIOTILE_DATA");
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        for (int form = 0; form < 3; form++) {
            static const int power[] = {[CHECK_BRDF] = 0, [CHECK_TIMES_COSINE] = 1, [CHECK_OVER_COSINE] = -1};
            struct import_options options = {.geometry = geometry()};
            struct measurement m;
            struct check c;
            char *path = xasprintf("%s/brdf/%s_rgb.bsdf", data ? data : "../shared/data", names[i]);
            if (access(path, R_OK)) {
                free(path);
                skip();
            }
            import_read(&m, path, &options);
            for (size_t k = 0; k < m.count; k++)
                for (int channel = 0; channel < 3; channel++)
                    m.points[k].rgb[channel] *=
                        (float)pow(cos((double)m.points[k].theta_out * fixture_pi / 180), power[form]);
            check_make(&c, &m, geometry());
            if ((int)c.quantity != form)
                fail_msg("%s in form %d is taken for %d, exponent %g", names[i], form, c.quantity, c.exponent);
            check_free(&c);
            measurement_free(&m);
            free(path);
        }
}

static void scattered_samples_are_resampled_and_their_faults_counted(void **state)
{
    (void)state;
    struct measurement m;
    struct check c;
    measurement_init(&m, "made");
    for (int i = 0; i < SLICES; i++)
        for (int k = 0; k < 600; k++) {
            double theta = acos(1 - 0.8 * (k + 0.5) / 600) * 180 / fixture_pi, phi = fmod(137.50776405 * k, 360);
            float x = (float)over_cosine(20 * i, theta, phi);
            measurement_add(
                &m, &(struct measurement_point){20.0f * (float)i, (float)theta, (float)phi, {x, x, x}, MEASURED});
        }
    m.points[5].rgb[0] = NAN;
    m.points[700].rgb[1] = -1;
    check_make(&c, &m, geometry());
    assert_int_equal(c.irregular, 4 * 600);
    assert_int_equal(c.nan, 1);
    assert_int_equal(c.negative, 1);
    assert_non_null(c.grid_problem);
    assert_int_equal(c.quantity, CHECK_OVER_COSINE);
    check_free(&c);
    measurement_free(&m);
}

static void nothing_but_nan_is_survived(void **state)
{
    (void)state;
    struct measurement m;
    struct check c;
    make(&m, fixture_brdf);
    for (size_t i = 0; i < m.count; i++)
        m.points[i].rgb[0] = NAN;
    check_make(&c, &m, geometry());
    assert_int_equal(c.nan, m.count);
    check_repair(&c, false);
    check_free(&c);
    m.points[0].theta_out = 1.23f; /* scattered, and nothing finite */
    m.count = 7;
    for (int i = 0; i < 7; i++)
        m.points[i].phi_out = 11.1f * (float)i, m.points[i].theta_out = 9.1f * (float)i;
    check_make(&c, &m, geometry());
    assert_int_equal(c.count, 0);
    check_repair(&c, false);
    check_free(&c);
    measurement_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sound_measurement_has_no_faults),
        cmocka_unit_test(one_plane_is_not_the_hemisphere),
        cmocka_unit_test(a_cap_around_the_normal_is_not_the_hemisphere),
        cmocka_unit_test(albedo_is_exact_for_a_constant_and_above_1_is_seen),
        cmocka_unit_test(a_cosine_too_much_or_too_little_is_told_and_undone),
        cmocka_unit_test(a_single_angle_of_incidence_is_judged_by_its_trend),
        cmocka_unit_test(a_broken_reciprocity_is_measured),
        cmocka_unit_test(single_bad_samples_are_counted_filled_and_marked),
        cmocka_unit_test(the_blind_spot_is_found_and_interpolated_across),
        cmocka_unit_test(darkness_that_goes_on_is_no_blind_spot),
        cmocka_unit_test(a_lobe_narrower_than_the_grid_is_no_outlier),
        cmocka_unit_test(noise_is_no_outlier_but_a_spike_in_it_is),
        cmocka_unit_test(real_materials_are_judged_right_in_all_three_forms),
        cmocka_unit_test(scattered_samples_are_resampled_and_their_faults_counted),
        cmocka_unit_test(nothing_but_nan_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
