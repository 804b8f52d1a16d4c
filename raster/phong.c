/*
 * Lafortune-Phong: f = kd/pi + ks (n+2)/(2 pi) max(v.r, 0)^n (Lafortune and Willems 1994; Cezner 2024, eq. 6), r the mirror
 * direction of l. 1 - v.r is 2 ((n.a)^2 + (n.b cos theta_d)^2), see block.h.
 */
#include "phong.h"

/* (n+2)/(2 pi), uq16_16: at most 652. */
static inline uint32_t peak_scale(const struct scene_material *m)
{
    return fx_over_pi((m->exponent >> 1) + (1u << 16));
}

/* Returns 64 or more when a pixel's sum may exceed RASTER_LIGHT_LIMIT, where n.l is at most 1 + 2^-12: when the diffuse part's product is
 * above 2^49, thus 32 display whites, or the lobe's above 2^43, thus 64. In: peak_scale(m) << 6; ks <= 1. */
static inline uint32_t colour_find(struct phong_colour *c, uint32_t scale, uq16_16_t kd, uq16_16_t ks,
                                   uq16_16_t irradiance)
{
    const uint64_t d = (uint64_t)fx_over_pi(kd << 12) * irradiance;        /* 2^26.4 2^32 */
    const uint64_t s = (uint64_t)fx_mulhi_u(scale, ks << 15) * irradiance; /* 2^30.4 2^32 */
    *c = (struct phong_colour){(uint32_t)(d >> 22), (uint32_t)(s >> 14)};
    return (uint32_t)(d >> 32) >> 11 | (uint32_t)(s >> 32) >> 5;
}

static uint32_t shade_bounded(struct raster_batch *b, uint32_t first, uint32_t end, const struct raster_lobe *lobe,
                              const struct raster_block_light *light, struct phong_loop *k)
{
#ifdef RASTER_ARM
    k->unlit = 0;
    k->end = &b->pixel[end];
    k->offset = lobe->offset;
    k->nodes = (uintptr_t)lobe->node + 2 * 16 * (7u + lobe->shift);
    raster_shade_lafortune_phong_loop(&b->pixel[first], b->radiance[first], light, k);
    return end - first - k->unlit / sizeof b->pixel[0];
#else
    uint32_t lit = 0;
    struct raster_walk walk = {.y = UINT32_MAX};
    for (uint32_t i = first; i < end; i++) {
        struct raster_pixel p;
        if (!raster_walk_pixel(&p, &walk, b, light, i, false))
            continue;
        lit++;
        const uint32_t nl = (uint32_t)p.nl;
        uint32_t s2 = (uint32_t)(((int64_t)p.na * p.na + (int64_t)p.nb * p.nb) >> 32);
        uint64_t sum = (uint64_t)raster_lobe_at(lobe, 2 * s2) * nl;
        const uint32_t power = (uint32_t)(sum >> 32);
        uint32_t *out = b->radiance[i];
        for (int c = 0; c < 3; c++) {
            const struct phong_colour *colour = &k->colour[c];
            sum = (uint64_t)out[c] << 32 | (uint32_t)sum;
            sum += (uint64_t)colour->diffuse * nl;
            sum += (uint64_t)colour->specular * power;
            out[c] = (uint32_t)(sum >> 32);
        }
    }
    return lit;
#endif
}

/* For what the loop does not take. Peaks with 20 fraction bits, without their `drop` lowest, so that they are below 2^31. */
struct bright {
    uint32_t diffuse[3], specular[3];
    unsigned drop;
};

static void bright_find(struct bright *c, const struct scene_material *m, const uq16_16_t irradiance[3])
{
    uint64_t peak[3];
    c->drop = 0;
    for (int k = 0; k < 3; k++) {
        peak[k] =
            (uint64_t)(uint32_t)((uint64_t)peak_scale(m) * m->ks[k] >> 16) * irradiance[k] >> 12; /* 2^25.4 2^32 */
        while (peak[k] >> c->drop >> 31)
            c->drop++;
        c->diffuse[k] = raster_diffuse_colour(m->kd[k], irradiance[k]);
    }
    for (int k = 0; k < 3; k++)
        c->specular[k] = (uint32_t)(peak[k] >> c->drop);
}

FX_COLD FX_NOINLINE static uint32_t shade_bright(struct raster_batch *b, uint32_t first, uint32_t end,
                                                 const struct raster_lobe *lobe, const struct raster_block_light *light,
                                                 const struct scene_material *m)
{
    struct bright c;
    uint32_t lit = 0;
    bright_find(&c, m, light->colour);
    struct raster_walk walk = {.y = UINT32_MAX};
    for (uint32_t i = first; i < end; i++) {
        struct raster_pixel p;
        if (!raster_walk_pixel(&p, &walk, b, light, i, false))
            continue;
        lit++;
        const uint32_t nl = (uint32_t)fx_min(p.nl, (1 << 30) - 1) << 2; /* Q32 */
        uint32_t s2 = (uint32_t)(((int64_t)p.na * p.na + (int64_t)p.nb * p.nb) >> 32);
        const uint32_t power = fx_mulhi_u(raster_lobe_at(lobe, 2 * s2) << 1, nl); /* Q32 */
        for (int k = 0; k < 3; k++) {
            uint32_t s = fx_mulhi_u(c.specular[k], power), d = fx_mulhi_u(c.diffuse[k], nl);
            s = s >> (31 - c.drop) ? INT32_MAX : s << c.drop;
            b->radiance[i][k] += raster_limited(s + d); /* < 2^32 */
        }
    }
    return lit;
}

static uint32_t shade_lafortune_phong(struct raster_batch *b, uint32_t first, uint32_t end, const struct raster *r,
                                      const struct raster_block_light *light)
{
    const struct raster_lobe *lobe = &r->lobes[r->lobe_of_material[b->material]];
    const struct scene_material *m = &r->frame.materials[b->material];
    struct phong_loop k;
    const uint32_t scale = peak_scale(m) << 6; /* < 2^32 */
    uint32_t bright = colour_find(&k.colour[0], scale, m->kd[0], m->ks[0], light->colour[0]);
    bright |= colour_find(&k.colour[1], scale, m->kd[1], m->ks[1], light->colour[1]);
    bright |= colour_find(&k.colour[2], scale, m->kd[2], m->ks[2], light->colour[2]);
    if (bright >= 64 || !lobe->shift) /* the loop has no exact lobe */
        return shade_bright(b, first, end, lobe, light, m);
    return shade_bounded(b, first, end, lobe, light, &k);
}

static void lafortune_lobe(struct raster_lobe *l, const struct scene_material *m)
{
    raster_lobe_setup(l, m->exponent);
}

static uint32_t lafortune_slow(const struct raster *r, const struct scene_material *m, const struct raster_lobe *l)
{
    uint32_t bright = 0;
    struct phong_loop k;
    for (uint32_t i = 0; i < r->frame.light_count; i++)
        for (int j = 0; j < 3; j++)
            bright |= colour_find(&k.colour[j], peak_scale(m) << 6, m->kd[j], m->ks[j], r->lights[i].irradiance[j]);
    return bright >= 64 || !l->shift ? RASTER_SLOW(RASTER_SHADE_LAFORTUNE_PHONG) : 0;
}

const struct raster_model raster_lafortune_phong_model = {.shading = RASTER_SHADE_LAFORTUNE_PHONG,
                                                          .shade = shade_lafortune_phong,
                                                          .lobe = lafortune_lobe,
                                                          .slow = lafortune_slow,
                                                          .scales_b = true};
