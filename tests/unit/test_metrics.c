/* The errors of a table against its source, against values worked out by hand or in another way. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "common.h"
#include "host_metrics.h"
#include "host_specular_frame.h"
#include "ref_table.h"

static const double pi = 3.14159265358979323846;

static void assert_near(double got, double want, double tolerance)
{
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%.9g is not %.9g within %g", got, want, tolerance);
}

/* --- sources --- */

/* What every pixel of the pictures shows: irradiance pi, whatever the light's angle. */
static void flat_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    (void)v;
    for (int c = 0; c < 3; c++)
        rgb[c] = ((const double *)ctx)[c] / pi / l[2];
}

/* One number for all channels as a function of the cosines, and of which side of the plane of n and l the viewer is on. */
typedef double cosine_function(double nl, double nv, double lv, double side);

static void cosine_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    cosine_function *const *f = ctx;
    rgb[0] = rgb[1] = rgb[2] = (*f)(l[2], v[2], l[0] * v[0] + l[1] * v[1] + l[2] * v[2], l[0] * v[1] - l[1] * v[0]);
}

static double one(double nl, double nv, double lv, double side)
{
    return 1 + 0 * (nl + nv + lv + side);
}

static double black(double nl, double nv, double lv, double side)
{
    return 0 * (nl + nv + lv + side);
}

static double only_nl(double nl, double nv, double lv, double side)
{
    return nl + 0 * (nv + lv + side);
}

static double only_nv(double nl, double nv, double lv, double side)
{
    return nv + 0 * (nl + lv + side);
}

static double uneven(double nl, double nv, double lv, double side)
{
    return 0.1 + 0.05 * nl * nv + 0.1 * lv * lv + 0.07 * side;
}

/* GGX of roughness 0.005, about 0.3 degrees, with height-correlated Smith masking, and no Fresnel factor. */
static double narrow(double nl, double nv, double lv, double side)
{
    (void)side;
    double a2 = 0.005 * 0.005, h2 = 2 + 2 * lv, c2 = (nl + nv) * (nl + nv) / h2;
    double d = c2 * a2 + fmax(1 - c2, 0);
    return a2 / (pi * d * d) / 2 / (nl * sqrt(a2 + (1 - a2) * nv * nv) + nv * sqrt(a2 + (1 - a2) * nl * nl));
}

static double narrow_and_more(double nl, double nv, double lv, double side)
{
    return 1.25 * narrow(nl, nv, lv, side);
}

static struct brdf_source source_of(cosine_function **f)
{
    return (struct brdf_source){.value = cosine_value, .ctx = f};
}

/* --- pictures --- */

static void colour_differences_of_known_colours(void **state)
{
    (void)state;
    static double red[3] = {1, 0, 0}, dark[3] = {0, 0, 0}, white[3] = {1, 1, 1}, glare[3] = {7, 3, 2};
    struct brdf_source r = {.value = flat_value, .ctx = red}, k = {.value = flat_value, .ctx = dark},
                       w = {.value = flat_value, .ctx = white}, g = {.value = flat_value, .ctx = glare};
    struct metrics m;
    metrics_pictures(&m, &r, &k); /* sRGB red is L* 53.24, a* 80.09, b* 67.20 */
    assert_near(m.de_mean, sqrt(53.24 * 53.24 + 80.09 * 80.09 + 67.20 * 67.20), 0.05);
    assert_near(m.de_p99, m.de_mean, 1e-6);
    assert_near(m.psnr, 10 * log10(3), 1e-6);
    metrics_pictures(&m, &k, &w);
    assert_near(m.de_mean, 100, 1e-3);
    assert_near(m.psnr, 0, 1e-6);
    metrics_pictures(&m, &g, &w); /* clipped */
    assert_near(m.de_mean, 0, 1e-9);
    assert_near(m.psnr, 120, 1e-6);
}

/* The picture set computed in world space and in XYZ, with a plain sort. */
static double encode(double x)
{
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}

static int ascending(const void *a, const void *b)
{
    return *(const double *)a > *(const double *)b ? 1 : -1;
}

