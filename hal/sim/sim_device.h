/*
 * A simulated device: the firmware on a simulated board (what a board's main.c is elsewhere), and a plain
 * host for it that runs the firmware until it answers. For tests and `gtsim`; many devices may live in one
 * process.
 */
#ifndef HAL_SIM_SIM_DEVICE_H
#define HAL_SIM_SIM_DEVICE_H

#include "app.h"
#include "sim.h"

struct sim_device {
    struct sim *board;
    struct app app;
    struct app_config config;
    uint16_t sequence;    /* of sim_device_request */
    uint32_t content_crc; /* of the DATA sent so far */
};

/* NULL on bad configuration, unreadable flash file or lack of memory. The device is unplugged. */
struct sim_device *sim_device_create(const struct sim_config *config);

/* False when the flash file could not be written. */
bool sim_device_destroy(struct sim_device *d);

/* One step of the firmware. */
void sim_device_poll(struct sim_device *d);

/* Power cycle: the firmware starts anew on the same flash; unplugged afterwards. */
void sim_device_restart(struct sim_device *d);

/* --- A host. All of these run the firmware. --- */

/* A whole control transfer; the data stage's length is setup's wLength. Returns the bytes of the data stage,
 * or SIM_STALL, SIM_GONE, or SIM_NAK when the device never answers. */
int sim_device_control(struct sim_device *d, const uint8_t setup[8], void *data);

/* Plugs the device when it is not and brings it to the configured state as a host does: reset, descriptors,
 * address 1, configuration 1. Writes the device descriptor (18 bytes) and the whole configuration descriptor
 * to `descriptors`; returns their bytes, or a negative enum sim_result. */
int sim_device_enumerate(struct sim_device *d, uint8_t descriptors[64]);

/* Between two requests: nothing of one has come, nothing of a reply is left. Then another host may make some. */
bool sim_device_idle(const struct sim_device *d);

/* Puts the check of a request with this payload into its header. DATA goes on from the DATA before; offset 0 starts anew. */
void sim_device_check(struct sim_device *d, struct usb_header *h, const void *payload);

/* One request and its (first) reply. `reply` takes at most `max` payload bytes. Returns false on a stalled
 * endpoint, unplugged device or no reply. */
bool sim_device_request(struct sim_device *d, uint8_t type, const void *payload, uint32_t bytes,
                        struct usb_header *header, void *reply, size_t max);

/* Begin, data, commit. *header is the last reply: its status tells the outcome. */
bool sim_device_push(struct sim_device *d, uint32_t slot, uint32_t kind, const void *data, uint32_t bytes,
                     struct usb_header *header);

/* A frame, assembled: width*height pixels of the device's format. *header is the last reply: a refusal's
 * status and detail, or USB_OK. */
bool sim_device_frame(struct sim_device *d, uint8_t *pixels, struct usb_header *header);

#endif
