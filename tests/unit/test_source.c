/* BRDF sources: every kind gives the values of the file it was opened from. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common.h"
#include "host_half_vector.h"
#include "host_source.h"
#include "importer_fixture.h"
#include "ref_table.h"

static const double pi = 3.14159265358979323846;
static const double degree = 3.14159265358979323846 / 180;

static void direction(double d[3], double theta, double phi)
{
    d[0] = sin(theta * degree) * cos(phi * degree);
    d[1] = sin(theta * degree) * sin(phi * degree);
    d[2] = cos(theta * degree);
}

/* Pairs that cover the hemisphere, at no angle that any grid has. */
static void pair(double l[3], double v[3], int i)
{
    direction(l, fmod(i * 37.13, 84) + 0.31, i * 11.7);
    direction(v, fmod(i * 53.71, 84) + 0.47, i * 71.3);
}

/* --- shifted-gamma fits --- */

static const char fit_header[] =
    "material,rhoD_r,rhoD_g,rhoD_b,rhoS_r,rhoS_g,rhoS_b,alpha_r,alpha_g,alpha_b,p_r,p_g,p_b,"
    "f0_r,f0_g,f0_b,f1_r,f1_g,f1_b,kap_r,kap_g,kap_b,lam_r,lam_g,lam_b,c_r,c_g,c_b,k_r,k_g,"
    "k_b,theta0_r,theta0_g,theta0_b\n";
static const char fit_row[] = "paint,.1,.2,.3,.04,.05,.06,.2,.25,.3,.5,.6,.7,.04,.05,.06,-.7,-.6,-.5,40,30,20,2,2.5,3,"
                              "1e-4,2e-4,3e-4,20,18,16,.2,.1,-.1\n";

static char *write_temporary(const char *name, const void *data, size_t bytes)
{
    static char path[256];
    snprintf(path, sizeof path, "/tmp/goniotile_%d_%s", (int)getpid(), name);
    write_file(path, data, bytes);
    return path;
}

/* The formula of the paper, by the angles. */
static double fit_value(int c, double theta_h, double theta_d, double theta_l, double theta_v)
{
    const double rho_d[] = {.1, .2, .3}, rho_s[] = {.04, .05, .06}, alpha[] = {.2, .25, .3}, p[] = {.5, .6, .7},
                 f0[] = {.04, .05, .06}, f1[] = {-.7, -.6, -.5}, kap[] = {40, 30, 20}, lam[] = {2, 2.5, 3},
                 cc[] = {1e-4, 2e-4, 3e-4}, k[] = {20, 18, 16}, theta0[] = {.2, .1, -.1};
    double fresnel = f0[c] - cos(theta_d) * f1[c] + pow(1 - cos(theta_d), 5) * (1 - f0[c]), g = 1;
    for (int i = 0; i < 2; i++) {
        double beyond = (i ? theta_v : theta_l) - theta0[c];
        double one = 1 + lam[c] * (1 - exp(cc[c] * (beyond > 0 ? pow(beyond, k[c]) : 0)));
        g *= one < 0 ? 0 : one > 1 ? 1 : one;
    }
    double a = alpha[c] + pow(tan(theta_h), 2) / alpha[c];
    double d = kap[c] * exp(-a) / (pi * pow(a, p[c]) * pow(cos(theta_h), 4));
    return fmax(0, rho_d[c] + rho_s[c] * fresnel * d * g / (cos(theta_l) * cos(theta_v))) / pi;
}

static void fits_are_evaluated_by_their_formula(void **state)
{
    (void)state;
    char *text = xasprintf("%s%s", fit_header, fit_row), *path = write_temporary("fits.csv", text, strlen(text));
    char *name = xasprintf("%s:paint", path), (*names)[64];
    struct brdf_source s;
    source_open(&s, name);
    assert_int_equal(source_fit_names(&names, path), 1);
    assert_string_equal(names[0], "paint");
    for (int i = 1; i < 500; i++) {
        double l[3], v[3], rgb[3], h[3], cosine = 0, length = 0;
        pair(l, v, i);
        for (int k = 0; k < 3; k++) {
            h[k] = l[k] + v[k];
            length += h[k] * h[k];
            cosine += l[k] * v[k];
        }
        s.value(rgb, s.ctx, l, v);
        for (int c = 0; c < 3; c++) {
            double want = fit_value(c, acos(h[2] / sqrt(length)), acos(cosine) / 2, acos(l[2]), acos(v[2]));
            assert_true(fabs(rgb[c] - want) <= 1e-9 + 1e-6 * want);
        }
    }
    source_close(&s);
    free(names);
    free(name);
    free(text);
    unlink(path);
}

