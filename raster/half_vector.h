/*
 * The half-vector table (lut.h) over a block: what its variants share. They give the same bits:
 *
 *   both = n.l + n.v                                               Q30, at most 2^31 + 2^19
 *   na2 = (n.a)^2, s2 = na2 + (n.b)^2                              Q28, each square rounded down
 *   y = s2 + 2^12, x = min(y, 2^28 - 1)                            Q28
 *   u = the h axis' warp at x, between nodes with 11 fraction bits  20 fraction bits: row h, then the fraction hf of 2^32
 *   ratio = n.l / both                                             Q15, below 2^15
 *   far = (2 ratio - 1)^2, which is (n.a)^2 |l-v|^2 / both^2        (2 ratio - 32767)^2 >> 20: at most 1023
 *   t2 = max(na2/(y >> 10), far), times T-1                        10 fraction bits: node t, then ft of 256; the quotient
 *                                                                  is at most 1023, too: na2 <= s2
 *   d from the term's plane                                        16 fraction bits: plane d, then fd of 64
 *   A = sum of row h's texels (t, d), (t+1, d), (t, d+1), (t+1, d+1) times (256-ft)(64-fd), ft (64-fd), (256-ft) fd, ft fd
 *   B = row h+1's                                                  15 bits by 2^14: below 2^29
 *   scale = ratio 2^16 2^-shift, scale1 = scale hf, scale0 = scale - scale1
 *   S = A scale0 + B scale1                                        each product's high word: below 2^28
 *   radiance += S colour                                           high word: below 2^27
 *
 * With four taps node t is the nearer of the two, t2 + 2^9 >> 10, and f = d's fraction of 2^14:
 *   A = row h's texels (t, d), (t, d+1) times 2^14 - f, f; B = row h+1's
 * With one it is so, and h and d go by their fractions' highest bits, the cell being the same:
 *   S = M scale/4                                                  >> 16: below 2^28
 *
 * A texel's 15 bits are M = (mantissa << 6) >> (E - e), E the largest exponent field of the h and d cell, which the table's file
 * lists, so that the re-packed copy ("slabs") gives the same bits.
 */
#ifndef RASTER_HALF_VECTOR_H
#define RASTER_HALF_VECTOR_H

#include "block.h"

/* Adds the light to pixels first .. end-1 of the batch and returns how many it reaches. In: n.v >= 2^-8 for each of them. */
typedef uint32_t raster_half_vector(struct raster_batch *b, uint32_t first, uint32_t end, const struct lut_table *table,
                                    const struct raster_block_light *light);
raster_half_vector raster_half_vector_plain;  /* any table; half_vector.c */
raster_half_vector raster_half_vector_packed; /* table->slabs != NULL */
raster_half_vector raster_half_vector_arm;    /* the same where RASTER_ARM; half_vector_arm.c */
raster_half_vector raster_half_vector_wide;   /* any table and taps, where RASTER_WIDE; half_vector_wide.c */
/* By the batch's fewer taps, as the first three. */
raster_half_vector raster_half_vector_fewer_plain;
raster_half_vector raster_half_vector_fewer_packed;
raster_half_vector raster_half_vector_fewer_arm;

/* The half-vector table by fewer taps than it has, as the batch says. */
struct raster_fewer_taps {
    raster_half_vector *shade;
};

/* What is used for tables with and without a re-packed copy. */
#ifdef RASTER_ARM
#define HALF_VECTOR_PACKED       raster_half_vector_arm
#define HALF_VECTOR_FEWER_PACKED raster_half_vector_fewer_arm
#elif defined(RASTER_WIDE)
#define HALF_VECTOR_PACKED       raster_half_vector_wide
#define HALF_VECTOR_FEWER_PACKED raster_half_vector_wide
#else
#define HALF_VECTOR_PACKED       raster_half_vector_packed
#define HALF_VECTOR_FEWER_PACKED raster_half_vector_fewer_packed
#endif
#ifdef RASTER_WIDE
#define HALF_VECTOR_PLAIN       raster_half_vector_wide
#define HALF_VECTOR_FEWER_PLAIN raster_half_vector_wide
#else
#define HALF_VECTOR_PLAIN       raster_half_vector_plain
#define HALF_VECTOR_FEWER_PLAIN raster_half_vector_fewer_plain
#endif

/* Rows that the loop for the re-packed copy takes: with DSP instructions the warp's coordinates are to be positive as 16-bit numbers. */
#if defined(RASTER_ARM) && !defined(__ARM_FEATURE_DSP)
#define HALF_VECTOR_LOOP_H LUT_MAX_H
#else
#define HALF_VECTOR_LOOP_H 64
#endif

/* One light and table: what does not change from pixel to pixel. */
struct half_vector_constants {
    uint32_t colour[3]; /* times 2^-up, Q31 */
    int32_t top;        /* cell exponent at which a term needs no shift, <= 31 */
};

/* A term is sum 2^(E - 24 - 6 - 14 + scale) * (ratio 2^-15) * (colour 2^(up - 31)) with 20 fraction bits, and is computed as
 * (sum * (ratio << 16 >> shift) >> 32) * colour >> 32, thus shift = 22 - scale - up - E. */
static inline struct half_vector_constants half_vector_constants_find(const struct lut_table *t,
                                                                      const uq16_16_t irradiance[3])
{
    struct half_vector_constants c;
    uint32_t largest = irradiance[0] | irradiance[1] | irradiance[2] | 1;
    unsigned lead = fx_clz(largest);
    c.top = 22 - t->scale - (16 - (int32_t)lead);
    unsigned dim = c.top > 31 ? (unsigned)c.top - 31 : 0; /* at most 38 - 31 + 16 */
    c.top -= (int32_t)dim;
    for (int k = 0; k < 3; k++)
        c.colour[k] = irradiance[k] << lead >> 1 >> dim;
    return c;
}

/* S colour >> 32, times 2^up, for a cell brighter than the scale's top, where the scale has not been shifted. */
static inline uint32_t half_vector_bright(uint32_t sum, uint32_t colour, uint32_t up)
{
    uint32_t x = fx_mulhi_u(sum, colour); /* < 2^27 */
    return up > 27 || x >> (27 - up) ? (x ? RASTER_LIGHT_LIMIT : 0) : x << up;
}

#endif
