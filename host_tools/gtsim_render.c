/*
 * `render`: scene and tables into the simulated device, a frame out of it, without USB programs.
 *
 * One thread and the natural order of tiles: the firmware's own frame loop renders, as on a device. Otherwise the firmware begins the
 * frame and gtsim_tiles.c renders its tiles; the picture is the same.
 */
#define _GNU_SOURCE
#include "gtsim.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "gtsim_device.h"
#include "gtsim_heatmap.h"
#include "gtsim_tiles.h"
#include "host_canvas.h"
#include "host_image.h"
#include "host_model.h"

#define MAX_THREADS 64

struct render {
    struct sim_config board;
    struct device_content content;
    const char *output, *heatmap;
    bool stats, shuffled;
    unsigned threads;
    uint32_t seed;
};

static error_t parse_option(int key, char *arg, struct argp_state *state)
{
    struct render *r = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &r->content;
        state->child_inputs[1] = &r->board;
        return 0;
    case 'o':
        r->output = arg;
        return 0;
    case 'h':
        r->heatmap = arg;
        return 0;
    case 'S':
        r->stats = true;
        return 0;
    case 'j':
        r->threads = (unsigned)parse_long("--threads", arg, 1, MAX_THREADS);
        return 0;
    case 'r':
        r->seed = (uint32_t)parse_long("--shuffle", arg, 0, UINT32_MAX);
        r->shuffled = true;
        return 0;
    case ARGP_KEY_ARG:
        if (r->content.scene)
            argp_usage(state);
        r->content.scene = arg;
        return 0;
    case ARGP_KEY_END:
        if (!r->content.scene || !r->output)
            die(EXIT_USAGE, "a scene and -o FILE.png are needed; see 'gtsim render --help'");
        image_need(r->output, ".png");
        if (r->heatmap)
            image_need(r->heatmap, ".png");
        if (r->heatmap && !strcmp(r->heatmap, r->output))
            die(EXIT_USAGE, "-h: %s is the picture of -o; give another name", r->heatmap);
        if ((r->board.tile_budget || r->heatmap) && (r->threads > 1 || r->shuffled))
            die(EXIT_USAGE,
                "--budget and --heatmap are for one tile after the other; leave out --threads and --shuffle");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* Dies when the device refused the frame. */
static void check_frame(const struct sim_device *d, const struct render *r, uint32_t status, uint32_t detail)
{
    char *why = device_refusal(d, status, detail);
    if (why)
        die(EXIT_REFUSED, "%s: %s", r->content.scene, why);
}

static void print_stats(uint32_t tiles, uint32_t meshlets, uint32_t bytes, const struct raster_stats *s)
{
    printf("tiles %u, visible meshlets %u, memory used %u bytes\n", tiles, meshlets, bytes);
    printf("triangles %u, tested %u, covered %u, shaded %u, fetches %u", s->triangles, s->tested, s->covered, s->shaded,
           s->fetches);
}

static void frame_stream(struct sim_device *d, const struct render *r, uint8_t *pixels)
{
    struct usb_header h;
    if (!sim_device_frame(d, pixels, &h))
        die(EXIT_INTERNAL, "the simulated device does not answer");
    check_frame(d, r, h.status, h.detail);
}

/* The frame as the firmware renders it. */
static void frame_by_firmware(struct sim_device *d, const struct render *r, uint8_t *pixels)
{
    struct usb_stats_request want = {0};
    struct usb_header h;
    struct usb_stats s;
    frame_stream(d, r, pixels);
    if (!r->stats)
        return;
    if (!sim_device_request(d, USB_MSG_STATS, &want, sizeof want, &h, &s, sizeof s) || h.status != USB_OK)
        die(EXIT_INTERNAL, "the simulated device has no statistics");
    const struct raster_stats sum = {.triangles = s.total.triangles,
                                     .tested = s.total.tested,
                                     .covered = s.total.covered,
                                     .shaded = s.total.shaded,
                                     .fetches = s.total.fetches};
    print_stats(s.tile_count, s.meshlets_visible, s.arena_used, &sum);
    printf(", ticks %u\n", s.total.ticks);
}

/* The frame that the firmware begins, its tiles rendered by the pool. */
static void frame_by_pool(struct sim_device *d, const struct render *r, uint8_t *pixels)
{
    const struct raster *frame = &d->app.frame.raster;
    uint32_t *order = xmalloc(d->config.tile_stats_count * sizeof *order);
    struct raster_stats sum;
    enum raster_status status = app_frame_begin(&d->app, false);
    if (status == RASTER_ERR_TABLE)
        check_frame(d, r, USB_ERR_TABLE, frame->bad_material);
    if (status == RASTER_ERR_ARENA)
        check_frame(d, r, USB_ERR_MEMORY, (uint32_t)frame->arena_needed);
    if (status != RASTER_OK)
        check_frame(d, r, USB_ERR_RENDER, (uint32_t)status);
    tiles_order(order, raster_tile_count(frame), r->shuffled, r->seed);
    tiles_render(pixels, &sum, frame, order, r->threads);
    free(order);
    if (!r->stats)
        return;
    print_stats(raster_tile_count(frame), frame->visible_count, (uint32_t)frame->arena_needed, &sum);
    putchar('\n');
}

/* FNV-1a, 32 bits, of the picture in the device's format: what the emulated boards print. */
static uint32_t pixels_hash(const uint8_t *pixels, size_t bytes)
{
    uint32_t hash = 2166136261u;
    for (size_t i = 0; i < bytes; i++)
        hash = (hash ^ pixels[i]) * 16777619u;
    return hash;
}

static double seconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

int command_render(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"output", 'o', "FILE", 0, "the picture (PNG)", 0},
        {"stats", 'S', NULL, 0, "print what the frame cost, its hash and the time it took on this machine", 0},
        {"heatmap", 'h', "FILE", 0, "a picture of every tile's ticks, rate of shading and predicted error (PNG)", 0},
        {"threads", 'j', "N", 0, "render tiles on N threads, 1 to 64 (1); the picture is the same", 0},
        {"shuffle", 'r', "SEED", 0, "render tiles in a random order; the picture is the same", 0},
        {0}};
    static const struct argp_child children[] = {{&content_argp, 0, NULL, 0}, {&board_argp, 0, NULL, 0}, {0}};
    static const struct argp argp = {options,
                                     parse_option,
                                     "SCENE",
                                     "Renders a scene (from gtscene) into a picture, on the simulated device."
                                     "\vExamples:\n"
                                     "  $ gtsim render six_models.blob --model lafortune_phong -o quick.png --stats\n"
                                     "  $ gtsim render oled.blob --table 0=gold.ktx2 --samples 4 -o gold.png\n"
                                     "  $ gtsim render six_models.blob -m blinn_phong -b 800000 -o b.png -h heat.png",
                                     children,
                                     NULL,
                                     NULL};
    struct render r = {.board = board_default(), .content.model = MODEL_OF_SCENE, .threads = 1};
    r.board.arena_bytes = DEVICE_ARENA_BYTES;
    uint8_t descriptors[64];
    struct canvas canvas;
    options_parse(&argp, 0, argc, argv, NULL, &r);
    struct sim_device *d = sim_device_create(&r.board);
    if (!d || sim_device_enumerate(d, descriptors) < 0)
        die(EXIT_INTERNAL, "the simulated device does not start");
    device_load(d, &r.content);
    canvas_init(&canvas, r.board.width, r.board.height, r.board.format);
    size_t bytes = (size_t)canvas.missing * canvas_pixel_bytes(r.board.format);
    uint8_t *pixels = xmalloc(bytes);
    for (int i = 0; i < LEARNING_FRAMES && r.board.tile_budget; i++)
        frame_stream(d, &r, pixels);
    double start = seconds_now();
    if (r.threads > 1 || r.shuffled)
        frame_by_pool(d, &r, pixels);
    else
        frame_by_firmware(d, &r, pixels);
    canvas_put(&canvas, 0, 0, canvas.width, canvas.height, pixels);
    if (r.stats)
        printf("frame hash %08x, threads %u, %.1f ms\n", pixels_hash(pixels, bytes), r.threads,
               1e3 * (seconds_now() - start));
    if (r.heatmap)
        heatmap_write(r.heatmap, d, &canvas);
    image_write_u8(r.output, canvas.width, canvas.height, 3, canvas.rgb);
    free(pixels);
    canvas_free(&canvas);
    sim_device_destroy(d);
    return EXIT_OK;
}
