/* gtlut preview: marks, the depth buffer, the finely sampled material, and a sphere in a white furnace. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "brdf_fixture.h"
#include "host_preview_internal.h"

static const double pi = 3.14159265358979323846;

static const struct ref_material shiny = {
    .kind = REF_MICROFACET, .roughness = 0.3, .eta = {0.2, 0.9, 1.1}, .k = {3.9, 2.4, 2.2}};
static const struct ref_material phong = {/* not reciprocal */
                                          .kind = REF_PHONG,
                                          .kd = {0.3, 0.3, 0.3},
                                          .ks = {0.4, 0.5, 0.6},
                                          .exponent = 20};

static struct preview preview_of(const struct ref_material *m)
{
    return (struct preview){.source = {.value = model_value, .ctx = (void *)m, .theta_in = 90, .theta_out = 90}};
}

static void finely_sampled_material_agrees(void **state)
{
    (void)state;
    static const struct ref_material *const materials[] = {&lambert, &rough, &shiny, &phong};
    uint32_t seed = 1;
    for (int k = 0; k < 4; k++) {
        struct preview p = preview_of(materials[k]);
        struct preview_fast *fast = preview_fast_make(&p, 2, 1);
        struct brdf_source f;
        double worst = 0, sum = 0;
        preview_fast_source(&f, fast);
        for (int i = 0; i < 4000; i++) {
            double l[3], v[3], got[3], want[3];
            preview_direction(l, 80 * random_unit(&seed), 360 * random_unit(&seed));
            preview_direction(v, 80 * random_unit(&seed), 360 * random_unit(&seed));
            f.value(got, f.ctx, l, v);
            model_value(want, materials[k], l, v);
            for (int c = 0; c < 3; c++) {
                double error = fabs(got[c] / want[c] - 1);
                worst = fmax(worst, error);
                sum += error / 12000;
            }
        }
        if (worst > 0.1 || sum > 0.005)
            fail_msg("material %d: mean relative error %g, worst %g", k, sum, worst);
        preview_fast_free(fast);
    }
}

/* theta_in 0, 30, 60; theta_out 0, 20, ... 80, the last extrapolated; two samples filled in. */
static void make_samples(struct measurement_grid *g)
{
    struct measurement m;
    measurement_init(&m, "samples");
    for (int i = 0; i <= 60; i += 30)
        for (int j = 0; j <= 80; j += 20)
            for (int k = 0; k < 360; k += 30) {
                uint32_t mark = j == 80                                       ? MEASUREMENT_EXTRAPOLATED
                                : i == 30 && j == 20 && (k == 330 || k == 30) ? MEASUREMENT_FILLED
                                                                              : MEASURED;
                struct measurement_point point = {(float)i, (float)j, (float)k, {1, 1, 1}, mark};
                measurement_add(&m, &point);
            }
    measurement_grid_make(g, &m, "samples");
    measurement_free(&m);
}

static enum measurement_mark mark_at(const struct preview *p, double theta_in, double theta_out, double phi)
{
    double l[3], v[3];
    preview_direction(l, theta_in, 123);
    preview_direction(v, theta_out, 123 + phi);
    return preview_mark(p, l, v);
}

static void marks_are_those_of_the_nearest_sample(void **state)
{
    (void)state;
    struct preview p = preview_of(&lambert);
    make_samples(&p.samples);
    assert_int_equal(mark_at(&p, 25, 40, 70), MEASURED);
    assert_int_equal(mark_at(&p, 59, 69, 180), MEASURED);
    assert_int_equal(mark_at(&p, 35, 75, 180), MEASUREMENT_EXTRAPOLATED);
    assert_int_equal(mark_at(&p, 35, 85, 180), MEASUREMENT_EXTRAPOLATED);
    assert_int_equal(mark_at(&p, 70, 20, 180), MEASURED); /* the other way round */
    assert_int_equal(mark_at(&p, 65, 65, 180), MEASUREMENT_EXTRAPOLATED);
    assert_int_equal(mark_at(&p, 29, 21, 340), MEASUREMENT_FILLED);
    assert_int_equal(mark_at(&p, 29, 21, -20), MEASUREMENT_FILLED);
    assert_int_equal(mark_at(&p, 29, 21, 0), MEASURED);
    assert_int_equal(mark_at(&p, 31, 22, 340), MEASURED); /* the other way round: theta_out 40 */
    measurement_grid_free(&p.samples);

    p.source.theta_in = 60; /* no samples: as far as the source says */
    p.source.theta_out = 75;
    assert_int_equal(mark_at(&p, 60, 75, 0), MEASURED);
    assert_int_equal(mark_at(&p, 61, 10, 0), MEASUREMENT_EXTRAPOLATED);
    assert_int_equal(mark_at(&p, 10, 76, 0), MEASUREMENT_EXTRAPOLATED);
}

static void depth_buffer_shows_what_is_in_front(void **state)
{
    (void)state;
    /* A square that covers all samples, and a triangle that pierces it. */
    static const double points[][3] = {{0, 0, 0},  {8, 0, 0},   {8, 8, 0},   {0, 8, 0},
                                       {0, 0, -1}, {20, 0, 19}, {0, 20, -1}, {50, 50, 3}};
    static const unsigned indices[] = {0, 1, 2, 0, 2, 3, 4, 5, 6};
    struct preview_hit *hits = preview_rasterize(8, 8, points, indices, 9);
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 8; x++) {
            const struct preview_hit *hit = &hits[8 * y + x];
            double px = x + 0.5, py = 8 - y - 0.5; /* top row first */
            unsigned want = px > 1 ? 7 : px > py ? 1 : 4;
            if (px != py || px > 1)
                assert_int_equal(hit->triangle, want);
            if (want == 7) {
                assert_true(fabs(hit->z - (px - 1)) < 1e-5);
                assert_true(fabs(hit->share[0] - px / 20) < 1e-6 && fabs(hit->share[1] - py / 20) < 1e-6);
            }
        }
    free(hits);
}

