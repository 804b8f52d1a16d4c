/*
 * Trilinear interpolation of RGB9_E5 texels by eight integer weights. Not for embedders.
 */
#ifndef LUT_INTERPOLATE_H
#define LUT_INTERPOLATE_H

#include "rgb9e5.h"

/* The cell of a coordinate: lower node, distance to the upper node (0 at the last node), weight of the upper node of 65536. */
struct lut_cell {
    uint32_t node, step, fraction;
};

/* In: coordinate with `bits` >= 12 fraction bits, of which 16 count; nodes >= 1, (nodes-1) << bits below 2^32. Beyond the last
 * node: clamped. */
static inline struct lut_cell lut_cell_find(uint32_t x, unsigned bits, uint32_t nodes)
{
    if (x >= (nodes - 1) << bits) {
        return (struct lut_cell){nodes - 1, 0, 0};
    }
    return (struct lut_cell){x >> bits, 1, (bits > 16 ? x >> (bits - 16) : x << (16 - bits)) & 65535};
}

/* Sums over the eight texels around (x, y, z) of an array of `width` x `height` x any; mantissas at most 511 * 2^20. The
 * eight weights sum to exactly 2^20, each is shifted down to the largest exponent. */
struct lut_rgb lut_interpolate(const uint32_t *texels, uint32_t width, uint32_t height, struct lut_cell x,
                               struct lut_cell y, struct lut_cell z);

#endif
