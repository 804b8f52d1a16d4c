#include "host_composite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common.h"
#include "host_half_vector.h"
#include "host_image.h"
#include "host_rgb9e5.h"
#include "host_specular_frame.h"
#include "lut.h"

static enum measurement_mark source_value(double rgb[3], const void *ctx, double theta_in, double theta_out,
                                          double phi_out)
{
    const struct brdf_source *s = ctx;
    double l[3] = {sin(theta_in), 0, cos(theta_in)};
    double v[3] = {sin(theta_out) * cos(phi_out), sin(theta_out) * sin(phi_out), cos(theta_out)};
    s->value(rgb, s->ctx, l, v);
    return MEASURED;
}

bool composite_recognise(const uint8_t *data, size_t bytes)
{
    static const uint8_t exr[4] = {0x76, 0x2f, 0x31, 0x01};
    return bytes >= sizeof exr && !memcmp(data, exr, sizeof exr);
}

/* The slices out of the image, as texels. */
static uint32_t *texels_of(const float *pixels, size_t columns, const struct import_options *o, const char *path)
{
    size_t negative = 0;
    uint32_t *texels = xmalloc((size_t)o->width * o->height * o->depth * sizeof *texels), *t = texels;
    for (size_t z = 0; z < o->depth; z++)
        for (size_t y = 0; y < o->height; y++) {
            const float *p = pixels + 3 * ((z / columns * o->height + y) * columns * o->width + z % columns * o->width);
            for (size_t x = 0; x < o->width; x++, p += 3) {
                if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]))
                    die(EXIT_BAD_INPUT, "%s: node (%zu, %zu) of slice %zu is not finite; export the table again", path,
                        x, y, z);
                negative += p[0] < 0 || p[1] < 0 || p[2] < 0;
                *t++ = rgb9e5_encode((double[3]){(double)p[0], (double)p[1], (double)p[2]});
            }
        }
    if (negative)
        warn("%s: %zu nodes with negative values, set to 0", path, negative);
    return texels;
}

void composite_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
                    const struct import_options *o)
{
    (void)data;
    (void)bytes;
    if (!o->width)
        die(EXIT_USAGE, "%s: an image does not say its axes; give --axes WIDTHxHEIGHTxSLICES and --theta-max DEGREES",
            path);
    int w, h;
    float *pixels = image_read_rgb(&w, &h, path, true);
    size_t columns = (size_t)w / o->width, rows = (size_t)h / o->height;
    if (columns * o->width != (size_t)w || rows * o->height != (size_t)h || columns * rows < o->depth ||
        columns * rows - o->depth >= columns)
        die(EXIT_BAD_INPUT, "%s: %d x %d pixels do not hold %u slices of %u x %u in full rows; correct --axes", path, w,
            h, o->depth, o->width, o->height);
    uint32_t *texels = texels_of(pixels, columns, o, path);
    struct specular_frame_table table = {
        .texels = texels, .width = o->width, .height = o->height, .depth = o->depth, .theta_max = o->theta_max};
    struct brdf_source source;
    specular_frame_source(&source, &table, "composite");
    measurement_init(out, path);
    measurement_sample(out, o->geometry, source_value, &source, o->depth > 1 ? o->theta_max : 90);
    free(texels);
    free(pixels);
}

bool table_file_recognise(const uint8_t *data, size_t bytes)
{
    return bytes >= 6 && !memcmp(data, "\xabKTX 2", 6);
}

void table_file_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
                     const struct import_options *o)
{
    struct ktx2_view view;
    struct lut_table table;
    struct brdf_source source;
    enum lut_status status = ktx2_open(&view, data, bytes);
    if (status == LUT_OK)
        status = lut_open(&table, data, bytes);
    if (status != LUT_OK)
        die(EXIT_BAD_INPUT, "%s: %s; build the table again", path, lut_status_text(status));
    measurement_init(out, path);
    if (table.kind == LUT_HALF_VECTOR) {
        struct half_vector t;
        half_vector_read(&t, &view);
        half_vector_source(&source, &t, "table");
        measurement_sample(out, o->geometry, source_value, &source, 90);
        half_vector_free(&t);
    } else {
        struct specular_frame_table t;
        specular_frame_read(&t, &view);
        specular_frame_source(&source, &t, "table");
        measurement_sample(out, o->geometry, source_value, &source, t.depth > 1 ? t.theta_max : 90);
    }
}

bool fit_name_recognise(const char *path)
{
    const char *colon = strrchr(path, ':');
    return colon && colon - path > 4 && !memcmp(colon - 4, ".csv", 4) && access(path, F_OK);
}

void fit_name_load(struct measurement *out, const char *path, const struct import_options *o)
{
    struct brdf_source source;
    source_open(&source, path);
    measurement_init(out, source.name);
    measurement_sample(out, o->geometry, source_value, &source, 90);
    source_close(&source);
}
