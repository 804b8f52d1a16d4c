/*
 * Simulated board: flash in RAM with the rules of NOR flash, a USB device controller whose bus side is
 * functions, a display that keeps the picture. Any number of boards in one process.
 *
 * The firmware's side is the struct hal of sim_hal; the host's side are the functions below. Nothing here
 * runs the firmware: see sim_device.h.
 */
#ifndef HAL_SIM_SIM_H
#define HAL_SIM_SIM_H

#include "hal.h"

#define SIM_FLASH_BLOCK 4096u

struct sim_config {
    uint16_t width, height;    /* of the picture; 0: 320 x 240 */
    uint8_t format;            /* enum raster_format: 0 RGB565, 1 RGB888 */
    uint8_t samples;           /* coverage samples per pixel: 4, or 0 or 1 */
    bool display;              /* the board has a display: frames are rendered all the time */
    bool high_speed;           /* 512-byte bulk packets instead of 64 */
    bool write_forbidden;      /* the strap that forbids writing flash; see sim_forbid_writing */
    uint8_t slot_count;        /* 0: 17 */
    uint32_t table_bank_bytes; /* multiples of SIM_FLASH_BLOCK; 0: 1152 KB, the full-size table fits */
    uint32_t scene_bank_bytes; /* 0: 2 MB */
    size_t arena_bytes;        /* 0: 64 KB */
    uint32_t tile_budget;      /* ticks per tile until the host sets another; 0: no limit */
    const char *serial;        /* NULL: "GT-SIM-0001" */
    const char *flash_file;    /* NULL: none. Flash image: read at creation when it exists, written at destruction */
};

enum sim_result {
    SIM_NAK = -1,     /* the device is not ready: run it and try again */
    SIM_STALL = -2,   /* the endpoint is stalled */
    SIM_GONE = -3,    /* unplugged */
    SIM_OVERFLOW = -4 /* the packet is longer than the buffer: it is lost (babble) */
};

struct sim;

/* NULL when memory is out or the flash file has the wrong size or cannot be read. */
struct sim *sim_create(const struct sim_config *config);

/* Writes the flash file, if any: false when that failed. */
bool sim_destroy(struct sim *s);

const struct hal *sim_hal(struct sim *s);

/* The configuration with the defaults filled in. */
const struct sim_config *sim_configuration(const struct sim *s);

/* The flash image, for tests that damage it; its bytes. */
uint8_t *sim_flash(struct sim *s, uint32_t *bytes);
void sim_forbid_writing(struct sim *s, bool forbidden);
/* Flash operations (erase or program) until the next one fails with HAL_ERROR and every later one, too;
 * negative: none fails. */
void sim_fail_flash_after(struct sim *s, long operations);

/*
 * Cuts the power at a flash operation, 0 being the next. From then on the flash does nothing, every operation on it returns
 * HAL_ERROR and the cable is dead, until sim_power_on; a cut may be planned while the power is off.
 *   SIM_CUT_BEFORE, SIM_CUT_AFTER   the operation has not begun; is complete
 *   SIM_CUT_DURING + n, any n       it stops half-way, each n another way: after some of its bytes, in front or behind; with one
 *                                   of its bits done, few, half, almost all, all but one; of an erase also while it writes zeros
 */
enum { SIM_CUT_BEFORE, SIM_CUT_AFTER, SIM_CUT_DURING };
void sim_cut_power(struct sim *s, long operation, uint32_t how);
bool sim_power_is_cut(const struct sim *s);
void sim_power_on(struct sim *s);
/* Flash operations so far, those that failed not counted. */
long sim_flash_operations(const struct sim *s);

/* The display: width*height pixels as sent last, tiles received. */
const uint8_t *sim_picture(const struct sim *s);
uint32_t sim_tiles_shown(const struct sim *s);

/* --- The bus as its host sees it. A new board is unplugged. --- */

void sim_plug(struct sim *s);   /* power and bus reset */
void sim_unplug(struct sim *s); /* what is under way is lost */
void sim_bus_reset(struct sim *s);
bool sim_plugged(const struct sim *s);
uint8_t sim_address(const struct sim *s); /* set by SET_ADDRESS, 0 after a reset */

/* A SETUP packet; clears the stall of endpoint 0 and what was queued on it. SIM_GONE, else 0. */
int sim_setup(struct sim *s, const uint8_t setup[8]);

/* OUT data to endpoint 0x00 or 0x01, cut into packets; bytes = 0 sends a zero-length packet. Returns the
 * bytes accepted, a multiple of the packet size when fewer than `bytes` (send the rest later), or SIM_NAK,
 * SIM_STALL, SIM_GONE. */
int sim_out(struct sim *s, uint8_t endpoint, const void *data, size_t bytes);

/* Takes one IN packet of endpoint 0x80 or 0x81. A transfer ends with a packet shorter than sim_packet(), or
 * when the host's buffer is full. Returns its length (0: a zero-length packet) or an enum sim_result. */
int sim_in(struct sim *s, uint8_t endpoint, void *data, size_t max);

size_t sim_packet(const struct sim *s, uint8_t endpoint);

/* True when no packet waits on the bulk endpoints, in either direction. */
bool sim_bulk_empty(const struct sim *s);

#endif
