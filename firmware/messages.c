#include "messages.h"

#include "content.h"
#include "crc32.h"
#include "goniotile_version.h"

/* Read per poll while a slot is verified: about 17,000 instructions, half of what a DATA message costs. */
#define VERIFY_BYTES 4096u

static void reply(struct app *app, enum usb_status status, uint32_t detail)
{
    protocol_reply(&app->protocol, status, detail, NULL, 0, NULL, 0);
    protocol_done(&app->protocol);
}

static void info_serve(struct app *app)
{
    const struct table_store *s = &app->store;
    const struct app_content *c = &app->content;
    struct usb_info info = {
        .protocol_version = USB_PROTOCOL_VERSION,
        .scene_version = SCENE_VERSION,
        .firmware = GONIOTILE_VERSION,
        .width = app->config.width,
        .height = app->config.height,
        .format = app->config.format,
        .slot_count = app->config.slot_count,
        .tile_width = RASTER_TILE_WIDTH,
        .tile_height = RASTER_TILE_HEIGHT,
        .arena_bytes = (uint32_t)app->config.arena_bytes,
        .flash_bytes = app->hal->flash_bytes,
        .flash_block_bytes = app->hal->flash_block_bytes,
        .scrubbed = s->scrubbed,
        .upload_slot = USB_NO_UPLOAD,
    };
    if (c->has_scene) {
        info.material_count = (uint16_t)c->scene.header->materials.count;
        info.object_count = (uint16_t)c->scene.header->objects.count;
        info.light_count = c->light_count;
        info.triangle_count = c->triangle_count;
    }
    if (s->upload.open) {
        info.upload_slot = s->upload.slot;
        info.upload_length = s->upload.length;
        info.upload_crc = s->upload.crc;
        info.upload_received = s->upload.received;
        info.upload_found = s->upload.found;
    }
    for (uint32_t i = 0; i < s->slot_count; i++) {
        const struct table_store_slot *slot = &s->slots[i];
        info.slots[i] = (struct usb_slot_info){
            slot->kind, slot->length, slot->crc, table_store_capacity(s, i), {slot->erases[0], slot->erases[1]}};
    }
    protocol_reply(&app->protocol, USB_OK, 0, &info, sizeof info, NULL, 0);
    protocol_done(&app->protocol);
}

static void begin_serve(struct app *app)
{
    struct usb_begin begin;
    __builtin_memcpy(&begin, app->protocol.payload, sizeof begin);
    struct table_store_result r = table_store_begin(&app->store, &begin);
    reply(app, r.status, r.detail);
}

static void data_serve(struct app *app)
{
    const struct table_store_upload *u = &app->store.upload;
    uint32_t offset = app->protocol.payload[0];
    uint32_t bytes = app->protocol.request.length - (uint32_t)sizeof(struct usb_data);
    bool rendering = app->frame.active || (app->hal->display_write && app->content.has_scene && !app->frame.refused);
    if (rendering && bytes > app->push_credit)
        return; /* the tiles to come will allow it */
    app->push_credit -= bytes < app->push_credit ? bytes : app->push_credit;
    if (!u->open) {
        reply(app, USB_ERR_STATE, 0);
    } else if (offset != u->received) {
        reply(app, USB_ERR_OFFSET, u->received);
    } else if (bytes > u->length - u->received) {
        reply(app, USB_ERR_LENGTH, (uint32_t)sizeof(struct usb_data) + u->length - u->received);
    } else {
        struct table_store_result r =
            table_store_write(&app->store, app->protocol.payload + 1, bytes, app->protocol.request.detail);
        reply(app, r.status, r.detail);
    }
}

static void commit_serve(struct app *app)
{
    struct table_store_upload *u = &app->store.upload;
    if (!u->open) {
        reply(app, USB_ERR_STATE, 0);
    } else if (u->received != u->length) {
        reply(app, USB_ERR_INCOMPLETE, u->received);
    } else {
        struct table_store_result r = table_store_commit(&app->store);
        if (r.status == USB_OK)
            content_load(app, u->slot);
        reply(app, r.status, r.detail);
    }
}

static void abort_serve(struct app *app)
{
    table_store_abort(&app->store);
    reply(app, USB_OK, 0);
}

static void verify_serve(struct app *app)
{
    uint32_t slot = app->protocol.payload[0], slots = app->store.slot_count, bytes;
    const uint8_t *content = slot < slots ? table_store_content(&app->store, slot, &bytes) : NULL;
    if (!content) {
        reply(app, slot < slots ? USB_ERR_STATE : USB_ERR_SLOT, slot < slots ? 0 : slots);
        return;
    }
    uint32_t n = bytes - app->verified < VERIFY_BYTES ? bytes - app->verified : VERIFY_BYTES;
    app->verify_crc = crc32_update(app->verified ? app->verify_crc : 0, content + app->verified, n);
    app->verified += n;
    if (app->verified == bytes) {
        app->verified = 0;
        reply(app, USB_OK, app->verify_crc);
    }
}