static void furnace(struct environment *e)
{
    static float rgb[16 * 8 * 3];
    for (int i = 0; i < 16 * 8 * 3; i++)
        rgb[i] = 2;
    environment_make(e, 16, 8, rgb);
}

static void sphere_in_a_white_furnace_shows_its_albedo(void **state)
{
    (void)state;
    struct environment e;
    struct preview p = preview_of(&lambert), shining = preview_of(&shiny);
    furnace(&e);
    for (int exact = 0; exact < 2; exact++) {
        struct preview_view view = {.environment = &e, .size = 12, .exposure = 1, .threads = 2, .coarseness = 1};
        struct preview_image image;
        double covered = 0;
        preview_render(&image, &p, &view, exact);
        for (int i = 0; i < 12 * 12; i++) {
            covered += image.coverage[i];
            for (int c = 0; c < 3; c++) {
                double want = image.coverage[i] > 0 ? 2 * lambert.kd[c] : 0;
                if (!(fabs(image.radiance[i][c] - want) <= 0.01 * want))
                    fail_msg("pixel %d: %g, not %g", i, image.radiance[i][c], want);
            }
            assert_int_equal(image.extrapolated[i], 0);
        }
        assert_true(fabs(covered / (pi * 5.5 * 5.5) - 1) < 0.02);
        preview_image_free(&image);

        preview_render(&image, &shining, &view, exact);
        for (int x = 1; x < 11; x++) { /* the row above the middle: theta of each pixel */
            double theta = asin(hypot(x - 5.5, 0.5) / 5.5), want[3];
            ref_albedo(want, ref_brdf_of_material, &shiny, theta, 256);
            for (int c = 0; c < 3; c++)
                if (!(fabs(image.radiance[5 * 12 + x][c] / 2 - want[c]) <= 0.02 * want[c]))
                    fail_msg("exact %d, column %d: %g, not %g", exact, x, image.radiance[5 * 12 + x][c] / 2, want[c]);
        }
        preview_image_free(&image);
    }
    environment_free(&e);
}

static void hatching_follows_what_is_extrapolated(void **state)
{
    (void)state;
    struct environment e;
    struct preview p = preview_of(&lambert);
    struct preview_view view = {.environment = &e, .size = 24, .exposure = 1, .threads = 1, .coarseness = 2};
    struct preview_image image;
    furnace(&e);
    p.source.theta_out = 45; /* of views: outside 0.707 of the radius */
    preview_render(&image, &p, &view, false);
    for (int i = 0; i < 24 * 24; i++) {
        double r = hypot(i % 24 - 11.5, i / 24 - 11.5) / 11.5;
        if (image.coverage[i] > 0 && fabs(r - 0.707) > 0.08)
            assert_int_equal(image.extrapolated[i], r > 0.707);
    }
    static uint8_t rgb[24 * 24 * 3];
    assert_int_equal(preview_place(rgb, 24, 0, 0, &image, &view), 1u << MEASURED | 1u << MEASUREMENT_EXTRAPOLATED);
    preview_image_free(&image);
    environment_free(&e);
}

static void mesh_is_seen_with_its_normals(void **state)
{
    (void)state;
    static struct mesh_vertex vertices[] = {
        {{-1, -1, 0}, {0, 0, 1}}, {{1, -1, 0}, {0, 0, 1}}, {{1, 1, 0}, {0, 0, 1}}, {{-1, 1, 0}, {0, 0, 1}}};
    static unsigned indices[] = {0, 1, 2, 0, 2, 3};
    struct mesh mesh = {vertices, indices, 4, 6};
    struct environment e;
    struct preview p = preview_of(&lambert);
    struct preview_view view = {
        .environment = &e, .mesh = &mesh, .size = 20, .exposure = 1, .threads = 1, .coarseness = 1};
    struct preview_image image;
    float rgb[16 * 8 * 3] = {0};
    for (int x = 0; x < 16; x++) /* the upper half of the map shines */
        for (int i = 0; i < 4 * 3; i++)
            rgb[3 * (i / 3 * 16 + x) + i % 3] = 1;
    environment_make(&e, 16, 8, rgb);
    preview_render(&image, &p, &view, true);
    assert_int_equal(image.width, 20);
    int middle = image.height / 2 * image.width + image.width / 2;
    assert_true(fabs(image.coverage[middle] - 1) < 1e-5);
    /* Tipped towards the viewer by 12 degrees, the normal looks down by as much: (1 - sin 12) / 2 of the light. */
    double want = 0.8 * (1 - sin(12 * pi / 180)) / 2;
    if (!(fabs(image.radiance[middle][0] - want) < 0.01 * want))
        fail_msg("%g, not %g", image.radiance[middle][0], want);
    preview_image_free(&image);
    environment_free(&e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finely_sampled_material_agrees),
        cmocka_unit_test(marks_are_those_of_the_nearest_sample),
        cmocka_unit_test(depth_buffer_shows_what_is_in_front),
        cmocka_unit_test(sphere_in_a_white_furnace_shows_its_albedo),
        cmocka_unit_test(hatching_follows_what_is_extrapolated),
        cmocka_unit_test(mesh_is_seen_with_its_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
