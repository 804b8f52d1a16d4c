/*
 * The half-vector table over a block, eight pixels at once (wide.h): the bits of half_vector.c, by as many taps as the batch says. With
 * fewer, the same texels are read, some of them for a weight of 0.
 */
#if defined(__AVX2__)
#include "half_vector.h"
#include "wide.h"

struct half_vector_lanes {
    struct wide_pixels p;
    wide na2[WIDE_GROUPS], y[WIDE_GROUPS], term[WIDE_GROUPS]; /* as half_vector.h has them */
    wide ratio[WIDE_GROUPS], t2[WIDE_GROUPS], hf[WIDE_GROUPS];
    wide warp_at[WIDE_GROUPS], warp_fraction[WIDE_GROUPS]; /* 11 bits */
    wide warp[WIDE_GROUPS];                                /* the warp's two nodes */
    wide cell_at[WIDE_GROUPS], cell[WIDE_GROUPS];          /* indices; E or the record */
    wide texel_at[WIDE_GROUPS];                            /* word of (h, d, t) */
    wide low0[WIDE_GROUPS], low1[WIDE_GROUPS];             /* weights of nodes t and t+1 in plane d */
    wide high0[WIDE_GROUPS], high1[WIDE_GROUPS];           /* in plane d+1 */
    wide scale0[WIDE_GROUPS], scale1[WIDE_GROUPS];
};

static void wide_squares_find(struct half_vector_lanes *o, const struct raster_plane plane[PLANE_COUNT])
{
    for (uint32_t i = 0; WIDE_LANES * i < o->p.count; i++) {
        const wide x = o->p.at[i] & 255, y = o->p.at[i] >> 8, xy = o->p.normal_xy[i], z = o->p.normal_z[i];
        const wide ab_z = wide_plane(&plane[PLANE_AB_Z], x, y);
        const wide na = wide_dot16(xy, wide_plane(&plane[PLANE_A_XY], x, y)) + wide_dot16(z & 0xffff, ab_z);
        const wide nb = wide_dot16(xy, wide_plane(&plane[PLANE_B_XY], x, y)) + wide_dot16(z << 16, ab_z);
        o->na2[i] = wide_mulhi_signed(na, na);
        o->y[i] = o->na2[i] + wide_mulhi_signed(nb, nb) + (1u << 12);
        o->term[i] = wide_plane(&plane[PLANE_TERM], x, y);
    }
}

/* Where the warp is read, and na2/(y >> 10): its approximation is off by at most one either way. In: y < 2^29. */
static void near_find(struct half_vector_lanes *o)
{
    for (uint32_t i = 0; WIDE_LANES * i < o->p.count; i++) {
        const wide na2 = o->na2[i], y = o->y[i], den = y >> 10, half = y >> 28;
        const struct wide_normal n = wide_normalise(wide_min(y, wide_all((1u << 28) - 1)), na2, 27);
        o->warp_at[i] = 8 * (14 - n.by) + (n.v >> 24);
        o->warp_fraction[i] = n.v >> 13 & 0x7ff;
        const wide inverse = wide_reciprocal((y & ~1023u) << n.by >> 12 >> half);
        const wide q = (n.x >> 12 >> half) * inverse >> 21, rest = na2 - q * den;
        o->t2[i] = q + wide_below(rest, wide_all(0)) + wide_below(rest, den) + 1;
    }
}

/* n.l / ((n.l + n.v) >> 15): the approximation is at most 3 too small. Then t2. */
static void ratio_find(struct half_vector_lanes *o)
{
    for (uint32_t i = 0; WIDE_LANES * i < o->p.count; i++) {
        const wide nl = o->p.nl[i], den = (nl + o->p.nv[i]) >> 15; /* 2^7 .. 2^16 + 2^4 */
        const struct wide_normal n = wide_normalise(den << 14, nl >> 1, 30);
        wide q = (n.x >> 15) * wide_reciprocal(n.v >> 15) >> 16, rest = nl - q * den;
        for (int k = 0; k < 3; k++) {
            const wide more = ~wide_below(rest, den);
            q -= more;
            rest -= more & den;
        }
        o->ratio[i] = q;
        const wide tilt = 2 * q - 32767;
        o->t2[i] = wide_max(o->t2[i], tilt * tilt >> 20);
    }
}

