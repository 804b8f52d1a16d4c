#include "gtlut_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_atlas.h"

static const double degree = 3.14159265358979323846 / 180;

const double table_albedo_angles[TABLE_ALBEDO_ANGLES] = {0, 20, 40, 60, 75, 85};

bool table_recognise(const void *data, size_t bytes)
{
    return bytes >= 6 && !memcmp(data, "\xabKTX 2", 6);
}

void table_open(struct table_file *out, const char *path, void *data, size_t bytes)
{
    out->data = data;
    out->bytes = bytes;
    enum lut_status status = ktx2_open(&out->view, data, bytes);
    if (atlas_recognise(data, bytes))
        die(EXIT_BAD_INPUT, "%s: an atlas; gtlut atlas --extract takes a table out of it", path);
    if (status == LUT_OK)
        status = lut_open(&out->table, data, bytes);
    if (status != LUT_OK)
        die(EXIT_BAD_INPUT, "%s: %s; build the table again", path, lut_status_text(status));
    if (out->table.kind == LUT_HALF_VECTOR)
        half_vector_read(&out->half_vector, &out->view);
    else
        specular_frame_read(&out->specular_frame, &out->view);
}

void table_close(struct table_file *t)
{
    if (t->table.kind == LUT_HALF_VECTOR)
        half_vector_free(&t->half_vector);
    free(t->data);
}

void table_source(struct brdf_source *out, const struct table_file *t)
{
    if (t->table.kind == LUT_HALF_VECTOR)
        half_vector_source(out, &t->half_vector, "table");
    else
        specular_frame_source(out, &t->specular_frame, "table");
}

uint32_t table_packed_bytes(const struct table_file *t)
{
    uint32_t bytes;
    return ktx2_find_bytes(&t->view, "goniotile.slabs", &bytes) ? bytes : 0;
}

double table_theta_in(const struct specular_frame_table *t, uint32_t z)
{
    return t->depth > 1 ? t->theta_max * z / (t->depth - 1) : 0;
}

/* Where a warp reaches a coordinate, in steps of the warp. */
static double warp_position(const uint16_t *warp, unsigned count, uint32_t node)
{
    double want = (double)node * (1 << LUT_WARP_BITS);
    unsigned k = 0;
    while (k + 2 < count && warp[k + 1] < want)
        k++;
    return warp[k + 1] > warp[k] ? k + fmin(fmax((want - warp[k]) / (warp[k + 1] - warp[k]), 0), 1) : k;
}

double table_theta_h(const struct half_vector *t, uint32_t i)
{
    double at = warp_position(t->warp_h, LUT_WARP_H_NODES, i);
    unsigned k = (unsigned)floor(at);
    double x = ldexp(1 + (k % 8 + at - k) / 8, (int)(k / 8) - 16);
    return asin(sqrt(fmin(fmax(x - 0x1p-16, 0), 1))) / degree;
}

double table_theta_d(const struct half_vector *t, uint32_t j)
{
    /* y = (1 + sin - cos) / 2 = (1 + sqrt(2) sin(theta_d - 45 degrees)) / 2 */
    double y = warp_position(t->warp_d, LUT_WARP_D_NODES, j) / 64;
    double x = 45 + asin(fmin(fmax((2 * y - 1) / sqrt(2), -1), 1)) / degree;
    return fmax(round(x * 1e9) / 1e9, 0); /* 0 and 90 to the digit */
}
