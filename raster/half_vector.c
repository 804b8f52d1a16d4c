/*
 * The half-vector table (lut.h) over a block. What reaches the eye is f n.l = g n.l/(n.l + n.v), g interpolated from eight
 * texels with fractions of 8, 8 and 6 bits (h, t, d) and weights that sum to 2^14. Mantissas are aligned to the largest exponent of
 * the h and d cell, which the table's file lists, so that the re-packed copy gives the same bits.
 */
#include "block.h"

/* One light and table: what does not change from pixel to pixel. */
struct constants {
    uint32_t colour[3]; /* times 2^-up, Q31 */
    int32_t top;        /* cell exponent at which a term needs no shift, <= 31 */
};

/* A term is sum 2^(E - 24 - 6 - 14 + scale) * (kq 2^-15) * (colour 2^(up - 31)) with 20 fraction bits, and is computed as
 * sum * ((kq << 16 >> shift) * colour >> 32) >> 32, thus shift = 22 - scale - up - E. */
static struct constants constants_find(const struct lut_table *t, const struct raster_block_light *light)
{
    struct constants c;
    uint32_t largest = light->colour[0] | light->colour[1] | light->colour[2] | 1;
    unsigned lead = fx_clz(largest);
    c.top = 22 - t->scale - (16 - (int32_t)lead);
    unsigned dim = c.top > 31 ? (unsigned)c.top - 31 : 0; /* at most 38 - 31 + 16 */
    c.top -= (int32_t)dim;
    for (int k = 0; k < 3; k++)
        c.colour[k] = light->colour[k] << lead >> 1 >> dim;
    return c;
}

/* Where a pixel's value is: cell and fractions. */
struct place {
    uint32_t h, d, t;            /* lower nodes */
    uint32_t w00, w01, w10, w11; /* of (h, t), (h, t+1), (h+1, t), (h+1, t+1); they sum to 256 */
    uint32_t fd;                 /* of 64 */
};

static inline struct place place_find(const struct lut_table *table, const struct raster_pixel *p, uint32_t both,
                                      uint32_t inv_lv)
{
    struct place o;
    uint32_t na2 = (uint32_t)fx_mulhi(p->na, p->na), s2 = na2 + (uint32_t)fx_mulhi(p->nb, p->nb); /* Q28 */
    uint32_t x = s2 + (1u << 12);
    x = x < (1u << 28) - 1 ? x : (1u << 28) - 1;
    unsigned zeros = fx_clz(x); /* 4 .. 19 */
    x <<= zeros;
    const uint16_t *w = table->warp_h + 8 * (19 - zeros) + (x >> 28 & 7);
    uint32_t u = ((uint32_t)w[0] << 11) + (uint32_t)(w[1] - w[0]) * (x >> 17 & 0x7ff); /* 20 fraction bits, < nodes-1 */
    o.h = u >> 20;
    uint32_t fh = u >> 12 & 255;
    /* cos^2 of the azimuth: over the smaller of sin^2 theta_h and ((n.l + n.v)/|l-v|)^2, 18 fraction bits */
    uint32_t wd = fx_mulhi_u(both, inv_lv); /* Q25, at most 2^29 */
    uint32_t far = fx_mulhi_u(wd, wd), near = s2 >> 10;
    uint32_t t2 = na2 / ((far < near ? far : near) | 1); /* 10 fraction bits */
    t2 = (t2 < 1023 ? t2 : 1023) * (table->width - 1);
    o.t = t2 >> 10;
    uint32_t ft = t2 >> 2 & 255;
    o.w11 = fh * ft >> 8;
    o.w10 = fh - o.w11;
    o.w01 = ft - o.w11;
    o.w00 = 256 - fh - o.w01;
    o.d = p->term >> TERM_D_BITS;
    o.fd = p->term >> (TERM_D_BITS - 6) & 63;
    return o;
}

struct sums { /* below 2^29, times 2^(E - 44) */
    uint32_t c[3];
};

static inline void tap(struct sums *s, uint32_t texel, uint32_t weight, uint32_t exponent)
{
    uint32_t down = (exponent - (texel >> 27)) & 31;
    s->c[0] += ((texel & 511) << 6 >> down) * weight;
    s->c[1] += ((texel >> 9 & 511) << 6 >> down) * weight;
    s->c[2] += ((texel >> 18 & 511) << 6 >> down) * weight;
}

