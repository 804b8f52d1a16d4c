#include "app.h"

#include "content.h"
#include "messages.h"

/* The modelled cost, in instructions of a Cortex-M4 as a prototype of the rasterizer took them: it orders tiles and
 * repeats exactly; hal.clock tells the truth. */
enum {
    COST_FRAME = 20000,         /* lights, clearing the bins */
    COST_VISIBLE_MESHLET = 400, /* culling and binning, the culled ones' share included */
    COST_TILE = 2000,
    COST_MESHLET = 1000, /* transform of about 20 vertices */
    COST_TRIANGLE = 230, /* edge set-up */
    COST_TESTED = 8,     /* per pixel whose depth is compared */
    COST_COVERED = 40,   /* normal, tone curve, packing */
    COST_SHADED = 60,    /* per pixel and light */
    COST_FETCH = 25,     /* per texel decoded and weighted */
};

static bool config_valid(const struct app_config *c)
{
    if (c->width == 0 || c->width > RASTER_MAX_WIDTH || c->height == 0 || c->height > RASTER_MAX_HEIGHT ||
        c->format > RASTER_RGB888 || (c->samples > 1 && c->samples != 4) || c->slot_count < 2 ||
        c->slot_count > USB_MAX_SLOTS)
        return false;
    if (!c->arena || (uintptr_t)c->arena % 8 != 0 || !c->serial)
        return false;
    size_t n = 0;
    while (n <= USB_MAX_SERIAL_CHARS && c->serial[n])
        n++;
    return n >= 1 && n <= USB_MAX_SERIAL_CHARS;
}

enum app_status app_init(struct app *app, const struct hal *hal, const struct app_config *config)
{
    __builtin_memset(app, 0, sizeof *app);
    if (!config_valid(config))
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

enum raster_status app_frame_begin(struct app *app, bool streamed)
{
    struct app_frame *f = &app->frame;
    const struct app_content *c = &app->content;
    struct raster_frame what = {
        .scene = &c->scene,
        .camera = &c->camera,
        .output = &c->output,
        .lights = c->lights,
        .materials = c->materials,
        .tables = c->table_of_slot,
        .width = app->config.width,
        .height = app->config.height,
        .light_count = c->light_count,
        .format = app->config.format,
        .samples = app->config.samples,
    };
    uint32_t start = clock_now(app);
    enum raster_status status = raster_begin(&f->raster, &what, app->config.arena, content_arena_bytes(app));
    f->refused = status != RASTER_OK;
    if (f->refused)
        return status;
    f->active = true;
    f->streamed = streamed;
    /* the statistics must hold still while they are being sent */
    f->recorded = !(app->protocol.sending && app->protocol.tail == (const uint8_t *)app->config.tile_stats &&
                    app->protocol.tail_bytes);
    f->next_tile = 0;
    f->stats = (struct usb_stats){
        .tile_count = raster_tile_count(&f->raster),
        .ticks_are_modelled = !app->hal->clock,
        .begin_ticks =
            app->hal->clock ? clock_now(app) - start : COST_FRAME + COST_VISIBLE_MESHLET * f->raster.visible_count,
        .meshlets_visible = f->raster.visible_count,
        .arena_used = (uint32_t)f->raster.arena_needed,
    };
    return RASTER_OK;
}

static uint32_t modelled_ticks(const struct raster_stats *s)
{
    uint64_t cost = COST_TILE; /* < 2^41: seven products of 32 and at most 10 bits */
    cost += (uint64_t)COST_MESHLET * s->meshlets + (uint64_t)COST_TRIANGLE * s->triangles;
    cost += (uint64_t)COST_TESTED * s->tested + (uint64_t)COST_COVERED * s->covered;
    cost += (uint64_t)COST_SHADED * s->shaded + (uint64_t)COST_FETCH * s->fetches;
    return cost < UINT32_MAX ? (uint32_t)cost : UINT32_MAX;
}

static void stats_add(struct usb_tile_stats *sum, const struct usb_tile_stats *t)
{
    sum->triangles = fx_add_sat_u(sum->triangles, t->triangles);
    sum->tested = fx_add_sat_u(sum->tested, t->tested);
    sum->covered = fx_add_sat_u(sum->covered, t->covered);
    sum->shaded = fx_add_sat_u(sum->shaded, t->shaded);
    sum->fetches = fx_add_sat_u(sum->fetches, t->fetches);
    sum->ticks = fx_add_sat_u(sum->ticks, t->ticks);
}

static void tile_render(struct app *app)
{
    struct app_frame *f = &app->frame;
    struct raster_rect rect;
    struct raster_stats s;
    uint32_t index = f->next_tile++, start = clock_now(app);
    raster_render_tile(&f->raster, index, &f->work, &rect, &s);
    uint32_t ticks = app->hal->clock ? clock_now(app) - start : modelled_ticks(&s);
    struct usb_tile_stats t = {s.triangles, s.tested, s.covered, s.shaded, s.fetches, ticks};
    stats_add(&f->stats.total, &t);
    app->push_credit += ticks / (APP_PUSH_SHARE * APP_PUSH_COST) + 1; /* < 2^27 */
    if (app->push_credit > USB_MAX_DATA)
        app->push_credit = USB_MAX_DATA;
    if (f->recorded && app->config.tile_stats && index < app->config.tile_stats_count)
        app->config.tile_stats[index] = t;
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
    if (f->recorded)
        app->stats = f->stats;
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
