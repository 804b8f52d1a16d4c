/*
 * Builds the specular-frame table (Cezner and Havran 2024, eqs. 14-16) from a measurement, in double precision.
 *
 * The slice of theta_in holds, at node (x, y), the BRDF for the outgoing direction whose spherical angles around the mirror
 * direction of the light are phi_d = 360 x / (width-1), theta_d = 180 y / (height-1) degrees; phi_d = 0 points away from the
 * normal. Directions beyond the largest measured theta_out are extrapolated, see specular_frame_options.
 */
#ifndef HOST_TOOLS_HOST_SPECULAR_FRAME_H
#define HOST_TOOLS_HOST_SPECULAR_FRAME_H

#include <stdbool.h>
#include <stdint.h>

#include "host_source.h"
#include "ktx2.h"

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

/* Encoded texels and what places them. */
struct specular_frame_table {
    const uint32_t *texels; /* [depth][height][width] RGB9_E5; not owned */
    uint32_t width, height, depth;
    double theta_max; /* degrees */
    bool swap;        /* l and v are exchanged when n.l < n.v */
};

/* A table file that lut_open has accepted as LUT_SPECULAR_FRAME; the texels stay in the file. */
void specular_frame_read(struct specular_frame_table *out, const struct ktx2_view *file);

/* BRDF in 1/sr, trilinear between the texels, for unit vectors with positive z. */
void specular_frame_value(double rgb[3], const struct specular_frame_table *t, const double l[3], const double v[3]);

/* The same as a source; the table stays the caller's. */
void specular_frame_source(struct brdf_source *out, const struct specular_frame_table *t, const char *name);

#endif
