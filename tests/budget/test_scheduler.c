/*
 * Tiles keep to their budgets: random scenes and hard ones, on the simulated device, whose ticks are modelled from counts. What is printed is
 * what boards are to be compared with.
 *
 * Environment: GONIOTILE_DEMO (folder of tables), GONIOTILE_SIX_MODELS (scene blob); GONIOTILE_SHEETS (a folder: frames of the animation are written
 * there, to be looked at).
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>

#include "../unit/device_fixture.h"
#include "common.h"
#include "costs/cortex_m7.h"
#include "scenes.h"

enum { WIDTH = 320, HEIGHT = 240, PICTURE = 3 * WIDTH * HEIGHT, MOST_SAMPLES = 1 << 16 };

static struct {
    double ratio[MOST_SAMPLES]; /* spent over predicted, of each tile */
    uint32_t ratios;
    double used[MOST_SAMPLES]; /* spent over budget, of each frame with a tile below full quality */
    uint32_t frames;
    uint64_t own, budget; /* ticks of deciding, of budgets, in these */
    uint32_t tiles, over, coarse;
    uint64_t fetches, shaded;
} seen;

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static double quantile(double *values, uint32_t count, double q)
{
    qsort(values, count, sizeof *values, compare);
    return count ? values[(uint32_t)((count - 1) * q)] : 0;
}

static void push_file(struct sim_device *d, uint32_t slot, const char *path)
{
    struct usb_header h;
    size_t bytes;
    void *data = read_file(path, SCENE_MAX_BYTES, &bytes);
    assert_true(sim_device_push(d, slot, slot ? USB_SLOT_TABLE : USB_SLOT_SCENE, data, (uint32_t)bytes, &h));
    assert_int_equal(h.status, USB_OK);
    free(data);
}

static struct sim_device *device(void)
{
    struct sim_config c = {
        .width = WIDTH, .height = HEIGHT, .format = RASTER_RGB888, .high_speed = true, .arena_bytes = 1 << 20};
    struct sim_device *d = sim_device_create(&c);
    uint8_t descriptors[64];
    assert_non_null(d);
    assert_true(sim_device_enumerate(d, descriptors) > 0);
    return d;
}

/* A table of the demo's. */
static void push_table(struct sim_device *d, uint32_t slot, const char *name)
{
    char *path = xasprintf("%s/%s.ktx2", getenv("GONIOTILE_DEMO"), name);
    push_file(d, slot, path);
    free(path);
}

/* With the tables that scenes.h names. */
static struct sim_device *device_with_tables(void)
{
    struct sim_device *d = device();
    struct usb_header h;
    size_t bytes;
    push_table(d, 1, "plastic_red");
    push_table(d, 2, "gold");
    void *table = fixture_table(200, &bytes);
    assert_true(sim_device_push(d, 1 + SCENES_SPECULAR_FRAME_SLOT, USB_SLOT_TABLE, table, (uint32_t)bytes, &h));
    assert_int_equal(h.status, USB_OK);
    free(table);
    return d;
}

static struct sim_device *device_with_six_models(void)
{
    static const char *const names[] = {"matte_white",        "plastic_red",  "gold",
                                        "plastic_blue_rough", "copper_satin", "satin_green"};
    struct sim_device *d = device();
    push_file(d, 0, getenv("GONIOTILE_SIX_MODELS"));
    for (uint32_t i = 0; i < 6; i++)
        push_table(d, i + 1, names[i]);
    return d;
}

static void push_scene(struct sim_device *d, enum scenes_kind kind, uint32_t seed)
{
    struct usb_header h;
    size_t bytes;
    void *blob = scenes_make(kind, seed, &bytes);
    assert_true(sim_device_push(d, 0, USB_SLOT_SCENE, blob, (uint32_t)bytes, &h));
    assert_int_equal(h.status, USB_OK);
    free(blob);
}

