/*
 * Measures the USB path; prints rows of results.csv.
 *
 *   bench_usb faults                            every power cut and every packet fault of tests/fault
 *   bench_usb bus SCENE.blob TABLE.ktx2...      a push of the full-size table over a Full-Speed bus: its bytes, its rate, idle and
 *                                               while the device renders the scene
 *   bench_usb requests FILE                     the requests of that push, for tests/board/push
 *
 * The bus: 19 packets per millisecond either way, as USB 2.0 (table 5-9) allows for bulk; a packet out that finds the device's
 * 4 KB full takes its turn and comes again. The device: CORE_HZ instructions per second (a Cortex-M7), of which tiles take what the
 * firmware models and bytes of a push PUSH_COST each; its flash is never waited for. While rendering, a device whose tiles take longer
 * than the 3.4 ms in which those 4 KB fill takes no more than that per tile. The host has eight requests on their way, as gtusb has.
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "common.h"
#include "packet_faults.h"
#include "power_cuts.h"
#include "ref_table.h"

#define CORE_HZ         480e6
#define PUSH_COST       ((double)APP_PUSH_COST)
#define POLL_COST       300.0 /* instructions of a step that finds nothing to do */
#define PACKETS_PER_MS  19.0
#define FULL_SPEED_RATE 1.216e6 /* bytes per second */

enum { WINDOW = 8, TABLE_SLOT = 16, MAX_REQUESTS = 4096 };

static void row(const char *metric, const char *unit, double value)
{
    printf("usb,x86-64,all,total,%s,%.*f,%s\n", metric, value == (double)(long)value ? 0 : 4, value, unit);
}

/* --- faults --- */

static void faults(void)
{
    uint32_t cut = 0, hit = 0, lost = 0;
    char name[64];
    struct power_cuts *p = power_cuts_create();
    for (unsigned s = 0; s < POWER_CUT_SCENARIOS; s++)
        for (uint32_t n = 0; n < power_cuts_count(p, s); n++, cut++) {
            struct power_cut c = power_cuts_case(p, s, n);
            const char *wrong = power_cuts_run(p, &c);
            power_cuts_name(name, &c);
            lost += wrong != NULL;
            if (wrong)
                warn("power cut %s: %s", name, wrong);
        }
    power_cuts_destroy(p);
    struct packet_faults *f = packet_faults_create();
    for (unsigned s = 0; s < PACKET_FAULT_SCENARIOS; s++)
        for (uint32_t n = 0; n < packet_faults_count(f, s); n++, hit++) {
            struct packet_fault c = packet_faults_case(f, s, n);
            const char *wrong = packet_faults_run(f, &c);
            packet_faults_name(name, &c);
            lost += wrong != NULL;
            if (wrong)
                warn("packet fault %s: %s", name, wrong);
        }
    packet_faults_destroy(f);
    row("power_cut_cases", "cases", cut);
    row("packet_fault_cases", "cases", hit);
    row("tables_lost_or_mixed", "cases", lost);
}

/* --- the requests of a push --- */

struct requests {
    uint8_t *bytes;
    size_t ends[MAX_REQUESTS]; /* of each request, in bytes */
    unsigned count, begin, commit;
    size_t content;
};

static void request_add(struct requests *r, uint8_t type, const void *payload, uint32_t bytes, const uint32_t *check)
{
    size_t at = r->count ? r->ends[r->count - 1] : 0;
    struct usb_header h = {USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION, type, (uint16_t)r->count, 0, bytes, 0};
    h.detail = check ? *check : (uint32_t)crc32(crc32(0, (uint8_t *)&h, 12), payload ? payload : "", bytes);
    r->bytes = xrealloc(r->bytes, at + sizeof h + bytes);
    memcpy(r->bytes + at, &h, sizeof h);
    if (bytes)
        memcpy(r->bytes + at + sizeof h, payload, bytes);
    r->ends[r->count++] = at + sizeof h + bytes;
}

/* The full-size table, pushed as gtusb pushes it; `whole`: with what it asks before and after. */
static struct requests push_requests(uint32_t slot, bool whole)
{
    enum { WIDTH = 361, HEIGHT = 181, DEPTH = 4 };
    struct requests r = {0};
    uint32_t *texels = xmalloc(WIDTH * HEIGHT * DEPTH * sizeof *texels), check = 0;
    for (uint32_t i = 0; i < WIDTH * HEIGHT * DEPTH; i++)
        texels[i] = (i * 2654435761u & 0x7ffffff) | 15u << 27;
    uint8_t *table = ref_ktx2_make(WIDTH, HEIGHT, DEPTH, texels, 60000, &r.content);
    struct usb_begin begin = {slot, USB_SLOT_TABLE, (uint32_t)r.content, (uint32_t)crc32(0, table, (uInt)r.content)};
    if (whole)
        request_add(&r, USB_MSG_INFO, NULL, 0, NULL);
    r.begin = r.count;
    request_add(&r, USB_MSG_BEGIN, &begin, sizeof begin, NULL);
    for (uint32_t at = 0; at < r.content; at += USB_MAX_DATA) {
        uint8_t payload[USB_MAX_PAYLOAD];
        uint32_t n = r.content - at < USB_MAX_DATA ? (uint32_t)r.content - at : USB_MAX_DATA;
        memcpy(payload, &at, 4);
        memcpy(payload + 4, table + at, n);
        check = (uint32_t)crc32(check, table + at, n);
        request_add(&r, USB_MSG_DATA, payload, 4 + n, &check);
    }
    r.commit = r.count;
    request_add(&r, USB_MSG_COMMIT, NULL, 0, NULL);
    if (whole)
        request_add(&r, USB_MSG_VERIFY, &slot, sizeof slot, NULL);
    free(texels);
    free(table);
    return r;
}