static void select_serve(struct app *app)
{
    struct usb_select select;
    __builtin_memcpy(&select, app->protocol.payload, sizeof select);
    struct table_store_result r = content_select(app, &select);
    reply(app, r.status, r.detail);
}

static void set_serve(struct app *app)
{
    struct table_store_result r = content_set(app, app->protocol.payload[0], app->protocol.payload + 1,
                                              app->protocol.request.length - (uint32_t)sizeof(struct usb_set));
    reply(app, r.status, r.detail);
}

static void frame_serve(struct app *app)
{
    if (app->frame.active) /* the display's ends first; the streamed one is on its way, tile by tile from app.c */
        return;
    if (!app->content.has_scene) {
        reply(app, USB_ERR_STATE, 0);
        return;
    }
    enum raster_status status = app_frame_begin(app, true);
    if (status == RASTER_ERR_TABLE)
        reply(app, USB_ERR_TABLE, app->frame.raster.bad_material);
    else if (status == RASTER_ERR_MODEL)
        reply(app, USB_ERR_MODEL, app->frame.raster.bad_material);
    else if (status == RASTER_ERR_ARENA)
        reply(app, USB_ERR_MEMORY, (uint32_t)app->frame.raster.arena_needed);
    else if (status == RASTER_ERR_BUDGET)
        reply(app, USB_ERR_BUDGET, app->frame.raster.budget_needed);
    else if (status != RASTER_OK)
        reply(app, USB_ERR_RENDER, (uint32_t)status);
}

static void stats_serve(struct app *app)
{
    uint32_t want_tiles = app->protocol.payload[0], bytes = 0;
    if (want_tiles > 1) {
        reply(app, USB_ERR_VALUE, 0);
        return;
    }
    struct usb_stats stats = app->stats;
    stats.frames = app->frames;
    if (want_tiles && app->config.tile_stats && stats.tile_count <= app->config.tile_stats_count && !app->tiles_mixed)
        bytes = stats.tile_count * (uint32_t)sizeof(struct usb_tile_stats);
    protocol_reply(&app->protocol, USB_OK, 0, &stats, sizeof stats, app->config.tile_stats, bytes);
    protocol_done(&app->protocol);
}

static void reset_serve(struct app *app)
{
    table_store_abort(&app->store);
    content_reset(app);
    reply(app, USB_OK, 0);
}

struct message {
    void (*serve)(struct app *app);
    uint16_t least, most; /* payload bytes */
    bool between_frames;  /* waits for the end of the frame in flight */
};

/* What is live changes only between two frames, so that the spare bank, which BEGIN erases at once, is never one that a
 * frame uses. */
static const struct message messages[] = {
    [USB_MSG_INFO] = {info_serve, 0, 0, false},
    [USB_MSG_BEGIN] = {begin_serve, sizeof(struct usb_begin), sizeof(struct usb_begin), false},
    [USB_MSG_DATA] = {data_serve, sizeof(struct usb_data) + 1, USB_MAX_PAYLOAD, false},
    [USB_MSG_COMMIT] = {commit_serve, 0, 0, true},
    [USB_MSG_ABORT] = {abort_serve, 0, 0, false},
    [USB_MSG_SELECT] = {select_serve, sizeof(struct usb_select), sizeof(struct usb_select), true},
    [USB_MSG_SET] = {set_serve, sizeof(struct usb_set), USB_MAX_PAYLOAD, true},
    [USB_MSG_FRAME] = {frame_serve, 0, 0, false},
    [USB_MSG_STATS] = {stats_serve, sizeof(struct usb_stats_request), sizeof(struct usb_stats_request), true},
    [USB_MSG_RESET] = {reset_serve, 0, 0, true},
    [USB_MSG_VERIFY] = {verify_serve, sizeof(struct usb_verify), sizeof(struct usb_verify), false},
};

void messages_serve(struct app *app)
{
    const struct usb_header *h = &app->protocol.request;
    if (h->type >= sizeof messages / sizeof messages[0] || !messages[h->type].serve) {
        reply(app, USB_ERR_TYPE, 0);
        return;
    }
    const struct message *m = &messages[h->type];
    if (h->length < m->least || h->length > m->most)
        reply(app, USB_ERR_LENGTH, m->most);
    else if (!m->between_frames || !app->frame.active)
        m->serve(app);
}
