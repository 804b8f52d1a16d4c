/*
 * Requests and replies over the two bulk endpoints, by asynchronous transfers.
 *
 * link_send queues a request and returns at once while fewer than LINK_DEPTH are on their way; link_receive waits for the next
 * reply. Every failure of the bus, a silent device and a malformed reply end the program with EXIT_USB (EXIT_REFUSED for another
 * protocol version, EXIT_INTERRUPTED after Ctrl-C), so that no caller has to handle them.
 */
#ifndef HOST_TOOLS_GTUSB_LINK_H
#define HOST_TOOLS_GTUSB_LINK_H

#include <libusb.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "usb_protocol.h"

#define LINK_DEPTH 8 /* requests on their way at once */

struct link;

struct reply {
    uint16_t status; /* enum usb_status */
    uint32_t detail;
    uint32_t length;        /* bytes of payload */
    const uint8_t *payload; /* valid until the next link_receive */
};

/* Takes over an opened device whose interface is claimed. `timeout` seconds without any transfer completing end the
 * program; SIGINT and SIGTERM are caught from now on (once: a second signal kills). */
struct link *link_open(libusb_context *context, libusb_device_handle *handle, unsigned packet_bytes, double timeout);
void link_close(struct link *l);

/* Requests whose answer takes the device longer (erasing flash, rendering) multiply the time-out: 1 is the default. */
void link_set_patience(struct link *l, double factor);

/* Queues a request with a payload of at most USB_MAX_DATA + 64 bytes, which is copied. No more than LINK_DEPTH requests may be
 * unanswered. */
void link_send(struct link *l, enum usb_message type, const void *payload, size_t bytes);

/* DATA; `check` is the CRC-32 of the upload's content up to the end of these bytes. */
void link_send_data(struct link *l, uint32_t offset, const void *data, size_t bytes, uint32_t check);

/* Waits for the reply to the oldest request sent. A reply with more to come (a frame's tiles) is received by calling again
 * after link_expect_more. */
void link_receive(struct link *l, struct reply *r);
void link_expect_more(struct link *l);

/* Send and receive; a refusal ends the program through reply_refuse, naming `what` (NULL: nothing to name). */
void link_request(struct link *l, struct reply *r, const char *what, enum usb_message type, const void *payload,
                  size_t bytes);

/* Ends the program with EXIT_REFUSED: "<what>: refused by the device: <status in words and detail>; <what to do>". */
_Noreturn void reply_refuse(const struct reply *r, const char *what);

/* True after Ctrl-C: finish what is on its way, tell the device, then call link_end_interrupted. */
bool link_interrupted(void);
_Noreturn void link_end_interrupted(void);

#endif