/* --- the bus --- */

struct result {
    double seconds;    /* from BEGIN to COMMIT's reply */
    double push_share; /* of the device's time in between */
};

/* The host's side of the wire. */
struct wire {
    const struct requests *r;
    size_t sent, received;    /* bytes of all requests; of the reply at hand */
    unsigned begun, answered; /* requests */
    double begin_time, commit_time;
};

/* One packet's time. */
static void wire_turn(struct wire *w, struct sim_device *d, double now)
{
    const struct requests *r = w->r;
    uint8_t packet[64];
    int n = sim_in(d->board, USB_ENDPOINT_IN, packet, sizeof packet);
    if (n >= 0) {
        struct usb_header h;
        memcpy(&h, packet, sizeof h);
        if (w->received == 0 && (n < (int)sizeof h || h.status != USB_OK))
            die(EXIT_REFUSED, "request %u refused: status %u", w->answered, h.status);
        w->received += (size_t)n;
        if (n == (int)sizeof packet)
            return;
        if (w->answered == r->commit)
            w->commit_time = now;
        w->answered++;
        w->received = 0;
        return;
    }
    bool inside = w->sent != (w->begun ? r->ends[w->begun - 1] : 0);
    if (w->begun == r->count || (!inside && w->begun - w->answered == WINDOW))
        return;
    if (w->begun == r->begin && !inside) { /* BEGIN waits for INFO, as in gtusb */
        if (w->answered < r->begin)
            return;
        w->begin_time = now;
    }
    size_t left = r->ends[w->begun] - w->sent;
    n = sim_out(d->board, USB_ENDPOINT_OUT, r->bytes + w->sent, left < sizeof packet ? left : sizeof packet);
    w->sent += n > 0 ? (size_t)n : 0;
    w->begun += w->sent == r->ends[w->begun];
}

static struct result push_timed(struct sim_device *d, const struct requests *r)
{
    struct wire w = {.r = r};
    double device_time = 0, bus_time = 0, pushing = 0;
    while (w.answered < r->count) {
        if (bus_time <= device_time) {
            bus_time += 1e-3 / PACKETS_PER_MS;
            wire_turn(&w, d, bus_time);
            continue;
        }
        const struct app_frame *f = &d->app.frame;
        uint32_t bytes = d->app.store.upload.received, ticks = f->stats.total.ticks, tile = f->next_tile;
        bool active = f->active;
        sim_device_poll(d);
        double cost = POLL_COST;
        if (f->active && !active)
            cost += f->stats.begin_ticks;
        else if (f->next_tile != tile)
            cost += f->stats.total.ticks - ticks;
        double push_cost =
            d->app.store.upload.received > bytes ? PUSH_COST * (d->app.store.upload.received - bytes) : 0;
        device_time += (cost + push_cost) / CORE_HZ;
        pushing += push_cost / CORE_HZ;
    }
    double seconds = w.commit_time - w.begin_time;
    return (struct result){seconds, pushing / seconds};
}

static void device_push(struct sim_device *d, uint32_t slot, const char *path)
{
    struct usb_header h = {0};
    size_t bytes;
    void *content = read_file(path, SCENE_MAX_BYTES, &bytes);
    if (!sim_device_push(d, slot, slot ? USB_SLOT_TABLE : USB_SLOT_SCENE, content, (uint32_t)bytes, &h) || h.status)
        die(EXIT_REFUSED, "%s: refused by the simulated device: status %u", path, h.status);
    free(content);
}

static void bus(int count, char **files)
{
    struct requests r = push_requests(TABLE_SLOT, true);
    for (int rendering = 0; rendering < 2; rendering++) {
        const struct sim_config config = {.format = RASTER_RGB888, .display = rendering};
        struct sim_device *d = sim_device_create(&config);
        uint8_t descriptors[64];
        if (!d || sim_device_enumerate(d, descriptors) < 0)
            die(EXIT_INTERNAL, "no simulated device");
        for (int i = count - 1; rendering && i >= 0; i--) /* the scene last, so that no frame lacks a table */
            device_push(d, (uint32_t)i, files[i]);
        struct result result = push_timed(d, &r);
        row(rendering ? "bus_share_rendering" : "bus_share_idle", "ratio",
            (double)r.content / result.seconds / FULL_SPEED_RATE);
        if (rendering)
            row("push_share_of_device_time", "ratio", result.push_share);
        sim_device_destroy(d);
    }
    /* Both ways: all of the requests but their content, all of the replies; INFO's has a payload. */
    size_t replies = r.count * sizeof(struct usb_header) + sizeof(struct usb_info);
    row("protocol_overhead", "ratio", (double)(r.ends[r.count - 1] - r.content + replies) / (double)r.content);
    free(r.bytes);
}

int main(int argc, char **argv)
{
    common_set_name("bench_usb", NULL);
    if (argc == 2 && !strcmp(argv[1], "faults")) {
        faults();
    } else if (argc > 3 && !strcmp(argv[1], "bus")) {
        bus(argc - 2, argv + 2);
    } else if (argc == 3 && !strcmp(argv[1], "requests")) {
        struct requests r = push_requests(1, false);
        uint32_t sizes[2] = {(uint32_t)r.content, (uint32_t)r.ends[r.count - 1]};
        uint8_t *file = xmalloc(sizeof sizes + sizes[1]);
        memcpy(file, sizes, sizeof sizes);
        memcpy(file + sizeof sizes, r.bytes, sizes[1]);
        write_file(argv[2], file, sizeof sizes + sizes[1]);
        free(file);
        free(r.bytes);
    } else {
        die(EXIT_USAGE, "usage: bench_usb faults | bus SCENE.blob TABLE.ktx2... | requests FILE");
    }
    return EXIT_OK;
}
