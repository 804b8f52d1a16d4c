/*
 * The options of gtlut import that gtlut check and fit share: how a file becomes samples.
 */
#ifndef HOST_TOOLS_GTLUT_IMPORT_H
#define HOST_TOOLS_GTLUT_IMPORT_H

#include <getopt.h>

#include "host_import.h"

#define GTLUT_IMPORT_OPTIONS                                                                                           \
    {"geometry", required_argument, 0, 'g'}, {"illuminant", required_argument, 0, 'l'},                                \
        {"axes", required_argument, 0, 'x'}, {"theta-max", required_argument, 0, 't'},                                 \
    {                                                                                                                  \
        "help", no_argument, 0, 'h'                                                                                    \
    }

/* Takes the option `c` with optarg; false when it is none of these. Dies with EXIT_USAGE. */
bool gtlut_import_option(struct import_options *o, int c);

/* Resamples the measurement to options->geometry, and says so, when it does not form a grid; true when it did that. */
bool gtlut_import_grid(struct measurement *m, const struct import_options *o, const char *path);

#endif