static void open_fit(const struct bytes *b)
{
    struct brdf_source s;
    char *path = write_temporary("bad.csv", b->data, b->count), *name = xasprintf("%s:paint", path);
    source_open(&s, name);
}

static void open_table(const struct bytes *b)
{
    struct brdf_source s;
    source_open(&s, write_temporary("bad.csv", b->data, b->count));
}

static void bad_fits_are_refused(void **state)
{
    (void)state;
    char *bad[] = {xasprintf("material,rhoD_r\n%s", fit_row),
                   xasprintf("%spaint,1,2\n", fit_header),
                   xasprintf("%sother%s", fit_header, fit_row + 5),
                   xasprintf("%.*s,4\n", (int)(sizeof fit_row - 2), ""),
                   xasprintf("%s%.*s,4\n", fit_header, (int)(sizeof fit_row - 2), fit_row),
                   xasprintf("%spaint,x%s", fit_header, fit_row + 6)};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct bytes b = {(uint8_t *)bad[i], strlen(bad[i])};
        assert_int_equal(exit_code_of(open_fit, &b), EXIT_BAD_INPUT);
        free(bad[i]);
    }
    unlink(write_temporary("bad.csv", "", 0));
}

/* --- measurements --- */

/* Smooth, reciprocal, with a lobe. */
static void smooth_value(double rgb[3], const double l[3], const double v[3])
{
    double h2 = 0, t2 = (l[0] + v[0]) * (l[0] + v[0]) + (l[1] + v[1]) * (l[1] + v[1]);
    for (int k = 0; k < 3; k++)
        h2 += (l[k] + v[k]) * (l[k] + v[k]);
    for (int c = 0; c < 3; c++)
        rgb[c] = 0.1 + 0.05 * c + 0.4 * exp(-20 * t2 / h2) * (1 + c);
}

static void measured(struct brdf_source *out, double theta_step, int theta_count, int theta_out_max)
{
    struct measurement m;
    struct measurement_grid grid;
    measurement_init(&m, "smooth");
    for (int i = 0; i < theta_count; i++)
        for (int o = 0; o <= theta_out_max; o++)
            for (int phi = 0; phi < 360; phi += 2) {
                double l[3], v[3], rgb[3];
                direction(l, i * theta_step, 0);
                direction(v, o, phi);
                smooth_value(rgb, l, v);
                struct measurement_point p = {.theta_in = (float)(i * theta_step),
                                              .theta_out = (float)o,
                                              .phi_out = (float)phi,
                                              .rgb = {(float)rgb[0], (float)rgb[1], (float)rgb[2]}};
                measurement_add(&m, &p);
            }
    measurement_grid_make(&grid, &m, "smooth");
    source_from_grid(out, &grid, m.source);
    assert_int_equal(grid.count, 0);
    measurement_free(&m);
}

static void measured_directions_keep_their_values_from_either_side(void **state)
{
    (void)state;
    struct brdf_source s;
    measured(&s, 20, 4, 75);
    assert_true(s.theta_in == 60 && s.theta_out == 75 && s.symmetric);
    for (int i = 1; i < 300; i++) {
        double l[3], v[3], got[3], turned[3], want[3];
        direction(l, i % 4 * 20, 17);
        direction(v, i * 7 % 76, 17 + 2 * (i * 13 % 180));
        s.value(got, s.ctx, l, v);
        s.value(turned, s.ctx, v, l);
        smooth_value(want, l, v);
        for (int c = 0; c < 3; c++) {
            assert_true(fabs(got[c] - turned[c]) <= 1e-12);
            assert_true(fabs(got[c] - want[c]) <= 2e-3 * want[c]);
        }
    }
    source_close(&s);
}

static void between_measured_angles_lobes_stay_in_place(void **state)
{
    (void)state;
    struct brdf_source s;
    measured(&s, 10, 9, 88);
    for (int i = 1; i < 500; i++) {
        double l[3], v[3], got[3], want[3];
        pair(l, v, i);
        s.value(got, s.ctx, l, v);
        smooth_value(want, l, v);
        for (int c = 0; c < 3; c++)
            assert_true(fabs(got[c] - want[c]) <= (fmin(l[2], v[2]) < cos(80 * degree) ? 0.15 : 0.06) * want[c]);
    }
    source_close(&s);
}

static void a_single_slice_serves_all_angles(void **state)
{
    (void)state;
    struct brdf_source s;
    measured(&s, 20, 1, 75);
    assert_true(s.theta_in == 0); /* measured there alone */
    for (int i = 1; i < 200; i++) {
        double l[3], v[3], got[3];
        pair(l, v, i);
        s.value(got, s.ctx, l, v);
        for (int c = 0; c < 3; c++)
            assert_true(got[c] > 0.05 && got[c] < 20);
    }
    source_close(&s);
}

