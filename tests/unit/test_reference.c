/*
 * The reference itself, against closed forms and physics: what everything else is measured with must be right.
 *
 * Environment: GONIOTILE_DATA (folder of real measurements).
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "ref_models.h"
#include "ref_rgl.h"
#include "ref_table.h"

static const double pi = 3.14159265358979323846, degree = 3.14159265358979323846 / 180;
static const double z[3] = {0, 0, 1};

static void assert_near(double got, double want, double tolerance)
{
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%.9g instead of %.9g", got, want);
}

static uint64_t seed = 1;

static double uniform(double low, double high)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(seed >> 40) * 0x1p-24;
}

static void random_above(double v[3])
{
    double c = uniform(0.02, 1), a = uniform(0, 2 * pi), s = sqrt(1 - c * c);
    v[0] = s * cos(a), v[1] = s * sin(a), v[2] = c;
}

static void albedos_equal_the_closed_forms(void **state)
{
    (void)state;
    struct ref_material lambert = {.kind = REF_LAMBERT, .kd = {1, 0.5, 0.25}};
    struct ref_material phong = {.kind = REF_LAFORTUNE_PHONG, .ks = {1, 1, 1}, .exponent = 50};
    double a[3];
    for (int angle = 0; angle < 90; angle += 15) {
        ref_albedo(a, ref_brdf_of_material, &lambert, angle * degree, 256);
        assert_near(a[0], 1, 5e-4);
        assert_near(a[2], 0.25, 1e-4);
    }
    ref_albedo(a, ref_brdf_of_material, &phong, 0, 256);
    assert_near(a[0], 1, 2e-3); /* the normalisation (n+2)/(2 pi) is for this angle */
}

/* With a perfect mirror's reflectance, all light that masking does not take comes back; nothing for small alpha is taken. */
static void perfect_microfacets_reflect_no_more_than_all(void **state)
{
    (void)state;
    static const double alpha[] = {0.001, 0.01, 0.1, 0.5, 1};
    for (int i = 0; i < 5; i++)
        for (int angle = 0; angle < 90; angle += 15) {
            struct ref_material m = {
                .kind = REF_MICROFACET, .eta = {1, 1, 1}, .k = {1e7, 1e7, 1e7}, .roughness = sqrt(alpha[i])};
            double a[3];
            ref_albedo(a, ref_brdf_of_material, &m, angle * degree, 200);
            assert_true(a[0] <= 1 + 5e-4);
            if (alpha[i] <= 0.01)
                assert_near(a[0], 1, 2e-3);
        }
}

/* The weak white furnace (Heitz 2014, eq. 26): the visible area of all facets is the surface's own, for masking alone. */
static void ggx_facets_cover_the_surface(void **state)
{
    (void)state;
    static const double alpha[] = {0.05, 0.3, 1};
    for (int i = 0; i < 3; i++) {
        double area = 0;
        const int steps = 4000;
        for (int j = 0; j < steps; j++) {
            double theta = (j + 0.5) / steps * pi / 2;
            area += ref_ggx(alpha[i], cos(theta)) * cos(theta) * 2 * pi * sin(theta) * pi / 2 / steps;
        }
        assert_near(area, 1, 1e-4);
    }
}

static void fresnel_has_its_known_values(void **state)
{
    (void)state;
    assert_near(ref_fresnel_dielectric(1.5, 1), 0.04, 1e-12);
    assert_near(ref_fresnel_dielectric(1.5, 0), 1, 1e-12);
    double brewster = atan(1.5); /* only one polarisation is left: half of ((1 - n^2)/(1 + n^2))^2 */
    assert_near(ref_fresnel_dielectric(1.5, cos(brewster)), pow(1.25 / 3.25, 2) / 2, 1e-12);
    assert_near(ref_fresnel_conductor(0.2, 3.4, 1), (0.64 + 3.4 * 3.4) / (1.44 + 3.4 * 3.4), 1e-12);
    assert_near(ref_fresnel_conductor(1.5, 0, 0.3), ref_fresnel_dielectric(1.5, 0.3), 1e-12);
    for (double f0 = 0.01; f0 < 0.9; f0 += 0.1) {
        assert_near(ref_fresnel_dielectric(ref_eta_of_f0(f0), 1), f0, 1e-12);
        assert_near(ref_fresnel_schlick(f0, 1), f0, 1e-12);
        assert_near(ref_fresnel_schlick(f0, 0), 1, 1e-12);
    }
}

/* Both are G/(4 n.l n.v), 1/4 at normal incidence; they agree for alpha of 0 and 1. */
static void masking_approximations_meet_the_exact_at_the_ends(void **state)
{
    (void)state;
    assert_near(ref_visibility_smith(0.3, 1, 1), 0.25, 1e-12);
    assert_near(ref_visibility_hammon(0.3, 1, 1), 0.25, 1e-12);
    for (int i = 0; i < 1000; i++) {
        double a = uniform(0.01, 1), b = uniform(0.01, 1);
        assert_near(ref_visibility_hammon(1, a, b) / ref_visibility_smith(1, a, b), 1, 1e-9);
        assert_near(ref_visibility_hammon(1e-6, a, b) / ref_visibility_smith(1e-6, a, b), 1, 2e-4);
    }
}

