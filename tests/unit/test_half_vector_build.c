/* Half-vector tables as the builder makes them: their bytes, their error, their energy. */
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
#include "host_metrics.h"
#include "ktx2.h"
#include "lut.h"
#include "ref_table.h"

static const double pi = 3.14159265358979323846;

/* --- materials --- */

static void constant_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    (void)ctx, (void)l, (void)v;
    rgb[0] = 0.8 / pi;
    rgb[1] = 0.3 / pi;
    rgb[2] = 0.02 / pi;
}

/* A mirror as rough as *ctx that reflects all its facets see: albedo 1 but for what facets hide. */
static void ggx_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    const double *alpha = ctx;
    double x = l[0] + v[0], y = l[1] + v[1], z = l[2] + v[2];
    /* ref_ggx takes a cosine, which has no bits left near the centre of the narrowest lobe */
    double sine2 = (x * x + y * y) / (x * x + y * y + z * z), d = (1 - sine2) * *alpha * *alpha + sine2;
    rgb[0] = rgb[1] = rgb[2] = *alpha * *alpha / (pi * d * d) * ref_visibility_smith(*alpha, l[2], v[2]);
}

/* A lobe of *ctx degrees around the light on a dark grey. */
static void retro_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    double d2 = 0, width = *(const double *)ctx * pi / 180;
    for (int k = 0; k < 3; k++)
        d2 += (l[k] - v[k]) * (l[k] - v[k]);
    rgb[0] = rgb[1] = rgb[2] = 0.05 / pi + 5 * exp(-d2 / (width * width));
}

/* Coloured, rough and smooth, not reciprocal, not the same on both sides. */
static void crooked_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    static const double alpha = 0.2;
    (void)ctx;
    ggx_value(rgb, &alpha, l, v);
    double side = 1 + 0.3 * (l[0] * v[1] - l[1] * v[0]);
    for (int c = 0; c < 3; c++)
        rgb[c] = rgb[c] * (0.1 + 0.3 * c) * side + 0.1 * l[2] * (3 - c);
}

static struct brdf_source source_of(void (*value)(double[3], const void *, const double[3], const double[3]),
                                    const double *ctx)
{
    return (struct brdf_source){.value = value, .ctx = (void *)ctx, .theta_in = 90, .theta_out = 90};
}

static struct half_vector build(const struct brdf_source *source, uint32_t h, uint32_t d, uint32_t t)
{
    struct half_vector table;
    struct half_vector_report report;
    half_vector_build(&table, &report, source, &(struct half_vector_options){.h = h, .d = d, .t = t});
    printf("# %ux%ux%u: %.2f s, dE %.3f\n", h, d, t, report.seconds, report.de);
    return table;
}

/* As the independent reader understands the file. */
static struct ref_table *as_reference(const struct half_vector *t)
{
    size_t bytes;
    uint8_t *file = half_vector_compose(&bytes, t, NULL, 0, false);
    struct ref_table *reference = ref_table_open(file, bytes);
    assert_non_null(reference);
    free(file);
    return reference;
}

/* --- the file --- */

/* One table that most tests look at. */
static struct half_vector crooked;

static struct half_vector crooked_table(void)
{
    struct brdf_source source = source_of(crooked_value, NULL);
    return build(&source, 24, 11, 5);
}

static int crooked_set_up(void **state)
{
    (void)state;
    crooked = crooked_table();
    return 0;
}

static int crooked_tear_down(void **state)
{
    (void)state;
    half_vector_free(&crooked);
    return 0;
}

static void bytes_equal_those_of_the_reference_with_and_without_the_packed_copy(void **state)
{
    (void)state;
    const struct ktx2_pair pairs[] = {{"KTXwriter", "reference", 0}};
    for (int packed = 0; packed < 2; packed++)
        for (int scale = -3; scale <= 0; scale += 3) {
            struct half_vector t = crooked;
            t.scale = scale;
            struct ref_half want = {.t = t.t, .h = t.h, .d = t.d, .texels = t.texels, .scale = scale, .slabs = packed};
            memcpy(want.warp_h, t.warp_h, sizeof t.warp_h);
            memcpy(want.warp_d, t.warp_d, sizeof t.warp_d);
            size_t bytes, want_bytes;
            uint8_t *file = half_vector_compose(&bytes, &t, pairs, 1, packed);
            void *want_file = ref_half_make(&want, &want_bytes);
            assert_int_equal(bytes, want_bytes);
            assert_memory_equal(file, want_file, bytes);
            free(want_file);
            free(file);
        }
}

