/*
 * A BRDF as a function of two directions, whatever file it comes from: what the half-vector table is fitted to and what errors
 * are measured against. Everything in double precision, in the tangent frame: z is the normal.
 */
#ifndef HOST_TOOLS_HOST_SOURCE_H
#define HOST_TOOLS_HOST_SOURCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_measurement.h"

struct brdf_source {
    char name[64]; /* printable ASCII, NUL-padded: what to put into goniotile.source */
    /* BRDF in 1/sr, >= 0 and finite, for unit vectors with positive z. Need not be reciprocal. */
    void (*value)(double rgb[3], const void *ctx, const double l[3], const double v[3]);
    void *ctx;
    void (*close)(void *ctx);   /* NULL when ctx is not owned */
    double theta_in, theta_out; /* degrees: beyond these the values are extrapolated; 90 when never */
    bool symmetric;             /* reciprocal, and the same when mirrored at the plane of l and n */
};

/*
 * Opens what stands at `path`, told apart by content:
 *   an RGL .bsdf file            evaluated as Dupuy and Jakob 2018 define it
 *   a measurement file or CSV    source_from_grid
 *   a table file of either kind  evaluated in double from its texels
 *   FILE.csv:NAME                one material of a table of shifted-gamma fits (Bagher et al. 2012, as merl_sgd.csv has them)
 * Dies with EXIT_FILE or EXIT_BAD_INPUT. Free with source_close.
 */
void source_open(struct brdf_source *out, const char *path);
void source_close(struct brdf_source *s);

/* A table file in memory, malloc'd and taken over; `path` is for messages and the name. Dies with EXIT_BAD_INPUT. */
void source_from_table(struct brdf_source *out, const char *path, uint8_t *data, size_t bytes);

/* A measurement on a grid, taken over (*grid is emptied), made reciprocal; the slice theta_in = 0 is averaged over phi_out first.
 * Bilinear in the outgoing angles. Between and beyond the measured theta_in:
 * - Either direction may be the one that the instrument called incident. Both readings are taken, weighted by their
 *   reliability: highest where that direction stands at a measured angle, low beyond the last.
 * - A pair is looked up in the slices next to it with its half vector held: lobes stay where they are.
 * - What rises above the material's base (of all values, the lowest hundredth in each channel) is taken to grow with
 *   (l.h)^-5/2, as Fresnel reflectance and masking make it grow; the base stays, but falls with the cube root of n.l + n.v
 *   where both directions are beyond the last slice.
 */
void source_from_grid(struct brdf_source *out, struct measurement_grid *grid, const char *name);

/* Names of the materials of a table of fits; returns their number. `names` is malloc'd as one block. Dies as source_open. */
size_t source_fit_names(char (**names)[64], const char *path);

/* (f(l,v) + f(v,l)) / 2, each also mirrored at the plane of l and n and averaged: what a half-vector table can hold. */
void source_symmetric(double rgb[3], const struct brdf_source *s, const double l[3], const double v[3]);

/* The same as a source; `s` stays the caller's. */
void source_make_symmetric(struct brdf_source *out, const struct brdf_source *s);

#endif
