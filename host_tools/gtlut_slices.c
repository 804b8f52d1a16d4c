#include "gtlut_slices.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_image.h"

static bool is_png(const char *path)
{
    const char *extension = strrchr(path, '.');
    return extension && !strcmp(extension, ".png");
}

void slices_need_image(const char *path)
{
    const char *extension = strrchr(path, '.');
    if (!is_png(path) && !(extension && !strcmp(extension, ".exr")))
        die(EXIT_USAGE, "-o: '%s' does not end in .exr or .png", path);
}

void slices_make(struct slices *out, uint32_t width, uint32_t height, uint32_t depth, bool image)
{
    *out = (struct slices){.width = width, .height = height, .depth = depth};
    out->columns = (uint32_t)fmin(ceil(sqrt(depth * (image ? (double)height / width : 1))), depth);
    out->rows = (depth + out->columns - 1) / out->columns;
    out->pixels = xcalloc((size_t)3 * width * out->columns * height * out->rows, sizeof *out->pixels);
}

void slices_free(struct slices *s)
{
    free(s->pixels);
}

void slices_put(struct slices *s, uint32_t x, uint32_t y, const struct lut_table *t, double factor)
{
    const size_t stride = (size_t)s->width * s->columns;
    const uint32_t *texel = t->texels;
    if (t->kind == LUT_HALF_VECTOR)
        factor = ldexp(factor, t->scale);
    for (uint32_t z = 0; z < t->depth; z++)
        for (size_t row = 0; row < t->height; row++) {
            float *p = s->pixels +
                       3 * (((size_t)(z / s->columns) * s->height + y + row) * stride + z % s->columns * s->width + x);
            for (uint32_t column = 0; column < t->width; column++) {
                struct lut_rgb c = lut_rgb9e5_decode(*texel++);
                for (int i = 0; i < 3; i++)
                    *p++ = (float)(factor * ldexp(c.c[i], c.e));
            }
        }
}

/* IEC 61966-2-1. */
static uint8_t srgb_byte(float linear)
{
    double x = fmin((double)linear, 1), y = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
    return (uint8_t)lround(255 * y);
}

void slices_write(const char *path, const struct slices *s)
{
    const int w = (int)(s->width * s->columns), h = (int)(s->height * s->rows);
    if (!is_png(path)) {
        image_write_float(path, w, h, 3, s->pixels);
        return;
    }
    size_t count = 3 * (size_t)w * (size_t)h;
    uint8_t *encoded = xmalloc(count);
    for (size_t i = 0; i < count; i++)
        encoded[i] = srgb_byte(s->pixels[i]);
    image_write_u8(path, w, h, 3, encoded);
    free(encoded);
}