/* Cells, and weights of texels. `step`: words from a texel to the next in t, h and d. */
static void cell_find(struct half_vector_lanes *o, const struct lut_table *t, const uint32_t step[3])
{
    for (uint32_t i = 0; WIDE_LANES * i < o->p.count; i++) {
        const wide w0 = o->warp[i] & 0xffff, w1 = o->warp[i] >> 16, u = (w0 << 11) + (w1 - w0) * o->warp_fraction[i];
        const wide h = u >> 20, d = o->term[i] >> TERM_D_BITS, t2 = o->t2[i] * (t->width - 1);
        o->hf[i] = u << 12;
        o->cell_at[i] = d * (t->height - 1) + h;
        o->texel_at[i] = (t2 >> 10) * step[0] + h * step[1] + d * step[2];
        const wide ft = t2 >> 2 & 255, fd = o->term[i] >> (TERM_D_BITS - 6) & 63, high1 = ft * fd;
        o->high1[i] = high1;
        o->high0[i] = 256 * fd - high1;
        o->low1[i] = 64 * ft - high1;
        o->low0[i] = (1u << 14) - 64 * ft - (256 * fd - high1);
    }
}

/* Leaves the weight of node t to the nearer of the two and, with one tap, that of d and hf likewise: hf as a mask. */
static void nearest_find(struct half_vector_lanes *o, const struct lut_table *t, enum raster_taps taps)
{
    for (uint32_t i = 0; WIDE_LANES * i < o->p.count; i++) {
        const wide t1 = wide_below(wide_all((1u << 9) - 1), o->t2[i] * (t->width - 1) & 1023);
        wide high = o->term[i] >> (TERM_D_BITS - 14) & 0x3fff;
        if (taps == RASTER_TAPS_1) {
            high = high >> 13 << 14;
            o->hf[i] = wide_shift_signed(o->hf[i], 31);
        }
        o->high1[i] = high & t1;
        o->high0[i] = high & ~t1;
        o->low1[i] = ((1u << 14) - high) & t1;
        o->low0[i] = ((1u << 14) - high) & ~t1;
    }
}

/* What sums are multiplied by. Returns the shifts. With one tap a sum is M << 14, and scale/4 a whole number. */
static inline wide scale_find(struct half_vector_lanes *o, uint32_t i, wide exponent,
                              const struct half_vector_constants *c, enum raster_taps taps)
{
    const wide shift = (uint32_t)c->top - exponent, scale = o->ratio[i] << 16 >> (shift & 31);
    o->scale1[i] = taps == RASTER_TAPS_1 ? scale & ~3u & o->hf[i] : wide_mulhi(scale, o->hf[i]);
    o->scale0[i] = (taps == RASTER_TAPS_1 ? scale & ~3u : scale) - o->scale1[i];
    return shift;
}

/* Returns whether no cell's shift is negative; false: o is spoilt. */
static bool plain_fetch(struct wide_couples row[4][WIDE_GROUPS], struct half_vector_lanes *o, const struct lut_table *t,
                        int32_t top)
{
    static const uint8_t place[WIDE_LANES] = {0, 1, 4, 5, 2, 3, 6, 7};
    const uint32_t width = t->width, plane = width * t->height;
    const uint32_t *const at = wide_lanes(o->texel_at), *const cell_at = wide_lanes(o->cell_at);
    uint32_t *const cell = wide_lanes(o->cell);
    int32_t shifts = 0;
    wide_pad(o->texel_at, o->p.count);
    wide_pad(o->cell_at, o->p.count);
    for (uint32_t i = 0; i < o->p.count; i += WIDE_LANES)
#pragma GCC unroll 8
        for (uint32_t j = 0; j < WIDE_LANES; j++) {
            const uint32_t *p = t->texels + at[i + j];
            __builtin_memcpy(row[0][i / WIDE_LANES].texel[place[j]], p, 8);
            __builtin_memcpy(row[1][i / WIDE_LANES].texel[place[j]], p + plane, 8);
            __builtin_memcpy(row[2][i / WIDE_LANES].texel[place[j]], p + width, 8);
            __builtin_memcpy(row[3][i / WIDE_LANES].texel[place[j]], p + width + plane, 8);
            cell[i + j] = t->cells[cell_at[i + j]];
            shifts |= top - (int32_t)cell[i + j];
        }
    return shifts >= 0;
}

