#include "packet_faults.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum {
    DATA_BYTES = 600, /* in a message: several messages, several packets each */
    WINDOW = 3,       /* messages on their way at once */
    PATIENCE = 200,   /* polls without an answer until the host gives up */
    NO_PACKET = -1,
};

enum how { PULL_BEFORE, PULL_AFTER, RESET, STALL, LOSE, REPEAT, EXCHANGE, SHORTEN, CHANGE, HOWS = CHANGE + 92 };

static const struct scenario {
    const char *name;
    bool high_speed;
    enum lab_content scene, table; /* before */
    uint32_t slot;
    enum lab_content pushed;
} scenarios[PACKET_FAULT_SCENARIOS] = {
    {"full_speed", false, LAB_SCENE_A, LAB_SMALL_A, 1, LAB_SMALL_B},
    {"full_speed_scene", false, LAB_SCENE_A, LAB_SMALL_A, 0, LAB_SCENE_B},
    {"high_speed", true, LAB_SCENE_A, LAB_SMALL_B, 1, LAB_SMALL_C},
    {"high_speed_big", true, LAB_SCENE_B, LAB_BIG_A, 1, LAB_BIG_B},
};

struct packet_faults {
    struct lab *labs[2]; /* by speed */
    uint8_t *images[PACKET_FAULT_SCENARIOS];
    unsigned packets_out[PACKET_FAULT_SCENARIOS], packets_in[PACKET_FAULT_SCENARIOS];
    uint32_t resumed;
};

/* One opening of the device: its packets are counted, one of them may be hit. */
struct host {
    struct sim_device *device;
    int target_out, target_in; /* the packet to hit, or NO_PACKET */
    unsigned how;
    int out, in; /* packets so far */
    bool failed; /* something went wrong that a host sees */
    uint16_t next, expected;
    uint8_t types[256];
    uint8_t held[512]; /* a packet that the next one overtakes */
    size_t held_bytes;
};

/* --- packets --- */

static void change(uint8_t *packet, size_t bytes, unsigned n)
{
    if (bytes == 0)
        return;
    size_t bit = (size_t)n * 43 % (8 * bytes);
    packet[bit / 8] ^= (uint8_t)(1 << bit % 8);
    for (unsigned more = 1; n >= 64 && more <= n % 4; more++) /* one bit, or a burst of up to four bytes */
        packet[(bit / 8 + more) % bytes] ^= (uint8_t)(0x35 * (n + more) + 1);
}

/* Faults that hit the bus rather than the packet. True when the packet has none or is over. */
static bool bus_fault(struct host *h, uint8_t endpoint)
{
    struct sim *board = h->device->board;
    const uint8_t halt[8] = {0x02, 3, 0, 0, endpoint};
    if (h->how == PULL_BEFORE || h->how == PULL_AFTER)
        sim_unplug(board);
    else if (h->how == RESET)
        sim_bus_reset(board);
    else if (h->how == STALL)
        sim_device_control(h->device, halt, NULL);
    else
        return false;
    return true;
}

static void packet_put(struct host *h, const uint8_t *packet, size_t bytes)
{
    int n = SIM_NAK;
    for (int i = 0; i < PATIENCE && n == SIM_NAK; i++) {
        n = sim_out(h->device->board, USB_ENDPOINT_OUT, packet, bytes);
        sim_device_poll(h->device);
    }
    h->failed = h->failed || n != (int)bytes;
}

