/* gtlut import: foreign measurement files to the measurement file. */
#include "gtlut.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_csv.h"
#include "host_measurement.h"
#include "host_rgl.h"

static const char help[] =
    "usage: gtlut import FILE -o out.gtm [options]\n"
    "\n"
    "Brings a measurement to the measurement file that gtlut build reads. The format is told from the content:\n"
    "\n"
    "  csv   a header line naming theta_in,theta_out,phi_out,R,G,B in any order; degrees and 1/sr; # comments\n"
    "  rgl   EPFL RGL material database, isotropic RGB .bsdf, evaluated at the directions of --geometry\n"
    "\n"
    "  -o FILE          the measurement file, - for stdout\n"
    "  --format NAME    csv or rgl: refuse a file of the other format\n"
    "  --geometry NAME  for rgl. minidiff: theta_in 0 20 40 60, theta_out 0..75 (default); dense: theta_in 0 5 .. 85,\n"
    "                   theta_out 0..88; both in steps of one degree over theta_out and phi_out 0..359\n";

#define MAX_FILE_BYTES ((size_t)1 << 30)

int gtlut_import(int argc, char **argv)
{
    static const struct option options[] = {{"format", required_argument, 0, 'f'},
                                            {"geometry", required_argument, 0, 'g'},
                                            {"help", no_argument, 0, 'h'},
                                            {0}};
    const struct measurement_geometry *g = NULL;
    const char *output = NULL, *format = NULL;
    for (int c; (c = gtlut_option(argc, argv, options, help)) != -1;) {
        if (c == 'o')
            output = optarg;
        else if (c == 'g')
            g = measurement_geometry_find(optarg);
        else
            format = optarg;
    }
    if (format && strcmp(format, "csv") && strcmp(format, "rgl"))
        die(EXIT_USAGE, "--format: '%s' is not csv or rgl", format);
    const char *input = gtlut_argument(argc, argv, "file");
    gtlut_need_output(output);

    size_t bytes;
    uint8_t *data = read_file(input, MAX_FILE_BYTES, &bytes);
    bool is_rgl = rgl_recognise(data, bytes);
    if (measurement_recognise(data, bytes))
        die(EXIT_BAD_INPUT, "%s: already a measurement file; give it to gtlut build", input);
    if (format && is_rgl != !strcmp(format, "rgl"))
        die(EXIT_BAD_INPUT, "%s: is %s, not %s; leave --format out", input, is_rgl ? "rgl" : "not an RGL file", format);
    if (g && !is_rgl)
        die(EXIT_USAGE, "--geometry: CSV keeps its own directions; leave the option out");

    struct measurement m;
    if (is_rgl) {
        struct rgl *r = rgl_open(input, data, bytes);
        rgl_sample(&m, r, input, g ? g : measurement_geometry_find("minidiff"));
        rgl_close(r);
    } else {
        csv_parse(&m, input, (char *)data, bytes);
    }
    struct measurement_grid
        grid; /* a cloud that no table can be built from is refused here, where its source is at hand */
    measurement_grid_make(&grid, &m, input);
    measurement_grid_free(&grid);
    measurement_write(&m, output);
    measurement_free(&m);
    free(data);
    return EXIT_OK;
}
