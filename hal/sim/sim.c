#include "sim.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define QUEUE_PACKETS  64u /* 4 KB at full speed, as a board offers */
#define PACKET_BYTES   512u
#define CONTROL_PACKET 64u
#define ERASED_WORD    0xffffffffu

/* Packets in flight on one endpoint and direction. */
struct queue {
    uint16_t bytes[QUEUE_PACKETS];
    uint8_t data[QUEUE_PACKETS][PACKET_BYTES];
    unsigned first, count;
    bool stalled;
};

struct sim {
    struct sim_config config;
    struct hal hal;
    uint8_t *flash, *picture;
    uint32_t tiles_shown;
    long flash_operations_left; /* until they fail; negative: for ever */
    long flash_operations;      /* done */
    long cut_at;                /* the power is cut in this one, counted like flash_operations; negative: never */
    uint32_t cut_how;
    bool power_cut;
    bool plugged, detach_event, reset_event, setup_event;
    uint8_t setup[8], address, new_address;
    bool has_new_address;
    struct queue control_out, control_in, bulk_out, bulk_in;
};

static size_t pixel_bytes(const struct sim *s)
{
    return s->config.format == 0 ? 2 : 3;
}

/* --- flash --- */

/* Breaking a rule of the flash is a defect of the firmware, not an event it may meet: stop there. */
static _Noreturn void flash_abuse(const char *what, uint32_t offset)
{
    fprintf(stderr, "sim: flash: %s at offset 0x%x; the firmware breaks the rules of hal.h\n", what, offset);
    abort();
}

static int flash_admit(struct sim *s)
{
    if (s->config.write_forbidden)
        return HAL_FORBIDDEN;
    if (s->flash_operations_left == 0 || s->power_cut)
        return HAL_ERROR;
    if (s->flash_operations_left > 0)
        s->flash_operations_left--;
    return HAL_OK;
}

/* Of `count` bytes of an operation those that differ from the old ones, done half-way in the n-th way. */
static void change_in_part(uint8_t *bytes, const uint8_t *wanted, uint32_t count, uint32_t n, bool erase)
{
    uint64_t random = 0x9e3779b97f4a7c15u * (n + 1);
    uint32_t odds[] = {0, 0, 4, 32, 60, 63}; /* of 64, for each bit to be done */
    uint32_t way = n % 9, turn = n / 9, split = turn % 64 * count / 64;
    uint32_t bit_alone =
        turn % 2 ? turn * 97 % (8 * count) : turn * 37 % 256 % (8 * count); /* every other one in a header */
    for (uint32_t i = 0; i < count; i++)
        for (int bit = 0; bit < 8; bit++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            bool dice = way < 6 && random >> 58 < odds[way], done = way == 0 ? i < split : way == 1 ? i >= split : dice;
            uint8_t mask = (uint8_t)(1 << bit), target = wanted[i];
            if (way == 6 || way == 7) /* all bits but one; that one alone */
                done = (8 * i + (uint32_t)bit != bit_alone) == (way == 6);
            if (way == 8 && erase) { /* before it erases, an erase writes zeros */
                target = 0;
                done = random >> 63 || turn % 2;
            }
            if (done)
                bytes[i] = (uint8_t)((bytes[i] & ~mask) | (target & mask));
        }
}

/* The operation happens: `wanted` instead of `count` bytes at `offset`. */
static int flash_change(struct sim *s, uint32_t offset, const uint8_t *wanted, uint32_t count, bool erase)
{
    int result = flash_admit(s);
    if (result != HAL_OK)
        return result;
    s->power_cut = s->flash_operations++ == s->cut_at;
    if (!s->power_cut || s->cut_how == SIM_CUT_AFTER)
        memcpy(s->flash + offset, wanted, count);
    else if (s->cut_how >= SIM_CUT_DURING)
        change_in_part(s->flash + offset, wanted, count, s->cut_how - SIM_CUT_DURING, erase);
    if (!s->power_cut)
        return HAL_OK;
    sim_unplug(s);
    return HAL_ERROR;
}