/* Renders a frame at a budget, tile by tile, and looks at every one. Returns the ticks of all. */
static uint64_t render(struct sim_device *d, uint32_t budget, uint8_t *picture)
{
    struct app_frame *f = &d->app.frame;
    uint64_t spent = 0, own = 0;
    bool reduced = false;
    d->app.content.tile_budget = budget;
    assert_int_equal(app_frame_begin(&d->app, false), RASTER_OK);
    const uint32_t tiles = raster_tile_count(&f->raster);
    for (uint32_t n = 0; n < tiles; n++) {
        const uint32_t i = raster_tile_at(&f->raster, n);
        struct budget_report t;
        struct raster_rect rect;
        struct raster_stats stats;
        if (budget) {
            budget_render_tile(&f->budget, &t, &f->raster, i, &f->work, &rect, &stats);
        } else {
            raster_render_tile(&f->raster, i, &f->work, &rect, &stats);
            t = (struct budget_report){.spent = (uint32_t)(stats.cost >> RASTER_COST_BITS),
                                       .lights = RASTER_ALL_LIGHTS};
        }
        spent += t.spent;
        own += t.own;
        reduced |= budget_reduced(&t);
        for (uint32_t y = 0; picture && y < rect.height; y++)
            memcpy(picture + 3 * ((rect.y + y) * WIDTH + rect.x), raster_tile_pixels(&f->work) + 3 * y * rect.width,
                   3 * rect.width);
        if (!budget)
            continue;
        seen.tiles++;
        seen.fetches += stats.fetches;
        seen.shaded += stats.shaded;
        seen.coarse += t.coarse;
        if (t.spent > t.share) {
            seen.over++;
            printf("# tile %u took %u of %u ticks\n", i, t.spent, t.share);
        }
        if (seen.ratios < MOST_SAMPLES)
            seen.ratio[seen.ratios++] = (double)t.spent / t.predicted;
    }
    f->active = false;
    if (budget) {
        assert_true(spent <= (uint64_t)budget * tiles);
        if (reduced && seen.frames < MOST_SAMPLES) {
            seen.used[seen.frames++] = (double)spent / ((double)budget * tiles);
            seen.own += own;
            seen.budget += (uint64_t)budget * tiles;
        }
    }
    return spent;
}

static uint32_t least_budget(struct sim_device *d)
{
    d->app.content.tile_budget = 0;
    assert_int_equal(app_frame_begin(&d->app, false), RASTER_OK);
    d->app.frame.active = false;
    return d->app.frame.raster.budget_needed;
}

static void clear_seen(void)
{
    memset(&seen, 0, sizeof seen);
}

static void print_seen(const char *what)
{
    printf(
        "# %s: %u tiles, %u over, %u at coarsest levels; spent/predicted p50 %.3f p99 %.3f most %.3f; used of reduced "
        "frames: median %.3f; deciding %.4f of budgets\n",
        what, seen.tiles, seen.over, seen.coarse, quantile(seen.ratio, seen.ratios, 0.5),
        quantile(seen.ratio, seen.ratios, 0.99), quantile(seen.ratio, seen.ratios, 1),
        quantile(seen.used, seen.frames, 0.5), seen.budget ? (double)seen.own / (double)seen.budget : 0);
}

static void no_tile_of_random_scenes_takes_more_than_its_share(void **unused)
{
    const uint32_t scenes = getenv("GONIOTILE_LONG") ? 400 : 40;
    (void)unused;
    struct sim_device *d = device_with_tables();
    clear_seen();
    for (uint32_t seed = 0; seed < scenes; seed++) {
        push_scene(d, SCENES_RANDOM, seed);
        const uint32_t least = least_budget(d), full = (uint32_t)(render(d, 0, NULL) / 40) + 1;
        const uint32_t above = full > least ? full - least : 0;
        for (uint32_t part = 0; part <= 4; part++)
            render(d, least + (uint32_t)((uint64_t)above * part / 4), NULL);
    }
    print_seen("random scenes");
    assert_int_equal(seen.over, 0);
    sim_device_destroy(d);
}

