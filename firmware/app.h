/*
 * The firmware: frame loop, USB device, protocol and table store over a struct hal. No main: a board's main
 * fills a struct hal and a struct app_config, calls app_init once and app_poll for ever.
 */
#ifndef FIRMWARE_APP_H
#define FIRMWARE_APP_H

#include "budget.h"
#include "hal.h"
#include "protocol.h"
#include "raster.h"
#include "table_store.h"
#include "usb_device.h"
#include "usb_protocol.h"

struct app_config {
    uint16_t width, height;           /* of the picture */
    uint8_t format;                   /* enum raster_format, for display and USB */
    uint8_t samples;                  /* per pixel: 4 smooths edges, up to 2048 x 2048; 0 or 1 not; see raster_frame */
    uint8_t slot_count;               /* 2..USB_MAX_SLOTS: the scene's and the table slots */
    uint32_t scene_bank_bytes;        /* of slot 0, a multiple of the flash block; 0: an equal share of the flash for
                                  every bank */
    const struct raster_parts *parts; /* of the renderer, that the firmware has: scenes that need others are refused */
    void *arena;                      /* 8-aligned: bins and transforms of a frame, and what the host has set */
    size_t arena_bytes;
    const struct raster_costs *costs; /* of the target (hal/costs): what a budget goes by, and ticks without a clock; up
                                     to APP_MOST_COST */
    const struct budget_scheduler
        *budgets;                      /* &budget_scheduler, or NULL: the firmware is without, and SET refuses one */
    uint32_t tile_budget;              /* ticks per tile on average until the host sets another; 0: no limit */
    struct raster_memory *memory;      /* zeroed, or NULL: budgets do not know what the last frame's surfaces showed */
    struct usb_tile_stats *tile_stats; /* one per tile, or NULL: no per-tile statistics */
    uint32_t tile_stats_count;
    const char *serial; /* USB serial number, ASCII, 1 to 31 characters, must outlive the app */
};

/* What entries of `costs` may be at most, with their 4 fraction bits. The plan's products of a sample under up to 128 lights, with 8 fraction
 * bits, then fit into 32 bits: (1 + 128) * 2^8 * APP_MOST_SAMPLE_COST < 2^32. The tables in hal/costs have up to 28,559 and 432,000. */
#define APP_MOST_SAMPLE_COST 130000u    /* of shading: sample, lit, dark, point; and part, cell */
#define APP_MOST_COST        (1u << 20) /* of all entries */

/* While a frame is rendered, uploads get one part in APP_PUSH_SHARE of the tiles' time: tiles earn credit, and a DATA message
 * waits until there is enough for it, at APP_PUSH_COST instructions per byte (tests/board/push measures fewer). What an erase
 * of a flash block takes comes on top. */
#define APP_PUSH_SHARE 8u
#define APP_PUSH_COST  12u

/* Lights that a host can set; those of a scene with more are as they are. */
#define APP_MAX_SET_LIGHTS 16

enum app_status { APP_OK = 0, APP_ERR_CONFIG, APP_ERR_FLASH };

/* What frames are made from: the live scene with what the host has overridden, and the live tables. Changes
 * only between two frames. */
struct app_content {
    bool has_scene;
    struct scene scene;
    uint32_t triangle_count; /* of all objects, finest levels */
    struct scene_camera camera;
    struct scene_output output;
    uint8_t light_count;
    uint32_t tile_budget;             /* as set, or the configuration's */
    const struct scene_light *lights; /* the scene's own until the host changes one; so are materials */
    const struct scene_material *materials;
    struct scene_material *own; /* copies at the arena's end; then lights, if no more than can be set; or NULL */
    struct lut_table tables[RASTER_MAX_SLOTS];
    const struct lut_table *table_of_slot[RASTER_MAX_SLOTS]; /* NULL: empty */
};

/* The frame in flight. */
struct app_frame {
    bool active;
    bool streamed; /* tiles go to USB, too */
    bool recorded; /* its statistics will be kept */
    bool refused;  /* the last frame for the display could not begin; wait for a change */
    uint32_t next_tile;
    struct raster raster;
    struct raster_tile work;
    struct budget budget;
    struct usb_stats stats;
    uint32_t rates, samples; /* of stats.total.rate: the sum, and of how many */
};

/* Everything the firmware knows; fields are internal. About 31 KB, place it in fast RAM. */
struct app {
    const struct hal *hal;
    struct app_config config;
    struct usb_device usb;
    struct protocol protocol;
    struct table_store store;
    struct app_content content;
    struct app_frame frame;
    struct usb_stats stats;        /* of the last complete frame */
    bool tiles_mixed;              /* config.tile_stats are of it and of one that was dropped */
    uint32_t push_credit;          /* bytes of DATA that the tiles so far allow, at most USB_MAX_DATA */
    uint32_t verified, verify_crc; /* of the VERIFY at work: bytes read, their CRC */
    uint32_t frames;               /* complete ones since app_init */
};

/* In: *hal and what *config points to stay owned by the caller and must outlive *app; *config is copied.
 * Reads all live flash content once (CRC). APP_ERR_CONFIG: a field out of range; APP_ERR_FLASH: the flash is
 * too small for the slots, or its blocks are not as hal.h says. */
enum app_status app_init(struct app *app, const struct hal *hal, const struct app_config *config);

/*
 * One step: bus events, endpoint 0, packets in and out, at most one request, at most one tile. Call it for
 * ever. With a display, frames follow each other; a FRAME request streams the next one. Without, only
 * requested frames are rendered.
 */
void app_poll(struct app *app);

/* For content.c, between two frames: USB_OK, or USB_ERR_BUDGET and the least budget that would do for the present content. */
struct table_store_result app_check_budget(struct app *app, uint32_t tile_budget);

/* For messages.c. Begins a frame; `streamed`: in answer to the request in hand. */
enum raster_status app_frame_begin(struct app *app, bool streamed);

#endif