static int flash_erase(void *ctx, uint32_t offset)
{
    struct sim *s = ctx;
    if (offset % SIM_FLASH_BLOCK || offset >= s->hal.flash_bytes)
        flash_abuse("erase outside the blocks", offset);
    static const uint8_t erased[SIM_FLASH_BLOCK] = {[0 ... SIM_FLASH_BLOCK - 1] = 0xff};
    return flash_change(s, offset, erased, SIM_FLASH_BLOCK, true);
}

static int flash_program(void *ctx, uint32_t offset, const void *data, uint32_t bytes)
{
    struct sim *s = ctx;
    if (offset % 4 || bytes % 4)
        flash_abuse("program of part of a word", offset);
    if (offset > s->hal.flash_bytes || bytes > s->hal.flash_bytes - offset)
        flash_abuse("program past the end", offset);
    for (uint32_t i = 0; i < bytes; i += 4) {
        uint32_t word;
        memcpy(&word, s->flash + offset + i, 4);
        if (word != ERASED_WORD)
            flash_abuse("program of a word that is not erased", offset + i);
    }
    return flash_change(s, offset, data, bytes, false);
}

static bool write_allowed(void *ctx)
{
    const struct sim *s = ctx;
    return !s->config.write_forbidden;
}

static bool flash_load(struct sim *s)
{
    FILE *f = fopen(s->config.flash_file, "rb");
    if (!f)
        return true; /* a new device */
    bool ok = fread(s->flash, 1, s->hal.flash_bytes, f) == s->hal.flash_bytes && fgetc(f) == EOF;
    fclose(f);
    return ok;
}

/* Beside the file, then renamed onto it: an interruption leaves the old image or the whole new one. */
static bool flash_save(const struct sim *s)
{
    size_t n = strlen(s->config.flash_file) + 5;
    char *temporary = malloc(n);
    if (!temporary)
        return false;
    snprintf(temporary, n, "%s.new", s->config.flash_file);
    FILE *f = fopen(temporary, "wb");
    bool ok = f && fwrite(s->flash, 1, s->hal.flash_bytes, f) == s->hal.flash_bytes;
    ok = f && fclose(f) == 0 && ok && rename(temporary, s->config.flash_file) == 0;
    if (f && !ok)
        remove(temporary);
    free(temporary);
    return ok;
}

/* --- display --- */

static int display_write(void *ctx, uint16_t x, uint16_t y, uint16_t w, uint16_t h, const void *pixels)
{
    struct sim *s = ctx;
    size_t size = pixel_bytes(s), row = w * size;
    if (x + w > s->config.width || y + h > s->config.height)
        return HAL_ERROR;
    for (size_t i = 0; i < h; i++)
        memcpy(s->picture + ((y + i) * s->config.width + x) * size, (const uint8_t *)pixels + i * row, row);
    s->tiles_shown++;
    return HAL_OK;
}

/* --- USB controller, the firmware's side --- */

static void queue_empty(struct queue *q)
{
    q->first = q->count = 0;
}

static bool queue_put(struct queue *q, const void *data, size_t bytes)
{
    if (q->count == QUEUE_PACKETS)
        return false;
    unsigned at = (q->first + q->count++) % QUEUE_PACKETS;
    q->bytes[at] = (uint16_t)bytes;
    if (bytes)
        memcpy(q->data[at], data, bytes);
    return true;
}

/* Takes a packet, of which at most `max` bytes are copied; its length, or -1. */
static int queue_take(struct queue *q, void *data, size_t max)
{
    if (q->count == 0)
        return -1;
    unsigned at = q->first;
    size_t n = q->bytes[at] < max ? q->bytes[at] : max;
    if (n)
        memcpy(data, q->data[at], n);
    q->first = (at + 1) % QUEUE_PACKETS;
    q->count--;
    return q->bytes[at];
}

static struct queue *queue_of(struct sim *s, uint8_t endpoint)
{
    switch (endpoint) {
    case 0x00:
        return &s->control_out;
    case 0x80:
        return &s->control_in;
    case 0x01:
        return &s->bulk_out;
    case 0x81:
        return &s->bulk_in;
    default:
        fprintf(stderr, "sim: usb: no endpoint 0x%02x\n", endpoint);
        abort();
    }
}

