#include "sim_device.h"

#include <stdlib.h>
#include <string.h>

#include "costs/cortex_m7.h"

#define PATIENCE 1000000u /* polls without an answer until the host gives up */

static bool firmware_start(struct sim_device *d)
{
    return app_init(&d->app, sim_hal(d->board), &d->config) == APP_OK;
}

struct sim_device *sim_device_create(const struct sim_config *config)
{
    struct sim_device *d = calloc(1, sizeof *d);
    if (!d)
        return NULL;
    d->board = sim_create(config);
    if (!d->board) {
        free(d);
        return NULL;
    }
    const struct sim_config *c = sim_configuration(d->board);
    uint32_t scale = c->samples == 4 ? 2 : 1; /* a tile is one of samples */
    uint32_t tiles = ((c->width * scale + RASTER_TILE_WIDTH - 1u) / RASTER_TILE_WIDTH) *
                     ((c->height * scale + RASTER_TILE_HEIGHT - 1u) / RASTER_TILE_HEIGHT);
    d->config = (struct app_config){
        .parts = &raster_all_parts,
        .width = c->width,
        .height = c->height,
        .format = c->format,
        .samples = c->samples,
        .slot_count = c->slot_count,
        .scene_bank_bytes = c->scene_bank_bytes,
        .arena = malloc(c->arena_bytes),
        .arena_bytes = c->arena_bytes,
        .costs = &costs_cortex_m7,
        .budgets = &budget_scheduler,
        .tile_budget = c->tile_budget,
        .memory = calloc(1, sizeof(struct raster_memory)),
        .tile_stats = calloc(tiles, sizeof(struct usb_tile_stats)),
        .tile_stats_count = tiles,
        .serial = c->serial,
    };
    if (!d->config.arena || !d->config.tile_stats || !d->config.memory || !firmware_start(d)) {
        sim_device_destroy(d);
        return NULL;
    }
    return d;
}

bool sim_device_destroy(struct sim_device *d)
{
    bool saved = sim_destroy(d->board);
    free(d->config.arena);
    free(d->config.tile_stats);
    free(d->config.memory);
    free(d);
    return saved;
}

void sim_device_poll(struct sim_device *d)
{
    app_poll(&d->app);
}

void sim_device_restart(struct sim_device *d)
{
    sim_unplug(d->board);
    sim_power_on(d->board);
    firmware_start(d); /* succeeded with the same configuration before */
}

/* --- a host --- */

/* Takes one IN packet, running the firmware until it comes. */
static int packet_await(struct sim_device *d, uint8_t endpoint, void *data, size_t max)
{
    int n = SIM_NAK;
    for (unsigned i = 0; i < PATIENCE && n == SIM_NAK; i++) {
        sim_device_poll(d);
        n = sim_in(d->board, endpoint, data, max);
    }
    return n;
}

int sim_device_control(struct sim_device *d, const uint8_t setup[8], void *data)
{
    int length = setup[6] | setup[7] << 8, moved = 0, n = sim_setup(d->board, setup);
    uint8_t packet[64];
    if (n < 0)
        return n;
    if (setup[0] & 0x80 && length) {
        do {
            n = packet_await(d, 0x80, packet, sizeof packet);
            if (n < 0)
                return n;
            if (n > length - moved)
                return SIM_OVERFLOW;
            memcpy((uint8_t *)data + moved, packet, (size_t)n);
            moved += n;
        } while (n == sizeof packet && moved < length);
        n = sim_out(d->board, 0x00, NULL, 0);
        sim_device_poll(d);
    } else {
        if (length) {
            sim_device_poll(d);
            moved = sim_out(d->board, 0x00, data, (size_t)length);
            if (moved < 0)
                return moved;
        }
        n = packet_await(d, 0x80, packet, sizeof packet);
    }
    return n < 0 ? n : moved;
}

int sim_device_enumerate(struct sim_device *d, uint8_t descriptors[64])
{
    static const uint8_t address[8] = {0x00, 5, 1}, device[8] = {0x80, 6, 0, 1, 0, 0, 18},
                         configuration[8] = {0x80, 6, 0, 2, 0, 0, 46}, configure[8] = {0x00, 9, 1};
    if (sim_plugged(d->board))
        sim_bus_reset(d->board);
    else
        sim_plug(d->board);
    int n = sim_device_control(d, address, NULL);
    if (n < 0)
        return n;
    int first = sim_device_control(d, device, descriptors);
    if (first < 0)
        return first;
    int second = sim_device_control(d, configuration, descriptors + first);
    if (second < 0)
        return second;
    n = sim_device_control(d, configure, NULL);
    return n < 0 ? n : first + second;
}

bool sim_device_idle(const struct sim_device *d)
{
    const struct protocol *p = &d->app.protocol;
    return sim_bulk_empty(d->board) && p->state == PROTOCOL_HEADER && p->filled == 0 &&
           p->packet_used == p->packet_bytes && !p->sending;
}

