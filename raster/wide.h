/*
 * Eight pixels at once, for models' variants on processors with AVX2. Vectors are the compilers' own (gcc and clang): only the
 * products and permutations that C has no operator for are built-in functions. Everything is in integers, so that
 * the bits are those of the portable files.
 *
 * A variant works in passes over a batch: lit pixels are packed into arrays (wide_gather), then vectors are computed for all
 * of them, with loops over single pixels between where tables are read. AVX2's gather instructions are no faster.
 */
#ifndef RASTER_WIDE_H
#define RASTER_WIDE_H

#include "block.h"

#ifdef RASTER_WIDE

typedef uint32_t wide __attribute__((vector_size(32)));
typedef int32_t wide_int __attribute__((vector_size(32)));
typedef uint64_t wide_long __attribute__((vector_size(32)));
typedef int16_t wide_short __attribute__((vector_size(32)));
typedef char wide_bytes __attribute__((vector_size(32)));
typedef uint32_t wide_half __attribute__((vector_size(16)));

#define WIDE_LANES  8
#define WIDE_GROUPS (RASTER_BATCH / WIDE_LANES) /* of a batch */

/* Lit pixels of a batch, in order. */
struct wide_pixels {
    wide normal_xy[WIDE_GROUPS + 1], normal_z[WIDE_GROUPS + 1], at[WIDE_GROUPS + 1]; /* as in the batch */
    wide nl[WIDE_GROUPS + 1], nv[WIDE_GROUPS + 1];                                   /* Q30 */
    uint8_t index[RASTER_BATCH + WIDE_LANES];                                        /* in the batch */
    uint32_t count;
};

/* Neighbouring texels of eight pixels, those of pixels 0, 1, 4, 5 in the first half. */
struct wide_couples {
    uint32_t texel[WIDE_LANES][2];
};

static inline uint32_t *wide_lanes(wide *row)
{
    return (uint32_t *)row;
}

static inline wide wide_all(uint32_t x)
{
    return (wide){x, x, x, x, x, x, x, x};
}

/* All ones where a < b, as signed numbers. */
static inline wide wide_below(wide a, wide b)
{
    return (wide)((wide_int)a < (wide_int)b);
}

static inline wide wide_select(wide mask, wide yes, wide no)
{
    return (yes & mask) | (no & ~mask);
}

/* Signed. */
static inline wide wide_min(wide a, wide b)
{
    return wide_select(wide_below(a, b), a, b);
}

static inline wide wide_max(wide a, wide b)
{
    return wide_select(wide_below(a, b), b, a);
}

static inline wide wide_shift_signed(wide a, int by)
{
    return (wide)((wide_int)a >> by);
}

/* Four bits for each lane that is not zero, of a vector of masks. */
static inline uint32_t wide_mask(wide a)
{
    return (uint32_t)__builtin_ia32_pmovmskb256((wide_bytes)a);
}

/* Sums of products of the lanes' signed 16-bit halves. */
static inline wide wide_dot16(wide a, wide b)
{
    return (wide)__builtin_ia32_pmaddwd256((wide_short)a, (wide_short)b);
}

static inline wide wide_high_words(wide_long even, wide_long odd)
{
    return __builtin_shufflevector((wide)(even >> 32), (wide)odd, 0, 9, 2, 11, 4, 13, 6, 15);
}

/* fx_mulhi_u */
static inline wide wide_mulhi(wide a, wide b)
{
    return wide_high_words(
        (wide_long)__builtin_ia32_pmuludq256((wide_int)a, (wide_int)b),
        (wide_long)__builtin_ia32_pmuludq256((wide_int)((wide_long)a >> 32), (wide_int)((wide_long)b >> 32)));
}

/* fx_mulhi */
static inline wide wide_mulhi_signed(wide a, wide b)
{
    return wide_high_words(
        (wide_long)__builtin_ia32_pmuldq256((wide_int)a, (wide_int)b),
        (wide_long)__builtin_ia32_pmuldq256((wide_int)((wide_long)a >> 32), (wide_int)((wide_long)b >> 32)));
}

/* Of eight numbers; index modulo 8. */
static inline wide wide_look_up(wide table, wide index)
{
    return (wide)__builtin_ia32_permvarsi256((wide_int)table, (wide_int)index);
}

static inline wide wide_plane(const struct raster_plane *p, wide x, wide y)
{
    return wide_all(p->base) + x * p->dx + y * p->dy;
}

static inline wide wide_load(const uint32_t *p)
{
    wide x;
    __builtin_memcpy(&x, p, sizeof x);
    return x;
}

static inline wide_half wide_load_half(const void *p)
{
    wide_half x;
    __builtin_memcpy(&x, p, sizeof x);
    return x;
}

static inline wide wide_load_halves(const void *low, const void *high)
{
    return __builtin_shufflevector(wide_load_half(low), wide_load_half(high), 0, 1, 2, 3, 4, 5, 6, 7);
}

static inline void wide_store_words(uint32_t *to, wide x)
{
    __builtin_memcpy(to, &x, sizeof x);
}

/* To lanes `at` .. `at` + 7. */
static inline void wide_store(wide *row, uint32_t at, wide x)
{
    wide_store_words(wide_lanes(row) + at, x);
}

/* The pixel that an array's lane belongs to, and those after it: whether they are neighbours in the batch. */
static inline bool wide_is_run(const struct wide_pixels *p, uint32_t first, uint32_t count)
{
    return first + count <= p->count && (uint32_t)(p->index[first + count - 1] - p->index[first]) == count - 1;
}

