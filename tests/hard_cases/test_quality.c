/*
 * Rungs of shading: the steps at full quality are the whole, coarse rates keep every edge and what a survey promised, lights left out
 * are the weakest.
 */
#include "scene_fixture.h"

#include "internal.h"
#include "point_light.h"
#include "quality.h"

enum { WIDTH = 150, HEIGHT = 109, PIXELS = WIDTH * HEIGHT };

static struct raster r;
static struct raster_tile work;
static struct raster_memory memory;
static uint64_t arena[1 << 17];

struct shown {
    uint8_t rgb[PIXELS][3];
    uint32_t samples, most, likely, cells, tried, passes; /* summed over tiles and their passes */
};

/* Through the steps, half of the classes at `rate`, the others at `other`; checks each survey against the surfaces. */
static void show_mixed(struct shown *out, const struct raster_frame *f, enum raster_rate rate, enum raster_rate other,
                       uint8_t lights)
{
    *out = (struct shown){0};
    assert_int_equal(raster_begin(&r, f, arena, sizeof arena), RASTER_OK);
    struct raster_quality q = {.lights = lights};
    memset(q.rate, rate, sizeof q.rate);
    memset(q.rate + RASTER_CLASSES / 2, other, sizeof q.rate - RASTER_CLASSES / 2);
    for (uint32_t t = 0; t < raster_tile_count(&r); t++) {
        struct raster_rect rect;
        struct raster_stats stats;
        memset(&work, 0xa5, sizeof work);
        raster_tile_begin(&r, t, &work, &rect, &stats);
        for (bool full = true; full;) {
            full = raster_tile_draw(&r, &work, UINT32_MAX, &stats) == RASTER_NO_SLOT;
            uint32_t waiting = 0, counted = 0, before = stats.samples, most = 0;
            for (unsigned i = 0; i < RASTER_TILE_PIXELS; i++) {
                const uint32_t x = i % RASTER_TILE_WIDTH >> r.sample_shift, y = i / RASTER_TILE_WIDTH >> r.sample_shift;
                waiting += x < rect.width && y < rect.height && (work.surface[i].depth_slot & 255);
            }
            const struct raster_survey *s = raster_tile_survey(&r, &work, &rect);
            for (uint32_t c = 0; c < s->classes; c++) {
                uint32_t likely[RASTER_RATE_COUNT];
                counted += s->total[c].pixels;
                raster_samples_likely(likely, &r, s, c, &s->total[c]);
                out->likely += likely[rate];
                out->cells += s->total[c].cells;
                most += raster_samples_most(&r, s, c, &s->total[c], rate);
            }
            assert_int_equal(counted, waiting);
            for (uint32_t i = 0; i < s->regions; i++)
                raster_tile_shade(&r, &work, &rect, i, &q, &stats);
            if (full)
                raster_tile_free_slots(&r, &work, &rect, &stats);
            if (rate == other && rate != RASTER_RATE_1X1)
                assert_true(stats.samples - before <= most);
            out->most += most;
            out->passes++;
        }
        raster_tile_finish(&r, &work, &rect, &stats);
        out->samples += stats.samples;
        out->tried += stats.tried;
        for (unsigned y = 0; y < rect.height; y++)
            memcpy(out->rgb[(rect.y + y) * WIDTH + rect.x], raster_tile_pixels(&work) + 3u * y * rect.width,
                   3u * rect.width);
    }
}

static void show(struct shown *out, const struct raster_frame *f, enum raster_rate rate, uint8_t lights)
{
    show_mixed(out, f, rate, rate, lights);
}

/* Cubes of two materials in a room. Every triangle is a meshlet, so that tiles run out of slots. */
static void open_cubes(struct opened *o)
{
    struct ref_blob b = new_scene();
    random_state = 7;
    const unsigned other = ref_blob_material(&b, 1, 0, 0.3, "other");
    const unsigned cube = add_cube(&b, 1000, 6, false), room = add_cube(&b, 32000, 4, true);
    ref_blob_object(&b, room, 0, origin, 12 / 32000.0);
    for (unsigned i = 0; i < 12; i++) {
        const double p[3] = {random_between(-4, 4), random_between(-3, 3), random_between(-9, -4)};
        ref_blob_object(&b, cube, i % 2 ? other : 0, p, 0.001 * random_between(0.3, 1));
    }

    open_scene(o, &b, WIDTH, HEIGHT);
    ref_blob_free(&b);
}