static void metadata_of_the_caller_is_sorted_in(void **state)
{
    (void)state;
    const struct ktx2_pair pairs[] = {{"goniotile.source", "paint", 0}, {"KTXwriter", "test", 0}};
    size_t bytes;
    uint8_t *file = half_vector_compose(&bytes, &crooked, pairs, 2, true);
    struct ktx2_view view;
    struct lut_table table;
    assert_int_equal(ktx2_open(&view, file, bytes), LUT_OK);
    assert_int_equal(lut_open(&table, file, bytes), LUT_OK);
    assert_int_equal(table.kind, LUT_HALF_VECTOR);
    assert_non_null(table.slabs);
    uint32_t n;
    const uint8_t *text = ktx2_find(&view, "goniotile.source", &n);
    assert_int_equal(n, 5);
    assert_memory_equal(text, "paint", 5);
    const char *before = "";
    for (uint32_t at = 0, size; at < view.kvd_bytes; at += 4 + ((size + 3) & ~3u)) {
        const char *key = (const char *)view.kvd + at + 4;
        memcpy(&size, view.kvd + at, 4);
        assert_true(strcmp(before, key) < 0);
        before = key;
    }
    free(file);
}

static void reading_a_file_gives_the_table_back(void **state)
{
    (void)state;
    struct half_vector t = crooked, back;
    t.scale = -2;
    size_t bytes;
    uint8_t *file = half_vector_compose(&bytes, &t, NULL, 0, false);
    struct ktx2_view view;
    assert_int_equal(ktx2_open(&view, file, bytes), LUT_OK);
    half_vector_read(&back, &view);
    assert_int_equal(back.scale, -2);
    assert_true(back.h == t.h && back.d == t.d && back.t == t.t);
    assert_memory_equal(back.warp_h, t.warp_h, sizeof t.warp_h);
    assert_memory_equal(back.warp_d, t.warp_d, sizeof t.warp_d);
    assert_memory_equal(back.texels, t.texels, 4 * t.h * t.d * t.t);
    half_vector_free(&back);
    free(file);
}

static void every_size_is_accepted_and_within_its_budget(void **state)
{
    (void)state;
    static const uint32_t sizes[][3] = {{2, 2, 2}, {128, 2, 2}, {2, 128, 2}, {2, 2, 32}};
    static const uint32_t budgets[] = {64, 65536};
    struct brdf_source source = source_of(constant_value, NULL);
    source.symmetric = true;
    for (size_t i = 0; i < 4 + 2; i++) {
        struct half_vector_options o = {.texels = i < 4 ? 0 : budgets[i - 4]};
        if (i < 4)
            o = (struct half_vector_options){sizes[i][0], sizes[i][1], sizes[i][2], 0};
        struct half_vector t;
        struct half_vector_report report;
        half_vector_build(&t, &report, &source, &o);
        if (i >= 4)
            assert_in_range(t.h * t.d * t.t, o.texels * 7 / 8, o.texels);
        size_t bytes;
        uint8_t *file = half_vector_compose(&bytes, &t, NULL, 0, true);
        struct lut_table table;
        assert_int_equal(lut_open(&table, file, bytes), LUT_OK);
        free(file);
        half_vector_free(&t);
    }
}

static void building_twice_gives_the_same_bits(void **state)
{
    (void)state;
    struct half_vector again = crooked_table();
    assert_memory_equal(again.warp_h, crooked.warp_h, sizeof again.warp_h);
    assert_memory_equal(again.warp_d, crooked.warp_d, sizeof again.warp_d);
    assert_memory_equal(again.texels, crooked.texels, 4 * again.h * again.d * again.t);
    half_vector_free(&again);
}

/* --- evaluation --- */

static double uniform(uint32_t *state)
{
    *state = *state * 1664525 + 1013904223;
    return (*state >> 8) / 16777216.0;
}