static void pictures_in_world_space(void **state)
{
    (void)state;
    static double de[3 * 96 * 96];
    double sum = 0, squares = 0, degrees[] = {30, 80, 140};
    size_t count = 0;
    for (int k = 0; k < 3; k++) {
        double a = degrees[k] * pi / 180, lx = sin(a) * 0.8, ly = sin(a) * 0.6, lz = cos(a);
        for (int j = 0; j < 96; j++)
            for (int i = 0; i < 96; i++) {
                double x = -1 + i / 47.5, y = 1 - j / 47.5, r2 = x * x + y * y;
                double z = sqrt(fmax(1 - r2, 0)), nl = x * lx + y * ly + z * lz;
                if (r2 >= 0.998 || nl <= 0.01)
                    continue;
                double got = pi * nl * uneven(nl, z, lz, x * ly - y * lx), want = pi * nl * only_nv(nl, z, lz, 0);
                got = fmin(fmax(got, 0), 1);
                want = fmin(fmax(want, 0), 1);
                /* greys: only L* differs */
                double ga = got > 0.008856 ? 116 * cbrt(got) - 16 : 903.3 * got,
                       wa = want > 0.008856 ? 116 * cbrt(want) - 16 : 903.3 * want;
                de[count++] = fabs(ga - wa);
                sum += fabs(ga - wa);
                squares += (encode(got) - encode(want)) * (encode(got) - encode(want));
            }
    }
    qsort(de, count, sizeof *de, ascending);
    static cosine_function *f = uneven, *g = only_nv;
    struct brdf_source a = source_of(&f), b = source_of(&g);
    struct metrics m;
    metrics_pictures(&m, &a, &b);
    assert_near(m.de_mean, sum / (double)count, 1e-3);
    assert_near(m.de_p99, de[count * 99 / 100], 0.05);
    assert_near(m.psnr, -10 * log10(squares / (double)count), 1e-4);
}

/* --- bands, reciprocity --- */

static void equal_brdfs_have_no_error(void **state)
{
    (void)state;
    static cosine_function *f = uneven, *k = black;
    struct brdf_source a = source_of(&f), b = source_of(&k);
    struct metrics m;
    metrics_compare(&m, &a, &a);
    assert_near(m.de_mean, 0, 0);
    assert_near(m.de_p99, 0, 0);
    assert_near(m.psnr, 120, 1e-6);
    for (int i = 0; i < METRICS_BANDS; i++)
        assert_near(m.band[i], 0, 0);
    metrics_compare(&m, &b, &b);
    assert_near(m.band[0], 0, 0);
    metrics_compare(&m, &a, &b); /* nothing to be relative to */
    assert_true(isinf(m.band[0]));
    assert_near(metrics_reciprocity(&b), 0, 0);
}

/* With c = n.v down to cos 88 degrees, E^2 of c against 1 is the integral of (c - 1)^2 c^2 over that of c^2. */
static void bands_are_weighted_integrals(void **state)
{
    (void)state;
    static cosine_function *f = only_nv, *g = one, *n = narrow, *more = narrow_and_more;
    struct brdf_source a = source_of(&f), b = source_of(&g), lobe = source_of(&n), lobe_more = source_of(&more);
    double c = cos(88 * pi / 180), third = (1 - pow(c, 3)) / 3, quarter = (1 - pow(c, 4)) / 4,
           fifth = (1 - pow(c, 5)) / 5;
    struct metrics m;
    metrics_compare(&m, &a, &b);
    for (int i = 0; i < METRICS_BANDS; i++)
        assert_near(m.band[i], sqrt((fifth - 2 * quarter + third) / third), 0.003);
    metrics_compare(&m, &lobe_more, &lobe);
    for (int i = 0; i < METRICS_BANDS; i++)
        assert_near(m.band[i], 0.25, 1e-12);
}

static void reciprocity_is_the_relative_difference_of_exchanged_directions(void **state)
{
    (void)state;
    static cosine_function *f = only_nl, *n = narrow, *u = one;
    struct brdf_source a = source_of(&f), b = source_of(&n), c = source_of(&u);
    /* theta_in uniform in 0..75 degrees: means of cos^2 and cos */
    double top = 75 * pi / 180, square = 0.5 + sin(2 * top) / (4 * top), mean = sin(top) / top;
    assert_near(metrics_reciprocity(&a), sqrt((square / 3 - 2 * mean / 4 + 1.0 / 5) / (square / 3)), 0.005);
    assert_near(metrics_reciprocity(&b), 0, 1e-12);
    assert_near(metrics_reciprocity(&c), 0, 0);
}

/* --- albedo --- */

static void albedo_of_constants_lobes_and_retroreflection(void **state)
{
    (void)state;
    static cosine_function *u = one, *v = only_nv, *n = narrow;
    struct brdf_source a = source_of(&u), b = source_of(&v), lobe = source_of(&n);
    static const double angles[] = {0, 20, 45, 70, 85};
    double rgb[3];
    for (size_t i = 0; i < sizeof angles / sizeof *angles; i++) {
        metrics_albedo(rgb, &a, angles[i]);
        assert_near(rgb[0], pi, 1e-12);
        assert_near(rgb[2], rgb[0], 0);
        metrics_albedo(rgb, &b, angles[i]);
        assert_near(rgb[1], 2 * pi / 3, 1e-3);
    }
    /* A mirror but for the masking and what scatters below the horizon. */
    metrics_albedo(rgb, &lobe, 30);
    assert_near(rgb[0], 1, 0.002);
    metrics_albedo(rgb, &lobe, 75);
    assert_near(rgb[0], 1, 0.01);
}