/* A SETUP packet ends the transfer before, what the firmware does for that one until it takes the packet included. */
static void control_clear(struct sim *s)
{
    queue_empty(&s->control_in);
    s->control_out.stalled = s->control_in.stalled = false;
    s->has_new_address = false;
}

static enum hal_usb_event usb_event(void *ctx, uint8_t setup[8])
{
    struct sim *s = ctx;
    if (s->detach_event) {
        s->detach_event = false;
        return HAL_USB_DETACH;
    }
    if (s->reset_event) {
        s->reset_event = false;
        return HAL_USB_RESET;
    }
    if (!s->setup_event)
        return HAL_USB_NONE;
    s->setup_event = false;
    control_clear(s);
    memcpy(setup, s->setup, 8);
    return HAL_USB_SETUP;
}

static int usb_read(void *ctx, uint8_t endpoint, void *data, size_t max)
{
    int n = queue_take(queue_of(ctx, endpoint), data, max);
    return n < 0 ? HAL_AGAIN : (size_t)n < max ? n : (int)max;
}

static int usb_write(void *ctx, uint8_t endpoint, const void *data, size_t bytes)
{
    struct sim *s = ctx;
    if (bytes > sim_packet(s, endpoint)) {
        fprintf(stderr, "sim: usb: packet of %zu bytes on endpoint 0x%02x\n", bytes, endpoint);
        abort();
    }
    if (!s->plugged)
        return HAL_AGAIN;
    return queue_put(queue_of(s, endpoint), data, bytes) ? HAL_OK : HAL_AGAIN;
}

static void usb_stall(void *ctx, uint8_t endpoint, bool stalled)
{
    struct sim *s = ctx;
    struct queue *q = queue_of(s, endpoint);
    q->stalled = stalled;
    if (endpoint == 0x00)
        s->control_in.stalled = stalled;
    if (!stalled)
        queue_empty(q);
}

static void usb_set_address(void *ctx, uint8_t address)
{
    struct sim *s = ctx;
    s->new_address = address;
    s->has_new_address = true;
}

/* --- creation --- */

static void config_complete(struct sim_config *c)
{
    if (!c->width)
        c->width = 320;
    if (!c->height)
        c->height = 240;
    if (!c->slot_count)
        c->slot_count = 17;
    if (!c->table_bank_bytes)
        c->table_bank_bytes = 1152u << 10;
    if (!c->scene_bank_bytes)
        c->scene_bank_bytes = 2u << 20;
    if (!c->arena_bytes)
        c->arena_bytes = 64u << 10;
    if (!c->serial)
        c->serial = "GT-SIM-0001";
}

struct sim *sim_create(const struct sim_config *config)
{
    struct sim *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->config = *config;
    config_complete(&s->config);
    s->flash_operations_left = s->cut_at = -1;
    uint32_t flash_bytes = 2 * (s->config.scene_bank_bytes + (s->config.slot_count - 1u) * s->config.table_bank_bytes);
    s->flash = malloc(flash_bytes);
    s->picture = calloc((size_t)s->config.width * s->config.height, pixel_bytes(s));
    if (!s->flash || !s->picture) {
        s->config.flash_file = NULL;
        sim_destroy(s);
        return NULL;
    }
    memset(s->flash, 0xff, flash_bytes);
    s->hal = (struct hal){
        .ctx = s,
        .display_write = s->config.display ? display_write : NULL,
        .usb_event = usb_event,
        .usb_read = usb_read,
        .usb_write = usb_write,
        .usb_stall = usb_stall,
        .usb_set_address = usb_set_address,
        .usb_high_speed = s->config.high_speed,
        .usb_high_speed_capable = s->config.high_speed,
        .flash = s->flash,
        .flash_bytes = flash_bytes,
        .flash_block_bytes = SIM_FLASH_BLOCK,
        .flash_erase = flash_erase,
        .flash_program = flash_program,
        .write_allowed = write_allowed,
    };
    if (s->config.flash_file && !flash_load(s)) {
        s->config.flash_file = NULL; /* leave a file that is not ours alone */
        sim_destroy(s);
        return NULL;
    }
    return s;
}

