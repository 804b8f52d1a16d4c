#include "app.h"

#include "content.h"
#include "messages.h"

/* Culling and binning without a clock: instructions of a Cortex-M7. */
enum {
    TICKS_FRAME = 20000,         /* lights, clearing the bins */
    TICKS_VISIBLE_MESHLET = 400, /* the culled ones' share included */
};

static bool costs_valid(const struct raster_costs *c)
{
    const struct raster_shading_cost *table = &c->shading[RASTER_SHADE_HALF_VECTOR];
    bool valid = c->clear <= c->tile && c->part <= APP_MOST_SAMPLE_COST && c->cell <= APP_MOST_SAMPLE_COST;
    for (size_t at = 0; at < sizeof *c; at += sizeof(uint32_t)) { /* it has no other members */
        uint32_t entry;
        __builtin_memcpy(&entry, (const uint8_t *)c + at, sizeof entry);
        valid = valid && entry <= APP_MOST_COST;
    }
    for (unsigned i = 0; i < RASTER_TAPS_COUNT; i++)
        valid = valid && c->taps[i] <= table->lit && table->lit + c->texels[i] + c->bright <= APP_MOST_SAMPLE_COST &&
                table->point + c->texels[i] + c->bright + c->slow_point <= APP_MOST_SAMPLE_COST;
    for (unsigned i = RASTER_SHADE_LAFORTUNE_PHONG; i <= RASTER_SHADE_BLINN_PHONG; i++)
        valid = valid && c->shading[i].material + RASTER_BROAD_PLANES * c->broad <= APP_MOST_COST &&
                c->shading[i].lit + c->broad <= APP_MOST_SAMPLE_COST &&
                c->shading[i].point + c->broad + c->slow_point <= APP_MOST_SAMPLE_COST;
    for (unsigned i = 0; i < RASTER_SHADE_COUNT; i++) {
        const struct raster_shading_cost *s = &c->shading[i];
        valid = valid && s->sample <= APP_MOST_SAMPLE_COST && s->lit <= APP_MOST_SAMPLE_COST &&
                s->dark <= APP_MOST_SAMPLE_COST && s->point <= APP_MOST_SAMPLE_COST;
    }
    return valid;
}

static bool config_valid(const struct hal *hal, const struct app_config *c)
{
    const unsigned shift = c->samples == 4;
    if (c->width == 0 || c->width > RASTER_MAX_WIDTH >> shift || c->height == 0 ||
        c->height > RASTER_MAX_HEIGHT >> shift || c->format > RASTER_RGB888 || (c->samples > 1 && c->samples != 4) ||
        (shift && (RASTER_TILE_WIDTH < 32 || RASTER_TILE_HEIGHT < 32)) || c->slot_count < 2 ||
        c->slot_count > USB_MAX_SLOTS)
        return false;
    if (!c->parts || !c->arena || (uintptr_t)c->arena % 8 != 0 || !c->serial)
        return false;
    if (c->costs && !costs_valid(c->costs))
        return false;
    if ((!c->costs && (c->budgets || !hal->clock)) || (c->tile_budget && !c->budgets) ||
        ((c->budgets || c->samples == 4) && !c->parts->cells))
        return false;
    size_t n = 0;
    while (n <= USB_MAX_SERIAL_CHARS && c->serial[n])
        n++;
    return n >= 1 && n <= USB_MAX_SERIAL_CHARS;
}

enum app_status app_init(struct app *app, const struct hal *hal, const struct app_config *config)
{
    __builtin_memset(app, 0, sizeof *app);
    if (!config_valid(hal, config))
        return APP_ERR_CONFIG;
    app->hal = hal;
    app->config = *config;
    usb_device_init(&app->usb, hal, config->serial);
    protocol_init(&app->protocol, &app->usb);
    if (!table_store_init(&app->store, hal, config->slot_count, config->scene_bank_bytes))
        return APP_ERR_FLASH;
    for (uint32_t slot = 0; slot < config->slot_count; slot++)
        content_load(app, slot);
    return APP_OK;
}

/* --- frames --- */

static uint32_t clock_now(const struct app *app)
{
    return app->hal->clock ? app->hal->clock(app->hal->ctx) : 0;
}