static inline void couples_add(wide s[3], const struct wide_couples *c, wide exponent, wide w0, wide w1)
{
    const wide a = wide_load(c->texel[0]), b = wide_load(c->texel[4]);
    const wide texel[2] = {__builtin_shufflevector(a, b, 0, 2, 8, 10, 4, 6, 12, 14),
                           __builtin_shufflevector(a, b, 1, 3, 9, 11, 5, 7, 13, 15)};
    const wide weight[2] = {w0, w1};
    for (int k = 0; k < 2; k++) {
        const wide down = (exponent - (texel[k] >> 27)) & 31;
        s[0] += ((texel[k] << 6 & 511 << 6) >> down) * weight[k];
        s[1] += ((texel[k] >> 3 & 511 << 6) >> down) * weight[k];
        s[2] += ((texel[k] >> 12 & 511 << 6) >> down) * weight[k];
    }
}

static void plain_shade(struct raster_batch *b, struct half_vector_lanes *o, struct wide_couples row[4][WIDE_GROUPS],
                        const struct half_vector_constants *c)
{
    const wide none = wide_all(0);
    for (uint32_t i = 0; WIDE_LANES * i < o->p.count; i++) {
        wide s[2][3] = {{none, none, none}, {none, none, none}}, x[3];
        couples_add(s[0], &row[0][i], o->cell[i], o->low0[i], o->low1[i]);
        couples_add(s[0], &row[1][i], o->cell[i], o->high0[i], o->high1[i]);
        couples_add(s[1], &row[2][i], o->cell[i], o->low0[i], o->low1[i]);
        couples_add(s[1], &row[3][i], o->cell[i], o->high0[i], o->high1[i]);
        scale_find(o, i, o->cell[i], c, (enum raster_taps)b->taps);
        for (int k = 0; k < 3; k++)
            x[k] = wide_mulhi(wide_mulhi(s[0][k], o->scale0[i]) + wide_mulhi(s[1][k], o->scale1[i]),
                              wide_all(c->colour[k]));
        wide_add_radiance(b, &o->p, WIDE_LANES * i, x);
    }
}

/* As plain_fetch. Leaves words' places in texel_at, and pairs of weights in low0 and low1. */
static bool packed_fetch(struct half_vector_lanes *o, const struct lut_table *t, const struct half_vector_constants *c,
                         enum raster_taps taps)
{
    wide shifts = wide_all(0);
    for (uint32_t i = 0; i < o->p.count; i++)
        wide_lanes(o->cell)[i] = t->slabs[wide_lanes(o->cell_at)[i]];
    wide_pad(o->cell, o->p.count);
    wide_pad(o->texel_at, o->p.count);
    for (uint32_t i = 0; WIDE_LANES * i < o->p.count; i++) {
        shifts |= scale_find(o, i, o->cell[i] & 255, c, taps);
        o->texel_at[i] += o->cell[i] >> 10;
        o->low0[i] |= o->high0[i] << 16;
        o->low1[i] |= o->high1[i] << 16;
    }
    return !wide_mask(wide_shift_signed(shifts, 31));
}

/* Lanes i .. i+3, twice. */
static inline wide four(const wide *row, uint32_t i)
{
    const wide_half x = wide_load_half((const uint32_t *)row + i);
    return __builtin_shufflevector(x, x, 0, 1, 2, 3, 0, 1, 2, 3);
}

/* Of four's lanes, the first or second two: one in each half. */
static inline wide wide_spread(wide four, bool second)
{
    static const wide_bytes of[2] = {
        {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 7, 4, 5, 6, 7, 4, 5, 6, 7},
        {8,  9,  10, 11, 8,  9,  10, 11, 8,  9,  10, 11, 8,  9,  10, 11,
         12, 13, 14, 15, 12, 13, 14, 15, 12, 13, 14, 15, 12, 13, 14, 15}};
    return (wide)__builtin_ia32_pshufb256((wide_bytes)four, of[second]);
}