bool sim_destroy(struct sim *s)
{
    bool saved = !s->config.flash_file || flash_save(s);
    free(s->flash);
    free(s->picture);
    free(s);
    return saved;
}

const struct hal *sim_hal(struct sim *s)
{
    return &s->hal;
}

const struct sim_config *sim_configuration(const struct sim *s)
{
    return &s->config;
}

uint8_t *sim_flash(struct sim *s, uint32_t *bytes)
{
    *bytes = s->hal.flash_bytes;
    return s->flash;
}

void sim_forbid_writing(struct sim *s, bool forbidden)
{
    s->config.write_forbidden = forbidden;
}

void sim_fail_flash_after(struct sim *s, long operations)
{
    s->flash_operations_left = operations;
}

void sim_cut_power(struct sim *s, long operation, uint32_t how)
{
    s->cut_at = s->flash_operations + operation;
    s->cut_how = how;
}

bool sim_power_is_cut(const struct sim *s)
{
    return s->power_cut;
}

void sim_power_on(struct sim *s)
{
    s->power_cut = false;
}

long sim_flash_operations(const struct sim *s)
{
    return s->flash_operations;
}

const uint8_t *sim_picture(const struct sim *s)
{
    return s->picture;
}

uint32_t sim_tiles_shown(const struct sim *s)
{
    return s->tiles_shown;
}

/* --- the bus --- */

static void controller_clear(struct sim *s)
{
    struct queue *all[] = {&s->control_out, &s->control_in, &s->bulk_out, &s->bulk_in};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        queue_empty(all[i]);
        all[i]->stalled = false;
    }
    s->setup_event = s->has_new_address = false;
    s->address = 0;
}

void sim_plug(struct sim *s)
{
    s->plugged = !s->power_cut;
    sim_bus_reset(s);
}

void sim_unplug(struct sim *s)
{
    controller_clear(s);
    s->plugged = s->reset_event = false;
    s->detach_event = true;
}

void sim_bus_reset(struct sim *s)
{
    controller_clear(s);
    s->reset_event = s->plugged;
}

bool sim_plugged(const struct sim *s)
{
    return s->plugged;
}

uint8_t sim_address(const struct sim *s)
{
    return s->address;
}

size_t sim_packet(const struct sim *s, uint8_t endpoint)
{
    return (endpoint & 0x7f) == 0 ? CONTROL_PACKET : s->config.high_speed ? PACKET_BYTES : 64;
}

int sim_setup(struct sim *s, const uint8_t setup[8])
{
    if (!s->plugged)
        return SIM_GONE;
    queue_empty(&s->control_out);
    control_clear(s);
    memcpy(s->setup, setup, 8);
    s->setup_event = true;
    return 0;
}

int sim_out(struct sim *s, uint8_t endpoint, const void *data, size_t bytes)
{
    struct queue *q = queue_of(s, endpoint);
    size_t packet = sim_packet(s, endpoint), sent = 0;
    if (!s->plugged)
        return SIM_GONE;
    if (q->stalled)
        return SIM_STALL;
    do {
        size_t n = bytes - sent < packet ? bytes - sent : packet;
        if (!queue_put(q, sent ? (const uint8_t *)data + sent : data, n)) /* data may be NULL for no bytes */
            return sent ? (int)sent : SIM_NAK;
        sent += n;
    } while (sent < bytes);
    return (int)sent;
}

int sim_in(struct sim *s, uint8_t endpoint, void *data, size_t max)
{
    struct queue *q = queue_of(s, endpoint);
    if (!s->plugged)
        return SIM_GONE;
    if (q->stalled)
        return SIM_STALL;
    int n = queue_take(q, data, max);
    if (n < 0)
        return SIM_NAK;
    if (endpoint == 0x80 && n == 0 && s->has_new_address) { /* the host's acknowledgement */
        s->address = s->new_address;
        s->has_new_address = false;
    }
    return (size_t)n > max ? SIM_OVERFLOW : n;
}

bool sim_bulk_empty(const struct sim *s)
{
    return s->bulk_out.count == 0 && s->bulk_in.count == 0;
}