/* Of `kind`, one red and one blue: what is seen of one has nothing of the other's colour. */
static void set_materials(struct opened *o, struct scene_material m[2], uint8_t kind)
{
    for (unsigned i = 0; i < 2; i++)
        m[i] = (struct scene_material){.kind = kind,
                                       .kd = {i ? 0 : 50000, 0, i ? 30000 : 0},
                                       .ks = {i ? 0 : 20000, 0, i ? 9000 : 0},
                                       .exponent = 20 << 16,
                                       .roughness = 30000};
    o->frame.materials = m;
}

static void steps_at_full_quality_are_the_whole(void **state)
{
    static const uint8_t kinds[] = {SCENE_MATERIAL_LAFORTUNE_PHONG, SCENE_MATERIAL_BLINN_PHONG,
                                    SCENE_MATERIAL_METALLIC_ROUGHNESS};
    static struct shown shown;
    struct opened o;
    struct scene_material m[2];
    (void)state;
    open_cubes(&o);
    for (unsigned i = 0; i < 6; i++) {
        set_materials(&o, m, kinds[i / 2]);
        o.frame.samples = i & 1 ? 4 : 0;
        o.frame.memory = i & 1 ? &memory : NULL;
        show(&shown, &o.frame, RASTER_RATE_1X1, RASTER_ALL_LIGHTS);
        assert_true(shown.passes > raster_tile_count(&r)); /* slots ran out */
        struct picture p = render_frame(&o.frame, FORWARD);
        assert_memory_equal(shown.rgb, p.rgb, sizeof shown.rgb);
        free(p.rgb);
    }
    free(o.blob);
}

/* Triangles are flat here, so diffuse light on one is the same everywhere: no rate may change a pixel by more than rounding, unless it
 * took another triangle's colour. */
static void coarse_rates_keep_every_edge(void **state)
{
    static struct shown full, coarse;
    struct opened o;
    struct scene_material m[2];
    (void)state;
    open_cubes(&o);
    set_materials(&o, m, SCENE_MATERIAL_LAFORTUNE_PHONG);
    for (unsigned i = 0; i < 2; i++)
        memset(m[i].ks, 0, sizeof m[i].ks);
    for (unsigned samples = 1; samples <= 4; samples += 3) {
        o.frame.samples = (uint8_t)samples;
        show(&full, &o.frame, RASTER_RATE_1X1, RASTER_ALL_LIGHTS);
        uint32_t last = full.samples;
        for (int rate = RASTER_RATE_2X1; rate < RASTER_RATE_COUNT; rate++) {
            show(&coarse, &o.frame, (enum raster_rate)rate, RASTER_ALL_LIGHTS);
            for (unsigned i = 0; i < PIXELS; i++)
                for (unsigned c = 0; c < 3; c++)
                    assert_true(abs(full.rgb[i][c] - coarse.rgb[i][c]) <= 2);
            /* with 4 samples per pixel, cells have at most 4 x 4 of them */
            assert_true(coarse.samples < last || (samples == 4 && rate <= RASTER_RATE_4X4 && coarse.samples == last));
            last = coarse.samples;
        }
    }
    free(o.blob);
}