static void packet_out(struct host *h, const uint8_t *packet, size_t bytes)
{
    uint8_t copy[512];
    bool hit = h->out++ == h->target_out;
    memcpy(copy, packet, bytes);
    if (hit && h->how != PULL_AFTER && bus_fault(h, USB_ENDPOINT_OUT)) {
        h->failed = h->failed || h->how != STALL; /* which the next packet meets */
        if (h->how != STALL)
            return;
    }
    if (hit && h->how == EXCHANGE) {
        memcpy(h->held, copy, bytes);
        h->held_bytes = bytes;
        return;
    }
    if (hit && h->how >= CHANGE)
        change(copy, bytes, h->how - CHANGE);
    if (hit && h->how == SHORTEN)
        bytes /= 2;
    if (!hit || h->how != LOSE)
        packet_put(h, copy, bytes);
    if (hit && h->how == REPEAT)
        packet_put(h, copy, bytes);
    if (h->held_bytes)
        packet_put(h, h->held, h->held_bytes);
    h->held_bytes = 0;
    if (hit && h->how == PULL_AFTER) {
        bus_fault(h, USB_ENDPOINT_OUT);
        h->failed = true;
    }
}

/* The next packet, or -1 when none comes. */
static int packet_in(struct host *h, uint8_t packet[512])
{
    static const size_t most = 512;
    int n = SIM_NAK;
    bool hit = h->in == h->target_in;
    if (hit && h->how == REPEAT) { /* the one before comes again; the first is one of zeros */
        h->in++;
        return (int)sim_packet(h->device->board, USB_ENDPOINT_IN);
    }
    for (int i = 0; i < PATIENCE && n == SIM_NAK; i++) {
        sim_device_poll(h->device);
        if (i == 0 && hit && h->how != PULL_AFTER && bus_fault(h, USB_ENDPOINT_IN) && h->how != STALL)
            break;
        n = sim_in(h->device->board, USB_ENDPOINT_IN, packet, most);
        if (n >= 0 && hit && (h->how == LOSE || h->how == EXCHANGE)) { /* behind the next one is as good as lost */
            hit = false;
            h->in++;
            n = SIM_NAK;
        }
    }
    if (hit && h->how == PULL_AFTER)
        bus_fault(h, USB_ENDPOINT_IN);
    h->in++;
    if (n < 0)
        return -1;
    if (hit && h->how >= CHANGE)
        change(packet, (size_t)n, h->how - CHANGE);
    return hit && h->how == SHORTEN ? n / 2 : n;
}

/* --- messages --- */

static void request(struct host *h, uint8_t type, const void *payload, uint32_t bytes, uint32_t check)
{
    uint8_t message[sizeof(struct usb_header) + USB_MAX_PAYLOAD];
    struct usb_header header = {USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION, type, h->next, 0, bytes, check};
    size_t packet = sim_packet(h->device->board, USB_ENDPOINT_OUT), total = sizeof header + bytes;
    h->types[h->next++ % sizeof h->types] = type;
    if (bytes)
        memcpy(message + sizeof header, payload, bytes);
    if (type != USB_MSG_DATA)
        header.detail = (uint32_t)crc32(crc32(0, (uint8_t *)&header, 12), message + sizeof header, bytes);
    memcpy(message, &header, sizeof header);
    for (size_t at = 0; at < total && !h->failed; at += packet)
        packet_out(h, message + at, total - at < packet ? total - at : packet);
}

/* The next reply; `most` bytes of its payload are wanted. False: nothing that a host could take for it. */
static bool reply(struct host *h, struct usb_header *header, void *payload, size_t most)
{
    uint8_t message[sizeof *header + sizeof(struct usb_info) + 512] = {0};
    size_t packet = sim_packet(h->device->board, USB_ENDPOINT_IN), at = 0;
    int n = (int)packet;
    while (n == (int)packet && at + 512 <= sizeof message && !h->failed) {
        n = packet_in(h, message + at);
        if (n < 0)
            h->failed = true;
        else
            at += (size_t)n;
    }
    memcpy(header, message, sizeof *header);
    uint8_t type = h->types[h->expected % sizeof h->types] | USB_REPLY;
    if (h->failed || header->magic != USB_PROTOCOL_MAGIC || header->version != USB_PROTOCOL_VERSION ||
        header->type != type || header->sequence != h->expected++ || header->length + sizeof *header != at)
        h->failed = true;
    else if (most)
        memcpy(payload, message + sizeof *header, header->length < most ? header->length : most);
    return !h->failed;
}

