/*
 * Numbers of any size, for what spans world units to pixels: m 2^e with 32 bits of m.
 */
#ifndef RASTER_MAGNITUDE_H
#define RASTER_MAGNITUDE_H

#include "func.h"

struct magnitude { /* m >= 2^31 */
    uint32_t m;
    int32_t e;
};

static inline struct magnitude magnitude_of(uint64_t x) /* rounded down; of 0: of 1 */
{
    unsigned shift = 0;
    while (x >> 32 >> shift)
        shift++;
    uint32_t m = (uint32_t)(x >> shift) | (x == 0);
    unsigned lead = fx_clz(m);
    return (struct magnitude){m << lead, (int32_t)shift - (int32_t)lead};
}

/* Rounded down, by less than 2^-30 of it. */
static inline struct magnitude magnitude_mul(struct magnitude a, struct magnitude b)
{
    uint32_t m = fx_mulhi_u(a.m, b.m); /* >= 2^30 */
    unsigned lead = fx_clz(m);
    return (struct magnitude){m << lead, a.e + b.e + 32 - (int32_t)lead};
}

/* Within 2^-26. */
static inline struct magnitude magnitude_inverse(struct magnitude a)
{
    uint32_t m = fx_recip(a.m); /* 2^29 .. 2^30 for 2^61/m */
    unsigned lead = fx_clz(m);
    return (struct magnitude){m << lead, -61 - a.e - (int32_t)lead};
}

/* Within 2^-21. */
static inline struct magnitude magnitude_root(struct magnitude a)
{
    unsigned shift;
    const uint32_t odd = (uint32_t)a.e & 1, x = a.m >> odd; /* an even exponent */
    const uint32_t m = fx_mulhi_u(x, lut_rsqrt(x, &shift)); /* >= 2^28 */
    struct magnitude root = magnitude_of(m);
    root.e += (a.e + (int32_t)odd) / 2 + 2 - (int32_t)shift;
    return root;
}

/* Rounded up, with 2^-20 of it added for roundings on the way, saturated. */
static inline uint32_t magnitude_above(struct magnitude a)
{
    if (a.e > 0)
        return UINT32_MAX;
    const uint32_t x = a.e <= -32 ? 0 : a.m >> -a.e;
    return fx_add_sat_u(x, (x >> 20) + 1);
}

#endif