static inline struct sums taps_plain(const struct lut_table *t, const struct place *o, uint32_t *exponent)
{
    const uint32_t width = t->width, plane = t->height * width, fd = o->fd;
    const uint32_t *p = t->texels + (o->d * t->height + o->h) * width + o->t;
    const uint32_t e = *exponent = t->cells[o->d * (t->height - 1) + o->h];
    struct sums s = {{0, 0, 0}};
    tap(&s, p[0], o->w00 * (64 - fd), e);
    tap(&s, p[1], o->w01 * (64 - fd), e);
    tap(&s, p[width], o->w10 * (64 - fd), e);
    tap(&s, p[width + 1], o->w11 * (64 - fd), e);
    p += plane;
    tap(&s, p[0], o->w00 * fd, e);
    tap(&s, p[1], o->w01 * fd, e);
    tap(&s, p[width], o->w10 * fd, e);
    tap(&s, p[width + 1], o->w11 * fd, e);
    return s;
}

/* A word of the re-packed copy: two planes' mantissas, 15 bits each. */
static inline uint32_t pair(uint32_t word, uint32_t low, uint32_t high)
{
    return (word & 0xffff) * low + (word >> 16) * high;
}

static inline struct sums taps_packed(const struct lut_table *t, const struct place *o, uint32_t *exponent)
{
    const uint32_t record = t->slabs[o->d * (t->height - 1) + o->h], fd = o->fd;
    const uint32_t *p = t->slabs + (record >> 10) + 3 * o->t, *q = p + 3 * t->width;
    const uint32_t b00 = o->w00 * fd, b01 = o->w01 * fd, b10 = o->w10 * fd, b11 = o->w11 * fd;
    const uint32_t a00 = 64 * o->w00 - b00, a01 = 64 * o->w01 - b01, a10 = 64 * o->w10 - b10, a11 = 64 * o->w11 - b11;
    *exponent = record & 255;
    struct sums s = {{pair(p[0], a00, b00) + pair(p[3], a01, b01) + pair(q[0], a10, b10) + pair(q[3], a11, b11),
                      pair(p[1], a00, b00) + pair(p[4], a01, b01) + pair(q[1], a10, b10) + pair(q[4], a11, b11),
                      pair(p[2], a00, b00) + pair(p[5], a01, b01) + pair(q[2], a10, b10) + pair(q[5], a11, b11)}};
    return s;
}

/* sum * scale >> 32, times 2^up, for a cell brighter than the scale's top. */
FX_NOINLINE static uint32_t bright(uint32_t sum, uint32_t scale, uint32_t up)
{
    uint32_t x = fx_mulhi_u(sum, scale); /* < 2^29 */
    return up > 27 || x >> (27 - up) ? (x ? RASTER_LIGHT_LIMIT : 0) : x << up;
}

__attribute__((always_inline)) static inline uint32_t shade(struct raster_batch *b, uint32_t first, uint32_t end,
                                                            const struct lut_table *table,
                                                            const struct raster_block_light *light, const bool packed)
{
    const struct constants k = constants_find(table, light);
    struct raster_walk walk = {.y = UINT32_MAX};
    uint32_t lit = 0;
    for (uint32_t i = first; i < end; i++) {
        struct raster_pixel p;
        if (!raster_walk_pixel(&p, &walk, b, light, i, false))
            continue;
        lit++;
        uint32_t both = (uint32_t)p.nl + (uint32_t)b->pixel[i].nv; /* Q30, <= 2^31 */
        struct place o = place_find(table, &p, both, light->inv_lv);
        uint32_t exponent, ratio = (uint32_t)p.nl / (both >> 15); /* n.l/(n.l + n.v), Q15, < 2^15 as n.v >= 2^-8 */
        struct sums s = packed ? taps_packed(table, &o, &exponent) : taps_plain(table, &o, &exponent);
        int32_t shift = k.top - (int32_t)exponent;
        uint32_t scale = ratio << 16 >> fx_max(shift, 0);
        uint32_t red = fx_mulhi_u(scale, k.colour[0]), green = fx_mulhi_u(scale, k.colour[1]),
                 blue = fx_mulhi_u(scale, k.colour[2]); /* < 2^30 */
        uint32_t *c = b->radiance[i];
        if (shift >= 0) {
            c[0] += fx_mulhi_u(s.c[0], red);
            c[1] += fx_mulhi_u(s.c[1], green);
            c[2] += fx_mulhi_u(s.c[2], blue);
        } else {
            c[0] += bright(s.c[0], red, (uint32_t)-shift);
            c[1] += bright(s.c[1], green, (uint32_t)-shift);
            c[2] += bright(s.c[2], blue, (uint32_t)-shift);
        }
    }
    return lit;
}

uint32_t raster_shade_half_vector(struct raster_batch *b, uint32_t first, uint32_t end, const struct raster *r,
                                  const struct raster_block_light *light)
{
    const struct lut_table *t = r->frame.tables[r->frame.materials[b->material].slot];
    return t->slabs ? shade(b, first, end, t, light, true) : shade(b, first, end, t, light, false);
}
