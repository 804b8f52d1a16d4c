/*
 * C interface of goniotile_oiio.so, the only part that links OpenImageIO. Opened on demand by host_image.c.
 */
#ifndef HOST_TOOLS_OIIO_SHIM_H
#define HOST_TOOLS_OIIO_SHIM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Write an image; the extension of `path` chooses the format. Pixels are row-major, top row first, channels
 * interleaved (1 grey, 3 RGB, 4 RGBA). Return 0, or -1 with a NUL-terminated message in err[err_bytes]. */
typedef int oiio_write_float_fn(const char *path, int width, int height, int channels, const float *pixels, char *err,
                                size_t err_bytes);
typedef int oiio_write_u8_fn(const char *path, int width, int height, int channels, const uint8_t *pixels, char *err,
                             size_t err_bytes);

oiio_write_float_fn oiio_write_image; /* linear light, stored as 32-bit float where the format can */
oiio_write_u8_fn oiio_write_image_u8; /* sRGB-encoded */

/* Read an image of at most max_pixels as RGB floats (grey is repeated), malloc'd into *rgb. Returns as above. */
typedef int oiio_read_fn(const char *path, size_t max_pixels, int *width, int *height, float **rgb, char *err,
                         size_t err_bytes);
oiio_read_fn oiio_read_image;

#ifdef __cplusplus
}
#endif

#endif
