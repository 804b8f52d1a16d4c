#define _GNU_SOURCE
#include "gtusb_link.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <zlib.h>

#include "common.h"
#include "raster.h"

#define MAX_REQUEST (USB_MAX_DATA + 64u)
#define MAX_REPLY   (1u << 20) /* payload bytes; statistics of 16384 tiles are the longest, 393 KB */
#define GRACE       2.0        /* seconds to finish in after Ctrl-C */

struct out_slot {
    struct libusb_transfer *transfer;
    struct link *link;
    bool busy;
    uint8_t data[sizeof(struct usb_header) + MAX_REQUEST];
};

struct link {
    libusb_context *context;
    libusb_device_handle *handle;
    unsigned packet_bytes;
    double timeout, patience;
    double last_activity; /* seconds; any transfer that completed */
    struct out_slot out[LINK_DEPTH];
    struct libusb_transfer *in;
    bool in_busy;
    uint8_t *buffer; /* received bytes; the first `have` are valid, `consumed` of them belong to the reply handed out */
    size_t have, consumed;
    uint16_t next_sequence, expected_sequence;
    uint8_t types[LINK_DEPTH]; /* of the requests unanswered, by sequence number */
    const char *failure;       /* set by a callback */
};

static volatile sig_atomic_t interrupted;

static void on_signal(int signal_number)
{
    (void)signal_number;
    interrupted = 1;
}

bool link_interrupted(void)
{
    return interrupted;
}

void link_end_interrupted(void)
{
    die(EXIT_INTERRUPTED, "interrupted; the device keeps what it had");
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static const char *transfer_failure(enum libusb_transfer_status status)
{
    switch (status) {
    case LIBUSB_TRANSFER_NO_DEVICE:
        return "the device was unplugged; plug it in and try again";
    case LIBUSB_TRANSFER_STALL:
        return "the device refused a damaged request and stalled; try again, and check the cable";
    case LIBUSB_TRANSFER_OVERFLOW:
        return "the device sent more than asked for; update its firmware";
    default:
        return "transfer failed; check the cable";
    }
}

static void on_out(struct libusb_transfer *t)
{
    struct out_slot *slot = t->user_data;
    slot->busy = false;
    slot->link->last_activity = now();
    if (t->status != LIBUSB_TRANSFER_COMPLETED)
        slot->link->failure = transfer_failure(t->status);
    else if (t->actual_length != t->length)
        slot->link->failure = "the device took only part of a request; unplug it and plug it in again";
}

static void on_in(struct libusb_transfer *t)
{
    struct link *l = t->user_data;
    l->in_busy = false;
    l->last_activity = now();
    if (t->status != LIBUSB_TRANSFER_COMPLETED)
        l->failure = transfer_failure(t->status);
    else
        l->have += (size_t)t->actual_length;
}

/* Cancels what is under way and collects it, so that closing the device is clean. */
static void link_stop(struct link *l)
{
    bool busy = true;
    if (l->in_busy)
        libusb_cancel_transfer(l->in);
    for (int i = 0; i < LINK_DEPTH; i++)
        if (l->out[i].busy)
            libusb_cancel_transfer(l->out[i].transfer);
    for (double end = now() + 1; busy && now() < end;) {
        struct timeval wait = {0, 50000};
        libusb_handle_events_timeout_completed(l->context, &wait, NULL);
        busy = l->in_busy;
        for (int i = 0; i < LINK_DEPTH; i++)
            busy = busy || l->out[i].busy;
    }
}

static _Noreturn void link_fail(struct link *l, const char *why)
{
    link_stop(l);
    if (interrupted)
        link_end_interrupted();
    die(EXIT_USB, "USB: %s", why);
}

/* Serves transfers for a moment; ends the program on failure and when nothing has moved for too long. */
static void link_pump(struct link *l)
{
    struct timeval wait = {0, 100000};
    int e = libusb_handle_events_timeout_completed(l->context, &wait, NULL);
    if (e && e != LIBUSB_ERROR_INTERRUPTED)
        link_fail(l, libusb_strerror(e));
    if (l->failure)
        link_fail(l, l->failure);
    double idle = now() - l->last_activity, limit = interrupted ? GRACE : l->timeout * l->patience;
    if (idle > limit) {
        char *why = xasprintf(
            "no answer within %g s; unplug the device and plug it in again, or give a longer --timeout", limit);
        link_fail(l, why);
    }
}

struct link *link_open(libusb_context *context, libusb_device_handle *handle, unsigned packet_bytes, double timeout)
{
    struct link *l = xcalloc(1, sizeof *l);
    l->context = context;
    l->handle = handle;
    l->packet_bytes = packet_bytes;
    l->timeout = timeout;
    l->patience = 1;
    l->last_activity = now();
    l->buffer = xmalloc(2 * sizeof(struct usb_header) + MAX_REPLY + 2 * packet_bytes);
    l->in = libusb_alloc_transfer(0);
    for (int i = 0; i < LINK_DEPTH; i++) {
        l->out[i].link = l;
        l->out[i].transfer = libusb_alloc_transfer(0);
        if (!l->out[i].transfer || !l->in)
            die(EXIT_INTERNAL, "out of memory");
    }
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)(SA_RESETHAND | SA_RESTART)};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    return l;
}

