/*
 * The display's transfer curves, by table and interpolation, in integers. Inline: every shaded pixel takes each three times.
 *
 * Limits    total and monotone; the tables are constant data (func_tables.h, 0.9 KB).
 * Errors    measured in tests/unit/test_func.c.
 */
#ifndef LUT_DISPLAY_H
#define LUT_DISPLAY_H

#include "func_tables.h"

/* sRGB encode (IEC 61966-2-1) to 8 bits, rounded to nearest. In: linear, 1.0 = 2^20; values below 0 are black, above 1.0 white.
 * Out: 0..255; differs from the exact rounded value only where that lies within 0.002 of a tie. */
static inline uint32_t lut_srgb8(int32_t linear)
{
    const uint32_t x = fx_clamp_bits(linear, 20); /* white is 254.9999 */
    if (x <= 3280)                                /* 0.0031308, or two units less: one instruction on ARM */
        return (x * 843418u + (1u << 27)) >> 28;  /* 255 * 12.92 * 2^8; below 2^32 */
    const unsigned z = fx_clz(x);                 /* 12..20 */
    const uint32_t m = x << z, node = func_srgb_power[m >> 25 & 63],
                   p = node + (node & 4095) * (m >> 13 & 4095); /* 1.0 = 2^31, below 2^31.5 */
    /* 1.0 = 2^22: 255 * 0.055 less, and a half more */
    return (fx_mulhi_u(p, func_srgb_octave[z - 12]) - 56727962u) >> 22;
}

/* The rational tone curve of Hill's ACES fit, RRT+ODT: y = (v(v+a)-b)/(v(c v+d)+e), at least 0.
 * In: v with 1.0 = 2^20, below 2^31; from 32 on as at 32, where y is 1.0033 (the limit is 1.0165). Out: 1.0 = 2^30.
 * Error <= 1.4e-4 absolute below that.
 * a = 0.0245786, b = 0.000090537, c = 0.983729, d = 0.4329510, e = 0.238081 (Hill, BakingLab ACES.hlsl, 2016). */
static inline uint32_t lut_aces_curve(uint32_t v)
{
    /* The offset makes the steps uniform near zero, where the curve is a parabola. */
    const uint32_t x = fx_clamp_bits((int32_t)v, 25) + (1u << 16); /* [2^16, 2^25 + 2^16) */
    const unsigned z = fx_clz(x);                                  /* 6..15 */
    const uint32_t m = x << z;
    const uint32_t node = func_aces[224 + (int32_t)(m >> 27) - 16 * (int32_t)z];
    return node + (node & 4095) * (m >> 12 & 0x7fff); /* below 2^30.1 */
}

#endif