static void random_direction(double d[3], uint32_t *state)
{
    double phi = 2 * pi * uniform(state), flat;
    d[2] = uniform(state) * 0.999 + 0.001;
    flat = sqrt(1 - d[2] * d[2]);
    d[0] = flat * cos(phi);
    d[1] = flat * sin(phi);
}

static void value_equals_the_reference_and_is_reciprocal_to_the_bit(void **state)
{
    (void)state;
    struct ref_table *reference = as_reference(&crooked);
    const double n[3] = {0, 0, 1};
    uint32_t seed = 7;
    for (int i = 0; i < 20000; i++) {
        double l[3], v[3], got[3], want[3], turned[3];
        random_direction(l, &seed);
        random_direction(v, &seed);
        half_vector_value(got, &crooked, l, v);
        half_vector_value(turned, &crooked, v, l);
        double size = ref_half_eval(want, reference, n, l, v);
        assert_memory_equal(got, turned, sizeof got);
        for (int c = 0; c < 3; c++)
            assert_true(fabs(got[c] - want[c]) <= 2e-6 * size);
    }
    ref_table_free(reference);
}

static void azimuth_is_without_effect_where_it_is_undefined(void **state)
{
    (void)state;
    const struct half_vector *t = &crooked;
    for (uint32_t j = 0; j < t->d; j++)
        for (uint32_t i = 0; i < t->h; i++)
            for (uint32_t k = 1; k < t->t && (!i || !j); k++)
                assert_int_equal(t->texels[k + t->t * (i + t->h * j)], t->texels[t->t * (i + t->h * j)]);
}

/* --- energy --- */

static void constant_brdf_keeps_its_albedo(void **state)
{
    (void)state;
    struct brdf_source source = source_of(constant_value, NULL);
    source.symmetric = true;
    struct half_vector t = build(&source, 26, 13, 3);
    struct ref_table *reference = as_reference(&t);
    for (int angle = 0; angle <= 80; angle += 20) {
        double albedo[3];
        ref_albedo(albedo, ref_brdf_of_table, reference, angle * pi / 180, 96);
        assert_true(fabs(albedo[0] - 0.8) < 0.001);
        assert_true(fabs(albedo[1] - 0.3) < 0.0005);
        assert_true(fabs(albedo[2] - 0.02) < 0.0002);
    }
    ref_table_free(reference);
    half_vector_free(&t);
}

/* No more than arrives, up to 2^-6, and not much less where facets hide nothing. */
static void check_ggx_energy(double alpha, uint32_t h, uint32_t d, uint32_t t, double least)
{
    struct brdf_source source = source_of(ggx_value, &alpha);
    source.symmetric = true;
    struct half_vector table = build(&source, h, d, t);
    struct ref_table *reference = as_reference(&table);
    for (int angle = 0; angle <= 88; angle += 22) {
        double albedo[3];
        ref_albedo(albedo, ref_brdf_of_table, reference, angle * pi / 180, 256);
        printf("# alpha %g, %d degrees: albedo %.4f\n", alpha, angle, albedo[0]);
        assert_true(albedo[0] <= 1 + 1.0 / 64);
        assert_true(angle > 70 || albedo[0] >= least);
    }
    ref_table_free(reference);
    half_vector_free(&table);
}

static void sharp_lobes_create_no_energy_and_lose_little(void **state)
{
    (void)state;
    check_ggx_energy(0.003, 26, 13, 3, 0.95);
    check_ggx_energy(0.003, 64, 16, 2, 0.98);
}

/* Narrower than the first cell of the warp: 2^-8.7 rad. */
static void lobes_too_narrow_for_the_axis_create_no_energy(void **state)
{
    (void)state;
    double alpha = 0.0005;
    struct brdf_source source = source_of(ggx_value, &alpha);
    source.symmetric = true;
    struct half_vector table = build(&source, 26, 13, 3);
    struct ref_table *reference = as_reference(&table);
    double albedo[3];
    ref_albedo(albedo, ref_brdf_of_table, reference, 0.5, 256);
    printf("# alpha %g: albedo %.4f\n", alpha, albedo[0]);
    assert_true(albedo[0] <= 1 + 1.0 / 64 && albedo[0] > 0.5);
    ref_table_free(reference);
    half_vector_free(&table);
}

