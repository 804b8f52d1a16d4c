/*
 * The half-vector table over a block in portable C: from its texels, or from the re-packed copy.
 */
#include "half_vector.h"

/* Where a pixel's value is. */
struct place {
    uint32_t h, d, t; /* lower nodes */
    uint32_t hf;      /* of 2^32 */
    uint32_t ft, fd;  /* of 256, of 64; with fewer taps t is the nearer node, and fd of 2^14 */
};

static inline struct place place_find(const struct lut_table *table, const struct raster_pixel *p, uint32_t ratio,
                                      enum raster_taps taps)
{
    struct place o;
    const uint32_t na2 = (uint32_t)fx_mulhi(p->na, p->na); /* Q28 */
    const uint32_t y = na2 + (uint32_t)fx_mulhi(p->nb, p->nb) + (1u << 12), x = y < (1u << 28) - 1 ? y : (1u << 28) - 1;
    const unsigned zeros = fx_clz(x); /* 4 .. 19 */
    const uint32_t m = x << zeros;
    const uint16_t *w = table->warp_h + 8 * (19 - zeros) + (m >> 28 & 7);
    const uint32_t u =
        ((uint32_t)w[0] << 11) + (uint32_t)(w[1] - w[0]) * (m >> 17 & 0x7ff); /* < nodes-1, see lut_open */
    o.h = u >> 20;
    o.hf = u << 12;
    /* cos^2 of the azimuth, or ((n.l - n.v)/(n.l + n.v))^2 where that is larger; 10 fraction bits */
    const int32_t tilt = 2 * (int32_t)ratio - 32767;
    const uint32_t near = na2 / (y >> 10), far = (uint32_t)(tilt * tilt) >> 20; /* both at most 1023 */
    const uint32_t t2 = (near > far ? near : far) * (table->width - 1);
    o.t = (taps == RASTER_TAPS_8 ? t2 : t2 + (1 << 9)) >> 10;
    o.ft = t2 >> 2 & 255;
    o.d = p->term >> TERM_D_BITS;
    o.fd = taps == RASTER_TAPS_8 ? p->term >> (TERM_D_BITS - 6) & 63 : p->term >> (TERM_D_BITS - 14) & 0x3fff;
    return o;
}

/* Weights of nodes t and t+1, in planes d and d+1; they sum to 2^14. */
struct weights {
    uint32_t low0, low1, high0, high1;
};

static inline struct weights weights_find(const struct place *o)
{
    const uint32_t high1 = o->ft * o->fd, low1 = 64 * o->ft - high1, high0 = 256 * o->fd - high1;
    return (struct weights){64 * (256 - o->ft) - high0, low1, high0, high1};
}

/* The same with four taps: none of node t+1. */
static inline struct weights weights_of_four(const struct place *o)
{
    return (struct weights){(1u << 14) - o->fd, 0, o->fd, 0};
}

/* Adds a texel's 15 bits, (mantissa << 6) >> down, by weight. Most texels are within 2^6 of their cell's largest and lose no bit. */
static inline void tap(uint32_t s[3], uint32_t texel, uint32_t weight, uint32_t exponent)
{
    const uint32_t down = (exponent - (texel >> 27)) & 31;
    uint32_t r = texel & 511, g = texel >> 9 & 511, b = texel >> 18 & 511;
    if (down > 6) {
        r >>= down - 6;
        g >>= down - 6;
        b >>= down - 6;
    } else {
        weight <<= 6 - down; /* <= 2^20 */
    }
    s[0] += r * weight;
    s[1] += g * weight;
    s[2] += b * weight;
}

/* Sums of a row, below 2^29, times 2^(E - 44): from texels of planes d and d+1. */
static inline void row_plain(uint32_t s[3], const uint32_t *low, const uint32_t *high, const struct weights *w,
                             uint32_t exponent, enum raster_taps taps)
{
    s[0] = s[1] = s[2] = 0;
    tap(s, low[0], w->low0, exponent);
    if (taps == RASTER_TAPS_8)
        tap(s, low[1], w->low1, exponent);
    tap(s, high[0], w->high0, exponent);
    if (taps == RASTER_TAPS_8)
        tap(s, high[1], w->high1, exponent);
}

/* The same of one channel from the re-packed copy, whose words have both planes' 15 bits. */
static inline uint32_t row_packed(const uint32_t *p, const struct weights *w, enum raster_taps taps)
{
    const uint32_t node = (p[0] & 0xffff) * w->low0 + (p[0] >> 16) * w->high0;
    return taps == RASTER_TAPS_8 ? node + (p[3] & 0xffff) * w->low1 + (p[3] >> 16) * w->high1 : node;
}