/* Bounds are found only for a budget, or where the costs are the clock. */
static struct raster_frame frame_of(const struct app *app, uint32_t tile_budget)
{
    const struct budget_scheduler *budgets = app->config.budgets;
    const struct app_content *c = &app->content;
    return (struct raster_frame){
        .parts = app->config.parts,
        .scene = &c->scene,
        .camera = &c->camera,
        .output = &c->output,
        .lights = c->lights,
        .materials = c->materials,
        .tables = c->table_of_slot,
        .costs = tile_budget || !app->hal->clock ? app->config.costs : NULL,
        .bounds = budgets && (tile_budget || !app->hal->clock) ? budgets->bounds : NULL,
        .tile_budget = tile_budget,
        .learnt = &app->frame.budget.learnt,
        .memory = tile_budget ? app->config.memory : NULL,
        .width = app->config.width,
        .height = app->config.height,
        .light_count = c->light_count,
        .format = app->config.format,
        .samples = app->config.samples,
    };
}

struct table_store_result app_check_budget(struct app *app, uint32_t tile_budget)
{
    struct raster *r = &app->frame.raster;
    const struct raster_frame what = frame_of(app, tile_budget);
    if (tile_budget && raster_begin(r, &what, app->config.arena, content_arena_bytes(app)) == RASTER_ERR_BUDGET)
        return (struct table_store_result){USB_ERR_BUDGET, r->budget_needed};
    return (struct table_store_result){USB_OK, 0}; /* what else may be wrong, the frame will say */
}

enum raster_status app_frame_begin(struct app *app, bool streamed)
{
    struct app_frame *f = &app->frame;
    const struct raster_frame what = frame_of(app, app->content.tile_budget);
    uint32_t start = clock_now(app);
    enum raster_status status = raster_begin(&f->raster, &what, app->config.arena, content_arena_bytes(app));
    f->refused = status != RASTER_OK;
    if (f->refused)
        return status;
    if (what.tile_budget)
        app->config.budgets->begin(&f->budget, app->hal, &f->raster, what.tile_budget);
    f->active = true;
    f->streamed = streamed;
    /* the statistics must hold still while they are being sent */
    f->recorded = !(app->protocol.sending && app->protocol.tail == (const uint8_t *)app->config.tile_stats &&
                    app->protocol.tail_bytes);
    f->next_tile = 0;
    f->rates = f->samples = 0;
    f->stats = (struct usb_stats){
        .tile_count = raster_tile_count(&f->raster),
        .ticks_are_modelled = !app->hal->clock,
        .begin_ticks =
            app->hal->clock ? clock_now(app) - start : TICKS_FRAME + TICKS_VISIBLE_MESHLET * f->raster.visible_count,
        .meshlets_visible = f->raster.visible_count,
        .arena_used = (uint32_t)f->raster.arena_needed,
        .tile_budget = what.tile_budget,
        .least_tile_budget = f->raster.budget_needed,
        .lod_bias = f->raster.lod_bias,
        .total.lights = RASTER_ALL_LIGHTS,
    };
    return RASTER_OK;
}

static void stats_add(struct usb_tile_stats *sum, const struct usb_tile_stats *t)
{
    sum->triangles = fx_add_sat_u(sum->triangles, t->triangles);
    sum->tested = fx_add_sat_u(sum->tested, t->tested);
    sum->covered = fx_add_sat_u(sum->covered, t->covered);
    sum->shaded = fx_add_sat_u(sum->shaded, t->shaded);
    sum->fetches = fx_add_sat_u(sum->fetches, t->fetches);
    sum->ticks = fx_add_sat_u(sum->ticks, t->ticks);
    sum->budget = fx_add_sat_u(sum->budget, t->budget);
    sum->predicted = fx_add_sat_u(sum->predicted, t->predicted);
    sum->error = fx_add_sat_u(sum->error, t->error);
    sum->coarsest = t->coarsest > sum->coarsest ? t->coarsest : sum->coarsest;
    sum->lights = t->lights < sum->lights ? t->lights : sum->lights;
}

/* Sum over count, 8 fraction bits. In: sum <= 5 count, count < 2^24. */
static uint16_t mean_rate(uint32_t sum, uint32_t count)
{
    const unsigned shift = sum >> 24 ? 4 : 0; /* sum < 2^27 */
    const uint32_t below = count >> shift;
    return (uint16_t)(below ? ((sum >> shift) << 8) / below : 0);
}

