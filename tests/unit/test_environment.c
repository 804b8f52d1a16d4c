/* host_environment: what a surface reflects of an environment map is the integral over all its pixels. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "brdf_fixture.h"
#include "host_environment.h"

static const double pi = 3.14159265358979323846;
static const double up[3] = {0, 0, 1};

static const struct ref_material shiny = {
    .kind = REF_MICROFACET, .roughness = 0.25, .eta = {0.2, 0.9, 1.1}, .k = {3.9, 2.4, 2.2}};

static struct brdf_source source_of(const struct ref_material *m)
{
    return (struct brdf_source){.value = model_value, .ctx = (void *)m};
}

static void random_direction(double d[3], uint32_t *state)
{
    double z = 2 * random_unit(state) - 1, phi = 2 * pi * random_unit(state), r = sqrt(1 - z * z);
    d[0] = r * cos(phi);
    d[1] = r * sin(phi);
    d[2] = z;
}

/* A view `theta` from n. */
static void view_at(double v[3], const double n[3], double theta, uint32_t *state)
{
    double t[3], along, length = 0;
    random_direction(t, state);
    along = t[0] * n[0] + t[1] * n[1] + t[2] * n[2];
    for (int c = 0; c < 3; c++) {
        t[c] -= along * n[c];
        length += t[c] * t[c];
    }
    for (int c = 0; c < 3; c++)
        v[c] = cos(theta) * n[c] + sin(theta) * t[c] / sqrt(length);
}

static void constant_map(struct environment *e, int width, int height, double radiance)
{
    float *rgb = malloc(3 * sizeof *rgb * (size_t)(width * height));
    for (int i = 0; i < 3 * width * height; i++)
        rgb[i] = (float)radiance;
    environment_make(e, width, height, rgb);
    free(rgb);
}

/* Dim noise and a sun of one pixel that sends as much light as all the rest. */
static void sunny_map(struct environment *e, int width, int height, uint32_t seed)
{
    float *rgb = malloc(3 * sizeof *rgb * (size_t)(width * height));
    for (int i = 0; i < 3 * width * height; i++)
        rgb[i] = (float)random_unit(&seed);
    for (int c = 0; c < 3; c++)
        rgb[3 * (height / 3 * width + width / 5) + c] = 0.4f * (float)(width * height);
    environment_make(e, width, height, rgb);
    free(rgb);
}

/* The reverse of environment_direction. */
static void map_point(double *x, double *y, const struct environment *e, const double d[3])
{
    double latitude = atan2(d[1], hypot(d[0], d[2])), longitude = atan2(d[0], d[2]);
    *x = (0.5 - longitude / (2 * pi)) * e->width;
    *y = (0.5 - latitude / pi) * e->height;
}

static void directions_are_those_of_the_pixels(void **state)
{
    (void)state;
    struct environment e;
    double d[3], x, y, whole = 0;
    uint32_t seed = 1;
    constant_map(&e, 36, 17, 1);
    static const double places[][5] = {
        {18, 8.5, 0, 0, 1}, {9, 8.5, 1, 0, 0}, {27, 8.5, -1, 0, 0}, {5, 0, 0, 1, 0}, {0, 8.5, 0, 0, -1}};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        environment_direction(d, &e, places[i][0], places[i][1]);
        for (int c = 0; c < 3; c++)
            assert_true(fabs(d[c] - places[i][2 + c]) < 1e-12);
    }
    for (int i = 0; i < 1000; i++) {
        double px = 36 * random_unit(&seed), py = 17 * random_unit(&seed);
        environment_direction(d, &e, px, py);
        map_point(&x, &y, &e, d);
        assert_true(fabs(x - px) < 1e-9 && fabs(y - py) < 1e-9);
    }
    for (int row = 0; row < 17; row++)
        whole += 36 * environment_solid_angle(&e, row);
    assert_true(fabs(whole - 4 * pi) < 1e-12);
    environment_free(&e);
}

static void white_furnace(const struct ref_material *m, double tolerance)
{
    struct environment e;
    struct brdf_source f = source_of(m);
    uint32_t seed = 3;
    for (int size = 0; size < 2; size++) {
        constant_map(&e, size ? 256 : 32, size ? 128 : 15, 2.5);
        for (int theta = 0; theta <= 80; theta += 20)
            for (int i = 0; i < 4; i++) {
                double n[3], v[3], got[3], albedo[3];
                random_direction(n, &seed);
                view_at(v, n, theta * pi / 180, &seed);
                environment_reflect(got, &e, &f, n, v, 1);
                ref_albedo(albedo, ref_brdf_of_material, m, theta * pi / 180, 256);
                for (int c = 0; c < 3; c++)
                    if (!(fabs(got[c] / 2.5 - albedo[c]) <= tolerance * albedo[c]))
                        fail_msg("%d degrees, channel %d: %g, albedo %g", theta, c, got[c] / 2.5, albedo[c]);
            }
        environment_free(&e);
    }
}

