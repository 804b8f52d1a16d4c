/*
 * RGB9_E5 decode (EXT_texture_shared_exponent; Vulkan VK_FORMAT_E5B9G9R9_UFLOAT_PACK32).
 *
 * Bits: R 0-8, G 9-17, B 18-26, exponent 27-31; value = mantissa * 2^(e-24), no hidden bit, largest 65408.
 * Encoding belongs to the host tools.
 */
#ifndef LUT_RGB9E5_H
#define LUT_RGB9E5_H

#include "fixed.h"

/* Three non-negative numbers with one exponent: channel = c[i] * 2^e, R, G, B in this order. */
struct lut_rgb {
    uint32_t c[3];
    int32_t e;
};

/* Mantissas 0..511, e in -24..7. Exact for all 2^32 words. */
static inline struct lut_rgb lut_rgb9e5_decode(uint32_t w)
{
    struct lut_rgb t = {{w & 511, w >> 9 & 511, w >> 18 & 511}, (int32_t)(w >> 27) - 24};
    return t;
}

#endif