/* Keeps what a tile took. */
static void tile_record(struct app *app, uint32_t index, const struct raster_stats *s, const struct budget_report *b)
{
    struct app_frame *f = &app->frame;
    const struct usb_tile_stats t = {
        .triangles = s->triangles,
        .tested = s->tested,
        .covered = s->covered,
        .shaded = s->shaded,
        .fetches = s->fetches,
        .ticks = b->spent,
        .budget = b->share,
        .predicted = b->predicted,
        .error = b->error,
        .coarsest = b->coarsest,
        .lights = b->lights,
        .rate = mean_rate(b->rates, b->pixels),
    };
    stats_add(&f->stats.total, &t);
    f->rates += b->rates;
    f->samples += b->pixels;
    f->stats.tiles_reduced += budget_reduced(b);
    f->stats.tiles_coarse += b->coarse;
    f->stats.budget_ticks = fx_add_sat_u(f->stats.budget_ticks, b->own);
    if (f->recorded && app->config.tile_stats && index < app->config.tile_stats_count)
        app->config.tile_stats[index] = t;
}

/* In full, whatever it takes. */
static void tile_render_full(struct app *app, struct budget_report *report, uint32_t index, struct raster_rect *rect,
                             struct raster_stats *s)
{
    const uint32_t start = clock_now(app);
    raster_render_tile(&app->frame.raster, index, &app->frame.work, rect, s);
    *report = (struct budget_report){.spent = app->hal->clock ? clock_now(app) - start
                                                              : (uint32_t)(s->cost >> RASTER_COST_BITS),
                                     .lights = RASTER_ALL_LIGHTS};
}

static void tile_render(struct app *app)
{
    struct app_frame *f = &app->frame;
    struct raster_rect rect;
    struct raster_stats s;
    struct budget_report report;
    const uint32_t index = raster_tile_at(&f->raster, f->next_tile++);
    if (f->raster.frame.tile_budget)
        app->config.budgets->render_tile(&f->budget, &report, &f->raster, index, &f->work, &rect, &s);
    else
        tile_render_full(app, &report, index, &rect, &s);
    tile_record(app, index, &s, &report);
    app->push_credit += report.spent / (APP_PUSH_SHARE * APP_PUSH_COST) + 1; /* < 2^27 */
    if (app->push_credit > USB_MAX_DATA)
        app->push_credit = USB_MAX_DATA;
    const uint8_t *pixels = raster_tile_pixels(&f->work);
    if (app->hal->display_write)
        app->hal->display_write(app->hal->ctx, rect.x, rect.y, rect.width, rect.height, pixels);
    if (f->streamed) {
        struct usb_tile tile = {rect.x, rect.y, rect.width, rect.height, 0};
        uint32_t pixel_bytes = app->config.format == RASTER_RGB565 ? 2 : 3;
        protocol_reply(&app->protocol, USB_OK, 0, &tile, sizeof tile, pixels,
                       (uint32_t)rect.width * rect.height * pixel_bytes);
    }
}

static void frame_end(struct app *app)
{
    struct app_frame *f = &app->frame;
    if (f->streamed) {
        struct usb_tile last = {.flags = USB_TILE_LAST};
        protocol_reply(&app->protocol, USB_OK, 0, &last, sizeof last, NULL, 0);
        protocol_done(&app->protocol);
    }
    app->frames++;
    f->stats.total.rate = mean_rate(f->rates, f->samples);
    if (f->recorded) {
        app->stats = f->stats;
        app->tiles_mixed = false;
    }
    f->active = f->streamed = false;
}

static void frame_step(struct app *app)
{
    struct app_frame *f = &app->frame;
    if (!f->active) {
        if (app->hal->display_write && app->content.has_scene && !f->refused)
            app_frame_begin(app, false);
    } else if (f->streamed && app->protocol.sending) {
        return; /* the tile's pixels are still being read */
    } else if (f->next_tile < raster_tile_count(&f->raster)) {
        tile_render(app);
    } else {
        frame_end(app);
    }
}

/* Nobody listens any more: the frame goes on for the display alone. */
static void stream_drop(struct app *app)
{
    protocol_clear_in(&app->protocol);
    app->verified = 0;
    if (!app->frame.streamed)
        return;
    app->frame.streamed = false;
    app->frame.active = app->hal->display_write != NULL;
    if (!app->frame.active && app->frame.recorded)
        app->tiles_mixed = true;
}

void app_poll(struct app *app)
{
    unsigned cleared = usb_device_poll(&app->usb);
    if (cleared & USB_CLEARED_OUT)
        protocol_clear_out(&app->protocol);
    if (cleared & USB_CLEARED_IN)
        stream_drop(app);
    protocol_receive(&app->protocol);
    if (app->protocol.state == PROTOCOL_REQUEST && !app->protocol.sending) {
        messages_serve(app);
        protocol_receive(&app->protocol); /* the controller has all of its buffer for what comes during the tile */
    }
    frame_step(app);
    protocol_send(&app->protocol);
}