static bool ask(struct host *h, uint8_t type, const void *payload, uint32_t bytes, struct usb_header *header,
                void *into, size_t most)
{
    request(h, type, payload, bytes, 0);
    return reply(h, header, into, most);
}

/* --- a push --- */

static bool stream(struct host *h, const uint8_t *data, uint32_t bytes, uint32_t done)
{
    struct usb_header header;
    uint32_t sent = done, check = (uint32_t)crc32(0, data, done);
    unsigned unanswered = 0;
    while (sent < bytes || unanswered) {
        if (sent < bytes && unanswered < WINDOW) {
            uint8_t payload[4 + DATA_BYTES];
            uint32_t n = bytes - sent < DATA_BYTES ? bytes - sent : DATA_BYTES;
            memcpy(payload, &sent, 4);
            memcpy(payload + 4, data + sent, n);
            check = (uint32_t)crc32(check, data + sent, n);
            request(h, USB_MSG_DATA, payload, 4 + n, check);
            sent += n;
            unanswered++;
        } else {
            if (!reply(h, &header, NULL, 0) || header.status != USB_OK)
                return false;
            unanswered--;
        }
    }
    return true;
}

/* What gtusb push does. *resumed: the bytes of an earlier one that were kept. False: it did not come to a good end. */
static bool push(struct host *h, uint32_t slot, const uint8_t *data, uint32_t bytes, uint32_t *resumed)
{
    struct usb_header header;
    struct usb_info info;
    uint32_t crc = (uint32_t)crc32(0, data, bytes);
    struct usb_begin begin = {slot, slot ? USB_SLOT_TABLE : USB_SLOT_SCENE, bytes, crc};
    struct usb_verify verify = {slot};
    if (!ask(h, USB_MSG_INFO, NULL, 0, &header, &info, sizeof info) || header.status != USB_OK ||
        header.length != sizeof info)
        return false;
    *resumed = info.upload_received;
    if (info.upload_slot != slot || info.upload_length != bytes || info.upload_crc != crc || *resumed > bytes ||
        info.upload_found != (uint32_t)crc32(0, data, *resumed)) {
        *resumed = 0;
        if (!ask(h, USB_MSG_BEGIN, &begin, sizeof begin, &header, NULL, 0) || header.status != USB_OK)
            return false;
    }
    return stream(h, data, bytes, *resumed) && ask(h, USB_MSG_COMMIT, NULL, 0, &header, NULL, 0) &&
           header.status == USB_OK && ask(h, USB_MSG_VERIFY, &verify, sizeof verify, &header, NULL, 0) &&
           header.status == USB_OK && header.detail == crc;
}

/* Plugs what was pulled, and clears both endpoints, as opening the device does. */
static bool device_reopen(struct sim_device *d)
{
    static const uint8_t interface[8] = {0x01, 11}, configuration[8] = {0x80, 8, 0, 0, 0, 0, 1};
    uint8_t descriptors[64], value = 0;
    bool configured = sim_plugged(d->board) && sim_device_control(d, configuration, &value) == 1 && value == 1;
    if (!configured && sim_device_enumerate(d, descriptors) < 0)
        return false;
    return sim_device_control(d, interface, NULL) == 0;
}

/* --- cases --- */

static struct lab *lab_of(const struct packet_faults *p, unsigned scenario)
{
    return p->labs[scenarios[scenario].high_speed];
}

