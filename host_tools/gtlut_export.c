/* gtlut export: the texels of a table as one image. */
#include "gtlut.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "gtlut_table.h"
#include "host_image.h"

static const char help[] = "Usage: gtlut export TABLE -o out.exr|out.png [options]\n"
                           "\n"
                           "Writes all texels of a table into one image, slice by slice in row-major order.\n"
                           "\n"
                           "  specular frame   a slice per theta_in, phi_d to the right, theta_d downwards, as square "
                           "an arrangement as fits (4\n"
                           "                   slices: 2 x 2); the BRDF in 1/sr\n"
                           "  half vector      a slice per node of the difference angle, its azimuth to the right, the "
                           "half angle downwards, as\n"
                           "                   square an image as fits; the BRDF times (n.l + n.v) in 1/sr\n"
                           "\n"
                           "EXR holds the values as linear floats; PNG clamps them to 0..1 and encodes sRGB.\n"
                           "\n"
                           "  -o FILE       the image; its extension chooses the format\n"
                           "  --exposure F  factor on all values, 1e-6..1e6; default 1\n"
                           "\n"
                           "Examples:\n"
                           "  $ gtlut export gold.ktx2 -o gold.exr\n"
                           "  $ gtlut export gold.ktx2 -o gold.png --exposure 0.2\n";

#define MAX_FILE_BYTES (((size_t)4 << 24) + (1 << 20))

static float *composite(const struct lut_table *t, uint32_t columns, uint32_t rows, double exposure)
{
    size_t w = t->width, h = t->height, stride = w * columns;
    float *pixels = xcalloc(3 * stride * h * rows, sizeof *pixels);
    const uint32_t *texel = t->texels;
    for (uint32_t z = 0; z < t->depth; z++)
        for (size_t y = 0; y < h; y++) {
            float *p = pixels + 3 * ((z / columns * h + y) * stride + z % columns * w);
            for (size_t x = 0; x < w; x++) {
                struct lut_rgb c = lut_rgb9e5_decode(*texel++);
                for (int i = 0; i < 3; i++)
                    *p++ = (float)(exposure * ldexp(c.c[i], c.e));
            }
        }
    return pixels;
}

/* Columns of the arrangement. */
static uint32_t columns_of(const struct lut_table *t)
{
    double shape = t->kind == LUT_HALF_VECTOR ? (double)t->height / t->width : 1; /* slices are tall and narrow */
    return (uint32_t)fmin(ceil(sqrt(t->depth * shape)), t->depth);
}

/* IEC 61966-2-1. */
static uint8_t srgb_byte(float linear)
{
    double x = fmin((double)linear, 1), y = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
    return (uint8_t)lround(255 * y);
}

int gtlut_export(int argc, char **argv)
{
    static const struct option options[] = {
        {"exposure", required_argument, 0, 'e'}, {"help", no_argument, 0, 'h'}, {0}};
    const char *output = NULL;
    double exposure = 1;
    for (int c; (c = gtlut_option(argc, argv, options, help)) != -1;) {
        if (c == 'o')
            output = optarg;
        else
            exposure = parse_double("--exposure", optarg, 1e-6, 1e6);
    }
    const char *input = gtlut_argument(argc, argv, "table");
    gtlut_need_output(output);
    const char *extension = strrchr(output, '.');
    bool png = extension && !strcmp(extension, ".png");
    if (!png && !(extension && !strcmp(extension, ".exr")))
        die(EXIT_USAGE, "-o: '%s' does not end in .exr or .png", output);

    size_t bytes;
    void *data = read_file(input, MAX_FILE_BYTES, &bytes);
    struct table_file t;
    table_open(&t, input, data, bytes);
    uint32_t columns = columns_of(&t.table), rows = (t.table.depth + columns - 1) / columns;
    int w = (int)(t.table.width * columns), h = (int)(t.table.height * rows);
    if (t.table.kind == LUT_HALF_VECTOR)
        exposure = ldexp(exposure, t.table.scale);
    float *pixels = composite(&t.table, columns, rows, exposure);
    if (png) {
        size_t count = 3 * (size_t)w * (size_t)h;
        uint8_t *encoded = xmalloc(count);
        for (size_t i = 0; i < count; i++)
            encoded[i] = srgb_byte(pixels[i]);
        image_write_u8(output, w, h, 3, encoded);
        free(encoded);
    } else {
        image_write_float(output, w, h, 3, pixels);
    }
    free(pixels);
    table_close(&t);
    return EXIT_OK;
}