/* Two ways of shading at two rates side by side: every pixel is one of those that there are where all is of one material and rate. */
static void materials_and_rates_side_by_side_change_no_pixel(void **state)
{
    static const uint8_t kinds[] = {SCENE_MATERIAL_LAFORTUNE_PHONG, SCENE_MATERIAL_BLINN_PHONG,
                                    SCENE_MATERIAL_METALLIC_ROUGHNESS};
    static struct shown mixed, alone[4];
    struct opened o;
    struct scene_material m[3][2];
    (void)state;
    open_cubes(&o);
    struct scene_camera camera = *o.frame.camera;
    camera.focal = 5 << 16; /* regions are blocks */
    o.frame.camera = &camera;
    o.frame.light_count = 4;
    for (unsigned i = 0; i < 3; i++)
        set_materials(&o, m[i], kinds[i]);
    for (unsigned pair = 0; pair < 3; pair++)
        for (int rate = RASTER_RATE_1X1; rate <= RASTER_RATE_4X4; rate += 2) {
            const struct scene_material own[2] = {m[pair][0], m[(pair + 1) % 3][1]};
            unsigned shows[4] = {0};
            for (unsigned i = 0; i < 4; i++) {
                const struct scene_material same[2] = {own[i & 1], own[i & 1]};
                o.frame.materials = same;
                show(&alone[i], &o.frame, i & 2 ? RASTER_RATE_2X2 : (enum raster_rate)rate, RASTER_ALL_LIGHTS);
            }
            o.frame.materials = own;
            show_mixed(&mixed, &o.frame, (enum raster_rate)rate, RASTER_RATE_2X2, RASTER_ALL_LIGHTS);
            for (unsigned i = 0; i < PIXELS; i++) {
                bool known = false;
                for (unsigned k = 0; k < 4; k++) {
                    const bool is = !memcmp(mixed.rgb[i], alone[k].rgb[i], 3);
                    known |= is;
                    shows[k] += is;
                }
                assert_true(known);
            }
            for (unsigned k = 0; k < 4; k++)
                assert_in_range(shows[k], PIXELS / 100, PIXELS - PIXELS / 100);
        }
    free(o.blob);
}

static void samples_are_what_the_survey_says(void **state)
{
    static struct shown shown;
    struct opened o;
    struct scene_material m[2];
    (void)state;
    open_cubes(&o);
    set_materials(&o, m, SCENE_MATERIAL_METALLIC_ROUGHNESS);
    for (int rate = 0; rate < RASTER_RATE_COUNT; rate++) {
        show(&shown, &o.frame, (enum raster_rate)rate, RASTER_ALL_LIGHTS);
        if (rate == RASTER_RATE_1X1)
            assert_int_equal(shown.samples, shown.most);
        if (rate == RASTER_RATE_4X4)
            assert_int_equal(shown.samples, shown.cells);
        assert_true(abs((int)shown.likely - (int)shown.samples) <= (int)shown.samples / 10);
    }
    free(o.blob);
}

/* 120 point lights and one directional one. */
static void weakest_lights_are_left_out(void **state)
{
    static struct shown all, few;
    struct opened o;
    struct scene_material m[2];
    struct scene_light lights[SCENE_MAX_LIGHTS];
    (void)state;
    open_cubes(&o);
    set_materials(&o, m, SCENE_MATERIAL_METALLIC_ROUGHNESS);
    lights[0] = o.frame.lights[0];
    for (unsigned i = 1; i < 121; i++) {
        lights[i] =
            (struct scene_light){.kind = SCENE_LIGHT_POINT, .radius = (uint32_t)random_between(1 << 16, 16 << 16)};
        for (unsigned c = 0; c < 3; c++) {
            lights[i].position[c] = (int32_t)(random_between(-8, 8) * 65536);
            lights[i].irradiance[c] = (uint32_t)(random_between(0.1, 9) * 65536);
        }
    }
    o.frame.lights = lights;
    o.frame.light_count = 121;
    show(&all, &o.frame, RASTER_RATE_4X4, RASTER_ALL_LIGHTS);
    show(&few, &o.frame, RASTER_RATE_4X4, 120); /* no tile has more in reach */
    assert_memory_equal(all.rgb, few.rgb, sizeof all.rgb);
    show(&few, &o.frame, RASTER_RATE_4X4, RASTER_LEAST_LIGHTS);
    assert_int_equal(few.tried, RASTER_LEAST_LIGHTS * few.samples);
    assert_true(all.tried > 5 * few.tried);

    struct raster_rect rect;
    struct raster_stats stats;
    struct raster_quality q = {.lights = 7};
    raster_tile_begin(&r, 2, &work, &rect, &stats);
    raster_tile_draw(&r, &work, 100, &stats);
    raster_tile_survey(&r, &work, &rect);
    raster_tile_shade(&r, &work, &rect, 0, &q, &stats);
    double weakest = 1e30, strongest = 0;
    unsigned chosen = 0;
    for (unsigned i = 0; i < 121; i++) {
        const struct raster_light *l = &r.lights[i];
        double e = fmax(fmax(l->irradiance[0], l->irradiance[1]), l->irradiance[2]);
        if (l->radius)
            e *= raster_light_box_attenuation(&work.m.shading.box, &l->v, l->radius) * 0x1p-30;
        if (work.light_chosen[i / 32] >> i % 32 & 1) {
            chosen++;
            weakest = fmin(weakest, e);
        } else {
            strongest = fmax(strongest, e);
        }
    }
    assert_int_equal(chosen, 7);
    assert_true(strongest > 0 && weakest >= strongest - 1);
    free(o.blob);
}

