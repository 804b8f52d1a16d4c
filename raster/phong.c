/*
 * Lafortune-Phong: f = kd/pi + ks (n+2)/(2 pi) max(v.r, 0)^n (Lafortune and Willems 1994; Cezner 2024, eq. 6), r the mirror
 * direction of l. 1 - v.r is 2 ((n.a)^2 + (n.b cos theta_d)^2), see block.h.
 */
#include "block.h"

/* Reflected radiance per n.l, 20 fraction bits; the lobe's peak without its `drop` lowest bits, so that it is below 2^31. */
struct colours {
    uint32_t diffuse[3], specular[3];
    unsigned drop;
    bool bounded; /* drop is 0, and the sum never above RASTER_LIGHT_LIMIT */
};

static void colours_find(struct colours *c, const struct scene_material *m, const uq16_16_t irradiance[3])
{
    uint64_t peak[3];
    c->drop = 0;
    c->bounded = true;
    for (int k = 0; k < 3; k++) {
        uint64_t scale = (uint64_t)fx_over_pi((m->exponent >> 1) + (1u << 16)) * m->ks[k] >> 16; /* uq16_16: <= 652 */
        peak[k] = scale * irradiance[k] >> 12;                                                   /* 2^25.4 * 2^32 */
        while (peak[k] >> c->drop >> 31)
            c->drop++;
        c->diffuse[k] = raster_diffuse_colour(m->kd[k], irradiance[k]);
        c->bounded &= peak[k] + c->diffuse[k] <= RASTER_LIGHT_LIMIT;
    }
    for (int k = 0; k < 3; k++)
        c->specular[k] = (uint32_t)(peak[k] >> c->drop);
}

static uint32_t bounded(const struct colours *c, int k, uint32_t nl, uint32_t power)
{
    uint32_t s = fx_mulhi_u(c->specular[k], power), d = fx_mulhi_u(c->diffuse[k], nl);
    s = s >> (31 - c->drop) ? INT32_MAX : s << c->drop;
    return raster_limited(s + d); /* < 2^32 */
}

uint32_t raster_shade_lafortune_phong(struct raster_batch *b, uint32_t first, uint32_t end, const struct raster *r,
                                      const struct raster_block_light *light)
{
    const struct raster_lobe *lobe = &r->lobes[r->lobe_of_material[b->material]];
    struct colours c;
    uint32_t lit = 0;
    colours_find(&c, &r->frame.materials[b->material], light->colour);
    struct raster_walk walk = {.y = UINT32_MAX};
    for (uint32_t i = first; i < end; i++) {
        struct raster_pixel p;
        if (!raster_walk_pixel(&p, &walk, b, light, i, false))
            continue;
        lit++;
        uint32_t nl = (uint32_t)fx_min(p.nl, (1 << 30) - 1) << 2; /* Q32 */
        uint32_t x = 2 * (uint32_t)(fx_mulhi(p.na, p.na) + fx_mulhi(p.nb, p.nb));
        uint32_t power = fx_mulhi_u(raster_lobe_at(lobe, x) << 5, nl); /* Q32 */
        uint32_t *out = b->radiance[i];
        if (c.bounded) {
            out[0] += fx_mulhi_u(c.specular[0], power) + fx_mulhi_u(c.diffuse[0], nl);
            out[1] += fx_mulhi_u(c.specular[1], power) + fx_mulhi_u(c.diffuse[1], nl);
            out[2] += fx_mulhi_u(c.specular[2], power) + fx_mulhi_u(c.diffuse[2], nl);
        } else {
            for (int k = 0; k < 3; k++)
                out[k] += bounded(&c, k, nl, power);
        }
    }
    return lit;
}
