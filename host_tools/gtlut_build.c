/* gtlut build: from a reflectance to a table file. */
#include "gtlut.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "common.h"
#include "gtlut_build.h"
#include "gtlut_table.h"
#include "host_check.h"
#include "host_import.h"
#include "host_rgl.h"

static const char help[] =
    "Usage: gtlut build SOURCE -o out.ktx2 [options]\n"
    "\n"
    "Builds a table, KTX 2.0 with RGB9_E5 texels, and says on stderr how far it is from its source. SOURCE is told\n"
    "from the content:\n"
    "\n"
    "  measurement, CSV       a measurement file, to which gtlut import brings other formats\n"
    "  RGL .bsdf              evaluated as the database defines it, no import needed\n"
    "  table                  built anew: another kind or size\n"
    "  FITS.csv:NAME          one material of a table of shifted-gamma fits (merl_sgd.csv:gold-paint)\n"
    "\n"
    "  -o FILE          the table, - for stdout\n"
    "  --kind KIND      half_vector: small, exact to exchanging light and viewer, fitted to the source; recommended\n"
    "                   specular_frame: resampled at the measured theta_in, which must start at 0 in equal steps (a\n"
    "                   single one serves all angles); measurements only\n"
    "                   default: specular_frame for a measurement, half_vector for everything else\n"
    "  --json           the report on stdout, too\n"
    "\n"
    "Options of half_vector:\n"
    "  --size SIZE      1K to 256K: bytes of texels, shared out among the axes as the material needs it; or HxDxT:\n"
    "                   nodes over the half angle (2..128), the difference angle (2..128) and its azimuth (2..32), at\n"
    "                   most 65536 in all; default 64K\n"
    "  --max-de E       the smallest of 1K, 2K, 4K, ... 256K whose mean colour difference from the source is at most "
    "E\n"
    "                   (0.001..100, CIE 1976, on pictures of a sphere); exit code 11 when none is\n"
    "  --packed         adds the copy for SIMD, faster on cores that have it: 3.2 to 3.4 times the table's bytes for\n"
    "                   most, at most 6; the file becomes four times as long\n"
    "\n"
    "Options of specular_frame:\n"
    "  --size WxH       nodes over phi_d (0..360 degrees) and theta_d (0..180); default 361x181, each 2..4096\n"
    "  --p P            share of the last measured value left at the horizon, 0..1; default 1 (diffuse), less for "
    "glossy\n"
    "  --l L            shape of that fade, 0..1; default 0.3\n"
    "  --swap           look l and v up exchanged where v is nearer to the normal: better beyond the measured "
    "theta_in\n"
    "\n"
    "Examples:\n"
    "  $ gtlut build gold.csv -o gold.ktx2 --kind half_vector  # 64 KB\n"
    "  $ gtlut build gold.csv -o gold.ktx2 --kind half_vector --max-de 0.5  # as small as that error allows\n"
    "  $ gtlut build merl_sgd.csv:red-phenolic -o red.ktx2 --size 16K\n"
    "  $ gtlut build gold.csv -o gold.ktx2 --size 91x46 --swap  # specular frame, 67 KB\n";

#define MAX_FILE_BYTES ((size_t)1 << 30)

double build_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* --- options --- */

static void parse_frame_size(struct build_options *o, const char *text)
{
    unsigned w, h;
    char tail;
    if (sscanf(text, "%4ux%4u%c", &w, &h, &tail) != 2 || w < 2 || h < 2 || w > KTX2_MAX_EXTENT || h > KTX2_MAX_EXTENT)
        die(EXIT_USAGE, "--size: '%s' is not WIDTHxHEIGHT with each from 2 to %u", text, KTX2_MAX_EXTENT);
    o->frame.width = w;
    o->frame.height = h;
}

static void parse_half_vector_size(struct build_options *o, const char *text)
{
    unsigned a, b, c;
    char unit, tail;
    if (sscanf(text, "%3u%c%c", &a, &unit, &tail) == 2 && unit == 'K' && a >= 1 && a <= 256) {
        o->half_vector = (struct half_vector_options){.texels = 256 * a};
        return;
    }
    if (sscanf(text, "%3ux%3ux%3u%c", &a, &b, &c, &tail) != 3 || a < 2 || b < 2 || c < 2 || a > HALF_VECTOR_MAX_H ||
        b > HALF_VECTOR_MAX_D || c > HALF_VECTOR_MAX_T || a * b * c > HALF_VECTOR_MAX_TEXELS)
        die(EXIT_USAGE, "--size: '%s' is neither 1K to 256K nor HxDxT from 2x2x2 to %dx%dx%d with at most %d nodes",
            text, HALF_VECTOR_MAX_H, HALF_VECTOR_MAX_D, HALF_VECTOR_MAX_T, HALF_VECTOR_MAX_TEXELS);
    o->half_vector = (struct half_vector_options){a, b, c, 0};
}

static enum lut_kind parse_kind(const char *text)
{
    if (!strcmp(text, "half_vector"))
        return LUT_HALF_VECTOR;
    if (!strcmp(text, "specular_frame"))
        return LUT_SPECULAR_FRAME;
    die(EXIT_USAGE, "--kind: '%s' is not half_vector or specular_frame", text);
}

