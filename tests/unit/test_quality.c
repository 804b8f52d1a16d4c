/*
 * How many samples rungs of shading are said to take, by hand; and that no surface of a box gets more of a light than is said.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>

#include <cmocka.h>
#include <string.h>

#include "internal.h"
#include "point_light.h"
#include "quality.h"

static uint64_t seed = 1;

static uint32_t random_u32(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(seed >> 32);
}

static int32_t random_in(int32_t lo, int32_t hi)
{
    return lo + (int32_t)(random_u32() % ((uint32_t)(hi - lo) + 1));
}

static void no_point_of_a_box_gets_more_light(void **state)
{
    unsigned reached = 0;
    (void)state;
    for (int n = 0; n < 300000; n++) {
        const int32_t scale = 1 << (6 + random_u32() % 20);
        const uint32_t radius = (uint32_t)random_in(1, 2 * scale);
        struct raster_light_box box;
        const struct vec3 a = {random_in(-scale, scale), random_in(-scale, scale), random_in(-scale, scale)},
                          light = {random_in(-scale, scale), random_in(-scale, scale), random_in(-scale, scale)};
        box.lo = a;
        box.hi = (struct vec3){a.x + random_in(0, scale), a.y + random_in(0, scale), a.z + random_in(0, scale)};
        const uint32_t most = raster_light_box_attenuation(&box, &light, radius);
        for (int i = 0; i < 4; i++) {
            const struct vec3 p = {random_in(box.lo.x, box.hi.x), random_in(box.lo.y, box.hi.y),
                                   random_in(box.lo.z, box.hi.z)};
            struct vec3 l;
            uint32_t attenuation;
            if (!raster_point_light(&l, &attenuation, &light, radius, p))
                continue;
            reached++;
            assert_true(attenuation <= most);
        }
    }
    assert_true(reached > 10000);
}

/* A square of a x a pixels anywhere among cells meets so many of them on average. */
static void likely_samples_are_those_of_squares(void **state)
{
    struct raster r = {0};
    struct raster_survey s = {.slots = 9, .meshlets = {5}};
    (void)state;
    for (uint32_t a = 1; a <= 40; a++) {
        const struct raster_area area = {.pixels = (uint16_t)(a * a), .cells = (uint16_t)((a + 3) * (a + 3) / 16)};
        const double want[RASTER_RATE_FLAT] = {a * a, (a + 1) * a / 2.0, (a + 1) * (a + 1) / 4.0,
                                               (a + 3) * (a + 1) / 8.0, (a + 3) * (a + 3) / 16.0};
        uint32_t likely[RASTER_RATE_COUNT];
        raster_samples_likely(likely, &r, &s, 0, &area);
        for (int rate = 0; rate < RASTER_RATE_FLAT; rate++) {
            assert_true(likely[rate] <= want[rate] * 1.02 + 1.5 && likely[rate] >= want[rate] * 0.96 - 1.5);
            assert_true(likely[rate] <= raster_samples_most(&r, &s, 0, &area, (enum raster_rate)rate) + 1);
        }
        assert_int_equal(likely[RASTER_RATE_FLAT], area.cells < 5 ? area.cells : 5);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_point_of_a_box_gets_more_light),
        cmocka_unit_test(likely_samples_are_those_of_squares),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
