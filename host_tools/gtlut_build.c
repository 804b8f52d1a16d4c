/* gtlut build: measurement to table file. */
#include "gtlut.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "goniotile_version.h"
#include "host_ktx2.h"
#include "host_measurement.h"
#include "host_rgb9e5.h"
#include "host_specular_frame.h"
#include "ktx2.h"

static const char help[] =
    "usage: gtlut build FILE -o out.ktx2 [options]\n"
    "\n"
    "Resamples a measurement file (gtlut import) or CSV on a regular grid to a specular-frame table: KTX 2.0 with\n"
    "RGB9_E5 texels. Slices are the measured theta_in, which must start at 0 in equal steps; a single slice serves\n"
    "all angles.\n"
    "\n"
    "  -o FILE      the table, - for stdout\n"
    "  --size WxH   nodes over phi_d (0..360 degrees) and theta_d (0..180); default 361x181, each 2..4096\n"
    "  --p P        share of the last measured value left at the horizon, 0..1; default 1 (diffuse), less for glossy\n"
    "  --l L        shape of that fade, 0..1; default 0.3\n";

static void parse_size(struct specular_frame_options *o, const char *text)
{
    unsigned w, h;
    char tail;
    if (sscanf(text, "%4ux%4u%c", &w, &h, &tail) != 2 || w < 2 || h < 2 || w > KTX2_MAX_EXTENT || h > KTX2_MAX_EXTENT)
        die(EXIT_USAGE, "--size: '%s' is not WIDTHxHEIGHT with each from 2 to %u", text, KTX2_MAX_EXTENT);
    o->width = w;
    o->height = h;
}

/* Rounding to RGB9_E5 may raise every texel by up to 2^-9 of itself: that is not the measurement's doing. */
static const double albedo_limit = 1 + 1.0 / 512;

/* Encodes and says what the encoding or the measurement does not survive. */
static uint32_t *encode(const struct specular_frame *t)
{
    size_t slice = (size_t)t->width * t->height, clipped = 0;
    uint32_t *texels = xmalloc(slice * t->depth * sizeof *texels);
    double largest = 0;
    for (size_t i = 0; i < slice * t->depth; i++) {
        const double *rgb = t->rgb + 3 * i;
        double max = fmax(rgb[0], fmax(rgb[1], rgb[2]));
        clipped += max > RGB9E5_MAX;
        largest = fmax(largest, max);
        texels[i] = rgb9e5_encode(rgb);
    }
    if (clipped)
        warn("%zu texels above %g 1/sr clipped, the largest %g; RGB9_E5 holds no more", clipped, RGB9E5_MAX, largest);
    return texels;
}

static void report_energy(const struct specular_frame *t, const uint32_t *texels)
{
    for (uint32_t z = 0; z < t->depth; z++) {
        double theta_in = t->depth > 1 ? t->theta_max * z / (t->depth - 1) : 0, albedo[3];
        specular_frame_albedo(albedo, texels + (size_t)z * t->width * t->height, t->width, t->height, theta_in);
        if (fmax(albedo[0], fmax(albedo[1], albedo[2])) > albedo_limit)
            warn("theta_in %g: albedo %.3f %.3f %.3f is above 1: the table creates energy; was the lobe sampled too "
                 "coarsely, or is "
                 "--p too high?",
                 theta_in, albedo[0], albedo[1], albedo[2]);
    }
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

int gtlut_build(int argc, char **argv)
{
    static const struct option options[] = {{"size", required_argument, 0, 's'},
                                            {"p", required_argument, 0, 'p'},
                                            {"l", required_argument, 0, 'l'},
                                            {"help", no_argument, 0, 'h'},
                                            {0}};
    struct specular_frame_options o = {.width = 361, .height = 181, .p = 1, .l = 0.3};
    const char *output = NULL;
    for (int c; (c = gtlut_option(argc, argv, options, help)) != -1;) {
        if (c == 'o')
            output = optarg;
        else if (c == 's')
            parse_size(&o, optarg);
        else if (c == 'p')
            o.p = parse_double("--p", optarg, 0, 1);
        else
            o.l = parse_double("--l", optarg, 0, 1);
    }
    const char *input = gtlut_argument(argc, argv, "measurement");
    gtlut_need_output(output);

    struct measurement m;
    struct measurement_grid grid;
    struct specular_frame table;
    measurement_read(&m, input);
    measurement_grid_make(&grid, &m, input);
    specular_frame_build(&table, &grid, &o, input);
    uint32_t *texels = encode(&table);
    report_energy(&table, texels);

    char *extrapolation = extrapolation_text(&grid, &o);
    char *theta_max = xasprintf("%ld", lround(1e3 * table.theta_max));
    const struct ktx2_pair pairs[] = {{"KTXwriter", "Goniotile gtlut " GONIOTILE_VERSION, 0},
                                      {"goniotile.extrapolation", extrapolation, 0},
                                      {"goniotile.kind", "specular_frame", 0},
                                      {"goniotile.source", m.source, 0},
                                      {"goniotile.theta_max", theta_max, 0},
                                      {"goniotile.version", "1", 0}};
    size_t bytes;
    uint8_t *file =
        ktx2_compose(&bytes, texels, table.width, table.height, table.depth, pairs, sizeof pairs / sizeof *pairs);
    write_file(output, file, bytes);
    free(file);
    free(theta_max);
    free(extrapolation);
    free(texels);
    specular_frame_free(&table);
    measurement_grid_free(&grid);
    measurement_free(&m);
    return EXIT_OK;
}