static void hard_scenes_keep_to_budgets_that_are_halved_until_refused(void **unused)
{
    (void)unused;
    struct sim_device *d = device_with_tables();
    for (int kind = SCENES_RANDOM + 1; kind < SCENES_KIND_COUNT; kind++) {
        push_scene(d, (enum scenes_kind)kind, 7);
        clear_seen();
        const uint32_t least = least_budget(d);
        uint32_t budget = 4u << 20;
        for (; budget >= least; budget /= 2)
            render(d, budget, NULL);
        d->app.content.tile_budget = budget;
        assert_int_equal(app_frame_begin(&d->app, false), RASTER_ERR_BUDGET);
        assert_int_equal(d->app.frame.raster.budget_needed, least);
        render(d, least, NULL);
        print_seen(scenes_name((enum scenes_kind)kind));
        assert_int_equal(seen.over, 0);
    }
    sim_device_destroy(d);
}

static void generous_budgets_change_no_pixel(void **unused)
{
    static uint8_t with[PICTURE], without[PICTURE];
    (void)unused;
    struct sim_device *d = device_with_tables();
    for (int kind = 0; kind < SCENES_KIND_COUNT; kind++) {
        push_scene(d, (enum scenes_kind)kind, 3);
        render(d, 0, without);
        render(d, 1000000000, with);
        if (memcmp(with, without, PICTURE))
            printf("# %s\n", scenes_name((enum scenes_kind)kind));
        assert_memory_equal(with, without, PICTURE);
    }
    sim_device_destroy(d);
}

/* RMS, in 8-bit steps. */
static double difference(const uint8_t *a, const uint8_t *b)
{
    double sum = 0;
    for (int i = 0; i < PICTURE; i++)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(sum / PICTURE);
}

static void larger_budgets_err_less(void **unused)
{
    static uint8_t full[PICTURE], picture[PICTURE];
    (void)unused;
    struct sim_device *d = device_with_tables();
    push_scene(d, SCENES_LIGHTS, 1);
    const uint32_t least = least_budget(d), most = (uint32_t)(render(d, 0, full) / 40);
    double before = INFINITY;
    for (uint32_t part = 1; part <= 8; part *= 2) {
        render(d, least + (most - least) / 8 * part, picture);
        render(d, least + (most - least) / 8 * part, picture); /* the first one learns */
        const double error = difference(full, picture);
        printf("# %u of 8 parts: %.2f dB\n", part, 20 * log10(255 / error));
        assert_true(error <= before * 1.05);
        before = error;
    }
    sim_device_destroy(d);
}

/* The six models in a little less than they take: fewer taps, where the program has them, err less than coarser cells alone. */
static void fewer_taps_come_before_coarser_cells(void **unused)
{
    static uint8_t full[PICTURE], picture[PICTURE];
    double decibels[2] = {0};
    (void)unused;
    for (int without = 0; without < 2; without++) {
        struct sim_device *d = device_with_six_models();
        struct raster_parts parts = *d->app.config.parts;
        parts.fewer_taps = without ? NULL : parts.fewer_taps;
        d->app.config.parts = &parts;
        const uint32_t most = (uint32_t)(render(d, 0, full) / 40);
        clear_seen();
        for (uint32_t part = 107; part >= 94; part--) { /* a survey and deciding come on top */
            for (int i = 0; i < 6; i++)                 /* the first ones learn */
                render(d, most / 100 * part, picture);
            decibels[without] += 20 * log10(255 / difference(full, picture)) / 14;
        }
        printf("# %s fewer taps: %.2f dB, %.3f texels for each pixel and light\n", without ? "without" : "with",
               decibels[without], (double)seen.fetches / (double)seen.shaded);
        assert_true(without ? seen.fetches == 8 * seen.shaded : seen.fetches < 7 * seen.shaded);
        sim_device_destroy(d);
    }
    assert_true(decibels[0] > decibels[1] + 0.25);
}

/* Counts up by 10 a call; a call behind which an interrupt takes its time counts that, too. */
static struct {
    uint32_t ticks, calls, interrupted, takes;
} on_clock;

static uint32_t interrupted_clock(void *ctx)
{
    (void)ctx;
    on_clock.ticks += ++on_clock.calls == on_clock.interrupted ? on_clock.takes : 10;
    return on_clock.ticks;
}

