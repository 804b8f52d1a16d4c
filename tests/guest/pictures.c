/*
 * In OpenImageIO's place (goniotile_oiio.so) beside the programs of this test: pictures as PPM. Loading its 260 libraries took the
 * emulated processor longer than all the rest, and has nothing to do with USB.
 */
#include <stdio.h>

#include "oiio_shim.h"

int oiio_write_image_u8(const char *path, int width, int height, int channels, const uint8_t *pixels, char *err,
                        size_t err_bytes)
{
    size_t bytes = (size_t)width * (size_t)height * 3;
    FILE *f = channels == 3 ? fopen(path, "wb") : NULL;
    if (f && fprintf(f, "P6 %d %d 255\n", width, height) > 0 && fwrite(pixels, 1, bytes, f) == bytes && !fclose(f))
        return 0;
    snprintf(err, err_bytes, "the PPM cannot be written");
    return -1;
}
