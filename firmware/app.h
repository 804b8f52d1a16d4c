/*
 * The firmware: frame loop, USB device, protocol and table store over a struct hal. No main: a board's main fills a
 * struct hal and a struct app_config, calls app_init once and app_poll for ever.
 */
#ifndef FIRMWARE_APP_H
#define FIRMWARE_APP_H

#include "hal.h"
#include "raster.h"
#include "table_store.h"
#include "usb_device.h"
#include "usb_protocol.h"

struct app_config {
    uint16_t width, height; /* of the picture */
    uint8_t format;         /* enum raster_format, for display and USB */
    uint8_t slot_count;     /* 2..USB_MAX_SLOTS: the scene's and the table slots */
    uint32_t scene_bank_bytes; /* of slot 0; 0: an equal share of the flash for every bank */
    void *arena;            /* 8-aligned: bins and transforms of a frame */
    size_t arena_bytes;
    struct usb_tile_stats *tile_stats; /* one per tile, or NULL: no per-tile statistics */
    uint32_t tile_stats_count;
    const char *serial;     /* USB serial number, ASCII, at most 31 characters, must outlive the app */
};

enum app_status { APP_OK = 0, APP_ERR_CONFIG, APP_ERR_FLASH };

struct app; /* defined below by firmware; sizeof is known to the caller */

#endif