/* Adds lanes 1..3, and 5..7, of x[0] and x[1] to the radiance of pixels i .. i+3. */
static inline void four_add(struct raster_batch *b, const struct wide_pixels *p, uint32_t i, const wide x[2])
{
    const wide_half part[4] = {
        __builtin_shufflevector(x[0], x[0], 0, 1, 2, 3), __builtin_shufflevector(x[0], x[0], 4, 5, 6, 7),
        __builtin_shufflevector(x[1], x[1], 0, 1, 2, 3), __builtin_shufflevector(x[1], x[1], 4, 5, 6, 7)};
    if (wide_is_run(p, i, 4)) {
        uint32_t *r = b->radiance[p->index[i]];
        const wide_half sum[3] = {wide_load_half(r) + __builtin_shufflevector(part[0], part[1], 1, 2, 3, 5),
                                  wide_load_half(r + 4) + __builtin_shufflevector(part[1], part[2], 2, 3, 5, 6),
                                  wide_load_half(r + 8) + __builtin_shufflevector(part[2], part[3], 3, 5, 6, 7)};
        __builtin_memcpy(r, sum, sizeof sum);
        return;
    }
    uint32_t lane[4][4];
    __builtin_memcpy(lane, part, sizeof lane);
    for (uint32_t j = 0; j < 4 && i + j < p->count; j++)
        for (int k = 0; k < 3; k++)
            b->radiance[p->index[i + j]][k] += lane[j][1 + k];
}

/* A row's words R, G, B of node t stand in lanes 1..3, so that nothing is read beyond the row's end; before its start are records. */
static void packed_shade(struct raster_batch *b, struct half_vector_lanes *o, const struct lut_table *t,
                         const struct half_vector_constants *c)
{
    const uint32_t *const at = wide_lanes(o->texel_at), row = 3 * t->width;
    const wide colour = {0, c->colour[0], c->colour[1], c->colour[2], 0, c->colour[0], c->colour[1], c->colour[2]};
    for (uint32_t i = 0; i < o->p.count; i += 4) {
        const wide low = four(o->low0, i), high = four(o->low1, i), scale0 = four(o->scale0, i),
                   scale1 = four(o->scale1, i);
        wide x[2];
        for (uint32_t j = 0; j < 2; j++) { /* two pixels */
            const uint32_t *p = t->slabs + at[i + 2 * j] - 1, *q = t->slabs + at[i + 2 * j + 1] - 1;
            const wide w0 = wide_spread(low, j), w1 = wide_spread(high, j);
            const wide s0 = wide_dot16(wide_load_halves(p, q), w0) + wide_dot16(wide_load_halves(p + 3, q + 3), w1);
            p += row;
            q += row;
            const wide s1 = wide_dot16(wide_load_halves(p, q), w0) + wide_dot16(wide_load_halves(p + 3, q + 3), w1);
            x[j] = wide_mulhi(wide_mulhi(s0, wide_spread(scale0, j)) + wide_mulhi(s1, wide_spread(scale1, j)), colour);
        }
        four_add(b, &o->p, i, x);
    }
}

static raster_half_vector *narrow_find(bool packed, enum raster_taps taps)
{
    if (taps == RASTER_TAPS_8)
        return packed ? raster_half_vector_packed : raster_half_vector_plain;
    return packed ? raster_half_vector_fewer_packed : raster_half_vector_fewer_plain;
}

uint32_t raster_half_vector_wide(struct raster_batch *b, uint32_t first, uint32_t end, const struct lut_table *t,
                                 const struct raster_block_light *light)
{
    const bool packed = t->slabs;
    const enum raster_taps taps = (enum raster_taps)b->taps;
    raster_half_vector *const narrow = narrow_find(packed, taps);
    if (first || end < WIDE_LANES)
        return narrow(b, first, end, t, light);
    const struct half_vector_constants c = half_vector_constants_find(t, light->colour);
    const uint32_t step[3] = {packed ? 3 : 1, packed ? 0 : t->width, packed ? 0 : t->width * t->height};
    struct half_vector_lanes o;
    wide_gather(&o.p, b, end, light);
    if (!o.p.count)
        return 0;
    wide_squares_find(&o, light->plane);
    near_find(&o);
    ratio_find(&o);
    for (uint32_t i = 0; i < o.p.count; i++)
        __builtin_memcpy(wide_lanes(o.warp) + i, t->warp_h + wide_lanes(o.warp_at)[i], 4);
    cell_find(&o, t, step);
    if (taps != RASTER_TAPS_8)
        nearest_find(&o, t, taps);
    if (packed) {
        if (!packed_fetch(&o, t, &c, taps))
            return narrow(b, first, end, t, light);
        packed_shade(b, &o, t, &c);
    } else {
        struct wide_couples row[4][WIDE_GROUPS];
        if (!plain_fetch(row, &o, t, c.top))
            return narrow(b, first, end, t, light);
        plain_shade(b, &o, row, &c);
    }
    return o.p.count;
}
#endif
