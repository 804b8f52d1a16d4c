/*
 * Image files for every host program, through OpenImageIO in goniotile_oiio.so, which is opened on first
 * use: from the executable's own folder, else from ../lib/goniotile beside it.
 *
 * Pixels are row-major, top row first, channels interleaved (1 grey, 3 RGB, 4 RGBA). Output is atomic: `path` is the old file or
 * the whole new one. Both die with EXIT_FILE, saying what to do, when the shared object is missing or the file cannot be written,
 * with EXIT_USAGE when `path` does not end as the format does.
 */
#ifndef HOST_TOOLS_HOST_IMAGE_H
#define HOST_TOOLS_HOST_IMAGE_H

#include <stdbool.h>
#include <stdint.h>

/* Dies with EXIT_USAGE unless the path ends in that extension (".png"). */
void image_need(const char *path, const char *extension);

/* sRGB-encoded bytes, PNG. */
void image_write_u8(const char *path, int width, int height, int channels, const uint8_t *pixels);

/* Linear light in 32-bit floats, EXR. */
void image_write_float(const char *path, int width, int height, int channels, const float *pixels);

/* Reads an image of at most 2^25 pixels as RGB, malloc'd; further channels are ignored, grey is repeated. Of integers 0..1 as they are
 * stored, unless `linear`, which is for light and refuses them. Dies with EXIT_FILE when the shared object or the file is missing, with
 * EXIT_BAD_INPUT when the file cannot be decoded. */
float *image_read_rgb(int *width, int *height, const char *path, bool linear);

#endif