void link_close(struct link *l)
{
    link_stop(l);
    libusb_free_transfer(l->in);
    for (int i = 0; i < LINK_DEPTH; i++)
        libusb_free_transfer(l->out[i].transfer);
    free(l->buffer);
    free(l);
}

void link_set_patience(struct link *l, double factor)
{
    l->patience = factor;
}

static struct out_slot *free_slot(struct link *l)
{
    for (;;) {
        for (int i = 0; i < LINK_DEPTH; i++)
            if (!l->out[i].busy)
                return &l->out[i];
        link_pump(l);
    }
}

/* `check`: of DATA, else NULL. */
static void message_send(struct link *l, enum usb_message type, const void *a, size_t a_bytes, const void *b,
                         size_t b_bytes, const uint32_t *check)
{
    struct out_slot *slot = free_slot(l);
    struct usb_header h = {.magic = USB_PROTOCOL_MAGIC,
                           .version = USB_PROTOCOL_VERSION,
                           .type = (uint8_t)type,
                           .sequence = l->next_sequence,
                           .length = (uint32_t)(a_bytes + b_bytes)};
    if (a_bytes + b_bytes > MAX_REQUEST)
        die(EXIT_INTERNAL, "request of %zu bytes, limit %u", a_bytes + b_bytes, MAX_REQUEST);
    l->types[l->next_sequence++ % sizeof l->types] = (uint8_t)type;
    if (a_bytes)
        memcpy(slot->data + sizeof h, a, a_bytes);
    if (b_bytes)
        memcpy(slot->data + sizeof h + a_bytes, b, b_bytes);
    uLong of_header = crc32(0, (const Bytef *)&h, offsetof(struct usb_header, detail));
    h.detail = check ? *check : (uint32_t)crc32(of_header, slot->data + sizeof h, (uInt)h.length);
    memcpy(slot->data, &h, sizeof h);
    libusb_fill_bulk_transfer(slot->transfer, l->handle, USB_ENDPOINT_OUT, slot->data,
                              (int)(sizeof h + a_bytes + b_bytes), on_out, slot, 0);
    int e = libusb_submit_transfer(slot->transfer);
    if (e == LIBUSB_ERROR_NO_DEVICE)
        link_fail(l, transfer_failure(LIBUSB_TRANSFER_NO_DEVICE));
    if (e)
        link_fail(l, libusb_strerror(e));
    slot->busy = true;
    l->last_activity = now();
}

void link_send(struct link *l, enum usb_message type, const void *payload, size_t bytes)
{
    message_send(l, type, payload, bytes, NULL, 0, NULL);
}

void link_send_data(struct link *l, uint32_t offset, const void *data, size_t bytes, uint32_t check)
{
    const struct usb_data d = {offset};
    message_send(l, USB_MSG_DATA, &d, sizeof d, data, bytes, &check);
}

/* Collects bytes until `wanted` are there. Never asks for a packet that need not come: whole packets that hold the bytes
 * missing, whether the device ends a reply with a short packet or lets the next one follow in it. */
static void collect(struct link *l, size_t wanted)
{
    while (l->have < wanted) {
        if (!l->in_busy) {
            size_t packets = (wanted - l->have + l->packet_bytes - 1) / l->packet_bytes;
            libusb_fill_bulk_transfer(l->in, l->handle, USB_ENDPOINT_IN, l->buffer + l->have,
                                      (int)(packets * l->packet_bytes), on_in, l, 0);
            int e = libusb_submit_transfer(l->in);
            if (e == LIBUSB_ERROR_NO_DEVICE)
                link_fail(l, transfer_failure(LIBUSB_TRANSFER_NO_DEVICE));
            if (e)
                link_fail(l, libusb_strerror(e));
            l->in_busy = true;
        }
        link_pump(l);
    }
}