/* What raster_remember leaves of a meshlet with this range of green over 100 pixels. */
static uint8_t remembered(uint8_t known, uint8_t low, uint8_t high)
{
    memory.contrast[5] = known;
    work.memory = &memory;
    work.slot_count = 1;
    work.slots[1].memory = 5;
    work.m.shading.low[1] = low;
    work.m.shading.high[1] = high;
    work.m.shading.pixels[1] = 100;
    raster_remember(&work);
    assert_null(work.memory);
    return memory.contrast[5];
}

/* Meshlets whose contrast is known after a frame that is black, at a rate. */
static unsigned count_known(struct shown *shown, const struct raster_frame *f, enum raster_rate rate)
{
    unsigned known = 0;
    memset(&memory, 0, sizeof memory);
    show(shown, f, rate, RASTER_ALL_LIGHTS);
    for (unsigned i = 0; i < 1 << RASTER_MEMORY_SHIFT; i++) {
        known += memory.contrast[i];
        assert_true(memory.contrast[i] <= 1);
    }
    return known;
}

static void contrast_is_remembered(void **state)
{
    static struct shown shown;
    struct opened o;
    struct scene_material m[2];
    (void)state;
    assert_int_equal(remembered(0, 9, 109), 7); /* 2^6 <= 101 < 2^7 */
    assert_int_equal(remembered(3, 9, 109), 7);
    assert_int_equal(remembered(10, 9, 109), 10); /* a little less may be for coarse cells */
    assert_int_equal(remembered(11, 9, 109), 10);
    assert_int_equal(remembered(9, 255, 0), 9); /* nothing was seen */

    open_cubes(&o); /* without light everything is black: nothing has any contrast, and the next frame knows */
    set_materials(&o, m, SCENE_MATERIAL_LAFORTUNE_PHONG);
    o.frame.memory = &memory;
    o.frame.light_count = 0;
    const unsigned coarse = count_known(&shown, &o.frame, RASTER_RATE_4X4),
                   known = count_known(&shown, &o.frame, RASTER_RATE_1X1);
    assert_true(known > 300);
    assert_true(coarse > 0 && coarse < known); /* fewer than four cells tell nothing */
    struct raster_rect rect;
    struct raster_stats stats;
    raster_tile_begin(&r, 2, &work, &rect, &stats);
    raster_tile_draw(&r, &work, UINT32_MAX, &stats);
    const struct raster_survey *s = raster_tile_survey(&r, &work, &rect);
    for (uint32_t c = 0; c < s->classes; c++) {
        assert_int_equal(s->detail[c], s->total[c].pixels);
        for (int rate = 1; rate < RASTER_RATE_COUNT; rate++)
            assert_true(raster_class_error(s, c, (enum raster_rate)rate) >=
                        raster_class_error(s, c, (enum raster_rate)(rate - 1)));
    }
    free(o.blob);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steps_at_full_quality_are_the_whole),
        cmocka_unit_test(coarse_rates_keep_every_edge),
        cmocka_unit_test(materials_and_rates_side_by_side_change_no_pixel),
        cmocka_unit_test(samples_are_what_the_survey_says),
        cmocka_unit_test(weakest_lights_are_left_out),
        cmocka_unit_test(contrast_is_remembered),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
