/*
 * USB device core (USB 2.0, chapter 9) for one vendor interface with a bulk OUT and a bulk IN endpoint.
 *
 * Purpose   answers endpoint 0 and keeps the device state; the protocol runs on the bulk endpoints.
 * Limits    one configuration, one alternate setting, no remote wake-up, no test modes (they need the controller); class
 *           requests are stalled, and vendor requests but the one for the Microsoft OS 2.0 descriptors. Suspend changes nothing here.
 * Errors    a request that is unknown, or not allowed in the device's state, stalls endpoint 0.
 */
#ifndef FIRMWARE_USB_DEVICE_H
#define FIRMWARE_USB_DEVICE_H

#include "hal.h"

#define USB_CONTROL_PACKET   64u
#define USB_FULL_SPEED_BULK  64u
#define USB_HIGH_SPEED_BULK  512u
#define USB_MAX_SERIAL_CHARS 31u

enum usb_device_state { USB_STATE_DETACHED, USB_STATE_DEFAULT, USB_STATE_ADDRESS, USB_STATE_CONFIGURED };

enum usb_control_stage { USB_STAGE_IDLE, USB_STAGE_DATA_IN, USB_STAGE_STATUS_OUT, USB_STAGE_STATUS_IN };

/* What a poll did to the bulk endpoints: their queues are empty, whoever uses them starts anew. */
enum usb_device_cleared { USB_CLEARED_OUT = 1, USB_CLEARED_IN = 2 };

struct usb_device {
    const struct hal *hal;
    const char *serial;
    enum usb_device_state state;
    enum usb_control_stage stage;
    bool halted_out, halted_in; /* the bulk endpoints' halt features */
    uint8_t new_address;        /* takes effect with the status stage */
    bool has_new_address;
    bool zero_packet; /* the data stage ends with a zero-length packet */
    uint16_t data_bytes, data_sent;
    const uint8_t *data; /* of the IN data stage: a constant, or */
    uint8_t built[64];   /* what is put together: the longest is a string of 31 characters */
};

/* `serial`: ASCII, 1 to USB_MAX_SERIAL_CHARS characters, must outlive the device. */
void usb_device_init(struct usb_device *d, const struct hal *hal, const char *serial);

/* Takes bus events and moves endpoint 0 on; never blocks. Returns enum usb_device_cleared flags. */
unsigned usb_device_poll(struct usb_device *d);

/* Bulk packet size at the controller's speed. */
size_t usb_device_packet(const struct usb_device *d);

/* One bulk packet; HAL_AGAIN also when not configured or halted. */
int usb_device_read(struct usb_device *d, void *data, size_t max);
int usb_device_write(struct usb_device *d, const void *data, size_t bytes);

/* Stalls the bulk OUT endpoint until the host clears the halt. */
void usb_device_halt_out(struct usb_device *d);

#endif