void link_receive(struct link *l, struct reply *r)
{
    struct usb_header h;
    l->last_activity = now();
    l->have -= l->consumed;
    memmove(l->buffer, l->buffer + l->consumed, l->have);
    l->consumed = 0;
    collect(l, sizeof h);
    memcpy(&h, l->buffer, sizeof h);
    if (h.magic != USB_PROTOCOL_MAGIC)
        link_fail(l, "the reply is not Goniotile's; unplug the device and plug it in again");
    if (h.version != USB_PROTOCOL_VERSION) {
        link_stop(l);
        die(EXIT_REFUSED, "the device speaks protocol version %u, this program version %u; update the older of the two",
            h.version, USB_PROTOCOL_VERSION);
    }
    uint8_t type = l->types[l->expected_sequence % sizeof l->types] | 0x80;
    if (h.type != type || h.sequence != l->expected_sequence || h.length > MAX_REPLY)
        link_fail(l, "the reply does not belong to the request; unplug the device and plug it in again");
    l->expected_sequence++;
    collect(l, sizeof h + h.length);
    l->consumed = sizeof h + h.length;
    r->status = h.status;
    r->detail = h.detail;
    r->length = h.length;
    r->payload = l->buffer + sizeof h;
}

void link_expect_more(struct link *l)
{
    l->expected_sequence--;
}

void link_request(struct link *l, struct reply *r, const char *what, enum usb_message type, const void *payload,
                  size_t bytes)
{
    link_send(l, type, payload, bytes);
    link_receive(l, r);
    if (r->status != USB_OK)
        reply_refuse(r, what);
}

/* What to print for a status; the text may hold one %u for the detail. */
static const struct {
    const char *text, *advice;
} refusals[USB_STATUS_COUNT] = {
    [USB_OK] = {"accepted", "nothing to do"},
    [USB_ERR_MAGIC] = {"malformed request", "unplug the device and plug it in again"},
    [USB_ERR_VERSION] = {"protocol version not served", "update the device's firmware"},
    [USB_ERR_TYPE] = {"unknown request", "update the device's firmware"},
    [USB_ERR_LENGTH] = {"request of the wrong length", "update the device's firmware"},
    [USB_ERR_STATE] = {"not possible now", "push a scene first"},
    [USB_ERR_SLOT] = {"no such slot", "see 'gtusb info' for the slots there are"},
    [USB_ERR_TOO_LARGE] = {"larger than the slot's bank of %u bytes", "build a smaller one"},
    [USB_ERR_OFFSET] = {"data out of order, offset %u was expected", "push again"},
    [USB_ERR_INCOMPLETE] = {"only %u bytes arrived", "push again"},
    [USB_ERR_CRC] = {"the data arrived damaged, its CRC-32 is %u", "push again; check the cable"},
    [USB_ERR_CONTENT] = {"content not valid (code %u)", "build the file again with tools of the firmware's version"},
    [USB_ERR_FLASH] = {"erasing or programming flash failed", "push again; the flash may be worn out"},
    [USB_ERR_FORBIDDEN] = {"the board forbids writing", "set its write jumper"},
    [USB_ERR_VALUE] = {"value out of range", "see 'gtusb info' for materials, lights and slots"},
    [USB_ERR_RENDER] = {"the frame cannot be rendered (code %u)", "simplify the scene"},
    [USB_ERR_DAMAGED] = {"the request arrived damaged", "try again; check the cable"},
    [USB_ERR_TABLE] = {"the table slot of material %u is empty", "push a table to it or select another slot"},
    [USB_ERR_BUDGET] = {"the scene needs %u ticks per tile", "give a larger budget, 0 for none, or simplify the scene"},
    [USB_ERR_MODEL] = {"the device is built without the model of material %u",
                       "give it another one in the scene, or use other firmware"},
    [USB_ERR_MEMORY] = {"the frame needs %u bytes of memory, more than the device has", "simplify the scene"},
};

void reply_refuse(const struct reply *r, const char *what)
{
    char *subject = what ? xasprintf("%s: ", what) : xstrdup("");
    if (r->status >= USB_STATUS_COUNT)
        die(EXIT_REFUSED, "%srefused by the device with unknown status %u; update this program", subject, r->status);
    const char *advice = refusals[r->status].advice, *text = refusals[r->status].text, *number = strstr(text, "%u");
    if (r->status == USB_ERR_RENDER)
        die(EXIT_REFUSED, "%srefused by the device: %s; %s", subject, raster_status_text((enum raster_status)r->detail),
            advice);
    if (!number)
        die(EXIT_REFUSED, "%srefused by the device: %s; %s", subject, text, advice);
    die(EXIT_REFUSED, "%srefused by the device: %.*s%u%s; %s", subject, (int)(number - text), text, r->detail,
        number + 2, advice);
}