/* --- tables and RGL files --- */

static void tables_of_both_kinds_give_their_texels(void **state)
{
    (void)state;
    uint32_t frame_texels[7 * 5 * 3], half_texels[4 * 6 * 5], seed = 1;
    for (int i = 0; i < 7 * 5 * 3; i++)
        frame_texels[i] = (15u << 27) | ((seed = seed * 1664525 + 1013904223) >> 5 & 0x7ffffff);
    for (int i = 0; i < 4 * 6 * 5; i++)
        half_texels[i] = (14u << 27) | ((seed = seed * 1664525 + 1013904223) >> 5 & 0x7ffffff);
    for (int i = 0; i < 15; i++) /* 360 degrees is 0 degrees */
        frame_texels[7 * i + 6] = frame_texels[7 * i];
    struct ref_half half = {.t = 4, .h = 6, .d = 5, .texels = half_texels, .scale = 2};
    ref_half_warp(&half, 0.2);
    const double n[3] = {0, 0, 1};
    for (int kind = 0; kind < 2; kind++) {
        size_t bytes;
        void *file = kind ? ref_half_make(&half, &bytes) : ref_ktx2_make(7, 5, 3, frame_texels, 60000, &bytes);
        struct ref_table *t = ref_table_open(file, bytes);
        char *path = write_temporary("table.ktx2", file, bytes);
        struct brdf_source s;
        source_open(&s, path);
        assert_true(s.theta_in == (kind ? 90 : 60));
        for (int i = 1; i < 500; i++) {
            double l[3], v[3], got[3], want[3];
            pair(l, v, i);
            s.value(got, s.ctx, l, v);
            double size = ref_table_eval(want, t, n, l, v);
            for (int c = 0; c < 3; c++)
                assert_true(fabs(got[c] - want[c]) <= 2e-6 * size);
        }
        source_close(&s);
        ref_table_free(t);
        free(file);
        unlink(path);
    }
}

static void damaged_tables_are_refused(void **state)
{
    (void)state;
    uint32_t texels[8] = {0};
    size_t bytes;
    uint8_t *file = ref_ktx2_make(2, 2, 2, texels, 60000, &bytes);
    struct bytes b = {file, bytes - 4};
    assert_int_equal(exit_code_of(open_table, &b), EXIT_BAD_INPUT);
    assert_non_null(strstr(child_message, "build the table again"));
    free(file);
    unlink(write_temporary("bad.csv", "", 0));
}

static void symmetric_part_is_the_mean_over_both_exchanges(void **state)
{
    (void)state;
    const char *folder = getenv("GONIOTILE_DATA");
    char *path = xasprintf("%s/brdf/satin_rosaline_rgb.bsdf", folder ? folder : "../shared/data");
    if (access(path, R_OK)) {
        free(path);
        skip();
    }
    struct brdf_source s;
    source_open(&s, path);
    assert_false(s.symmetric);
    for (int i = 1; i < 100; i++) {
        double l[3], v[3], a[3], b[3], one[3], mean[3] = {0};
        pair(l, v, i);
        double ml[3] = {l[0], -l[1], l[2]}, mv[3] = {v[0], -v[1], v[2]};
        for (int k = 0; k < 4; k++) {
            const double *in = k == 0   ? l
                               : k == 1 ? v
                               : k == 2 ? ml
                                        : mv,
                         *out = k == 0   ? v
                                : k == 1 ? l
                                : k == 2 ? mv
                                         : ml;
            s.value(one, s.ctx, in, out);
            for (int c = 0; c < 3; c++)
                mean[c] += one[c] / 4;
        }
        source_symmetric(a, &s, l, v);
        source_symmetric(b, &s, v, l);
        for (int c = 0; c < 3; c++) {
            assert_true(fabs(a[c] - b[c]) <= 1e-12 * a[c]);
            assert_true(fabs(a[c] - mean[c]) <= 1e-12 * a[c]);
        }
    }
    source_close(&s);
    free(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fits_are_evaluated_by_their_formula),
        cmocka_unit_test(bad_fits_are_refused),
        cmocka_unit_test(measured_directions_keep_their_values_from_either_side),
        cmocka_unit_test(between_measured_angles_lobes_stay_in_place),
        cmocka_unit_test(a_single_slice_serves_all_angles),
        cmocka_unit_test(tables_of_both_kinds_give_their_texels),
        cmocka_unit_test(damaged_tables_are_refused),
        cmocka_unit_test(symmetric_part_is_the_mean_over_both_exchanges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
