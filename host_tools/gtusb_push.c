/* `push`: a scene or a table to the device's flash; `verify`: whether the flash holds it. */
#define _GNU_SOURCE
#include "gtusb.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <zlib.h>

#include "host_atlas.h"
#include "scene.h"

#define MAX_RETRIES 8 /* of messages that arrive damaged, without any progress between them */

struct push {
    const char *path, *name;
    long slot; /* table slot, -1: not given */
    bool want_json;
    FILE *json; /* what is to be printed at the end, or NULL: text, at once */
    uint8_t *file;
    size_t file_bytes;
    struct atlas atlas; /* of no tables: the file is one table, or a scene */
    long first;         /* table slot of an atlas */
    /* What goes into one slot. */
    uint8_t *data;
    size_t bytes;
    uint32_t kind; /* enum usb_slot_kind */
    uint32_t crc;
    char *where, *what; /* for messages: the slot; the file and the slot */
};

static error_t parse_option(int key, char *arg, struct argp_state *state)
{
    struct push *p = state->input;
    switch (key) {
    case 'n':
        p->slot = parse_long("--slot", arg, 0, USB_MAX_SLOTS - 2);
        return 0;
    case 'j':
        p->want_json = true;
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

/* CRC-32 of the file's first bytes. */
static uint32_t crc_of(const struct push *p, size_t bytes)
{
    return (uint32_t)crc32(0, p->data, (uInt)bytes);
}

static void push_read(struct push *p)
{
    const char *slash = strrchr(p->path, '/');
    p->name = slash ? slash + 1 : p->path;
    p->file = read_file(p->path, ATLAS_MAX_BYTES, &p->file_bytes);
    if (!atlas_recognise(p->file, p->file_bytes))
        return;
    atlas_open(&p->atlas, p->path, p->file, p->file_bytes);
    p->first = p->slot < 0 ? 0 : p->slot;
}

/* Slots that the file fills. */
static uint32_t push_parts(const struct push *p)
{
    return p->atlas.tables ? p->atlas.tables : 1;
}

/* Before anything is sent. */
static void push_check_slots(const struct push *p, const struct usb_info *info)
{
    if (p->atlas.tables && (uint32_t)p->first + p->atlas.tables > info->slot_count - 1u)
        die(EXIT_REFUSED, "%s: %u tables from slot %ld on, the device has table slots 0 to %u; give fewer", p->name,
            p->atlas.tables, p->first, info->slot_count - 2u);
}

/* Finds out what the file is and checks it as the device will. */
static void file_check(struct push *p)
{
    static const uint8_t ktx2[] = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb};
    static const uint8_t scene_magic[] = {'G', 'T', 'S', 'C'};
    struct lut_table table;
    struct scene scene;
    if (p->bytes >= sizeof ktx2 && !memcmp(p->data, ktx2, sizeof ktx2)) {
        enum lut_status s = lut_open(&table, p->data, p->bytes);
        p->kind = USB_SLOT_TABLE;
        if (s)
            die(EXIT_BAD_INPUT, "%s: not a valid table: %s; build it again with gtlut", p->path, lut_status_text(s));
        if (p->slot < 0)
            die(EXIT_USAGE, "%s is a table: --slot is missing; say which of the scene's table slots it fills", p->path);
    } else if (p->bytes >= sizeof scene_magic && !memcmp(p->data, scene_magic, sizeof scene_magic)) {
        enum scene_status s = scene_open_bounded(&scene, p->data, p->bytes);
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

/* Makes table i of an atlas, or the file, ready. */
static void push_part(struct push *p, uint32_t i)
{
    if (p->atlas.tables) {
        p->data = atlas_table(&p->bytes, &p->atlas, i);
        p->kind = USB_SLOT_TABLE;
        p->slot = p->first + (long)i;
    } else {
        p->data = p->file;
        p->bytes = p->file_bytes;
        file_check(p);
    }
    p->crc = crc_of(p, p->bytes);
    p->where = p->slot < 0 ? xstrdup("scene") : xasprintf("table slot %ld", p->slot);
    p->what = xasprintf("%s of %zu bytes to %s", p->name, p->bytes, p->where);
}

static void part_free(struct push *p)
{
    if (p->data != p->file)
        free(p->data);
    free(p->where);
    free(p->what);
}

static uint32_t device_slot(const struct push *p)
{
    return (uint32_t)(p->slot + 1);
}

/* Drops the upload and ends the program, because of a refusal (NULL: of what else the device said) or Ctrl-C. */
static _Noreturn void push_abandon(struct link *l, const struct reply *refusal, const struct push *p)
{
    struct reply ignored;
    link_set_patience(l, 1);
    link_send(l, USB_MSG_ABORT, NULL, 0);
    link_receive(l, &ignored);
    device_close(l);
    if (link_interrupted())
        link_end_interrupted();
    if (!refusal)
        die(EXIT_USB,
            "%s: the device lost count of the bytes; push again, and update its firmware if that does not help",
            p->what);
    if (refusal->status == USB_ERR_STATE)
        die(EXIT_REFUSED, "%s: refused by the device: the upload is no longer open; push again", p->what);
    reply_refuse(refusal, p->what);
}

/* Streams from `done` on, LINK_DEPTH messages on their way, until all is there, a refusal (then *r is the first) or Ctrl-C, and takes in
 * every reply. Returns the bytes that arrived. */
static size_t push_stream(struct link *l, const struct push *p, size_t done, struct reply *r)
{
    size_t sent = done;
    uint32_t check = crc_of(p, done);
    unsigned unanswered = 0;
    *r = (struct reply){.status = USB_OK};
    for (;;) {
        while (sent < p->bytes && unanswered < LINK_DEPTH && r->status == USB_OK && !link_interrupted()) {
            size_t n = p->bytes - sent < USB_MAX_DATA ? p->bytes - sent : USB_MAX_DATA;
            check = (uint32_t)crc32(check, p->data + sent, (uInt)n);
            link_send_data(l, (uint32_t)sent, p->data + sent, n, check);
            sent += n;
            unanswered++;
        }
        if (!unanswered)
            return done;
        struct reply one;
        link_receive(l, &one);
        unanswered--;
        if (r->status == USB_OK) {
            *r = one;
            if (one.status == USB_OK)
                done = one.detail;
        }
        progress("push", done, p->bytes);
    }
}

/* What arrives damaged is sent again. */
static void push_content(struct link *l, const struct push *p, size_t done)
{
    struct reply r;
    for (int tries = 0; done < p->bytes; tries++) {
        size_t before = done;
        done = push_stream(l, p, done, &r);
        tries = done > before ? 0 : tries;
        bool again = r.status == USB_ERR_DAMAGED || r.status == USB_ERR_OFFSET, refused = r.status != USB_OK;
        if (link_interrupted() || (refused && (!again || tries == MAX_RETRIES)))
            push_abandon(l, &r, p);
        if (r.detail > p->bytes || tries == MAX_RETRIES)
            push_abandon(l, NULL, p);
        done = r.detail; /* of a refusal: the offset expected; else that after the last message */
    }
}

/* Reads the slot's content in flash and compares. */
static void push_verify(struct link *l, const struct push *p)
{
    struct usb_verify verify = {device_slot(p)};
    struct reply r;
    link_request(l, &r, p->what, USB_MSG_VERIFY, &verify, sizeof verify);
    if (r.detail != p->crc)
        die(EXIT_MISMATCH, "%s: %s differs: its CRC-32 is %08x, the file's %08x; push the file again", p->name,
            p->where, r.detail, p->crc);
}

static void json_string(FILE *to, const char *text)
{
    fputc('"', to);
    for (; *text; text++)
        if ((unsigned char)*text < ' ')
            fprintf(to, "\\u%04x", (unsigned)*text);
        else
            fprintf(to, *text == '"' || *text == '\\' ? "\\%c" : "%c", *text);
    fputc('"', to);
}

/* `there`: all of it was in the slot before, nothing was sent. */
static void push_report(const struct push *p, size_t kept, double seconds, bool there)
{
    double rate = seconds > 0 ? (double)(p->bytes - kept) / seconds : 0;
    if (p->json) {
        fprintf(p->json, "{\"file\": ");
        json_string(p->json, p->path);
        fprintf(p->json,
                ", \"kind\": \"%s\", \"slot\": %ld, \"bytes\": %zu, \"resumed_after\": %zu, \"crc\": %u,\n"
                " \"seconds\": %.6f, \"bytes_per_second\": %.0f, \"already_there\": %s, \"verified\": true}",
                p->kind == USB_SLOT_SCENE ? "scene" : "table", p->slot, p->bytes, kept, p->crc, seconds, rate,
                there ? "true" : "false");
        return;
    }
    if (there) {
        printf("%s to %s: all %zu bytes are there already\n", p->name, p->where, p->bytes);
        return;
    }
    printf("%s to %s: %zu bytes in %.3f s, %.2f MB/s\n", p->name, p->where, p->bytes - kept, seconds, rate / 1e6);
    if (kept)
        printf("resumed after %zu bytes of an earlier push\n", kept);
}

static const struct argp_option slot_option = {
    "slot", 'n', "N", 0, "table slot 0 to 15, as the scene's materials name it (tables only)", 0};
static const struct argp_option json_option = {
    "json", 'j', NULL, 0, "print JSON: an object, of an atlas an array of them", 0};

/* Of an atlas that was pushed in part, what is there stays: the open upload would be lost. */
static bool part_is_there(const struct usb_info *info, const struct push *p)
{
    const struct usb_slot_info *slot = &info->slots[device_slot(p)];
    return p->atlas.tables && slot->kind == p->kind && slot->bytes == p->bytes && slot->crc == p->crc;
}

/* Sends one slot's content. */
static void part_push(struct link *l, struct usb_info *info, const struct push *p)
{
    struct usb_begin begin = {device_slot(p), p->kind, (uint32_t)p->bytes, p->crc};
    struct reply r;
    struct timespec t0, t1;
    if (part_is_there(info, p)) {
        push_verify(l, p);
        push_report(p, p->bytes, 0, true);
        return;
    }
    clock_gettime(CLOCK_MONOTONIC, &t0);
    /* The same upload, cut off earlier, goes on where it stopped, when what the device has of it is right. */
    size_t kept = info->upload_received;
    if (info->upload_slot != begin.slot || info->upload_length != begin.length || info->upload_crc != begin.crc ||
        kept > p->bytes || info->upload_found != crc_of(p, kept)) {
        kept = 0;
        link_request(l, &r, p->what, USB_MSG_BEGIN, &begin, sizeof begin);
    }
    info->upload_slot = USB_NO_UPLOAD; /* an atlas's next table does not go on with it */
    push_content(l, p, kept);
    if (link_interrupted())
        push_abandon(l, NULL, p);
    link_send(l, USB_MSG_COMMIT, NULL, 0);
    link_receive(l, &r);
    if (r.status == USB_ERR_CONTENT)
        die(EXIT_REFUSED, "%s: refused by the device: %s; build it again with tools of the firmware's version", p->what,
            p->kind == USB_SLOT_TABLE ? lut_status_text((enum lut_status)r.detail)
                                      : scene_status_text((enum scene_status)r.detail));
    if (r.status != USB_OK)
        push_abandon(l, &r, p);
    clock_gettime(CLOCK_MONOTONIC, &t1);
    push_verify(l, p);
    push_report(p, kept, (double)(t1.tv_sec - t0.tv_sec) + 1e-9 * (double)(t1.tv_nsec - t0.tv_nsec), false);
}

void command_push(int argc, char **argv)
{
    const struct argp_option options[] = {slot_option, json_option, {0}};
    const struct argp argp = {
        options,
        parse_option,
        "FILE",
        "Sends a table (KTX 2.0, from gtlut) or a scene (from gtscene) to the device's flash. "
        "The device goes on with what it has until the new file is complete and checked; then its flash is read once "
        "more and compared. A push that was cut off goes on where it stopped. An atlas (from gtlut atlas) fills "
        "as many table slots as it has tables, from --slot on (0). Prints bytes, time and rate."
        "\vExamples:\n"
        "  $ gtusb push six_models.blob\n"
        "  $ gtusb push gold.ktx2 --slot 2\n"
        "  $ gtusb push atlas.ktx2",
        device_options,
        NULL,
        NULL};
    struct push p = {.slot = -1};
    struct usb_info info;
    options_parse(&argp, argc, argv, &p);
    push_read(&p);
    push_part(&p, 0);
    struct link *l = device_open(&info);
    push_check_slots(&p, &info);
    link_set_patience(l, 6);
    char *text = NULL;
    size_t text_bytes;
    if (p.want_json && !(p.json = open_memstream(&text, &text_bytes)))
        die(EXIT_INTERNAL, "out of memory");
    for (uint32_t i = 0; i < push_parts(&p); i++) {
        if (i)
            push_part(&p, i);
        if (i && p.json)
            fputs(",\n ", p.json);
        part_push(l, &info, &p);
        part_free(&p);
    }
    device_close(l);
    if (p.json && fclose(p.json) == 0)
        printf(p.atlas.tables ? "[%s]\n" : "%s\n", text);
    free(text);
    free(p.file);
}

void command_verify(int argc, char **argv)
{
    const struct argp_option options[] = {slot_option, {0}};
    const struct argp argp = {
        options,
        parse_option,
        "FILE",
        "Lets the device read a slot's content from its flash and compares it with a file. Exit code 10: it differs."
        "\vExamples:\n"
        "  $ gtusb verify gold.ktx2 --slot 2",
        device_options,
        NULL,
        NULL};
    struct push p = {.slot = -1};
    struct usb_info info;
    options_parse(&argp, argc, argv, &p);
    push_read(&p);
    push_part(&p, 0);
    struct link *l = device_open(&info);
    push_check_slots(&p, &info);
    link_set_patience(l, 6);
    for (uint32_t i = 0; i < push_parts(&p); i++) {
        if (i)
            push_part(&p, i);
        if (device_slot(&p) < info.slot_count && info.slots[device_slot(&p)].kind == USB_SLOT_EMPTY)
            die(EXIT_MISMATCH, "%s: %s is empty; push the file", p.name, p.where);
        push_verify(l, &p);
        printf("%s is in %s: %zu bytes, CRC-32 %08x\n", p.name, p.where, p.bytes, p.crc);
        part_free(&p);
    }
    device_close(l);
    free(p.file);
}