/* Packs the first `count` pixels of the batch that face the light. */
static inline void wide_gather(struct wide_pixels *o, const struct raster_batch *b, uint32_t count,
                               const struct raster_block_light *light)
{
    const wide l_xy = wide_all(light->l_xy), l_z = wide_all((uint32_t)light->l_z & 0xffff);
    uint32_t lit = 0;
    for (uint32_t i = 0; i < count; i += WIDE_LANES) {
        const struct raster_batch_pixel *p = &b->pixel[i];
        const wide p04 = wide_load_halves(p, p + 4), p15 = wide_load_halves(p + 1, p + 5),
                   p26 = wide_load_halves(p + 2, p + 6), p37 = wide_load_halves(p + 3, p + 7);
        const wide low0 = __builtin_shufflevector(p04, p15, 0, 8, 1, 9, 4, 12, 5, 13),
                   low1 = __builtin_shufflevector(p26, p37, 0, 8, 1, 9, 4, 12, 5, 13),
                   high0 = __builtin_shufflevector(p04, p15, 2, 10, 3, 11, 6, 14, 7, 15),
                   high1 = __builtin_shufflevector(p26, p37, 2, 10, 3, 11, 6, 14, 7, 15);
        const wide xy = __builtin_shufflevector(low0, low1, 0, 1, 8, 9, 4, 5, 12, 13),
                   z = __builtin_shufflevector(low0, low1, 2, 3, 10, 11, 6, 7, 14, 15);
        const wide nl = wide_dot16(xy, l_xy) + wide_dot16(z, l_z);
        wide_store(o->normal_xy, lit, xy);
        wide_store(o->normal_z, lit, z);
        wide_store(o->nv, lit, __builtin_shufflevector(high0, high1, 0, 1, 8, 9, 4, 5, 12, 13));
        wide_store(o->at, lit, __builtin_shufflevector(high0, high1, 2, 3, 10, 11, 6, 7, 14, 15));
        wide_store(o->nl, lit, nl);
        const uint64_t indices = 0x0706050403020100u + i * 0x0101010101010101u;
        __builtin_memcpy(o->index + lit, &indices, sizeof indices);
        uint32_t mask =
            wide_mask(wide_below(wide_all(0), nl) & wide_below((wide){0, 1, 2, 3, 4, 5, 6, 7}, wide_all(count - i)));
        if (mask == UINT32_MAX) {
            lit += WIDE_LANES;
            continue;
        }
        wide *const row[5] = {o->normal_xy, o->normal_z, o->at, o->nl, o->nv};
        for (uint32_t from = lit; mask; from++, mask >>= 4)
            if (mask & 1) {
                for (int k = 0; k < 5; k++)
                    wide_lanes(row[k])[lit] = wide_lanes(row[k])[from];
                o->index[lit++] = o->index[from];
            }
    }
    o->count = lit;
}

/* Gives lanes beyond the last pixel the value of the first, so that what is read from there exists. */
static inline void wide_pad(wide *row, uint32_t count)
{
    for (uint32_t i = count; i % WIDE_LANES; i++)
        wide_lanes(row)[i] = wide_lanes(row)[0];
}

/* 2^31/m, at most 4 too small: one of eight chords, and a Newton step. In: m 2^15 .. 2^16-1. */
static inline wide wide_reciprocal(wide m)
{
    const wide node = {65429, 58178, 52372, 47619, 43657, 40303, 37428, 34935},
               slope = {7282, 5825, 4766, 3972, 3361, 2881, 2497, 2185}, at = m >> 12;
    const wide r = wide_look_up(node, at) - ((m & 4095) * wide_look_up(slope, at) >> 12);
    return r * (65535 - (m * r >> 16)) >> 15;
}

/* Multiplies v, 2^(bit-15) or more and below 2^(bit+1), by the power of two that brings it to 2^bit, and x by the same; `by`, its exponent. */
struct wide_normal {
    wide v, x, by;
};
static inline struct wide_normal wide_normalise(wide v, wide x, unsigned bit)
{
    struct wide_normal o = {v, x, wide_all(0)};
    for (unsigned step = 8; step; step >>= 1) {
        const wide by = wide_below(o.v, wide_all(1u << (bit + 1 - step))) & step;
        o.v <<= by;
        o.x <<= by;
        o.by += by;
    }
    return o;
}

static inline void wide_add_words(uint32_t *at, wide x)
{
    wide_store_words(at, x + wide_load(at));
}

/* Adds to the radiance of pixels first .. first+7. */
static inline void wide_add_radiance(struct raster_batch *b, const struct wide_pixels *p, uint32_t first,
                                     const wide x[3])
{
    if (wide_is_run(p, first, WIDE_LANES)) {
        uint32_t *at = b->radiance[p->index[first]];
        const wide rg0 = __builtin_shufflevector(x[0], x[1], 0, 8, 0, 1, 9, 1, 2, 10),
                   rg1 = __builtin_shufflevector(x[0], x[1], 0, 3, 11, 0, 4, 12, 0, 5),
                   rg2 = __builtin_shufflevector(x[0], x[1], 13, 0, 6, 14, 0, 7, 15, 0);
        wide_add_words(at, __builtin_shufflevector(rg0, x[2], 0, 1, 8, 3, 4, 9, 6, 7));
        wide_add_words(at + 8, __builtin_shufflevector(rg1, x[2], 10, 1, 2, 11, 4, 5, 12, 7));
        wide_add_words(at + 16, __builtin_shufflevector(rg2, x[2], 0, 13, 2, 3, 14, 5, 6, 15));
        return;
    }
    uint32_t lane[3][WIDE_LANES];
    __builtin_memcpy(lane, x, sizeof lane);
    for (uint32_t j = 0; j < WIDE_LANES && first + j < p->count; j++)
        for (int k = 0; k < 3; k++)
            b->radiance[p->index[first + j]][k] += lane[k][j];
}

#endif
#endif
