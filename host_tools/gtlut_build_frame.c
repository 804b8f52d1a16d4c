/* gtlut build: the specular-frame table. */
#include <math.h>
#include <stdlib.h>

#include "common.h"
#include "goniotile_version.h"
#include "gtlut_build.h"
#include "host_ktx2.h"
#include "host_rgb9e5.h"

/* Encodes and says what the encoding does not survive. */
static uint32_t *encode(size_t *out_clipped, double *out_largest, const struct specular_frame *t)
{
    size_t count = (size_t)t->width * t->height * t->depth, clipped = 0;
    uint32_t *texels = xmalloc(count * sizeof *texels);
    double largest = 0;
    for (size_t i = 0; i < count; i++) {
        const double *rgb = t->rgb + 3 * i;
        double max = fmax(rgb[0], fmax(rgb[1], rgb[2]));
        clipped += max > RGB9E5_MAX;
        largest = fmax(largest, max);
        texels[i] = rgb9e5_encode(rgb);
    }
    if (clipped)
        warn("%zu texels above %g 1/sr clipped, the largest %g; RGB9_E5 holds no more", clipped, RGB9E5_MAX, largest);
    *out_clipped = clipped;
    *out_largest = fmin(largest, RGB9E5_MAX);
    return texels;
}

static char *extrapolation_text(const struct measurement_grid *g, const struct specular_frame_options *o)
{
    double lo = 90, hi = 0;
    for (size_t i = 0; i < g->count; i++) {
        double last = g->slices[i].theta_out[g->slices[i].theta_count - 1];
        lo = fmin(lo, last);
        hi = fmax(hi, last);
    }
    return lo < hi ? xasprintf("p=%g,l=%g,theta_b=%g..%g", o->p, o->l, lo, hi)
                   : xasprintf("p=%g,l=%g,theta_b=%g", o->p, o->l, hi);
}

static uint8_t *compose(size_t *bytes, const struct specular_frame *t, const uint32_t *texels, const char *source,
                        const char *extrapolation, bool swap)
{
    char *theta_max = xasprintf("%ld", lround(1e3 * t->theta_max));
    struct ktx2_pair pairs[7] = {{"KTXwriter", "Goniotile gtlut " GONIOTILE_VERSION, 0},
                                 {"goniotile.extrapolation", extrapolation, 0},
                                 {"goniotile.kind", "specular_frame", 0},
                                 {"goniotile.source", source, 0}};
    size_t count = 4;
    if (swap)
        pairs[count++] = (struct ktx2_pair){"goniotile.swap", "1", 0};
    pairs[count++] = (struct ktx2_pair){"goniotile.theta_max", theta_max, 0};
    pairs[count++] = (struct ktx2_pair){"goniotile.version", "1", 0};
    uint8_t *file = ktx2_compose(bytes, texels, t->width, t->height, t->depth, pairs, count);
    free(theta_max);
    return file;
}

void build_specular_frame(const struct build_input *in, const struct build_options *o)
{
    struct measurement_grid grid;
    struct specular_frame table;
    double start = build_seconds();
    measurement_grid_make(&grid, &in->measurement, o->input);
    char *extrapolation = extrapolation_text(&grid, &o->frame);
    specular_frame_build(&table, &grid, &o->frame, o->input);
    measurement_grid_free(&grid);
    size_t clipped;
    double largest;
    uint32_t *texels = encode(&clipped, &largest, &table);
    struct build_result r = {.kind = LUT_SPECULAR_FRAME,
                             .nodes = {table.width, table.height, table.depth},
                             .table_bytes = sizeof *texels * table.width * table.height * table.depth,
                             .seconds = build_seconds() - start};

    struct specular_frame_table encoded = {texels, table.width, table.height, table.depth, table.theta_max, o->swap};
    struct brdf_source source;
    specular_frame_source(&source, &encoded, "table");
    metrics_compare(&r.metrics, &source, &in->source);
    build_judge(&r, clipped, largest, o->input);
    uint8_t *file = compose(&r.file_bytes, &table, texels, in->measurement.source, extrapolation, o->swap);
    write_file(o->output, file, r.file_bytes);
    build_report(&r, &source, in, o->json);
    free(file);
    free(extrapolation);
    free(texels);
    specular_frame_free(&table);
}
