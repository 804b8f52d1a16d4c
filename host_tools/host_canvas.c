#include "host_canvas.h"

#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "raster.h"

unsigned canvas_pixel_bytes(uint8_t format)
{
    return format == RASTER_RGB565 ? 2 : 3;
}

void canvas_init(struct canvas *c, uint16_t width, uint16_t height, uint8_t format)
{
    c->width = width;
    c->height = height;
    c->format = format;
    c->missing = (uint32_t)width * height;
    c->rgb = xcalloc(c->missing, 3);
    c->covered = xcalloc(c->missing, 1);
}

void canvas_free(struct canvas *c)
{
    free(c->rgb);
    free(c->covered);
}

static void widen_565(uint8_t rgb[3], const uint8_t *two)
{
    unsigned v = two[0] | (unsigned)two[1] << 8, r = v >> 11, g = v >> 5 & 63, b = v & 31;
    rgb[0] = (uint8_t)(r << 3 | r >> 2);
    rgb[1] = (uint8_t)(g << 2 | g >> 4);
    rgb[2] = (uint8_t)(b << 3 | b >> 2);
}

bool canvas_put(struct canvas *c, unsigned x, unsigned y, unsigned width, unsigned height, const uint8_t *pixels)
{
    if (x + width > c->width || y + height > c->height)
        return false;
    for (unsigned row = y; row < y + height; row++)
        if (memchr(c->covered + (size_t)row * c->width + x, 1, width))
            return false;
    for (unsigned row = y; row < y + height; row++) {
        size_t first = (size_t)row * c->width + x;
        memset(c->covered + first, 1, width);
        for (size_t i = first; i < first + width; i++, pixels += canvas_pixel_bytes(c->format)) {
            if (c->format == RASTER_RGB565)
                widen_565(c->rgb + 3 * i, pixels);
            else
                memcpy(c->rgb + 3 * i, pixels, 3);
        }
    }
    c->missing -= width * height;
    return true;
}
