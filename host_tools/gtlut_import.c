/* gtlut import: foreign measurement files to the measurement file. */
#include "gtlut.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "gtlut_import.h"
#include "host_check.h"
#include "host_import.h"
#include "host_resample.h"

static const char help[] =
    "Usage: gtlut import FILE -o out.gtm [options]\n"
    "\n"
    "Brings a measurement to the measurement file that gtlut build reads. The format is told from the content; gtlut\n"
    "formats lists what is read. Samples on a regular grid are kept as they are. Irregular ones are resampled to\n"
    "--geometry, and so are formats that hold a function of any two directions. What lies beyond the measured angles "
    "is\n"
    "marked as extrapolated in the file.\n"
    "\n"
    "  -o FILE               the measurement file, - for stdout\n"
    "  --format NAME         refuse a file of another format\n"
    "  --geometry NAME       minidiff: theta_in 0 20 40 60, theta_out 0..75 (default); dense: theta_in 0 5 .. 85,\n"
    "                        theta_out 0..88; both in steps of one degree over theta_out and phi_out 0..359\n"
    "  --illuminant NAME     of spectral data: D65 (default), E or A\n"
    "  --axes WxHxN          of a composite image: N slices of W x H nodes (phi_d, theta_d)\n"
    "  --theta-max DEGREES   of a composite image: theta_in of the last slice, default 60\n"
    "  --fill-blind-spot     interpolate across the spot around the light that the instrument cannot see, and mark it\n"
    "\n"
    "Examples:\n"
    "  $ gtlut import gold.csv -o gold.gtm\n"
    "  $ gtlut import blue.bsdf --geometry dense --fill-blind-spot -o blue.gtm\n";

static void parse_axes(struct import_options *o, const char *text)
{
    char tail;
    if (sscanf(text, "%4ux%4ux%4u%c", &o->width, &o->height, &o->depth, &tail) != 3 || o->width < 2 || o->height < 2 ||
        !o->depth || o->width > 4096 || o->height > 4096 || (size_t)o->width * o->height * o->depth > (size_t)1 << 24)
        die(EXIT_USAGE, "--axes: '%s' is not WIDTHxHEIGHTxSLICES with 2 to 4096 nodes and at most 16777216 in all",
            text);
}

bool gtlut_import_option(struct import_options *o, int c)
{
    if (c == 'g')
        o->geometry = measurement_geometry_find(optarg);
    else if (c == 'l')
        o->illuminant = spectral_illuminant_find(optarg);
    else if (c == 'x')
        parse_axes(o, optarg);
    else if (c == 't')
        o->theta_max = parse_double("--theta-max", optarg, 0.1, 90);
    else
        return false;
    return true;
}

bool gtlut_import_grid(struct measurement *m, const struct import_options *o, const char *path)
{
    char *problem = measurement_grid_problem(m);
    free(problem);
    if (!problem)
        return false;
    struct measurement grid;
    measurement_resample(&grid, m, o->geometry);
    warn("%s: %zu samples at %zu angles of incidence resampled to the directions of %s", path, m->count,
         measurement_slice_count(m), o->geometry->name);
    measurement_free(m);
    *m = grid;
    return true;
}

int gtlut_import(int argc, char **argv)
{
    static const struct option options[] = {
        {"format", required_argument, 0, 'f'}, {"fill-blind-spot", no_argument, 0, 'b'}, GTLUT_IMPORT_OPTIONS, {0}};
    struct import_options o = {.theta_max = 60};
    const char *output = NULL, *format_name = NULL;
    bool fill = false;
    for (int c; (c = gtlut_option(argc, argv, options, help)) != -1;) {
        if (gtlut_import_option(&o, c))
            continue;
        if (c == 'o')
            output = optarg;
        else if (c == 'f')
            format_name = import_format_find(optarg)->name;
        else
            fill = true;
    }
    const char *input = gtlut_argument(argc, argv, "file");
    gtlut_need_output(output);
    bool geometry_given = o.geometry != NULL;
    o.geometry = geometry_given ? o.geometry : measurement_geometry_find("minidiff");

    struct measurement m;
    o.raw = fill;
    const struct import_format *format = import_read(&m, input, &o);
    if (!strcmp(format->name, "gtm") && !fill)
        die(EXIT_BAD_INPUT, "%s: already a measurement file; give it to gtlut build", input);
    if (format_name && strcmp(format_name, format->name))
        die(EXIT_BAD_INPUT, "%s: is %s, not %s; leave --format out", input, format->name, format_name);
    if (fill)
        check_fill_blind_spot(&m, input);
    if (!geometry_given && !strcmp(format->name, "csv")) { /* one's own export: rather say where its grid breaks */
        char *problem = measurement_grid_problem(&m);
        if (problem)
            die(EXIT_BAD_INPUT, "%s: %s, or give --geometry to resample", input, problem);
    } else if (!gtlut_import_grid(&m, &o, input) && geometry_given && !format->evaluated) {
        die(EXIT_USAGE, "--geometry: %s keeps its own directions, which form a grid; leave the option out",
            format->name);
    }
    measurement_write(&m, output);
    measurement_free(&m);
    return EXIT_OK;
}