/* What a pixel's two rows weigh. */
struct scales {
    uint32_t row[2];
    uint32_t up; /* cells brighter than the constants' top: by how much */
};

static inline struct scales scales_find(const struct half_vector_constants *k, uint32_t ratio, uint32_t hf,
                                        uint32_t exponent)
{
    const int32_t shift = k->top - (int32_t)exponent;
    const uint32_t scale = ratio << 16 >> fx_max(shift, 0), scale1 = fx_mulhi_u(scale, hf);
    return (struct scales){{scale - scale1, scale1}, (uint32_t)fx_max(-shift, 0)};
}

/* In: sum < 2^28. */
static inline void add_sum(uint32_t *radiance, uint32_t sum, const struct scales *s, uint32_t colour)
{
    *radiance += s->up ? half_vector_bright(sum, colour, s->up) : fx_mulhi_u(sum, colour);
}

static inline void add(uint32_t *radiance, uint32_t a, uint32_t b, const struct scales *s, uint32_t colour)
{
    add_sum(radiance, fx_mulhi_u(a, s->row[0]) + fx_mulhi_u(b, s->row[1]), s, colour);
}

__attribute__((always_inline)) static inline void add_plain(uint32_t c[3], const struct lut_table *t,
                                                            const struct place *o, uint32_t ratio,
                                                            const struct half_vector_constants *k,
                                                            enum raster_taps taps)
{
    const struct weights w = taps == RASTER_TAPS_8 ? weights_find(o) : weights_of_four(o);
    const uint32_t *low = t->texels + (o->d * t->height + o->h) * t->width + o->t, *high = low + t->height * t->width;
    const uint32_t exponent = t->cells[o->d * (t->height - 1) + o->h];
    const struct scales s = scales_find(k, ratio, o->hf, exponent);
    uint32_t a[3], b[3];
    row_plain(a, low, high, &w, exponent, taps);
    row_plain(b, low + t->width, high + t->width, &w, exponent, taps);
    for (int j = 0; j < 3; j++)
        add(&c[j], a[j], b[j], &s, k->colour[j]);
}

__attribute__((always_inline)) static inline void add_packed(uint32_t c[3], const struct lut_table *t,
                                                             const struct place *o, uint32_t ratio,
                                                             const struct half_vector_constants *k,
                                                             enum raster_taps taps)
{
    const struct weights w = taps == RASTER_TAPS_8 ? weights_find(o) : weights_of_four(o);
    const uint32_t record = t->slabs[o->d * (t->height - 1) + o->h];
    const uint32_t *p = t->slabs + (record >> 10) + 3 * o->t, *q = p + 3 * t->width;
    const struct scales s = scales_find(k, ratio, o->hf, record & 255);
    for (int j = 0; j < 3; j++)
        add(&c[j], row_packed(p + j, &w, taps), row_packed(q + j, &w, taps), &s, k->colour[j]);
}

/* With one tap. */
__attribute__((always_inline)) static inline void add_nearest(uint32_t c[3], const struct lut_table *t,
                                                              const struct place *o, uint32_t ratio,
                                                              const struct half_vector_constants *k, bool packed)
{
    const uint32_t row = o->hf >> 31, plane = o->fd >> 13, cell = o->d * (t->height - 1) + o->h;
    const uint32_t exponent = packed ? t->slabs[cell] & 255 : t->cells[cell];
    const struct scales s = scales_find(k, ratio, 0, exponent);
    uint32_t bits[3] = {0};
    if (packed) {
        const uint32_t *p = t->slabs + (t->slabs[cell] >> 10) + 3 * (row * t->width + o->t);
        for (int j = 0; j < 3; j++)
            bits[j] = p[j] >> 16 * plane & 0xffff;
    } else {
        tap(bits, t->texels[((o->d + plane) * t->height + o->h + row) * t->width + o->t], 1, exponent);
    }
    for (int j = 0; j < 3; j++)
        add_sum(&c[j], fx_mulhi_u(bits[j] << 16, s.row[0] >> 2), &s, k->colour[j]);
}

