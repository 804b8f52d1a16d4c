#include "gtsim_heatmap.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common.h"
#include "host_image.h"

enum { GAP = 6, SCALE = 8 };

void heatmap_colour(uint8_t rgb[3], double x)
{
    static const double stops[][3] = {{0, 0, 40}, {90, 20, 130}, {200, 55, 90}, {250, 150, 30}, {255, 255, 180}};
    x = (x < 0 ? 0 : x > 1 ? 1 : x) * 4;
    int i = x < 3 ? (int)x : 3;
    for (int k = 0; k < 3; k++)
        rgb[k] = (uint8_t)(stops[i][k] + (x - i) * (stops[i + 1][k] - stops[i][k]) + 0.5);
}

const char *heatmap_name(int panel)
{
    static const char *const names[HEATMAP_PANELS] = {"ticks", "rate of shading (5: flat)",
                                                      "predicted error, rms, 8-bit steps"};
    return names[panel];
}

double heatmap_value(const struct usb_tile_stats *t, int panel)
{
    switch (panel) {
    case HEATMAP_TICKS:
        return t->ticks;
    case HEATMAP_RATE:
        return t->rate / 256.0;
    default:
        return t->covered ? sqrt(t->error / (3.0 * t->covered)) : 0;
    }
}

double heatmap_most(const struct usb_tile_stats *tiles, uint32_t count, int panel)
{
    double most = 0;
    for (uint32_t i = 0; i < count; i++)
        most = fmax(most, heatmap_value(&tiles[i], panel));
    return panel == HEATMAP_RATE ? RASTER_RATE_FLAT : most > 0 ? most : 1;
}

struct heatmap {
    uint8_t *rgb;
    unsigned width, height; /* of all panels */
};

static void pixel_put(const struct heatmap *h, unsigned x, unsigned y, double value, double grey)
{
    uint8_t *p = h->rgb + ((size_t)y * h->width + x) * 3;
    heatmap_colour(p, value);
    for (int k = 0; k < 3; k++)
        p[k] = (uint8_t)(p[k] * 0.7 + grey * 0.3);
}

static void panel_draw(const struct heatmap *h, unsigned x0, const struct sim_device *d, const struct canvas *frame,
                       int panel, double most)
{
    const unsigned shift = d->config.samples == 4, tile_width = RASTER_TILE_WIDTH >> shift,
                   tile_height = RASTER_TILE_HEIGHT >> shift, columns = (frame->width + tile_width - 1) / tile_width;
    for (unsigned y = 0; y < frame->height; y++)
        for (unsigned x = 0; x < frame->width; x++) {
            const struct usb_tile_stats *t = &d->config.tile_stats[y / tile_height * columns + x / tile_width];
            const uint8_t *p = frame->rgb + ((size_t)y * frame->width + x) * 3;
            const bool edge = x % tile_width == 0 || y % tile_height == 0;
            pixel_put(h, x0 + x, y, heatmap_value(t, panel) / most, edge ? 0 : (p[0] + 2 * p[1] + p[2]) / 4.0);
        }
    for (unsigned y = frame->height + GAP; y < h->height; y++)
        for (unsigned x = 0; x < frame->width; x++)
            pixel_put(h, x0 + x, y, (double)x / frame->width, 255);
}

void heatmap_write(const char *path, const struct sim_device *d, const struct canvas *frame)
{
    struct heatmap h = {.width = HEATMAP_PANELS * frame->width + (HEATMAP_PANELS - 1) * GAP,
                        .height = frame->height + GAP + SCALE};
    h.rgb = xcalloc((size_t)h.width * h.height, 3);
    for (int panel = 0; panel < HEATMAP_PANELS; panel++) {
        double most = heatmap_most(d->config.tile_stats, d->app.stats.tile_count, panel);
        printf("heatmap %d: %s, bright is %.5g\n", panel + 1, heatmap_name(panel), most);
        panel_draw(&h, (unsigned)panel * (frame->width + GAP), d, frame, panel, most);
    }
    image_write_u8(path, (int)h.width, (int)h.height, 3, h.rgb);
    free(h.rgb);
}