static void a_tile_that_takes_all_that_is_left_is_charged_with_it(void **unused)
{
    (void)unused;
    struct sim_device *d = device_with_tables();
    struct app_frame *f = &d->app.frame;
    struct hal hal = *d->app.hal;
    struct budget_report t;
    struct raster_rect rect;
    struct raster_stats stats;
    hal.clock = interrupted_clock;
    push_scene(d, SCENES_LIGHTS, 1);
    for (uint32_t more = 0; more < 2; more++) {
        d->app.hal = &hal;
        memset(&on_clock, 0, sizeof on_clock);
        d->app.content.tile_budget = 1u << 20;
        assert_int_equal(app_frame_begin(&d->app, false), RASTER_OK);
        budget_render_tile(&f->budget, &t, &f->raster, raster_tile_at(&f->raster, 0), &f->work, &rect, &stats);
        assert_int_equal(f->budget.left, (40u << 20) - t.spent);
        on_clock.interrupted = on_clock.calls + 2; /* the first is the tile's start */
        on_clock.takes = (uint32_t)f->budget.left + 1000 * more;
        budget_render_tile(&f->budget, &t, &f->raster, raster_tile_at(&f->raster, 1), &f->work, &rect, &stats);
        assert_true(t.spent >= on_clock.takes);
        assert_int_equal(f->budget.left, 0);
        budget_render_tile(&f->budget, &t, &f->raster, raster_tile_at(&f->raster, 2), &f->work, &rect, &stats);
        assert_true(t.coarse || t.pixels == 0); /* nothing is left for it */
        f->active = false;
    }
    sim_device_destroy(d);
}

/* --- over the protocol --- */

static unsigned set_budget(struct sim_device *d, uint32_t ticks, uint32_t *detail)
{
    const uint32_t payload[2] = {USB_SET_BUDGET, ticks};
    struct usb_header h;
    assert_true(sim_device_request(d, USB_MSG_SET, payload, sizeof payload, &h, NULL, 0));
    *detail = h.detail;
    return h.status;
}

static void statistics(struct sim_device *d, struct usb_stats *s)
{
    struct usb_header h;
    uint32_t want = 0;
    assert_true(sim_device_request(d, USB_MSG_STATS, &want, sizeof want, &h, s, sizeof *s));
    assert_int_equal(h.length, sizeof *s);
}

static void the_host_sets_budgets_and_reads_what_they_cost(void **unused)
{
    static uint8_t picture[PICTURE];
    struct usb_header h;
    struct usb_stats s;
    uint32_t detail, least;
    (void)unused;
    struct sim_device *d = device_with_tables();
    assert_int_equal(set_budget(d, 100, &detail), USB_ERR_STATE);
    push_scene(d, SCENES_LIGHTS, 1);
    assert_int_equal(set_budget(d, 100, &least), USB_ERR_BUDGET);
    assert_int_equal(set_budget(d, least - 1, &detail), USB_ERR_BUDGET);
    assert_int_equal(detail, least);
    assert_true(sim_device_frame(d, picture, &h) && h.status == USB_OK); /* what was refused does not hold */
    statistics(d, &s);
    assert_int_equal(s.tile_budget, 0);
    assert_int_equal(s.total.budget, 0);
    assert_int_equal(s.total.coarsest, RASTER_RATE_1X1);
    assert_int_equal(set_budget(d, least, &detail), USB_OK);
    assert_true(sim_device_frame(d, picture, &h) && h.status == USB_OK);
    statistics(d, &s);
    assert_int_equal(s.tile_budget, least);
    assert_int_equal(s.least_tile_budget, least);
    assert_true(s.total.ticks <= s.total.budget && s.total.ticks <= 40 * least);
    assert_true(s.tiles_reduced > 0 && s.total.coarsest > RASTER_RATE_1X1 && s.total.error > 0 && s.total.rate > 0);
    assert_true(sim_device_request(d, USB_MSG_RESET, NULL, 0, &h, NULL, 0));
    assert_true(sim_device_frame(d, picture, &h) && h.status == USB_OK);
    statistics(d, &s);
    assert_int_equal(s.tile_budget, 0);
    sim_device_destroy(d);
}