__attribute__((always_inline)) static inline uint32_t shade(struct raster_batch *b, uint32_t first, uint32_t end,
                                                            const struct lut_table *table,
                                                            const struct raster_block_light *light, const bool packed,
                                                            const enum raster_taps taps)
{
    const struct half_vector_constants k = half_vector_constants_find(table, light->colour);
    struct raster_walk walk = {.y = UINT32_MAX};
    uint32_t lit = 0;
    for (uint32_t i = first; i < end; i++) {
        struct raster_pixel p;
        if (!raster_walk_pixel(&p, &walk, b, light, i, false))
            continue;
        lit++;
        const uint32_t both = (uint32_t)p.nl + (uint32_t)b->pixel[i].nv;
        const uint32_t ratio = (uint32_t)p.nl / (both >> 15); /* < 2^15 as n.v >= 2^-8 */
        const struct place o = place_find(table, &p, ratio, taps);
        if (taps == RASTER_TAPS_1)
            add_nearest(b->radiance[i], table, &o, ratio, &k, packed);
        else if (packed)
            add_packed(b->radiance[i], table, &o, ratio, &k, taps);
        else
            add_plain(b->radiance[i], table, &o, ratio, &k, taps);
    }
    return lit;
}

uint32_t raster_half_vector_plain(struct raster_batch *b, uint32_t first, uint32_t end, const struct lut_table *table,
                                  const struct raster_block_light *light)
{
    return shade(b, first, end, table, light, false, RASTER_TAPS_8);
}

uint32_t raster_half_vector_packed(struct raster_batch *b, uint32_t first, uint32_t end, const struct lut_table *table,
                                   const struct raster_block_light *light)
{
    return shade(b, first, end, table, light, true, RASTER_TAPS_8);
}

uint32_t raster_half_vector_fewer_plain(struct raster_batch *b, uint32_t first, uint32_t end,
                                        const struct lut_table *table, const struct raster_block_light *light)
{
    return b->taps == RASTER_TAPS_1 ? shade(b, first, end, table, light, false, RASTER_TAPS_1)
                                    : shade(b, first, end, table, light, false, RASTER_TAPS_4);
}

uint32_t raster_half_vector_fewer_packed(struct raster_batch *b, uint32_t first, uint32_t end,
                                         const struct lut_table *table, const struct raster_block_light *light)
{
    return b->taps == RASTER_TAPS_1 ? shade(b, first, end, table, light, true, RASTER_TAPS_1)
                                    : shade(b, first, end, table, light, true, RASTER_TAPS_4);
}

static uint32_t shade_fewer(struct raster_batch *b, uint32_t first, uint32_t end, const struct lut_table *t,
                            const struct raster_block_light *light)
{
    return t->slabs ? HALF_VECTOR_FEWER_PACKED(b, first, end, t, light)
                    : HALF_VECTOR_FEWER_PLAIN(b, first, end, t, light);
}

const struct raster_fewer_taps raster_fewer_taps = {shade_fewer};

static uint32_t shade_half_vector(struct raster_batch *b, uint32_t first, uint32_t end, const struct raster *r,
                                  const struct raster_block_light *light)
{
    const struct lut_table *t = r->frame.tables[r->frame.materials[b->material].slot];
    if (b->taps != RASTER_TAPS_8)
        return r->frame.parts->fewer_taps->shade(b, first, end, t, light);
    return t->slabs ? HALF_VECTOR_PACKED(b, first, end, t, light) : HALF_VECTOR_PLAIN(b, first, end, t, light);
}

/* On cores whose loop is for the re-packed copy: from its texels, or with cells that the loop leaves to them. */
static uint32_t half_vector_slow(const struct raster *r, const struct scene_material *m, const struct raster_lobe *l)
{
    const struct lut_table *t = r->frame.tables[m->slot];
    (void)l;
    uint32_t slow = !t->slabs || t->height > HALF_VECTOR_LOOP_H ? RASTER_SLOW(RASTER_SHADE_HALF_VECTOR) : 0;
    for (uint32_t i = 0; i < r->frame.light_count && !slow; i++)
        if (half_vector_constants_find(t, r->lights[i].irradiance).top < (int32_t)t->brightest)
            slow = RASTER_SLOW(RASTER_SHADE_HALF_VECTOR) | RASTER_SLOW_BRIGHT;
    return slow;
}

/* The coordinate on the d axis, TERM_D_BITS. */
static uint32_t half_vector_term(const struct lut_table *t, uint32_t sine, uint32_t cosine)
{
    return lut_d_coordinate(t, sine, cosine) >> (LUT_D_BITS - TERM_D_BITS);
}

const struct raster_model raster_half_vector_model = {.shading = RASTER_SHADE_HALF_VECTOR,
                                                      .shade = shade_half_vector,
                                                      .term = half_vector_term,
                                                      .slow = half_vector_slow,
                                                      .facing = true};
