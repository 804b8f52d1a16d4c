/* `push`: a scene or a table to the device's flash. */
#define _GNU_SOURCE
#include "gtusb.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <zlib.h>

#include "lut.h"
#include "scene.h"

struct push {
    const char *path, *name;
    long slot; /* table slot, -1: not given */
    uint8_t *data;
    size_t bytes;
    uint32_t kind; /* enum usb_slot_kind */
};

static error_t parse_option(int key, char *arg, struct argp_state *state)
{
    struct push *p = state->input;
    switch (key) {
    case 'n':
        p->slot = parse_long("--slot", arg, 0, USB_MAX_SLOTS - 2);
        return 0;
    case ARGP_KEY_ARG:
        if (p->path)
            argp_usage(state);
        p->path = arg;
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_usage(state);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* Reads the file, finds out what it is and checks it as the device will. */
static void push_load(struct push *p)
{
    static const uint8_t ktx2[] = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb};
    static const uint8_t scene_magic[] = {'G', 'T', 'S', 'C'};
    struct lut_table table;
    struct scene scene;
    const char *slash = strrchr(p->path, '/');
    p->name = slash ? slash + 1 : p->path;
    p->data = read_file(p->path, SCENE_MAX_BYTES, &p->bytes);
    if (p->bytes >= sizeof ktx2 && !memcmp(p->data, ktx2, sizeof ktx2)) {
        enum lut_status s = lut_open(&table, p->data, p->bytes);
        p->kind = USB_SLOT_TABLE;
        if (s)
            die(EXIT_BAD_INPUT, "%s: not a valid table: %s; build it again with gtlut", p->path, lut_status_text(s));
        if (p->slot < 0)
            die(EXIT_USAGE, "%s is a table: --slot is missing; say which of the scene's table slots it fills", p->path);
    } else if (p->bytes >= sizeof scene_magic && !memcmp(p->data, scene_magic, sizeof scene_magic)) {
        enum scene_status s = scene_open(&scene, p->data, p->bytes);
        p->kind = USB_SLOT_SCENE;
        if (s)
            die(EXIT_BAD_INPUT, "%s: not a valid scene: %s; build it again with gtscene", p->path,
                scene_status_text(s));
        if (p->slot >= 0)
            die(EXIT_USAGE, "%s is a scene and goes to the scene's own slot; leave --slot out", p->path);
    } else
        die(EXIT_BAD_INPUT, "%s: neither a table (KTX 2.0) nor a scene of %zu bytes; build one with gtlut or gtscene",
            p->path, p->bytes);
}

/* Drops the upload and ends the program. */
static _Noreturn void push_abandon(struct link *l, const struct reply *why, unsigned unanswered, const char *what)
{
    struct reply ignored, refusal = why ? *why : (struct reply){0};
    link_set_patience(l, 1);
    while (unanswered--)
        link_receive(l, &ignored);
    link_send(l, USB_MSG_ABORT, NULL, 0, NULL, 0);
    link_receive(l, &ignored);
    device_close(l);
    if (link_interrupted())
        link_end_interrupted();
    reply_refuse(&refusal, what);
}

/* Streams the bytes from `done` on, LINK_DEPTH messages on their way. */
static void push_stream(struct link *l, const struct push *p, size_t done, const char *what)
{
    size_t sent = done;
    unsigned unanswered = 0;
    struct reply r;
    while (done < p->bytes) {
        while (sent < p->bytes && unanswered < LINK_DEPTH && !link_interrupted()) {
            struct usb_data d = {(uint32_t)sent};
            size_t n = p->bytes - sent < USB_MAX_DATA ? p->bytes - sent : USB_MAX_DATA;
            link_send(l, USB_MSG_DATA, &d, sizeof d, p->data + sent, n);
            sent += n;
            unanswered++;
        }
        if (!unanswered)
            push_abandon(l, NULL, 0, what);
        link_receive(l, &r);
        unanswered--;
        if (r.status != USB_OK)
            push_abandon(l, &r, unanswered, what);
        done = done + USB_MAX_DATA < p->bytes ? done + USB_MAX_DATA : p->bytes;
        progress("push", done, p->bytes);
    }
}

void command_push(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"slot", 'n', "N", 0, "table slot 0 to 15, as the scene's materials name it (tables only)", 0}, {0}};
    static const struct argp argp = {
        options,
        parse_option,
        "FILE",
        "Sends a table (KTX 2.0, from gtlut) or a scene (from gtscene) to the device's flash. "
        "The device goes on with what it has until the new file is complete and checked. "
        "Prints bytes, time and rate.",
        device_options,
        NULL,
        NULL};
    struct push p = {.slot = -1};
    struct usb_info info;
    struct reply r;
    struct timespec t0, t1;
    options_parse(&argp, argc, argv, &p);
    push_load(&p);
    struct usb_begin begin = {.slot = (uint32_t)(p.slot + 1), .kind = p.kind, .length = (uint32_t)p.bytes};
    begin.crc = (uint32_t)crc32(crc32(0, NULL, 0), p.data, (uInt)p.bytes);
    char *where = p.slot < 0 ? xstrdup("scene") : xasprintf("table slot %ld", p.slot);
    char *what = xasprintf("%s of %zu bytes to %s", p.name, p.bytes, where);

    struct link *l = device_open(&info);
    clock_gettime(CLOCK_MONOTONIC, &t0);
    link_set_patience(l, 6);
    /* The same upload, cut off earlier, goes on where it stopped. */
    bool resumes = info.upload_slot == begin.slot && info.upload_length == begin.length && info.upload_crc == begin.crc;
    size_t kept = resumes && info.upload_received <= p.bytes ? info.upload_received : 0;
    if (!resumes)
        link_request(l, &r, what, USB_MSG_BEGIN, &begin, sizeof begin);
    push_stream(l, &p, kept, what);
    if (link_interrupted())
        push_abandon(l, NULL, 0, what);
    link_send(l, USB_MSG_COMMIT, NULL, 0, NULL, 0);
    link_receive(l, &r);
    if (r.status == USB_ERR_CONTENT)
        die(EXIT_REFUSED, "%s: refused by the device: %s; build it again with tools of the firmware's version", what,
            p.kind == USB_SLOT_TABLE ? lut_status_text((enum lut_status)r.detail)
                                     : scene_status_text((enum scene_status)r.detail));
    if (r.status != USB_OK)
        reply_refuse(&r, what);
    clock_gettime(CLOCK_MONOTONIC, &t1);
    double seconds = (double)(t1.tv_sec - t0.tv_sec) + 1e-9 * (double)(t1.tv_nsec - t0.tv_nsec);
    printf("%s to %s: %zu bytes in %.3f s, %.2f MB/s\n", p.name, where, p.bytes - kept, seconds,
           (double)(p.bytes - kept) / 1e6 / seconds);
    if (kept)
        printf("resumed after %zu bytes of an earlier push\n", kept);
    device_close(l);
    free(what);
    free(where);
    free(p.data);
}