static void firmware_without_budgets_refuses_any(void **unused)
{
    static uint8_t picture[PICTURE], same[PICTURE];
    struct usb_header h;
    struct usb_stats s;
    uint32_t detail = 7;
    (void)unused;
    struct sim_device *d = device_with_tables();
    push_scene(d, SCENES_LIGHTS, 1);
    assert_true(sim_device_frame(d, picture, &h) && h.status == USB_OK);
    d->app.config.budgets = NULL;
    assert_int_equal(set_budget(d, 1u << 26, &detail), USB_ERR_VALUE);
    assert_int_equal(detail, 0);
    assert_int_equal(set_budget(d, 0, &detail), USB_OK);
    assert_true(sim_device_frame(d, same, &h) && h.status == USB_OK);
    assert_memory_equal(picture, same, PICTURE);
    statistics(d, &s);
    assert_int_equal(s.least_tile_budget, 0);
    assert_true(s.total.ticks > 0);
    sim_device_destroy(d);
}

static void a_frame_that_a_budget_no_longer_allows_is_refused_with_the_least(void **unused)
{
    static uint8_t picture[PICTURE];
    struct usb_header h;
    uint32_t detail, least;
    (void)unused;
    struct sim_device *d = device_with_tables();
    push_scene(d, SCENES_RANDOM, 3);
    assert_int_equal(set_budget(d, 1, &least), USB_ERR_BUDGET);
    assert_int_equal(set_budget(d, least, &detail), USB_OK);
    d->app.config.tile_budget = 100; /* as a board's own would be */
    assert_true(sim_device_request(d, USB_MSG_RESET, NULL, 0, &h, NULL, 0));
    assert_true(sim_device_frame(d, picture, &h));
    assert_int_equal(h.status, USB_ERR_BUDGET);
    assert_int_equal(h.detail, least);
    assert_int_equal(set_budget(d, 0, &detail), USB_OK);
    assert_true(sim_device_frame(d, picture, &h) && h.status == USB_OK);
    sim_device_destroy(d);
}

/* --- an animation --- */

/* Around the six models, `frame` of 60. */
static void orbit(struct sim_device *d, uint32_t frame)
{
    struct scene_camera *c = &d->app.content.camera;
    const double a = frame * (2 * 3.14159265358979 / 60) * 0.1, s = sin(a), cosine = cos(a);
    const struct scene_camera *from = &d->app.content.scene.header->camera;
    *c = *from;
    for (int i = 0; i < 3; i++) { /* the scene turned about y: every row and the eye */
        c->rotation[3 * i] = (q2_30_t)lrint(cosine * from->rotation[3 * i] + s * from->rotation[3 * i + 2]);
        c->rotation[3 * i + 2] = (q2_30_t)lrint(-s * from->rotation[3 * i] + cosine * from->rotation[3 * i + 2]);
    }
    c->eye[0] = (q16_16_t)lrint(cosine * from->eye[0] + s * from->eye[2]);
    c->eye[2] = (q16_16_t)lrint(-s * from->eye[0] + cosine * from->eye[2]);
}

static void write_ppm(const uint8_t *picture, unsigned budget, unsigned frame)
{
    const char *folder = getenv("GONIOTILE_SHEETS");
    if (!folder)
        return;
    char *path = xasprintf("%s/orbit_%u_%02u.ppm", folder, budget, frame);
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    fprintf(f, "P6 %d %d 255\n", WIDTH, HEIGHT);
    fwrite(picture, 1, PICTURE, f);
    fclose(f);
    free(path);
}

