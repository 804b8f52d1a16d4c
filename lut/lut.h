/*
 * Measured-BRDF tables: open and evaluate, in integers, in place.
 *
 * A table file (SPEC.md, "Table file") is a KTX 2.0 container of RGB9_E5 texels with goniotile.* metadata.
 * lut_open validates the file and fills a small descriptor; lut_eval shades with it.
 *
 * Specular-frame table (Cezner and Havran 2024, eqs. 14-16): slices over theta_in = 0..theta_max in equal
 * steps; in a slice x is phi_d (0..360 degrees) and y is theta_d (0..180 degrees) of the view direction around
 * the mirror direction of l, nodes on whole steps with both ends included.
 */
#ifndef LUT_LUT_H
#define LUT_LUT_H

#include "ktx2.h"
#include "rgb9e5.h"

enum lut_kind { LUT_SPECULAR_FRAME = 1 };

struct lut_table {
    enum lut_kind kind;
    const uint32_t *texels;
    uint32_t width, height, depth; /* phi_d, theta_d, theta_in nodes; width, height >= 2, depth >= 1 */
    uint32_t slice_scale; /* slice coordinate, 12 fraction bits = angle * slice_scale >> 32, 180 degrees = 2^28 */
};

/* Opens a table. In: `file` of `bytes` bytes, 4-aligned, owned by the caller, must outlive *out. On error *out is
 * untouched. No texel is read. Metadata read: goniotile.version, goniotile.kind, goniotile.theta_max
 * (thousandths of a degree, 1..90000, slices at least 3 apart); see SPEC.md. */
enum lut_status lut_open(struct lut_table *out, const void *file, size_t bytes);

/*
 * f(l,v) * (n.l), in 1/sr. In: n, l, v unit vectors, any orientation. Accuracy is stated for components rounded
 * to the nearest q17_15_t (SPEC.md, "Table evaluation"); any components up to 32768 + 64 in magnitude are safe.
 * Out: *out with mantissas below 2^21 and shared exponent; all zero when n.l <= 0 or n.v <= 0.
 * Overflow and rounding: n.l is taken as at most 1; interpolation uses 12-bit fractions and eight weights that sum
 * to exactly 2^20, each shifted down to the largest exponent of the taps; the result is rounded to nearest. Equal
 * texels are reproduced exactly. Texels must be normalised (what encoders write): a large exponent with small
 * mantissas costs its neighbours precision.
 * l parallel to n: phi_d is arbitrary; the first slice of a well-made table is constant over phi.
 * theta_in beyond the last slice clamps. Returns the number of texels fetched (0 or 8).
 */
unsigned lut_eval(struct lut_rgb *out, const struct lut_table *t, struct vec3 n, struct vec3 l, struct vec3 v);

#endif
