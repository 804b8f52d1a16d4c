/* `info` and `stats`: what the device is and what its last frame cost. */
#include "gtusb.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "raster.h"

struct report_args {
    bool json, tiles;
};

static error_t parse_option(int key, char *arg, struct argp_state *state)
{
    struct report_args *a = state->input;
    (void)arg;
    switch (key) {
    case 'j':
        a->json = true;
        return 0;
    case 'a':
        a->tiles = true;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const char *kind_text(uint32_t kind)
{
    return kind == USB_SLOT_TABLE ? "table" : kind == USB_SLOT_SCENE ? "scene" : "empty";
}

/* Printable ASCII without quotes and backslashes, so that it needs no escapes in JSON. */
static void version_text(char out[17], const char *field)
{
    memset(out, 0, 17);
    for (int i = 0; i < 16 && field[i]; i++)
        out[i] = field[i] >= ' ' && field[i] < 127 && field[i] != '"' && field[i] != '\\' ? field[i] : '?';
}

static void info_json(const struct usb_info *i, const char *version)
{
    printf("{\"firmware\": \"%s\", \"protocol_version\": %u, \"scene_version\": %u,\n", version, i->protocol_version,
           i->scene_version);
    printf(" \"width\": %u, \"height\": %u, \"format\": \"%s\", \"tile_width\": %u, \"tile_height\": %u,\n", i->width,
           i->height, i->format == RASTER_RGB565 ? "rgb565" : "rgb888", i->tile_width, i->tile_height);
    printf(" \"objects\": %u, \"materials\": %u, \"lights\": %u, \"triangles\": %u, \"arena_bytes\": %u,\n",
           i->object_count, i->material_count, i->light_count, i->triangle_count, i->arena_bytes);
    if (i->upload_slot != USB_NO_UPLOAD)
        printf(" \"upload\": {\"bytes\": %u, \"received\": %u, \"crc\": %u},\n", i->upload_length, i->upload_received,
               i->upload_crc);
    printf(" \"flash\": {\"bytes\": %u, \"block_bytes\": %u, \"scrubbed\": %u},\n", i->flash_bytes,
           i->flash_block_bytes, i->scrubbed);
    for (unsigned s = 0; s < i->slot_count; s++) {
        const struct usb_slot_info *slot = &i->slots[s];
        if (s == 0)
            printf(" \"scene\": {");
        else
            printf("%s{\"slot\": %u, ", s == 1 ? " \"tables\": [\n  " : ",\n  ", s - 1);
        printf("\"kind\": \"%s\", \"bytes\": %u, \"crc\": %u, \"bank_bytes\": %u, \"erases\": [%u, %u]}",
               kind_text(slot->kind), slot->bytes, slot->crc, slot->bank_bytes, slot->erases[0], slot->erases[1]);
        if (s == 0)
            printf(",\n");
    }
    printf("%s]}\n", i->slot_count > 1 ? "" : " \"tables\": [");
}

static void info_text(const struct usb_info *i, const char *version)
{
    printf("firmware   %s, protocol version %u, scene version %u\n", version, i->protocol_version, i->scene_version);
    printf("picture    %u x %u, %s, tiles of %u x %u\n", i->width, i->height,
           i->format == RASTER_RGB565 ? "RGB565" : "RGB888", i->tile_width, i->tile_height);
    printf("scene      %u objects, %u materials, %u lights, %u triangles\n", i->object_count, i->material_count,
           i->light_count, i->triangle_count);
    printf("memory     %u bytes for a frame\n", i->arena_bytes);
    if (i->upload_slot != USB_NO_UPLOAD)
        printf("upload     %u of %u bytes; push the same file to go on\n", i->upload_received, i->upload_length);
    printf("flash      %u bytes in blocks of %u%s\n", i->flash_bytes, i->flash_block_bytes,
           i->scrubbed ? "; a write cut off by a power failure was cleaned up" : "");
    printf("slot       content     bytes   CRC-32    bank bytes   erased\n");
    for (unsigned s = 0; s < i->slot_count; s++) {
        const struct usb_slot_info *slot = &i->slots[s];
        char name[16] = "scene";
        if (s)
            snprintf(name, sizeof name, "%u", s - 1);
        printf("%-10s %-7s %9u  %08x  %10u  %u + %u times\n", name, kind_text(slot->kind), slot->bytes, slot->crc,
               slot->bank_bytes, slot->erases[0], slot->erases[1]);
    }
}

void command_info(int argc, char **argv)
{
    static const struct argp_option options[] = {{"json", 'j', NULL, 0, "print JSON", 0}, {0}};
    static const struct argp argp = {options,
                                     parse_option,
                                     NULL,
                                     "Prints what the device is and what its slots hold."
                                     "\vExamples:\n"
                                     "  $ gtusb info\n"
                                     "  $ gtusb info --port 1-1 --json",
                                     device_options,
                                     NULL,
                                     NULL};
    struct report_args a = {false, false};
    struct usb_info info;
    char version[17];
    options_parse(&argp, argc, argv, &a);
    struct link *l = device_open(&info);
    device_close(l);
    version_text(version, info.firmware);
    if (a.json)
        info_json(&info, version);
    else
        info_text(&info, version);
}

static int compare_ticks(const void *a, const void *b)
{
    const struct usb_tile_stats *x = *(const struct usb_tile_stats *const *)a;
    const struct usb_tile_stats *y = *(const struct usb_tile_stats *const *)b;
    if (x->ticks != y->ticks)
        return x->ticks < y->ticks ? -1 : 1;
    return x < y ? -1 : x > y; /* row-major order among equals */
}

static const char *const rate_names[] = {"1x1", "2x1", "2x2", "4x2", "4x4", "flat"};

static const char *rate_text(unsigned rate)
{
    return rate < sizeof rate_names / sizeof *rate_names ? rate_names[rate] : "?";
}

/* Root mean square of the predicted error, 8-bit steps. */
static double rms_error(const struct usb_tile_stats *t)
{
    return t->covered ? sqrt(t->error / (3.0 * t->covered)) : 0;
}

static void tile_json(const struct usb_tile_stats *t)
{
    printf("\"triangles\": %u, \"tested\": %u, \"covered\": %u, \"shaded\": %u, \"fetches\": %u, \"ticks\": %u",
           t->triangles, t->tested, t->covered, t->shaded, t->fetches, t->ticks);
    if (t->budget)
        printf(", \"budget\": %u, \"predicted\": %u, \"coarsest\": \"%s\", \"rate\": %.3f, \"lights\": %u, \"error\": "
               "%.4f",
               t->budget, t->predicted, rate_text(t->coarsest), t->rate / 256.0, t->lights, rms_error(t));
    printf("}");
}

static void tile_text(const char *name, const struct usb_tile_stats *t)
{
    printf("%-14s %9u %9u %9u %9u %9u %11u", name, t->triangles, t->tested, t->covered, t->shaded, t->fetches,
           t->ticks);
    if (t->budget)
        printf(" %11u  %-4s %5.2f %6.2f", t->budget, rate_text(t->coarsest), t->rate / 256.0, rms_error(t));
    printf("\n");
}

struct stats_view {
    struct usb_stats head;
    struct usb_tile_stats *tiles; /* head.tile_count, or none */
    uint32_t count, slowest, median;
};

static void stats_json(const struct stats_view *v, bool tiles)
{
    printf("{\"frames\": %u, \"tile_count\": %u, \"ticks_are_modelled\": %s, \"begin_ticks\": %u, "
           "\"meshlets_visible\": %u, \"arena_used\": %u,\n",
           v->head.frames, v->head.tile_count, v->head.ticks_are_modelled ? "true" : "false", v->head.begin_ticks,
           v->head.meshlets_visible, v->head.arena_used);
    if (v->head.tile_budget)
        printf(" \"budget\": {\"tile\": %u, \"least\": %u, \"ticks\": %u, \"tiles_reduced\": %u, \"tiles_coarse\": %u, "
               "\"lod_bias\": %u},\n",
               v->head.tile_budget, v->head.least_tile_budget, v->head.budget_ticks, v->head.tiles_reduced,
               v->head.tiles_coarse, v->head.lod_bias);
    printf(" \"total\": {");
    tile_json(&v->head.total);
    if (v->count) {
        printf(",\n \"slowest\": {\"tile\": %u, ", v->slowest);
        tile_json(&v->tiles[v->slowest]);
        printf(",\n \"median\": {\"tile\": %u, ", v->median);
        tile_json(&v->tiles[v->median]);
    }
    for (uint32_t i = 0; tiles && i < v->count; i++) {
        printf("%s{", i ? ",\n  " : ",\n \"tiles\": [\n  ");
        tile_json(&v->tiles[i]);
    }
    printf("%s}\n", tiles && v->count ? "]" : "");
}

static void stats_text(const struct stats_view *v, bool tiles)
{
    char name[32];
    printf("frames %u, tiles %u, visible meshlets %u, memory used %u bytes, culling and binning %u ticks%s\n",
           v->head.frames, v->head.tile_count, v->head.meshlets_visible, v->head.arena_used, v->head.begin_ticks,
           v->head.ticks_are_modelled ? " (ticks are modelled)" : "");
    if (v->head.tile_budget)
        printf("budget %u ticks a tile, %u at least, %u tiles below full quality, deciding took %u ticks\n",
               v->head.tile_budget, v->head.least_tile_budget, v->head.tiles_reduced, v->head.budget_ticks);
    printf("%-14s %9s %9s %9s %9s %9s %11s%s\n", "tile", "triangles", "tested", "covered", "shaded", "fetches", "ticks",
           v->head.tile_budget ? "      budget  worst  rate  error" : "");
    tile_text("all", &v->head.total);
    if (v->count) {
        snprintf(name, sizeof name, "slowest %u", v->slowest);
        tile_text(name, &v->tiles[v->slowest]);
        snprintf(name, sizeof name, "median %u", v->median);
        tile_text(name, &v->tiles[v->median]);
    }
    for (uint32_t i = 0; tiles && i < v->count; i++) {
        snprintf(name, sizeof name, "%u", i);
        tile_text(name, &v->tiles[i]);
    }
}

/* Fills *v from the reply; slowest is the first of the dearest tiles, median the upper one. */
static void stats_read(struct stats_view *v, const struct reply *r)
{
    if (r->length < sizeof v->head || (r->length - sizeof v->head) % sizeof *v->tiles)
        die(EXIT_USB, "stats: %u bytes do not fit the protocol; update the firmware", r->length);
    memcpy(&v->head, r->payload, sizeof v->head);
    v->count = (uint32_t)((r->length - sizeof v->head) / sizeof *v->tiles);
    v->tiles = xmalloc(v->count * sizeof *v->tiles);
    memcpy(v->tiles, r->payload + sizeof v->head, v->count * sizeof *v->tiles);
    if (!v->count)
        return;
    const struct usb_tile_stats **sorted = xmalloc(v->count * sizeof *sorted);
    for (uint32_t i = 0; i < v->count; i++) {
        sorted[i] = &v->tiles[i];
        if (v->tiles[i].ticks > v->tiles[v->slowest].ticks)
            v->slowest = i;
    }
    qsort(sorted, v->count, sizeof *sorted, compare_ticks);
    v->median = (uint32_t)(sorted[v->count / 2] - v->tiles);
    free(sorted);
}

void command_stats(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"json", 'j', NULL, 0, "print JSON", 0}, {"tiles", 'a', NULL, 0, "print every tile, row by row", 0}, {0}};
    static const struct argp argp = {options,
                                     parse_option,
                                     NULL,
                                     "Prints what the last frame cost: all tiles, the slowest and the median one."
                                     "\vExamples:\n"
                                     "  $ gtusb stats\n"
                                     "  $ gtusb stats --tiles",
                                     device_options,
                                     NULL,
                                     NULL};
    struct report_args a = {false, false};
    struct usb_stats_request request = {1};
    struct stats_view v = {.count = 0};
    struct usb_info info;
    struct reply r;
    options_parse(&argp, argc, argv, &a);
    struct link *l = device_open(&info);
    link_request(l, &r, NULL, USB_MSG_STATS, &request, sizeof request);
    stats_read(&v, &r);
    device_close(l);
    if (a.json)
        stats_json(&v, a.tiles);
    else
        stats_text(&v, a.tiles);
    free(v.tiles);
}
