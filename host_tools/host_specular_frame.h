/*
 * Builds the specular-frame table (Cezner and Havran 2024, eqs. 14-16) from a measurement, in double precision.
 *
 * The slice of theta_in holds, at node (x, y), the BRDF for the outgoing direction whose spherical angles around the mirror
 * direction of the light are phi_d = 360 x / (width-1), theta_d = 180 y / (height-1) degrees; phi_d = 0 points away from the
 * normal. Directions beyond the largest measured theta_out are extrapolated, see specular_frame_options.
 */
#ifndef HOST_TOOLS_HOST_SPECULAR_FRAME_H
#define HOST_TOOLS_HOST_SPECULAR_FRAME_H

#include <stddef.h>
#include <stdint.h>

#include "host_measurement.h"

struct specular_frame_options {
    uint32_t width, height; /* 2..4096 */
    double p;               /* 0..1: share of the last measured value that remains at the horizon; 1 clamps */
    double l;               /* 0..1: abscissa of the fade's Bezier control point (l, 1-l) */
};

struct specular_frame {
    uint32_t width, height, depth;
    double theta_max; /* theta_in of the last slice, degrees; 90 when there is only one, which then serves all angles */
    double *rgb;      /* [depth][height][width][3], 1/sr; owned */
};

/* The grid's first slice (theta_in = 0) is averaged over phi_out in place. Dies with EXIT_USAGE when the table would exceed what a
 * device reads (KTX2_MAX_EXTENT); `path` is for messages. */
void specular_frame_build(struct specular_frame *out, struct measurement_grid *grid,
                          const struct specular_frame_options *options, const char *path);
void specular_frame_free(struct specular_frame *t);

/* Directional-hemispherical reflectance of one slice of encoded texels for light at theta_in (degrees): the sum over 180 x 720
 * cells of the hemisphere whose weights add up to pi exactly, values bilinear between the table's nodes. */
void specular_frame_albedo(double rgb[3], const uint32_t *slice, uint32_t width, uint32_t height, double theta_in);

#endif