/* CRC-32 of IEEE 802.3, half a byte at a time. */
static uint32_t crc32_of(uint32_t crc, const void *data, size_t bytes)
{
    static const uint32_t remainders[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4,
                                            0x4db26158, 0x5005713c, 0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c,
                                            0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
    crc = ~crc;
    for (const uint8_t *p = data; bytes; bytes--) {
        crc ^= *p++;
        crc = crc >> 4 ^ remainders[crc & 15];
        crc = crc >> 4 ^ remainders[crc & 15];
    }
    return ~crc;
}

void sim_device_check(struct sim_device *d, struct usb_header *h, const void *payload)
{
    uint32_t check = crc32_of(0, h, offsetof(struct usb_header, detail));
    h->detail = crc32_of(check, payload, h->length);
    if (h->type != USB_MSG_DATA || h->length < sizeof(struct usb_data))
        return;
    uint32_t offset;
    memcpy(&offset, payload, sizeof offset);
    d->content_crc =
        crc32_of(offset ? d->content_crc : 0, (const uint8_t *)payload + sizeof offset, h->length - sizeof offset);
    h->detail = d->content_crc;
}

static bool message_send(struct sim_device *d, uint8_t type, const void *payload, uint32_t bytes)
{
    uint8_t message[sizeof(struct usb_header) + USB_MAX_PAYLOAD];
    struct usb_header h = {USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION, type, ++d->sequence, 0, bytes, 0};
    if (bytes > USB_MAX_PAYLOAD)
        return false;
    sim_device_check(d, &h, payload);
    memcpy(message, &h, sizeof h);
    if (bytes)
        memcpy(message + sizeof h, payload, bytes);
    size_t total = sizeof h + bytes, sent = 0;
    for (unsigned i = 0; i < PATIENCE && sent < total; i++) {
        int n = sim_out(d->board, USB_ENDPOINT_OUT, message + sent, total - sent);
        if (n < 0 && n != SIM_NAK)
            return false;
        sent += n > 0 ? (size_t)n : 0;
        sim_device_poll(d);
    }
    return sent == total;
}

/* One reply; what of its payload exceeds `max` is dropped. */
static bool message_receive(struct sim_device *d, struct usb_header *header, void *payload, size_t max)
{
    uint8_t packet[512];
    size_t size = sim_packet(d->board, USB_ENDPOINT_IN), at = 0;
    int n;
    do {
        n = packet_await(d, USB_ENDPOINT_IN, packet, size);
        if (n < 0 || (at == 0 && n < (int)sizeof *header))
            return false;
        size_t skip = at == 0 ? sizeof *header : 0, take = (size_t)n - skip;
        if (at == 0)
            memcpy(header, packet, sizeof *header);
        size_t place = at == 0 ? 0 : at - sizeof *header;
        if (place < max)
            memcpy((uint8_t *)payload + place, packet + skip, take < max - place ? take : max - place);
        at += (size_t)n;
    } while ((size_t)n == size);
    return header->magic == USB_PROTOCOL_MAGIC && header->sequence == d->sequence &&
           at == sizeof *header + header->length;
}

bool sim_device_request(struct sim_device *d, uint8_t type, const void *payload, uint32_t bytes,
                        struct usb_header *header, void *reply, size_t max)
{
    return message_send(d, type, payload, bytes) && message_receive(d, header, reply, max);
}

bool sim_device_push(struct sim_device *d, uint32_t slot, uint32_t kind, const void *data, uint32_t bytes,
                     struct usb_header *header)
{
    struct usb_begin begin = {slot, kind, bytes, crc32_of(0, data, bytes)};
    bool ok = sim_device_request(d, USB_MSG_BEGIN, &begin, sizeof begin, header, NULL, 0);
    for (uint32_t at = 0; ok && header->status == USB_OK && at < bytes;) {
        uint32_t n = bytes - at < USB_MAX_DATA ? bytes - at : USB_MAX_DATA;
        uint8_t message[USB_MAX_PAYLOAD];
        memcpy(message, &at, sizeof at);
        memcpy(message + sizeof at, (const uint8_t *)data + at, n);
        ok = sim_device_request(d, USB_MSG_DATA, message, (uint32_t)sizeof at + n, header, NULL, 0);
        at += n;
    }
    if (ok && header->status == USB_OK)
        ok = sim_device_request(d, USB_MSG_COMMIT, NULL, 0, header, NULL, 0);
    return ok;
}

bool sim_device_frame(struct sim_device *d, uint8_t *pixels, struct usb_header *header)
{
    static const size_t tile_bytes = RASTER_TILE_WIDTH * RASTER_TILE_HEIGHT * 3;
    uint8_t reply[sizeof(struct usb_tile) + RASTER_TILE_WIDTH * RASTER_TILE_HEIGHT * 3];
    size_t size = d->config.format == RASTER_RGB565 ? 2 : 3;
    if (!message_send(d, USB_MSG_FRAME, NULL, 0))
        return false;
    for (;;) {
        struct usb_tile tile;
        if (!message_receive(d, header, reply, sizeof reply))
            return false;
        if (header->status != USB_OK)
            return true;
        memcpy(&tile, reply, sizeof tile);
        if (tile.flags & USB_TILE_LAST)
            return true;
        size_t row = tile.width * size;
        if (row * tile.height > tile_bytes || tile.x + tile.width > d->config.width ||
            tile.y + tile.height > d->config.height)
            return false;
        for (size_t y = 0; y < tile.height; y++)
            memcpy(pixels + ((tile.y + y) * d->config.width + tile.x) * size, reply + sizeof tile + y * row, row);
    }
}
