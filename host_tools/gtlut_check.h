/*
 * The plot page of gtlut check.
 */
#ifndef HOST_TOOLS_GTLUT_CHECK_H
#define HOST_TOOLS_GTLUT_CHECK_H

#include "host_check.h"

/* Draws the page with gnuplot: the plane of incidence, albedo, reciprocity and the state of every sample. `path` ends in .svg, or is a
 * folder that gets check.svg. Dies with EXIT_FILE when gnuplot is missing or fails. */
void check_plot(const struct check *c, const char *title, const char *path);

#endif