struct packet_faults *packet_faults_create(void)
{
    struct packet_faults *p = calloc(1, sizeof *p);
    p->labs[0] = lab_create(false, false);
    p->labs[1] = lab_create(true, false);
    for (unsigned i = 0; i < PACKET_FAULT_SCENARIOS; i++) {
        const struct scenario *s = &scenarios[i];
        struct lab *lab = lab_of(p, i);
        uint32_t bytes, resumed;
        lab_start(lab, NULL);
        lab_push(lab, 0, s->scene);
        lab_push(lab, 1, s->table);
        p->images[i] = malloc(lab->flash_bytes);
        memcpy(p->images[i], sim_flash(lab->device->board, &bytes), lab->flash_bytes);
        struct host h = {.device = lab->device, .target_out = NO_PACKET, .target_in = NO_PACKET};
        if (!device_reopen(lab->device) ||
            !push(&h, s->slot, lab->data[s->pushed], (uint32_t)lab->bytes[s->pushed], &resumed))
            abort();
        p->packets_out[i] = (unsigned)h.out;
        p->packets_in[i] = (unsigned)h.in;
    }
    return p;
}

void packet_faults_destroy(struct packet_faults *p)
{
    for (unsigned i = 0; i < PACKET_FAULT_SCENARIOS; i++)
        free(p->images[i]);
    lab_destroy(p->labs[0]);
    lab_destroy(p->labs[1]);
    free(p);
}

const char *packet_faults_scenario(unsigned scenario)
{
    return scenarios[scenario].name;
}

uint32_t packet_faults_count(const struct packet_faults *p, unsigned scenario)
{
    return (p->packets_out[scenario] + p->packets_in[scenario]) * HOWS;
}

struct packet_fault packet_faults_case(const struct packet_faults *p, unsigned scenario, uint32_t n)
{
    (void)p;
    return (struct packet_fault){scenario, n / HOWS, n % HOWS};
}

void packet_faults_name(char name[64], const struct packet_fault *f)
{
    snprintf(name, 64, "%s/%u/%u", scenarios[f->scenario].name, f->packet, f->how);
}

bool packet_faults_parse(struct packet_fault *f, const char *name)
{
    for (unsigned s = 0; s < PACKET_FAULT_SCENARIOS; s++) {
        size_t n = strlen(scenarios[s].name);
        f->scenario = s;
        if (strncmp(name, scenarios[s].name, n) == 0 && sscanf(name + n, "/%u/%u", &f->packet, &f->how) == 2)
            return true;
    }
    return false;
}

uint32_t packet_faults_resumed(const struct packet_faults *p)
{
    return p->resumed;
}

const char *packet_faults_run(struct packet_faults *p, const struct packet_fault *f)
{
    const struct scenario *s = &scenarios[f->scenario];
    struct lab *lab = lab_of(p, f->scenario);
    const uint8_t *data = lab->data[s->pushed];
    uint32_t bytes = (uint32_t)lab->bytes[s->pushed], resumed;
    enum lab_content slots[LAB_SLOTS] = {s->scene, s->table};
    const char *wrong;
    lab_start(lab, p->images[f->scenario]);
    if (!device_reopen(lab->device))
        return "the device cannot be opened";

    struct host h = {.device = lab->device, .target_out = NO_PACKET, .target_in = NO_PACKET, .how = f->how};
    if (f->packet < p->packets_out[f->scenario])
        h.target_out = (int)f->packet;
    else
        h.target_in = (int)(f->packet - p->packets_out[f->scenario]);
    bool done = push(&h, s->slot, data, bytes, &resumed);

    if (!device_reopen(lab->device))
        return "the device cannot be opened again";
    if (lab_slot(lab, s->slot) == (int)s->pushed)
        slots[s->slot] = s->pushed;
    else if (done)
        return "the host was told of success, and the content is not there";
    if ((wrong = lab_check(lab, slots)))
        return wrong;

    struct host again = {.device = lab->device, .target_out = NO_PACKET, .target_in = NO_PACKET};
    if (!done && !push(&again, s->slot, data, bytes, &resumed))
        return "the push cannot be repeated";
    p->resumed += !done && resumed != 0;
    slots[s->slot] = s->pushed;
    return lab_check(lab, slots);
}