static void lights_fade_as_defined(void **state)
{
    (void)state;
    assert_near(ref_attenuation(0, 10), 1, 0);
    assert_near(ref_attenuation(2, 1e9), 0.25, 1e-12);
    assert_near(ref_attenuation(5, 10), pow(15.0 / 16, 2) / 25, 1e-12);
    assert_near(ref_attenuation(10, 10), 0, 0);
    assert_near(ref_attenuation(11, 10), 0, 0);
}

static void physical_models_are_reciprocal(void **state)
{
    (void)state;
    static const enum ref_model_kind kinds[] = {REF_LAMBERT, REF_LAFORTUNE_PHONG, REF_METALLIC_ROUGHNESS,
                                                REF_MICROFACET};
    for (int i = 0; i < 4000; i++) {
        struct ref_material m = {.kind = kinds[i % 4],
                                 .kd = {0.5, 0.3, 0.1},
                                 .ks = {0.2, 0.2, 0.2},
                                 .exponent = 20,
                                 .metalness = 0.3,
                                 .roughness = 0.4,
                                 .eta = {1.5, 0.2, 1},
                                 .k = {0, 3, 5}};
        double l[3], v[3], a[3], b[3];
        random_above(l);
        random_above(v);
        ref_model_value(a, &m, z, l, v);
        ref_model_value(b, &m, z, v, l);
        for (int c = 0; c < 3; c++)
            assert_near(a[c], b[c], 1e-9 * b[c]);
    }
}

/* Halving every step of a table brings it nearer to what it was sampled from, at second order. */
static void half_vector_tables_converge_to_their_source(void **state)
{
    (void)state;
    struct ref_material m = {.kind = REF_METALLIC_ROUGHNESS, .kd = {0.8, 0.4, 0.1}, .roughness = 0.5};
    double error[2] = {0, 0};
    for (int fine = 0; fine < 2; fine++) {
        struct ref_half f = {.t = fine ? 15 : 8, .h = fine ? 127 : 64, .d = fine ? 33 : 17};
        size_t bytes;
        ref_half_warp(&f, 0.25);
        ref_half_sample(&f, ref_brdf_of_material, &m);
        void *file = ref_half_make(&f, &bytes);
        struct ref_table *t = ref_table_open(file, bytes);
        seed = 7;
        for (int i = 0; i < 20000; i++) {
            double l[3], v[3], got[3], want[3];
            random_above(l);
            random_above(v);
            ref_table_eval(got, t, z, l, v);
            ref_model_value(want, &m, z, l, v);
            error[fine] += fabs(got[0] - want[0]) * l[2] * v[2] / 20000;
        }
        ref_table_free(t);
        free(file);
        free((void *)f.texels);
    }
    print_message("# mean error of the coarser table %.6f, of the finer %.6f\n", error[0], error[1]);
    assert_true(error[1] < 0.4 * error[0]);
}

/*
 * Dupuy and Jakob 2018, eqs. 3 and 6: the density of visible normals is D(m) max(i.m, 0) / sigma(i), normalised. A file has all three:
 * they fit each other only where angles, azimuths and Jacobians are read as meant.
 */
static void rgl_densities_are_those_of_visible_normals(void **state)
{
    (void)state;
    const char *folder = getenv("GONIOTILE_DATA");
    char *path = xasprintf("%s/brdf/satin_rosaline_rgb.bsdf", folder ? folder : "");
    FILE *exists = fopen(path, "rb");
    if (!exists) {
        free(path);
        skip();
    }
    fclose(exists);
    size_t bytes;
    unsigned char *file = read_file(path, 64u << 20, &bytes);
    struct ref_rgl *r = ref_rgl_open(file, bytes);
    double worst = 0, compared = 0;
    for (int i = 0; i < 2000; i++) {
        /* one of the file's own angles of incidence: between them densities are mixed */
        double theta_i = ref_rgl_angle(r, i % 6), theta_m = uniform(0.05, 0.6), phi = uniform(-pi, pi), terms[3];
        double cosine = cos(theta_i) * cos(theta_m) + sin(theta_i) * sin(theta_m) * cos(phi);
        ref_rgl_terms(terms, r, theta_i, theta_m, phi);
        if (cosine < 0.2 || terms[1] < 0.02)
            continue;
        worst = fmax(worst, fabs(terms[0] * terms[2] / (terms[1] * cosine) - 1));
        compared++;
    }
    print_message("# density of visible normals against D (i.m) / sigma: off by %.4f at most in %g places\n", worst,
                  compared);
    assert_true(compared > 500 && worst <= 0.1);
    ref_rgl_close(r);
    free(file);
    free(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(albedos_equal_the_closed_forms),
        cmocka_unit_test(perfect_microfacets_reflect_no_more_than_all),
        cmocka_unit_test(ggx_facets_cover_the_surface),
        cmocka_unit_test(fresnel_has_its_known_values),
        cmocka_unit_test(masking_approximations_meet_the_exact_at_the_ends),
        cmocka_unit_test(lights_fade_as_defined),
        cmocka_unit_test(physical_models_are_reciprocal),
        cmocka_unit_test(half_vector_tables_converge_to_their_source),
        cmocka_unit_test(rgl_densities_are_those_of_visible_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
