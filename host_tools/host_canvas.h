/*
 * A picture put together from tiles as a device delivers them, for gtusb and gtsim.
 */
#ifndef HOST_TOOLS_HOST_CANVAS_H
#define HOST_TOOLS_HOST_CANVAS_H

#include <stdbool.h>
#include <stdint.h>

struct canvas {
    uint16_t width, height;
    uint8_t format;   /* of the tiles: enum raster_format */
    uint8_t *rgb;     /* width * height * 3 */
    uint8_t *covered; /* per pixel: a tile has come */
    uint32_t missing; /* pixels without a tile yet */
};

/* Bytes of one pixel in a tile. */
unsigned canvas_pixel_bytes(uint8_t format);

/* Dies with EXIT_INTERNAL when memory is out. */
void canvas_init(struct canvas *c, uint16_t width, uint16_t height, uint8_t format);
void canvas_free(struct canvas *c);

/* Places a tile; RGB565 is widened by repeating the upper bits. False, and nothing placed, when it is not inside the picture or
 * overlaps an earlier one. */
bool canvas_put(struct canvas *c, unsigned x, unsigned y, unsigned width, unsigned height, const uint8_t *pixels);

#endif
