#define _GNU_SOURCE
#include "gtsim_window_frame.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "common.h"
#include "gtsim_device.h"
#include "host_image.h"

void frame_init(struct frame *f)
{
    const struct sim_config *board = sim_configuration(f->device->board);
    canvas_init(&f->canvas, board->width, board->height, board->format);
    f->tiles = xcalloc(f->device->config.tile_stats_count, sizeof *f->tiles);
}

void frame_free(struct frame *f)
{
    canvas_free(&f->canvas);
    free(f->refusal);
    free(f->tiles);
}

static double seconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static void picture_write(const struct canvas *c, char *path)
{
    image_write_u8(path, c->width, c->height, 3, c->rgb);
    free(path);
}

/* What the last frame cost. */
static void stats_fetch(struct frame *f)
{
    struct sim_device *d = f->device;
    struct usb_stats_request want = {1};
    struct usb_header h;
    struct {
        struct usb_stats head;
        struct usb_tile_stats tiles[];
    } * reply;
    size_t bytes = sizeof *reply + d->config.tile_stats_count * sizeof *reply->tiles;
    reply = xmalloc(bytes);
    if (!sim_device_request(d, USB_MSG_STATS, &want, sizeof want, &h, reply, bytes) || h.status != USB_OK)
        die(EXIT_INTERNAL, "the simulated device has no statistics");
    f->stats = reply->head;
    memcpy(f->tiles, reply->tiles, reply->head.tile_count * sizeof *f->tiles);
    free(reply);
}

void frame_fetch(struct frame *f)
{
    const struct sim_config *board = sim_configuration(f->device->board);
    struct canvas next;
    struct usb_header h;
    canvas_init(&next, board->width, board->height, board->format);
    size_t bytes = 3 * (size_t)next.width * next.height;
    uint8_t *pixels = xmalloc(bytes);
    double start = seconds_now();
    if (!sim_device_frame(f->device, pixels, &h))
        die(EXIT_INTERNAL, "the simulated device does not answer");
    char *refusal = device_refusal(f->device, h.status, h.detail);
    if (refusal && (!f->refusal || strcmp(refusal, f->refusal)))
        warn("%s", refusal);
    free(f->refusal);
    f->refusal = refusal;
    if (refusal) {
        canvas_free(&next);
    } else {
        f->seconds = seconds_now() - start;
        canvas_put(&next, 0, 0, next.width, next.height, pixels);
        bool same = f->recorded && !memcmp(next.rgb, f->canvas.rgb, bytes);
        canvas_free(&f->canvas);
        f->canvas = next;
        stats_fetch(f);
        if (f->record && !same)
            picture_write(&f->canvas, xasprintf("%s/frame-%06u.png", f->record, ++f->recorded));
    }
    free(pixels);
}

void frame_write(const struct frame *f, const char *folder)
{
    char *path = NULL;
    for (unsigned i = 1; !path || !access(path, F_OK); i++) {
        free(path);
        path = xasprintf("%s/gtsim-%04u.png", folder, i);
    }
    picture_write(&f->canvas, path);
}