/* Options of one kind given together with the other: named, rather than ignored. */
static void check_kind(enum lut_kind kind, const char *half_vector_option, const char *frame_option)
{
    const char *misplaced = kind == LUT_HALF_VECTOR ? frame_option : half_vector_option;
    if (misplaced)
        die(EXIT_USAGE, "%s: only for %s, this is a %s table; leave it out or give --kind %s", misplaced,
            kind == LUT_HALF_VECTOR ? "specular_frame" : "half_vector",
            kind == LUT_HALF_VECTOR ? "half_vector" : "specular_frame",
            kind == LUT_HALF_VECTOR ? "specular_frame" : "half_vector");
}

/* --- input --- */

/* A path that is no file but becomes one when cut at its last colon. */
static bool names_a_fit(const char *path)
{
    const char *colon = strrchr(path, ':');
    if (!colon || !access(path, F_OK))
        return false;
    char *file = xstrdup(path);
    file[colon - path] = 0;
    bool is_file = !access(file, F_OK);
    free(file);
    return is_file;
}

/* A table can be built of it all the same. */
static void look_at_measurement(struct build_input *in, const char *path)
{
    struct check c;
    check_make(&c, &in->measurement, measurement_geometry_find("dense"));
    in->reciprocity = c.reciprocal_pairs ? c.reciprocity[0] : NAN;
    if (c.coverage_problem)
        warn("%s: %s", path, c.coverage_problem);
    if (c.quantity == CHECK_TIMES_COSINE || c.quantity == CHECK_OVER_COSINE)
        warn("%s: the values seem to be BRDF %s cos(theta_out); gtlut check --repair undoes that", path,
             c.quantity == CHECK_TIMES_COSINE ? "times" : "divided by");
    check_free(&c);
}

static void input_open(struct build_input *in, const char *path)
{
    memset(in, 0, sizeof *in);
    if (names_a_fit(path)) {
        source_open(&in->source, path);
        return;
    }
    size_t bytes;
    uint8_t *data = read_file(path, MAX_FILE_BYTES, &bytes);
    if (table_recognise(data, bytes)) {
        source_from_table(&in->source, path, data, bytes);
        return;
    }
    if (rgl_recognise(data, bytes)) {
        source_open(&in->source, path);
    } else {
        struct measurement_grid grid;
        const char *format = import_format_of(data, bytes)->name;
        if (strcmp(format, "gtm") && strcmp(format, "csv"))
            die(EXIT_BAD_INPUT, "%s: is %s; gtlut import it first", path, format);
        in->is_measurement = true;
        measurement_load(&in->measurement, path, data, bytes);
        measurement_grid_make(&grid, &in->measurement, path);
        look_at_measurement(in, path);
        source_from_grid(&in->source, &grid, in->measurement.source);
    }
    free(data);
}

static void input_close(struct build_input *in)
{
    source_close(&in->source);
    if (in->is_measurement)
        measurement_free(&in->measurement);
}

int gtlut_build(int argc, char **argv)
{
    static const struct option options[] = {{"kind", required_argument, 0, 'k'},   {"size", required_argument, 0, 's'},
                                            {"max-de", required_argument, 0, 'e'}, {"packed", no_argument, 0, 'c'},
                                            {"p", required_argument, 0, 'p'},      {"l", required_argument, 0, 'l'},
                                            {"swap", no_argument, 0, 'w'},         {"json", no_argument, 0, 'j'},
                                            {"help", no_argument, 0, 'h'},         {0}};
    struct build_options o = {.frame = {.width = 361, .height = 181, .p = 1, .l = 0.3},
                              .half_vector = {.texels = 16384}};
    const char *size = NULL, *frame_option = NULL, *half_vector_option = NULL;
    for (int c; (c = gtlut_option(argc, argv, options, help)) != -1;) {
        if (c == 'o')
            o.output = optarg;
        else if (c == 'k')
            o.kind = parse_kind(optarg);
        else if (c == 's')
            size = optarg;
        else if (c == 'e')
            o.max_de = parse_double(half_vector_option = "--max-de", optarg, 0.001, 100);
        else if (c == 'c')
            o.packed = (half_vector_option = "--packed");
        else if (c == 'p')
            o.frame.p = parse_double(frame_option = "--p", optarg, 0, 1);
        else if (c == 'l')
            o.frame.l = parse_double(frame_option = "--l", optarg, 0, 1);
        else if (c == 'w')
            o.swap = (frame_option = "--swap");
        else
            o.json = true;
    }
    o.input = gtlut_argument(argc, argv, "source");
    gtlut_need_output(o.output);
    if (o.json && !strcmp(o.output, "-"))
        die(EXIT_USAGE, "--json: stdout is taken by the table of -o -; give a file");
    if (size && o.max_de > 0)
        die(EXIT_USAGE, "--max-de: chooses the size itself; leave --size out");

    struct build_input in;
    input_open(&in, o.input);
    if (!o.kind)
        o.kind = in.is_measurement ? LUT_SPECULAR_FRAME : LUT_HALF_VECTOR;
    check_kind(o.kind, half_vector_option, frame_option);
    if (o.kind == LUT_SPECULAR_FRAME && !in.is_measurement)
        die(EXIT_BAD_INPUT,
            "%s: not a measurement, a specular_frame table needs one; gtlut import it first, or --kind half_vector",
            o.input);
    if (size && o.kind == LUT_HALF_VECTOR)
        parse_half_vector_size(&o, size);
    else if (size)
        parse_frame_size(&o, size);
    (o.kind == LUT_HALF_VECTOR ? build_half_vector : build_specular_frame)(&in, &o);
    input_close(&in);
    return EXIT_OK;
}
