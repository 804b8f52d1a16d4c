/*
 * In OpenImageIO's place (goniotile_oiio.so) beside the programs of this test: pictures as PPM, whatever they are called. Loading its 260 libraries took the
 * emulated processor longer than all the rest, and has nothing to do with USB.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "oiio_shim.h"

int oiio_encode_png(unsigned char **file, size_t *bytes, int width, int height, int channels, const void *pixels,
                    char *err, size_t err_bytes)
{
    char head[64];
    size_t pixel_bytes = (size_t)width * (size_t)height * 3;
    size_t head_bytes = (size_t)snprintf(head, sizeof head, "P6 %d %d 255\n", width, height);
    *file = channels == 3 ? malloc(head_bytes + pixel_bytes) : NULL;
    if (!*file) {
        snprintf(err, err_bytes, "no memory for a PPM");
        return -1;
    }
    *bytes = head_bytes + pixel_bytes;
    memcpy(*file, head, head_bytes);
    memcpy(*file + head_bytes, pixels, pixel_bytes);
    return 0;
}
