/*
 * RGB9_E5 encode (EXT_texture_shared_exponent); the layout is in lut/rgb9e5.h.
 */
#ifndef HOST_TOOLS_HOST_RGB9E5_H
#define HOST_TOOLS_HOST_RGB9E5_H

#include <stdint.h>

#define RGB9E5_MAX 65408.0

/* Nearest word; ties go up. NaN and negative channels become 0, channels above RGB9E5_MAX (infinity too)
 * become RGB9E5_MAX. Rounding is exact for every double. */
uint32_t rgb9e5_encode(const double rgb[3]);

#endif
