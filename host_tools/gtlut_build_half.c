/* gtlut build: the half-vector table. */
#include <math.h>
#include <stdlib.h>

#include "common.h"
#include "goniotile_version.h"
#include "gtlut_build.h"
#include "gtlut_table.h"
#include "rgb9e5.h"

static void symmetric_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    source_symmetric(rgb, ctx, l, v);
}

/* Fits the smallest of 1K, 2K, ... 256K whose mean colour difference is at most max_de, found by halving: larger tables are taken
 * to be truer. */
static void fit_within(struct half_vector *table, double *seconds, const struct build_input *in,
                       const struct brdf_source *truth, double max_de)
{
    enum { SIZES = 9 };
    unsigned low = 0, high = SIZES; /* the answer; SIZES: none */
    double smallest = INFINITY;
    *seconds = 0;
    while (low < high) {
        unsigned size = (low + high) / 2;
        struct half_vector_options options = {.texels = 256u << size};
        struct half_vector_report report;
        struct half_vector one;
        struct brdf_source source;
        struct metrics m;
        half_vector_build(&one, &report, &in->source, &options);
        *seconds += report.seconds;
        half_vector_source(&source, &one, "table");
        metrics_pictures(&m, &source, truth);
        smallest = fmin(smallest, m.de_mean);
        if (m.de_mean > max_de) {
            low = size + 1;
            half_vector_free(&one);
            continue;
        }
        if (high < SIZES)
            half_vector_free(table);
        high = size;
        *table = one;
    }
    if (high == SIZES)
        die(EXIT_WANTING, "--max-de: %g is not reached, the smallest mean dE is %.4g at 256K; allow more", max_de,
            smallest);
}

/* Says what the encoding does not survive. */
static void judge(const struct build_result *r, const struct half_vector *t, const char *path)
{
    size_t clipped = 0, count = (size_t)t->h * t->d * t->t;
    double largest = 0;
    for (size_t i = 0; i < count; i++) {
        struct lut_rgb texel = lut_rgb9e5_decode(t->texels[i]);
        uint32_t most = texel.c[0] > texel.c[1] ? texel.c[0] : texel.c[1];
        most = most > texel.c[2] ? most : texel.c[2];
        clipped += t->scale == HALF_VECTOR_MAX_SCALE && texel.e == 31 - 24 && most == 511;
        largest = fmax(largest, ldexp(most, texel.e + t->scale));
    }
    if (clipped)
        warn("%zu texels clipped at %g, times cosines in 1/sr; a table holds no more", clipped, largest);
    build_judge(r, clipped, largest, path);
}

static char *error_text(const struct metrics *m)
{
    return xasprintf("de=%.3g,de_p99=%.3g,psnr=%.3g,e_0_60=%.3g,e_60_75=%.3g,e_75_87=%.3g", m->de_mean, m->de_p99,
                     m->psnr, m->band[0], m->band[1], m->band[2]);
}

void build_half_vector(const struct build_input *in, const struct build_options *o)
{
    struct brdf_source truth = {.value = symmetric_value, .ctx = (void *)&in->source, .symmetric = true};
    struct brdf_source source;
    struct half_vector table;
    struct build_result r = {.kind = LUT_HALF_VECTOR};
    if (o->max_de > 0) {
        fit_within(&table, &r.seconds, in, &truth, o->max_de);
    } else {
        struct half_vector_report report;
        half_vector_build(&table, &report, &in->source, &o->half_vector);
        r.seconds = report.seconds;
    }
    half_vector_source(&source, &table, "table");
    metrics_compare(&r.metrics, &source, &truth);
    judge(&r, &table, o->input);
    r.nodes[0] = table.h;
    r.nodes[1] = table.d;
    r.nodes[2] = table.t;
    r.table_bytes = half_vector_bytes(&table);

    char *error = error_text(&r.metrics);
    const struct ktx2_pair pairs[] = {{"KTXwriter", "Goniotile gtlut " GONIOTILE_VERSION, 0},
                                      {"goniotile.error", error, 0},
                                      {"goniotile.source", in->source.name, 0}};
    uint8_t *file = half_vector_compose(&r.file_bytes, &table, pairs, sizeof pairs / sizeof *pairs, o->packed);
    if (o->packed) {
        struct ktx2_view view;
        uint32_t bytes = 0;
        if (ktx2_open(&view, file, r.file_bytes) != LUT_OK || !ktx2_find_bytes(&view, "goniotile.slabs", &bytes))
            die(EXIT_INTERNAL, "%s: the table just composed has no re-packed copy; leave --packed out", o->input);
        r.packed_bytes = bytes;
    }
    write_file(o->output, file, r.file_bytes);
    build_report(&r, &source, in, o->json);
    free(file);
    free(error);
    half_vector_free(&table);
}
