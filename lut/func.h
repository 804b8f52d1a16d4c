/*
 * Elementary functions by table and interpolation, in integers.
 *
 * Purpose   what shading needs: roots, logarithms, angles.
 * Limits    every function is total on the stated range, and its largest error is stated; the tables are
 *           constant data (0.6 KB). lut_exp2_neg is monotone; the others are so
 *           but for steps back well below their error.
 * Errors    measured in tests/unit/test_func.c, which also recomputes every table entry in double precision.
 */
#ifndef LUT_FUNC_H
#define LUT_FUNC_H

#include "fixed.h"

/* 1/sqrt(x) as mantissa and exponent. In: x >= 1 (integer). Out: m in [2^30, 2^31], *shift in 1..16 such
 * that 1/sqrt(x) = m * 2^-(30 + *shift). Relative error <= 2^-22 (48 linear steps, then one Newton step). */
uint32_t lut_rsqrt(uint32_t x, unsigned *shift);

/* Base-2 logarithm. In: x >= 1, an integer. Out: log2(x) in units of 2^-25 (0..2^30).
 * Error <= 2^-22 absolute; exact at powers of two. */
uint32_t lut_log2(uint32_t x);

/* 2^-y for y >= 0 in units of 2^-25. Out: 1.0 = 2^30; 0 when y >= 31. Relative error <= 2^-18 while y < 12, then
 * one unit. Powers: x^n = lut_exp2_neg(n * (log2(1) - lut_log2(x))), with the product capped to 32 bits, is good to
 * 2^-12 relative for n <= 4096 where the result is above 2^-12. */
uint32_t lut_exp2_neg(uint32_t y);

/* Angle from the squared sine of its half: theta = 2 asin(sqrt(s2)), for theta in 0..90 degrees.
 * In: s2 with 1.0 = 2^30, 0 <= s2 <= 2^29 (values above are clamped). Out: angle with 180 degrees = 2^28.
 * s2 comes from |a-b|^2/4 of unit vectors a, b: no cancellation at small angles, unlike acos(a.b).
 * Error <= 5e-6 of the angle (0.0005 degrees at 90) plus one unit. */
uint32_t lut_angle_from_sin2_half(uint32_t s2);

/* Azimuth of (x, y): atan2(y, x) mapped to a full turn. In: any. Out: [0, 2^28), a full
 * turn = 2^28; (0,0) gives 0. Error <= 0.001 degrees; exact on the axes. */
uint32_t lut_turn(int32_t y, int32_t x);

#endif
