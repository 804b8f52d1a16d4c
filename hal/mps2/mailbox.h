/*
 * A USB device controller for boards that have none: registers, endpoint buffers and doorbells in memory, whose other side is a bridge
 * outside the emulator (tests/guest). Full speed.
 *
 * Each word has one writer at a time. The bridge posts one event at a time and waits until the firmware has taken it: meanwhile the
 * firmware may empty any buffer. It moves no bulk packets during a control transfer, in which the firmware may empty the bulk buffers.
 */
#ifndef HAL_MPS2_MAILBOX_H
#define HAL_MPS2_MAILBOX_H

#include <stdint.h>

#define MAILBOX_OFFSET (29u << 19) /* in external memory, behind the flash, before the picture */
#define MAILBOX_READY  0x58424d47u

enum { MAILBOX_PACKETS = 64, MAILBOX_PACKET_BYTES = 64 };
enum { MAILBOX_CONTROL_OUT, MAILBOX_CONTROL_IN, MAILBOX_BULK_OUT, MAILBOX_BULK_IN, MAILBOX_BUFFERS };

/* Packets on their way, one direction of one endpoint. `put` and `taken` count packets and wrap at 2^32. */
struct mailbox_buffer {
    uint32_t put, taken;
    uint32_t stalled; /* written by the firmware */
    uint32_t bytes[MAILBOX_PACKETS];
    uint8_t data[MAILBOX_PACKETS][MAILBOX_PACKET_BYTES];
};

struct mailbox {
    uint32_t ready;           /* firmware: MAILBOX_READY once it serves */
    uint32_t posted, handled; /* bridge, firmware: events so far */
    uint32_t event;           /* bridge: enum hal_usb_event */
    uint8_t setup[8];
    uint32_t address; /* firmware: of SET_ADDRESS; holds for a bridge from when it takes the status packet */
    struct mailbox_buffer buffers[MAILBOX_BUFFERS];
};

#endif
