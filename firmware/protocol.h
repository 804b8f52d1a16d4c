/*
 * Protocol framing: requests out of the bulk OUT packets, replies into the bulk IN packets (usb_protocol.h).
 *
 * One request is held at a time; nothing here blocks. What a request means is messages.c's.
 */
#ifndef FIRMWARE_PROTOCOL_H
#define FIRMWARE_PROTOCOL_H

#include "usb_device.h"
#include "usb_protocol.h"

enum protocol_state {
    PROTOCOL_HEADER,  /* collecting a header */
    PROTOCOL_PAYLOAD, /* collecting its payload */
    PROTOCOL_DRAIN,   /* dropping a payload that is refused */
    PROTOCOL_REFUSED, /* the refusal's reply waits for the one being sent */
    PROTOCOL_REQUEST, /* a whole request stands in `request` and `payload` */
    PROTOCOL_HALTED   /* waiting for the host to clear the halt */
};

#define PROTOCOL_REPLY_BYTES (sizeof(struct usb_header) + sizeof(struct usb_info))

struct protocol {
    struct usb_device *usb;
    enum protocol_state state;
    struct usb_header request;
    uint32_t payload[(USB_MAX_PAYLOAD + 3) / 4];
    uint32_t filled; /* bytes of header or payload collected, or drained */
    enum usb_status refusal;
    uint32_t refusal_detail;
    bool refusal_halts;

    uint16_t packet_bytes, packet_used; /* the OUT packet being taken apart */
    uint8_t packet[USB_HIGH_SPEED_BULK];

    bool sending;
    uint32_t head_bytes, tail_bytes, sent; /* the reply: head, then tail, then a short packet */
    const uint8_t *tail;                   /* the caller's, unchanged until `sending` is false */
    uint8_t head[PROTOCOL_REPLY_BYTES];
};

void protocol_init(struct protocol *p, struct usb_device *usb);

/* Forget a half-received request; forget the reply being sent. */
void protocol_clear_out(struct protocol *p);
void protocol_clear_in(struct protocol *p);

/* Takes packets until a request is complete or there are none. */
void protocol_receive(struct protocol *p);

/* Queues the reply to the request: `bytes` of `data` (at most sizeof(struct usb_info)) are copied,
 * `tail_bytes` of `tail` are not. Only while !p->sending. */
void protocol_reply(struct protocol *p, enum usb_status status, uint32_t detail, const void *data, uint32_t bytes,
                    const void *tail, uint32_t tail_bytes);

/* The request is dealt with; the next may be received. */
void protocol_done(struct protocol *p);

/* Sends packets of the reply until it is sent or the controller is full. */
void protocol_send(struct protocol *p);

#endif