/* --- error --- */

static double colour_difference(const struct half_vector *t, const struct brdf_source *truth)
{
    struct brdf_source source;
    struct metrics m;
    half_vector_source(&source, t, "table");
    metrics_pictures(&m, &source, truth);
    return m.de_mean;
}

static void lobes_and_retroreflectors_are_met_at_4_kilobytes(void **state)
{
    (void)state;
    static const double alpha = 0.1, width = 4;
    for (int i = 0; i < 2; i++) {
        struct brdf_source source = i ? source_of(retro_value, &width) : source_of(ggx_value, &alpha);
        source.symmetric = true;
        struct half_vector t = build(&source, 26, 13, 3);
        double de = colour_difference(&t, &source);
        printf("# material %d: mean dE %.3f\n", i, de);
        assert_true(de < (i ? 0.1 : 0.14));
        half_vector_free(&t);
    }
}

static void a_source_that_is_not_reciprocal_is_made_so(void **state)
{
    (void)state;
    uint32_t seed = 3;
    double error = 0, size = 0;
    for (int i = 0; i < 4000; i++) {
        double l[3], v[3], got[3], one[3], mean[3] = {0};
        random_direction(l, &seed);
        random_direction(v, &seed);
        half_vector_value(got, &crooked, l, v);
        for (int k = 0; k < 4; k++) {
            const double *a = k & 1 ? v : l, *b = k & 1 ? l : v;
            double turn = k & 2 ? -1 : 1;
            crooked_value(one, NULL, (double[3]){a[0], turn * a[1], a[2]}, (double[3]){b[0], turn * b[1], b[2]});
            for (int c = 0; c < 3; c++)
                mean[c] += one[c] / 4;
        }
        for (int c = 0; c < 3; c++) {
            error += (got[c] - mean[c]) * (got[c] - mean[c]) * l[2] * v[2];
            size += mean[c] * mean[c] * l[2] * v[2];
        }
    }
    printf("# relative error %.4f\n", sqrt(error / size));
    assert_true(sqrt(error / size) < 0.02);
}

static void measured_materials_are_met_at_4_kilobytes(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double bound;
    } materials[] = {{"paper_white_rgb.bsdf", 0.31}, {"merl_sgd.csv:red-phenolic", 0.08}};
    const char *folder = getenv("GONIOTILE_DATA");
    folder = folder ? folder : "../shared/data";
    char *probe = xasprintf("%s/brdf/merl_sgd.csv", folder);
    bool there = !access(probe, R_OK);
    free(probe);
    if (!there)
        skip();
    for (int i = 0; i < 2; i++) {
        char *path = xasprintf("%s/brdf/%s", folder, materials[i].name);
        struct brdf_source source, truth;
        source_open(&source, path);
        source_make_symmetric(&truth, &source);
        struct half_vector t = build(&source, 26, 13, 3);
        double de = colour_difference(&t, &truth);
        printf("# %s: mean dE %.3f\n", materials[i].name, de);
        assert_true(de < materials[i].bound);
        half_vector_free(&t);
        source_close(&source);
        free(path);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_equal_those_of_the_reference_with_and_without_the_packed_copy),
        cmocka_unit_test(metadata_of_the_caller_is_sorted_in),
        cmocka_unit_test(reading_a_file_gives_the_table_back),
        cmocka_unit_test(every_size_is_accepted_and_within_its_budget),
        cmocka_unit_test(building_twice_gives_the_same_bits),
        cmocka_unit_test(value_equals_the_reference_and_is_reciprocal_to_the_bit),
        cmocka_unit_test(azimuth_is_without_effect_where_it_is_undefined),
        cmocka_unit_test(constant_brdf_keeps_its_albedo),
        cmocka_unit_test(sharp_lobes_create_no_energy_and_lose_little),
        cmocka_unit_test(lobes_too_narrow_for_the_axis_create_no_energy),
        cmocka_unit_test(lobes_and_retroreflectors_are_met_at_4_kilobytes),
        cmocka_unit_test(a_source_that_is_not_reciprocal_is_made_so),
        cmocka_unit_test(measured_materials_are_met_at_4_kilobytes),
    };
    return cmocka_run_group_tests(tests, crooked_set_up, crooked_tear_down);
}
