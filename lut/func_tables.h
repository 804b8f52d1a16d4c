/*
 * Node values of the elementary functions in func.h: private to lut/func.c, display.h and their test.
 *
 * Every entry is its formula rounded to the nearest integer; tests/unit/test_func.c recomputes all of them in
 * double precision. Tables with a guard node at each end have one entry before the first node and one after
 * the last, for the second difference that the interpolation takes.
 */
#ifndef LUT_FUNC_TABLES_H
#define LUT_FUNC_TABLES_H

#include "fixed.h"

/* [i] = 2^15 / sqrt(1 + i/16), 1..4 */
extern const uint16_t func_rsqrt[49];

/* [i] = 2^25 log2(1 + (i-1)/64), guarded */
extern const int32_t func_log2[67];

/* [i] = 2^30 2^(-(i-1)/16), guarded */
extern const int32_t func_exp2[19];

/* [i] = 2^31 g((i-1)/16), guarded, with a node more as 1/2 itself is in the range; g(u) = 2 asin(sqrt(u)) / (pi sqrt(u)), g(0) = 2/pi, for u < 0 its analytic
 * continuation 2 asinh(sqrt(-u)) / (pi sqrt(-u)) */
extern const int32_t func_angle[12];

/* [i] = 2^28 atan((i-1)/16) / 2pi, guarded */
extern const int32_t func_atan[19];

/* [i]: the nearest to 2^31 (1 + i/64)^(1/2.4) whose 12 low bits are 2^-12 of what it is to the next node */
extern const uint32_t func_srgb_power[64];

/* [i] = 2^23 * 255 * 1.055 * 2^(-(i+1)/2.4): the factor of the octave [2^-(i+1), 2^-i) */
extern const uint32_t func_srgb_octave[9];

/*
 * [16 o + s]: the curve of lut_aces_curve at x = 2^(o-4) (1 + s/16) - 2^-4, raised by half of what the chord to the next node errs in the
 * middle. The nearest to 2^30 of that whose 12 low bits are 2^-15 of the rise to the next node, an eighth less and rounded down: the next
 * node is never below the chord's end.
 */
extern const uint32_t func_aces[145];

#endif
