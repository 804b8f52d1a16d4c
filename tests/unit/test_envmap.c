/* host_envmap: the lights that stand for an environment map have its energy, stand where it is bright, and show nearly what it shows. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "brdf_fixture.h"
#include "envlight_fixture.h"

enum { WIDTH = 64, HEIGHT = 32 };

static void pixel_set(float *map, int x, int y, double r, double g, double b)
{
    float *p = map + 3 * (y * WIDTH + x);
    p[0] = (float)r;
    p[1] = (float)g;
    p[2] = (float)b;
}

static void map_make(struct environment *e, const float *map)
{
    environment_make(e, WIDTH, HEIGHT, map);
}

/* Noise over six orders of magnitude. */
static void noise_map(struct environment *e, uint32_t seed)
{
    static float map[3 * WIDTH * HEIGHT];
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++)
        map[i] = (float)pow(10, 6 * random_unit(&seed) - 3);
    map_make(e, map);
}

/* A blue sky that is brighter towards the horizon, brown ground, a low sun with a glow around it and a lamp. */
static void outdoor_map(struct environment *e)
{
    static float map[3 * WIDTH * HEIGHT];
    const double sun[3] = {0.6, 0.28, 0.75};
    environment_make(e, WIDTH, HEIGHT, map);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            double d[3];
            environment_direction(d, e, x + 0.5, y + 0.5);
            double near = envlight_dot(d, sun), glow = 0.8 * exp(30 * (near - 1)) + (near > 0.995 ? 60 : 0);
            double sky = 0.3 + 0.5 * exp(-4 * fabs(d[1]));
            if (d[1] < 0)
                pixel_set(map, x, y, 0.12, 0.09, 0.06);
            else
                pixel_set(map, x, y, 0.5 * sky + glow, 0.7 * sky + 0.8 * glow, sky + 0.5 * glow);
        }
    for (int x = 4; x < 8; x++)
        for (int y = 12; y < 15; y++)
            pixel_set(map, x, y, 4, 1, 0.3);
    environment_free(e);
    map_make(e, map);
}

static void irradiance_sum(double sum[3], const struct envmap_light *lights, unsigned count)
{
    memset(sum, 0, 3 * sizeof *sum);
    for (unsigned k = 0; k < count; k++)
        for (int c = 0; c < 3; c++)
            sum[c] += lights[k].irradiance[c];
}

static void the_lights_have_all_the_energy_of_the_map(void **state)
{
    (void)state;
    for (unsigned count = ENVMAP_MIN_LIGHTS; count <= ENVMAP_MAX_LIGHTS; count += 5) {
        struct environment e;
        struct envmap_light lights[ENVMAP_MAX_LIGHTS];
        double want[3] = {0}, got[3];
        noise_map(&e, count);
        assert_int_equal(envmap_lights(lights, count, &e), count);
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            for (int c = 0; c < 3; c++)
                want[c] += (double)e.rgb[3 * i + c] * environment_solid_angle(&e, i / WIDTH);
        irradiance_sum(got, lights, count);
        for (int c = 0; c < 3; c++)
            assert_true(fabs(got[c] - want[c]) < 1e-9 * want[c]);
        environment_free(&e);
    }
}

static void lights_are_unit_vectors_the_brightest_first(void **state)
{
    (void)state;
    struct environment e;
    struct envmap_light lights[ENVMAP_MAX_LIGHTS];
    double last = INFINITY;
    noise_map(&e, 7);
    assert_int_equal(envmap_lights(lights, 20, &e), 20);
    for (int k = 0; k < 20; k++) {
        const double *i = lights[k].irradiance, bright = 0.2126 * i[0] + 0.7152 * i[1] + 0.0722 * i[2];
        assert_true(fabs(envlight_dot(lights[k].direction, lights[k].direction) - 1) < 1e-12);
        assert_true(bright > 0 && bright <= last);
        last = bright;
    }
    environment_free(&e);
}

