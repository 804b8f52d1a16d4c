/*
 * The half-vector table on the host: fitted to a BRDF in double precision, composed into a table file, and evaluated from its
 * texels as lut/half_vector.h does in integers. The table is defined in SPEC.md, "Half-vector table".
 */
#ifndef HOST_TOOLS_HOST_HALF_VECTOR_H
#define HOST_TOOLS_HOST_HALF_VECTOR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_ktx2.h"
#include "host_source.h"

enum {
    HALF_VECTOR_WARP_H = 129,
    HALF_VECTOR_WARP_D = 65,
    HALF_VECTOR_MAX_H = 128,
    HALF_VECTOR_MAX_D = 128,
    HALF_VECTOR_MAX_T = 32,
    HALF_VECTOR_MAX_SCALE = 16,
    HALF_VECTOR_MAX_TEXELS = 65536,
    HALF_VECTOR_MIN_TEXELS = 64 /* smallest budget when dimensions are chosen */
};

struct half_vector {
    uint32_t h, d, t;                                                /* nodes */
    int scale;                                                       /* texels times 2^scale are g */
    uint16_t warp_h[HALF_VECTOR_WARP_H], warp_d[HALF_VECTOR_WARP_D]; /* row coordinate x 512 */
    uint32_t *texels;                                                /* [d][h][t] RGB9_E5; owned */
};

struct half_vector_options {
    uint32_t h, d, t; /* nodes, 2 to the limits above; all 0: chosen by */
    uint32_t texels;  /* the budget, HALF_VECTOR_MIN_TEXELS..HALF_VECTOR_MAX_TEXELS, which is never exceeded */
};

struct half_vector_report {
    double seconds; /* wall clock, for printing only */
    double de;      /* the fit's own estimate of the mean colour difference, over lights at every angle to the view */
};

/* Fits a table to the symmetric part of the source. Deterministic, single thread. Values beyond what the texels hold
 * are what `scale` is for; beyond that they are clipped, or lost where they are too small or no floats: compare the table. */
void half_vector_build(struct half_vector *out, struct half_vector_report *report, const struct brdf_source *source,
                       const struct half_vector_options *options);
void half_vector_free(struct half_vector *t);

/* Texels and warps. */
size_t half_vector_bytes(const struct half_vector *t);

/* BRDF in 1/sr from the encoded texels, for unit vectors with positive z. */
void half_vector_value(double rgb[3], const struct half_vector *t, const double l[3], const double v[3]);

/* The same as a source; the table stays the caller's. */
void half_vector_source(struct brdf_source *out, const struct half_vector *t, const char *name);

/* Reads the texels, warps and scale of a table file that lut_open has accepted as LUT_HALF_VECTOR; a copy. */
struct ktx2_view;
void half_vector_read(struct half_vector *out, const struct ktx2_view *file);

/* The table file, malloc'd. `pairs`: further metadata (KTXwriter, goniotile.source, ...) in any order; the table's own keys are
 * added here: goniotile.cells, .kind, .scale, .version, .warpd, .warph and, if packed, .slabs. */
uint8_t *half_vector_compose(size_t *bytes, const struct half_vector *t, const struct ktx2_pair *pairs,
                             size_t pair_count, bool packed);

#endif
