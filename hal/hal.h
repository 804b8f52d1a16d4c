/*
 * The contract between the firmware and a board: one struct of functions with a context pointer.
 *
 * A board fills a struct hal and hands it to app_init. All functions are called from app_poll's thread only,
 * never from an interrupt; none may block for longer than a few microseconds unless stated. They are called
 * per tile or per packet, never per pixel.
 */
#ifndef HAL_HAL_H
#define HAL_HAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Negative results; zero or positive is success. */
enum hal_result {
    HAL_OK = 0,
    HAL_AGAIN = -1,    /* nothing there / no room now: try again later */
    HAL_ERROR = -2,    /* the operation failed */
    HAL_FORBIDDEN = -3 /* refused by the board */
};

enum hal_usb_event {
    HAL_USB_NONE = 0,
    HAL_USB_RESET,  /* bus reset or (re)plug: device goes to the default state, endpoint queues are empty, no
                       stalls */
    HAL_USB_DETACH, /* cable out */
    /* A SETUP packet arrived: the 8 bytes are in `setup`. By its arrival it has emptied endpoint 0 in both directions, cleared its
     * stall, voided an address that waited for its status packet and replaced a SETUP that was not yet taken: only the last one
     * counts. What the firmware did on endpoint 0 from then to this event is of the transfer before: packets to the host, a stall
     * and an address of that time are dropped, too. */
    HAL_USB_SETUP
    /* Suspend, 3 ms without any activity, is no event: all state stays, and goes on with the bus. To stay below what a suspended
     * device may draw is the board's part: it may call app_poll less often, or not at all until the bus is active. */
};

struct hal {
    void *ctx; /* passed to every function */

    /* Free-running counter of cycles or instructions, wraps at 2^32. NULL: the firmware reports a cost
     * modelled from its own counts, which repeats exactly. */
    uint32_t (*clock)(void *ctx);

    /* A finished tile, a frame's in any order: w*h pixels, rows without padding, in the format of app_config.
     * NULL: no display. The pixels may be overwritten when the call returns, so that it may take as long as their transfer, which
     * is in no tile's ticks. Returns HAL_OK or HAL_ERROR: the firmware goes on with the next tile. */
    int (*display_write)(void *ctx, uint16_t x, uint16_t y, uint16_t w, uint16_t h, const void *pixels);

    /* --- USB device controller. Endpoint numbers carry the direction in bit 7 (0x80 = IN, device to host).
     * --- */

    /* Takes the next bus event. For HAL_USB_SETUP fills setup[8]. Never blocks. */
    enum hal_usb_event (*usb_event)(void *ctx, uint8_t setup[8]);

    /* Takes one received OUT packet of `endpoint` (0 or 1): copies at most `max` bytes, returns its length (0
     * for a zero-length packet), or HAL_AGAIN. The controller accepts further packets as room appears; at
     * least 4 KB are buffered. `data` has any alignment, and is the board's to write only during the call. */
    int (*usb_read)(void *ctx, uint8_t endpoint, void *data, size_t max);

    /* Queues one IN packet of `bytes` <= the endpoint's packet size (0 = zero-length) on `endpoint` (0x80 or
     * 0x81): HAL_OK, or HAL_AGAIN when its buffer is still full. `data` has any alignment and is valid only during the
     * call: it is copied before the return. */
    int (*usb_write)(void *ctx, uint8_t endpoint, const void *data, size_t bytes);

    /* Sets or clears STALL on an endpoint (0x00 stands for both directions of endpoint 0). A stall of
     * endpoint 0 clears itself with the next SETUP. Clearing also empties the endpoint's queue and resets its
     * data toggle; the first clearing after a bus reset, at SET_CONFIGURATION, opens the endpoint. */
    void (*usb_stall)(void *ctx, uint8_t endpoint, bool stalled);

    /* The address of a SET_ADDRESS, called before its status packet is queued; takes effect when that packet is
     * acknowledged. A SETUP packet or a bus reset before then voids it. May be called again with the same address. */
    void (*usb_set_address)(void *ctx, uint8_t address);

    /* Now: 512-byte bulk packets instead of 64. Changes only just before HAL_USB_RESET is returned. */
    bool usb_high_speed;
    bool usb_high_speed_capable; /* the controller can run at high speed, whether or not it does now */

    /* --- Flash for tables and scene: memory-mapped for reading, erased to 0xff in blocks of one size, bits program from
     * 1 to 0.
     *
     * Each word of 4 bytes can be programmed by itself, once between two erasures, whatever was programmed beside it; and reading
     * a word whose programming or erasure a power cut has torn gives any value, but no fault. Serial NOR does both, as does
     * internal flash that is programmed by 32 bits (STM32F4, F7). Internal flash with an error-correcting code over 8 bytes or
     * more does neither (STM32L4, G4, WB: 8 bytes; U5: 16; H7: 32). --- */
    const uint8_t *flash;       /* 4-aligned */
    uint32_t flash_bytes;       /* a multiple of flash_block_bytes */
    uint32_t flash_block_bytes; /* erase unit, a power of two, 256 or more */

    /* Erases one block at a block-aligned offset. May take milliseconds. HAL_OK, HAL_ERROR or HAL_FORBIDDEN.
     */
    int (*flash_erase)(void *ctx, uint32_t offset);

    /* Programs `bytes` at `offset`, both multiples of 4; only erased words may be programmed, once. `data` is 4-aligned.
     * May take milliseconds; what it wrote is read back as soon as it returns. */
    int (*flash_program)(void *ctx, uint32_t offset, const void *data, uint32_t bytes);

    /* NULL or true: flash may be written. False: a jumper or strap forbids it; begin is refused. */
    bool (*write_allowed)(void *ctx);
};

#endif
