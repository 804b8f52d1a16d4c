#include "protocol.h"

#include "crc32.h"

void protocol_init(struct protocol *p, struct usb_device *usb)
{
    p->usb = usb;
    p->state = PROTOCOL_HEADER;
    p->filled = 0;
    p->packet_bytes = p->packet_used = 0;
    p->sending = false;
}

void protocol_clear_out(struct protocol *p)
{
    p->packet_bytes = p->packet_used = 0;
    if (p->state != PROTOCOL_REQUEST)
        protocol_done(p);
}

void protocol_done(struct protocol *p)
{
    p->state = PROTOCOL_HEADER;
    p->filled = 0;
}

/* A request that is refused is dealt with. */
static void refused_done(struct protocol *p)
{
    protocol_done(p);
    if (p->refusal_halts) { /* where the next header begins is unknown: clearing the halt drops what came behind */
        usb_device_halt_out(p->usb);
        p->state = PROTOCOL_HALTED;
    }
}

void protocol_clear_in(struct protocol *p)
{
    p->sending = false;
    if (p->state == PROTOCOL_REQUEST)
        protocol_done(p);
    else if (p->state == PROTOCOL_REFUSED)
        refused_done(p);
}

static void refuse_later(struct protocol *p, enum usb_status why, uint32_t detail)
{
    p->state = PROTOCOL_REFUSED;
    p->refusal = why;
    p->refusal_detail = detail;
    p->refusal_halts = true;
}

/* The request is complete. DATA's check goes on from the upload's content: the table store sees to it. */
static void request_arrived(struct protocol *p)
{
    p->state = PROTOCOL_REQUEST;
    if (p->request.type == USB_MSG_DATA)
        return;
    uint32_t check = crc32_update(0, &p->request, offsetof(struct usb_header, detail));
    if (crc32_update(check, p->payload, p->request.length) != p->request.detail)
        refuse_later(p, USB_ERR_DAMAGED, 0);
}

/* The header is complete: what to do with what follows. */
static void header_arrived(struct protocol *p)
{
    const struct usb_header *h = &p->request;
    p->filled = 0;
    if (h->magic != USB_PROTOCOL_MAGIC) {
        p->request.type = 0;
        p->request.sequence = 0;
        refuse_later(p, USB_ERR_MAGIC, USB_PROTOCOL_MAGIC);
    } else if (h->version != USB_PROTOCOL_VERSION) {
        refuse_later(p, USB_ERR_VERSION, USB_PROTOCOL_VERSION);
    } else if (h->length > USB_MAX_PAYLOAD) {
        refuse_later(p, USB_ERR_LENGTH, USB_MAX_PAYLOAD);
        if (h->length <= USB_MAX_DRAIN) {
            p->refusal_halts = false;
            p->state = PROTOCOL_DRAIN;
        }
    } else if (h->length) {
        p->state = PROTOCOL_PAYLOAD;
    } else {
        request_arrived(p);
    }
}

/* Takes bytes of the packet at hand for the part of the message being collected. */
static void packet_take(struct protocol *p)
{
    bool header = p->state == PROTOCOL_HEADER;
    uint32_t wanted = (header ? (uint32_t)sizeof p->request : p->request.length) - p->filled;
    uint32_t n = (uint32_t)p->packet_bytes - p->packet_used;
    if (n > wanted)
        n = wanted;
    if (p->state != PROTOCOL_DRAIN) /* filled + n <= sizeof payload: header_arrived saw to it */
        __builtin_memcpy((header ? (uint8_t *)&p->request : (uint8_t *)p->payload) + p->filled,
                         p->packet + p->packet_used, n);
    p->packet_used = (uint16_t)(p->packet_used + n);
    p->filled += n;
    if (n < wanted)
        return;
    if (header)
        header_arrived(p);
    else if (p->state == PROTOCOL_DRAIN)
        p->state = PROTOCOL_REFUSED;
    else
        request_arrived(p);
}

static void refuse(struct protocol *p)
{
    protocol_reply(p, p->refusal, p->refusal_detail, NULL, 0, NULL, 0);
    refused_done(p);
}

void protocol_receive(struct protocol *p)
{
    for (;;) {
        if (p->state == PROTOCOL_REFUSED && !p->sending)
            refuse(p);
        if (p->state == PROTOCOL_REQUEST || p->state == PROTOCOL_REFUSED || p->state == PROTOCOL_HALTED)
            return;
        if (p->packet_used == p->packet_bytes) {
            uint32_t most = (uint32_t)usb_device_packet(p->usb);
            if (p->state == PROTOCOL_PAYLOAD &&
                p->request.length - p->filled >= most) { /* no detour for a whole packet */
                int n = usb_device_read(p->usb, (uint8_t *)p->payload + p->filled, most);
                if (n < 0)
                    return;
                p->filled += (uint32_t)n;
                if (p->filled == p->request.length)
                    request_arrived(p);
                continue;
            }
            int n = usb_device_read(p->usb, p->packet, most);
            if (n < 0)
                return;
            p->packet_bytes = (uint16_t)n;
            p->packet_used = 0;
        }
        if (p->packet_used < p->packet_bytes)
            packet_take(p);
    }
}

void protocol_reply(struct protocol *p, enum usb_status status, uint32_t detail, const void *data, uint32_t bytes,
                    const void *tail, uint32_t tail_bytes)
{
    struct usb_header h = {USB_PROTOCOL_MAGIC,
                           USB_PROTOCOL_VERSION,
                           (uint8_t)(p->request.type | USB_REPLY),
                           p->request.sequence,
                           (uint16_t)status,
                           bytes + tail_bytes,
                           detail};
    __builtin_memcpy(p->head, &h, sizeof h);
    if (bytes)
        __builtin_memcpy(p->head + sizeof h, data, bytes);
    p->head_bytes = (uint32_t)sizeof h + bytes;
    p->tail = tail;
    p->tail_bytes = tail_bytes;
    p->sent = 0;
    p->sending = true;
}

/* Puts the next packet of head and tail together; returns its length. */
static uint32_t packet_next(const struct protocol *p, uint8_t *packet, uint32_t max)
{
    uint32_t total = p->head_bytes + p->tail_bytes, at = p->sent, n = 0;
    if (at < p->head_bytes) {
        n = p->head_bytes - at < max ? p->head_bytes - at : max;
        __builtin_memcpy(packet, p->head + at, n);
        at += n;
    }
    uint32_t rest = total - at < max - n ? total - at : max - n;
    if (rest)
        __builtin_memcpy(packet + n, p->tail + (at - p->head_bytes), rest);
    return n + rest;
}

void protocol_send(struct protocol *p)
{
    uint32_t max = (uint32_t)usb_device_packet(p->usb);
    uint8_t packet[USB_HIGH_SPEED_BULK];
    while (p->sending) {
        uint32_t n = packet_next(p, packet, max);
        if (usb_device_write(p->usb, packet, n) != HAL_OK)
            return;
        p->sent += n;
        p->sending = n == max; /* a short packet, perhaps of no bytes, ends the reply */
    }
}
