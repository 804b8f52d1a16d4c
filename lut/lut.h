/*
 * Measured-BRDF tables: open and evaluate, in integers, in place.
 *
 * A table file (SPEC.md, "Table file") is a KTX 2.0 container of RGB9_E5 texels with goniotile.* metadata.
 * lut_open validates the file and fills a small descriptor; lut_eval evaluates it for any three directions.
 *
 * Specular-frame table (Cezner and Havran 2024, eqs. 14-16): slices over theta_in = 0..theta_max in equal
 * steps; in a slice x is phi_d (0..360 degrees) and y is theta_d (0..180 degrees) of the view direction around
 * the mirror direction of l, nodes on whole steps with both ends included.
 *
 * Half-vector table: for isotropic materials, reciprocal by construction. With h = (l+v)/|l+v|, theta_d the angle
 * between l and h, a = (l-v)/|l-v| and b = (l x v)/|l x v|, its axes are
 *   h (y): sin^2 theta_h = (n.a)^2 + (n.b)^2, through a warp stored with the material;
 *   d (z): (1 + sin theta_d - cos theta_d)/2, through another;
 *   t (x): (n.a)^2 / sin^2 theta_h, or ((n.l-n.v)/(n.l+n.v))^2 where theta_h > 90 degrees - theta_d, where the azimuth
 *          that the former stands for cannot reach 0 above the horizon;
 * and it stores f (n.l + n.v), which stays finite where f does not.
 */
#ifndef LUT_LUT_H
#define LUT_LUT_H

#include "ktx2.h"
#include "rgb9e5.h"

enum lut_kind { LUT_SPECULAR_FRAME = 1, LUT_HALF_VECTOR = 2 };

#define LUT_WARP_H_NODES 129u /* at sin^2 theta_h + 2^-16 = 2^(k/8 - 16) (1 + (k%8)/8) */
#define LUT_WARP_D_NODES 65u  /* at k/64 */
#define LUT_WARP_BITS    9    /* fraction bits of a warp's node coordinates */
#define LUT_MAX_T        32u  /* nodes of the half-vector table's axes; at least 2, and at most 2^16 texels */
#define LUT_MAX_H        128u
#define LUT_MAX_D        128u

struct lut_table {
    enum lut_kind kind;
    const uint32_t *texels;
    uint32_t width, height,
        depth;            /* phi_d, theta_d, theta_in nodes: width, height >= 2, depth >= 1; or t, h, d nodes */
    uint32_t slice_scale; /* slice coordinate, 12 fraction bits = angle * slice_scale >> 32, 180 degrees = 2^28 */
    bool swap;            /* specular frame: theta_in is the smaller of both directions' angles */
    /* half-vector */
    int32_t scale;          /* texels are times 2^scale */
    const uint16_t *warp_h; /* LUT_WARP_H_NODES */
    const uint16_t *warp_d; /* LUT_WARP_D_NODES */
    const uint8_t *cells;   /* largest exponent field of a cell's texels over all t: [d][h], (depth-1) x (height-1) */
    uint32_t brightest;     /* the largest of these */
    const uint32_t
        *slabs; /* NULL, or the re-packed copy: records of all cells, then rows (SPEC.md, "Re-packed copy") */
};

/* Opens a table. In: `file` of `bytes` bytes, 4-aligned, owned by the caller, must outlive *out. On error *out is
 * untouched. No texel is read. Metadata: see SPEC.md. */
enum lut_status lut_open(struct lut_table *out, const void *file, size_t bytes);

/*
 * f(l,v), in 1/sr. In: n, l, v unit vectors, any orientation. Accuracy is stated for components rounded
 * to the nearest q17_15_t (SPEC.md, "Table evaluation"); any components up to 32768 + 64 in magnitude are safe.
 * Out: *out with mantissas below 2^21 and shared exponent; all zero when n.l <= 0 or n.v <= 0.
 * Overflow and rounding: interpolation uses fractions of 16 bits (specular frame: 12) and eight weights that sum to
 * exactly 2^20, each shifted down to the largest exponent of the taps; the result is rounded to nearest. Equal texels are
 * reproduced exactly.
 * Texels must be normalised (what encoders write): a large exponent with small mantissas costs its neighbours precision.
 * Specular frame: l parallel to n: phi_d is arbitrary; the first slice of a well-made table is constant over phi.
 * theta_in beyond the last slice clamps. Half-vector: exactly reciprocal; l = v: t is arbitrary, and so is all where l = -v.
 * Returns the number of texels that it stands for: 8, or 0 where n.l <= 0 or n.v <= 0.
 */
unsigned lut_eval(struct lut_rgb *out, const struct lut_table *t, struct vec3 n, struct vec3 l, struct vec3 v);

/* f from a specular-frame table at its own angles, 180 degrees = 2^28; phi_d below a full turn, 2^28. Accuracy as above. */
struct lut_rgb lut_specular_frame_at(const struct lut_table *t, uint32_t theta_in, uint32_t theta_d, uint32_t phi_d);

/* Coordinate on the half-vector table's d axis, LUT_D_BITS fraction bits, 0 .. depth-1. In: sine and cosine of theta_d,
 * 1.0 = 2^27 (within 2^-9 of a unit circle). Warps are followed exactly but for a truncation by 2^-24 of a cell. */
#define LUT_D_BITS 24
uint32_t lut_d_coordinate(const struct lut_table *t, uint32_t sine, uint32_t cosine);

#endif
