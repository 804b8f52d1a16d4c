/*
 * C interface of goniotile_oiio.so, the only part that links OpenImageIO. Opened on demand by host_image.c.
 */
#ifndef HOST_TOOLS_OIIO_SHIM_H
#define HOST_TOOLS_OIIO_SHIM_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* An image file in memory, malloc'd into *file. Pixels are row-major, top row first, channels interleaved (1 grey, 3 RGB, 4 RGBA).
 * Return 0, or -1 with a NUL-terminated message in err[err_bytes]. */
typedef int oiio_encode_fn(unsigned char **file, size_t *bytes, int width, int height, int channels, const void *pixels,
                           char *err, size_t err_bytes);

oiio_encode_fn oiio_encode_exr; /* floats, linear light */
oiio_encode_fn oiio_encode_png; /* bytes, sRGB-encoded */

/* Read an image of at most max_pixels as RGB floats (grey is repeated), malloc'd into *rgb. linear != 0: one of integers, which may
 * be encoded in any way, is refused. Returns as above. */
typedef int oiio_read_fn(const char *path, int linear, size_t max_pixels, int *width, int *height, float **rgb,
                         char *err, size_t err_bytes);
oiio_read_fn oiio_read_image;

#ifdef __cplusplus
}
#endif

#endif