/* --- tables as sources --- */

static void albedo_of_a_constant_table_is_exact(void **state)
{
    (void)state;
    uint32_t texels[37 * 19 * 2];
    for (size_t i = 0; i < sizeof texels / sizeof *texels; i++)
        texels[i] = 256u | 128u << 9 | 64u << 18 | 15u << 27; /* 1/2, 1/4, 1/8 per sr */
    struct specular_frame_table table = {texels, 37, 19, 2, 60, false};
    struct brdf_source source;
    specular_frame_source(&source, &table, "constant");
    for (double theta_in = 0; theta_in < 90; theta_in += 29) {
        double albedo[3];
        metrics_albedo(albedo, &source, theta_in);
        for (int c = 0; c < 3; c++)
            assert_near(albedo[c], pi / (2 << c), 1e-12);
    }
}

static uint32_t random_word(uint32_t *state)
{
    *state = *state * 1664525 + 1013904223;
    return *state >> 8;
}

static double random_unit(uint32_t *state)
{
    return (random_word(state) + 0.5) / (1 << 24);
}

static void specular_frame_in_double_equals_the_reference(void **state)
{
    (void)state;
    enum { WIDTH = 19, HEIGHT = 10, DEPTH = 4 };
    uint32_t seed = 1, texels[WIDTH * HEIGHT * DEPTH];
    for (size_t i = 0; i < sizeof texels / sizeof *texels; i++)
        texels[i] = (random_word(&seed) & 0x7ffffff) | (14 + (uint32_t)i % 3) << 27;
    for (int swap = 0; swap < 2; swap++) {
        struct ref_keys keys = {0};
        ref_key_set_text(&keys, "goniotile.version", "1");
        ref_key_set_text(&keys, "goniotile.kind", "specular_frame");
        ref_key_set_text(&keys, "goniotile.theta_max", "60000");
        if (swap)
            ref_key_set_text(&keys, "goniotile.swap", "1");
        size_t bytes;
        void *file = ref_ktx2_write(WIDTH, HEIGHT, DEPTH, texels, &keys, &bytes);
        struct ref_table *reference = ref_table_open(file, bytes);
        struct ktx2_view view;
        struct specular_frame_table table;
        struct brdf_source source;
        assert_non_null(reference);
        assert_int_equal(ktx2_open(&view, file, bytes), LUT_OK);
        specular_frame_read(&table, &view);
        assert_int_equal(table.swap, swap);
        specular_frame_source(&source, &table, "random");
        for (int i = 0; i < 2000; i++) {
            static const double n[3] = {0, 0, 1};
            double d[2][3], got[3], want[3];
            for (int k = 0; k < 2; k++) {
                double z = random_unit(&seed), phi = 2 * pi * random_unit(&seed), r = sqrt(1 - z * z);
                d[k][0] = r * cos(phi);
                d[k][1] = r * sin(phi);
                d[k][2] = z;
            }
            source.value(got, source.ctx, d[0], d[1]);
            ref_table_eval(want, reference, n, d[0], d[1]);
            for (int c = 0; c < 3; c++)
                assert_near(got[c], want[c], 1e-6 * want[c] + 1e-7);
        }
        ref_table_free(reference);
        ref_keys_free(&keys);
        free(file);
    }
}

/* --- real files: the asymmetry an independent study found --- */

static void real_materials_are_not_reciprocal(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double want;
    } files[] = {{"paper_white", 0.0368},
                 {"cc_ibiza_sunset", 0.2304},
                 {"colodur_napoli_4f", 0.0606},
                 {"satin_rosaline", 0.6229}};
    const char *data = getenv("GONIOTILE_DATA");
    char *probe = xasprintf("%s/brdf/paper_white_rgb.bsdf", data ? data : "../shared/data");
    int readable = access(probe, R_OK);
    free(probe);
    if (readable)
        skip();
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char *path = xasprintf("%s/brdf/%s_rgb.bsdf", data ? data : "../shared/data", files[i].name);
        struct brdf_source s;
        source_open(&s, path);
        double got = metrics_reciprocity(&s);
        assert_near(got / files[i].want, 1, 0.1);
        source_close(&s);
        free(path);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colour_differences_of_known_colours),
        cmocka_unit_test(pictures_in_world_space),
        cmocka_unit_test(equal_brdfs_have_no_error),
        cmocka_unit_test(bands_are_weighted_integrals),
        cmocka_unit_test(reciprocity_is_the_relative_difference_of_exchanged_directions),
        cmocka_unit_test(albedo_of_constants_lobes_and_retroreflection),
        cmocka_unit_test(albedo_of_a_constant_table_is_exact),
        cmocka_unit_test(specular_frame_in_double_equals_the_reference),
        cmocka_unit_test(real_materials_are_not_reciprocal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