/* Eight spots, one of them at a pole, on black. */
static void spots_on_black_get_one_light_each(void **state)
{
    (void)state;
    static const int spots[8][2] = {{0, 9}, {20, 0}, {20, 12}, {24, 12}, {40, 20}, {41, 28}, {50, 16}, {60, 10}};
    static float map[3 * WIDTH * HEIGHT];
    struct environment e;
    struct envmap_light lights[ENVMAP_MAX_LIGHTS];
    memset(map, 0, sizeof map);
    for (int i = 0; i < 8; i++)
        pixel_set(map, spots[i][0], spots[i][1], 1 + i, 1 + i, 2);
    map_make(&e, map);
    assert_int_equal(envmap_lights(lights, 32, &e), 8);
    for (int i = 0; i < 8; i++) {
        double d[3], best = -1;
        environment_direction(d, &e, spots[i][0] + 0.5, spots[i][1] + 0.5);
        for (int k = 0; k < 8; k++)
            best = fmax(best, envlight_dot(d, lights[k].direction));
        assert_true(best > 1 - 1e-12);
    }
    environment_free(&e);
}

static void a_black_map_has_no_light(void **state)
{
    (void)state;
    static float map[3 * WIDTH * HEIGHT];
    struct environment e;
    struct envmap_light lights[ENVMAP_MAX_LIGHTS];
    memset(map, 0, sizeof map);
    map_make(&e, map);
    assert_int_equal(envmap_lights(lights, 16, &e), 0);
    environment_free(&e);
}

/* Pixels of the map fall into 4 x 2: fewer than lights. */
static void a_map_of_eight_pixels_has_eight_lights(void **state)
{
    (void)state;
    static const float map[24] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 1, 2, 3, 4, 5, 6, 7, 8, 9, 1, 2, 3, 4, 5, 6};
    struct environment e;
    struct envmap_light lights[ENVMAP_MAX_LIGHTS];
    environment_make(&e, 4, 2, map);
    assert_int_equal(envmap_lights(lights, 64, &e), 8);
    environment_free(&e);
}

/* Differences from numerical integration with K = 4, 16 and 64 lights. */
static void differences(double out[3], const struct environment *e, const struct brdf_source *f, int step)
{
    static struct envlight_picture p;
    static const unsigned counts[3] = {4, 16, 64};
    envlight_reference(&p, e, f, step);
    for (int i = 0; i < 3; i++) {
        struct envmap_light lights[ENVMAP_MAX_LIGHTS];
        out[i] = envlight_difference(&p, lights, envmap_lights(lights, counts[i], e), f);
    }
}

/* The bounds of SPEC.md, "Environment light". */
static void sixteen_lights_show_a_sphere_nearly_as_the_map_does(void **state)
{
    (void)state;
    static const struct ref_material fairly_rough = {
        .kind = REF_MICROFACET, .kd = {0.5, 0.3, 0.1}, .roughness = 0.7, .eta = {1.5, 1.5, 1.5}};
    const struct brdf_source white = {.value = envlight_white},
                             plastic = {.value = model_value, .ctx = (void *)&fairly_rough};
    struct environment e;
    double de[3];
    outdoor_map(&e);
    differences(de, &e, &white, 2);
    print_message("# white: dE %.3f with 4 lights, %.3f with 16, %.3f with 64\n", de[0], de[1], de[2]);
    assert_true(de[1] < 0.6 && de[0] > de[1] && de[1] > de[2]);
    differences(de, &e, &plastic, 2);
    print_message("# rough plastic: dE %.3f with 4 lights, %.3f with 16, %.3f with 64\n", de[0], de[1], de[2]);
    assert_true(de[1] < 0.7 && de[0] > de[1] && de[1] > de[2]);
    environment_free(&e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_lights_have_all_the_energy_of_the_map),
                                       cmocka_unit_test(lights_are_unit_vectors_the_brightest_first),
                                       cmocka_unit_test(spots_on_black_get_one_light_each),
                                       cmocka_unit_test(a_black_map_has_no_light),
                                       cmocka_unit_test(a_map_of_eight_pixels_has_eight_lights),
                                       cmocka_unit_test(sixteen_lights_show_a_sphere_nearly_as_the_map_does)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