static void lambert_in_a_white_furnace_shows_its_albedo(void **state)
{
    (void)state;
    white_furnace(&lambert, 0.002);
}

static void glossy_surfaces_in_a_white_furnace_show_their_albedo(void **state)
{
    (void)state;
    white_furnace(&rough, 0.005);
    white_furnace(&shiny, 0.005);
}

/* Every pixel in parts x parts pieces. */
static void exhaustive(double sum[3], const struct environment *e, const struct ref_material *m, const double n[3],
                       const double v[3], int parts)
{
    memset(sum, 0, 3 * sizeof *sum);
    for (int y = 0; y < e->height * parts; y++) {
        double t0 = pi * y / (e->height * parts), t1 = pi * (y + 1) / (e->height * parts);
        double solid = (cos(t0) - cos(t1)) * 2 * pi / (e->width * parts);
        for (int x = 0; x < e->width * parts; x++) {
            double latitude = pi / 2 - (t0 + t1) / 2, longitude = pi * (1 - 2 * (x + 0.5) / (e->width * parts)), f[3];
            double l[3] = {cos(latitude) * sin(longitude), sin(latitude), cos(latitude) * cos(longitude)};
            double nl = n[0] * l[0] + n[1] * l[1] + n[2] * l[2];
            if (nl <= 0)
                continue;
            ref_model_value(f, m, n, l, v);
            for (int c = 0; c < 3; c++)
                sum[c] += f[c] * e->rgb[3 * (y / parts * e->width + x / parts) + c] * nl * solid;
        }
    }
}

static void summation_over_every_pixel_agrees(void **state)
{
    (void)state;
    static const struct ref_material *const materials[] = {&lambert, &rough, &shiny};
    struct environment e;
    uint32_t seed = 11;
    sunny_map(&e, 64, 32, 5);
    for (int k = 0; k < 3; k++) {
        struct brdf_source f = source_of(materials[k]);
        for (int i = 0; i < 8; i++) {
            double n[3], v[3], got[3], want[3];
            random_direction(n, &seed);
            view_at(v, n, 1.4 * random_unit(&seed), &seed);
            environment_reflect(got, &e, &f, n, v, 1);
            exhaustive(want, &e, materials[k], n, v, 8);
            for (int c = 0; c < 3; c++)
                if (!(fabs(got[c] - want[c]) <= 0.01 * want[c]))
                    fail_msg("material %d, channel %d: %g, not %g", k, c, got[c], want[c]);
        }
    }
    environment_free(&e);
}

static void count_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    (void)v;
    ++*(size_t *)ctx;
    assert_true(l[2] > 0 && fabs(l[0] * l[0] + l[1] * l[1] + l[2] * l[2] - 1) < 1e-9);
    rgb[0] = rgb[1] = rgb[2] = 1;
}

static void a_point_takes_a_few_thousand_evaluations(void **state)
{
    (void)state;
    struct environment e;
    size_t count = 0, points = 0, most = 0;
    struct brdf_source f = {.value = count_value, .ctx = &count};
    uint32_t seed = 7;
    sunny_map(&e, 256, 128, 5);
    for (int theta = 0; theta < 90; theta += 3, points++) {
        double n[3], v[3], rgb[3];
        size_t before = count;
        random_direction(n, &seed);
        view_at(v, n, theta * pi / 180, &seed);
        environment_reflect(rgb, &e, &f, n, v, 1);
        if (count - before > most)
            most = count - before;
    }
    print_message("evaluations: mean %zu, most %zu\n", count / points, most);
    assert_in_range(count / points, 500, 4000);
    environment_free(&e);
}

static void nothing_is_seen_from_behind(void **state)
{
    (void)state;
    struct environment e;
    struct brdf_source f = source_of(&lambert);
    double v[3] = {0.6, 0, -0.8}, rgb[3] = {1, 1, 1};
    constant_map(&e, 8, 4, 1);
    environment_reflect(rgb, &e, &f, up, v, 1);
    assert_true(rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0);
    environment_free(&e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(directions_are_those_of_the_pixels),
        cmocka_unit_test(lambert_in_a_white_furnace_shows_its_albedo),
        cmocka_unit_test(glossy_surfaces_in_a_white_furnace_show_their_albedo),
        cmocka_unit_test(summation_over_every_pixel_agrees),
        cmocka_unit_test(a_point_takes_a_few_thousand_evaluations),
        cmocka_unit_test(nothing_is_seen_from_behind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