static void an_animation_does_not_pop(void **unused)
{
    enum { FRAMES = 60 };
    static const double parts[] = {0.75, 0.5, 0.25}; /* of what shading takes beyond the least */
    static uint8_t full[2][PICTURE], tight[2][PICTURE];
    (void)unused;
    struct sim_device *d = device_with_six_models();
    const uint32_t most = (uint32_t)(render(d, 0, NULL) / 40), least = least_budget(d);
    for (uint32_t n = 0; n < 3; n++) {
        const uint32_t budget = least + (uint32_t)((most - least) * parts[n]);
        double worst = 0, mean = 0, pops = 0;
        uint32_t bias = 0;
        clear_seen();
        for (uint32_t frame = 0; frame < FRAMES; frame++) {
            uint8_t *f = full[frame % 2], *t = tight[frame % 2];
            orbit(d, frame);
            render(d, 0, f);
            render(d, budget, t);
            bias = d->app.frame.raster.lod_bias > bias ? d->app.frame.raster.lod_bias : bias;
            const double error = difference(f, t);
            worst = error > worst ? error : worst;
            mean += error / FRAMES;
            if (frame > 1) { /* the first learns */
                const double moves = difference(f, full[!(frame % 2)]), seems = difference(t, tight[!(frame % 2)]);
                pops = seems / moves > pops ? seems / moves : pops;
            }
            write_ppm(t, budget, frame);
        }
        printf("# budget %u, levels of detail up to %u times coarser: rms error mean %.2f, most %.2f steps; change "
               "from frame to frame at most %.2f of what the "
               "scene's "
               "movement makes\n",
               budget, 1u << bias, mean, worst, pops);
        print_seen("animation");
        assert_int_equal(seen.over, 0);
        assert_true(pops < (bias ? 4 : 2)); /* another level of detail is another shape */
    }
    sim_device_destroy(d);
}

/* Coarser levels may take more runs of the arena than finer ones: the budget then goes without them. */
static void a_budget_takes_no_more_arena_than_the_levels_that_the_scene_asks_for(void **unused)
{
    (void)unused;
    static const struct lut_table *const none[RASTER_MAX_SLOTS];
    struct raster r;
    uint32_t coarsened = 0;
    for (uint32_t seed = 0; seed < 40; seed++) {
        struct scene s;
        struct scene_material materials[SCENE_MAX_MATERIALS];
        size_t bytes;
        void *blob = scenes_make(seed ? SCENES_RANDOM : SCENES_LIGHTS, seed, &bytes);
        assert_int_equal(scene_open_bounded(&s, blob, bytes), SCENE_OK);
        for (uint32_t i = 0; i < s.header->materials.count; i++) {
            materials[i] = s.materials[i];
            materials[i].kind = SCENE_MATERIAL_LAFORTUNE_PHONG;
        }
        struct raster_frame f = {.parts = &raster_all_parts,
                                 .scene = &s,
                                 .camera = &s.header->camera,
                                 .output = &s.header->output,
                                 .lights = s.lights,
                                 .materials = materials,
                                 .tables = none,
                                 .width = WIDTH,
                                 .height = HEIGHT,
                                 .light_count = (uint8_t)s.header->lights.count,
                                 .format = RASTER_RGB888,
                                 .costs = &costs_cortex_m7,
                                 .bounds = &raster_tile_bounds};
        const size_t needed = raster_arena_bytes(&f);
        void *arena = malloc(needed);
        assert_int_equal(raster_begin(&r, &f, arena, needed), RASTER_OK);
        const uint32_t least = r.budget_needed;
        for (uint32_t times = 4; times; times--) {
            f.tile_budget = least * times;
            assert_string_equal(raster_status_text(raster_begin(&r, &f, arena, needed)), raster_status_text(RASTER_OK));
            assert_int_equal(r.budget_needed, least);
            assert_true(r.arena_needed <= needed);
            coarsened += r.lod_bias != 0;
        }
        free(arena);
        free(blob);
    }
    assert_true(coarsened > 40);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_tile_of_random_scenes_takes_more_than_its_share),
        cmocka_unit_test(hard_scenes_keep_to_budgets_that_are_halved_until_refused),
        cmocka_unit_test(generous_budgets_change_no_pixel),
        cmocka_unit_test(larger_budgets_err_less),
        cmocka_unit_test(fewer_taps_come_before_coarser_cells),
        cmocka_unit_test(a_tile_that_takes_all_that_is_left_is_charged_with_it),
        cmocka_unit_test(the_host_sets_budgets_and_reads_what_they_cost),
        cmocka_unit_test(firmware_without_budgets_refuses_any),
        cmocka_unit_test(a_frame_that_a_budget_no_longer_allows_is_refused_with_the_least),
        cmocka_unit_test(a_budget_takes_no_more_arena_than_the_levels_that_the_scene_asks_for),
        cmocka_unit_test(an_animation_does_not_pop),
    };
    if (!getenv("GONIOTILE_DEMO") || !getenv("GONIOTILE_SIX_MODELS"))
        return 1;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
