/* What app_init refuses. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "device_fixture.h"

/* An entry as large as may be is taken, a larger one is not: each entry, and those that lights multiply have less. */
static void costs_out_of_range_are_refused(void **state)
{
    static struct app app;
    struct sim_device *d = fixture_device(false, false);
    struct app_config config = d->config;
    struct raster_costs costs = *d->config.costs;
    uint32_t *const entries[] = {&costs.tile, &costs.survey, &costs.plan, &costs.shading[0].material,
                                 &costs.shading[RASTER_SHADE_COUNT - 1].flat};
    uint32_t *const of_samples[] = {&costs.part,
                                    &costs.cell,
                                    &costs.shading[0].sample,
                                    &costs.shading[1].lit,
                                    &costs.shading[2].dark,
                                    &costs.shading[RASTER_SHADE_METALLIC_ROUGHNESS].point};
    (void)state;
    config.costs = &costs;
    for (size_t i = 0; i < 11; i++) {
        uint32_t *entry = i < 5 ? entries[i] : of_samples[i - 5], was = *entry;
        *entry = i < 5 ? APP_MOST_COST : APP_MOST_SAMPLE_COST;
        assert_int_equal(app_init(&app, d->app.hal, &config), APP_OK);
        ++*entry;
        assert_int_equal(app_init(&app, d->app.hal, &config), APP_ERR_CONFIG);
        *entry = was;
    }
    costs.clear = costs.tile + 1; /* part of it */
    assert_int_equal(app_init(&app, d->app.hal, &config), APP_ERR_CONFIG);
    costs = *d->config.costs;
    costs.taps[RASTER_TAPS_1] = costs.shading[RASTER_SHADE_HALF_VECTOR].lit + 1; /* likewise */
    assert_int_equal(app_init(&app, d->app.hal, &config), APP_ERR_CONFIG);
    costs = *d->config.costs;
    costs.texels[RASTER_TAPS_8] =
        APP_MOST_SAMPLE_COST - costs.shading[RASTER_SHADE_HALF_VECTOR].point - costs.bright - costs.slow_point;
    assert_int_equal(app_init(&app, d->app.hal, &config), APP_OK);
    costs.texels[RASTER_TAPS_8]++; /* on top of that */
    assert_int_equal(app_init(&app, d->app.hal, &config), APP_ERR_CONFIG);
    costs = *d->config.costs;
    uint32_t *material = &costs.shading[RASTER_SHADE_LAFORTUNE_PHONG].material;
    *material = APP_MOST_COST - RASTER_BROAD_PLANES * costs.broad;
    assert_int_equal(app_init(&app, d->app.hal, &config), APP_OK);
    ++*material; /* broad lobes' planes on top */
    assert_int_equal(app_init(&app, d->app.hal, &config), APP_ERR_CONFIG);
    costs = *d->config.costs;
    uint32_t *point = &costs.shading[RASTER_SHADE_BLINN_PHONG].point;
    *point = APP_MOST_SAMPLE_COST - costs.broad - costs.slow_point;
    assert_int_equal(app_init(&app, d->app.hal, &config), APP_OK);
    ++*point;
    assert_int_equal(app_init(&app, d->app.hal, &config), APP_ERR_CONFIG);
    sim_device_destroy(d);
}

/* What raster_begin would refuse of every frame is refused at the start. */
static void pictures_with_4_samples_are_at_most_half_as_wide_and_high(void **state)
{
    (void)state;
    struct app app;
    struct sim_device *d = fixture_device(false, false);
    struct app_config config = d->app.config;
    config.samples = 4;
    for (unsigned i = 0; i < 2; i++) {
        uint16_t *edge = i ? &config.height : &config.width;
        const uint16_t was = *edge;
        *edge = RASTER_MAX_WIDTH / 2;
        assert_int_equal(app_init(&app, d->app.hal, &config), APP_OK);
        ++*edge;
        assert_int_equal(app_init(&app, d->app.hal, &config), APP_ERR_CONFIG);
        *edge = was;
    }
    sim_device_destroy(d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(costs_out_of_range_are_refused),
        cmocka_unit_test(pictures_with_4_samples_are_at_most_half_as_wide_and_high),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
