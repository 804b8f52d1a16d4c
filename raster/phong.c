/*
 * Lafortune-Phong: f = kd/pi + ks (n+2)/(2 pi) max(v.r, 0)^n (Lafortune and Willems 1994; Cezner 2024, eq. 6), r the mirror
 * direction of l. 1 - v.r is 2 ((n.a)^2 + (n.b cos theta_d)^2), see block.h.
 */
#include "block.h"

uint32_t raster_shade_lafortune_phong(struct raster_batch *b, uint32_t first, uint32_t end, const struct raster *r,
                                      const struct raster_block_light *light)
{
    const struct scene_material *m = &r->frame.materials[b->material];
    const struct raster_lobe *lobe = &r->lobes[r->lobe_of_material[b->material]];
    /* Reflected radiance per n.l, 20 fraction bits; ks <= 2^16, irradiance < 2^32. */
    uint32_t diffuse[3], specular[3], lit = 0;
    uint64_t peak[3];
    unsigned drop = 0; /* bits off the lobe's peak to keep it below 2^31 */
    for (int k = 0; k < 3; k++) {
        uint64_t scale = (uint64_t)fx_over_pi((m->exponent >> 1) + (1u << 16)) * m->ks[k] >> 16; /* uq16_16: <= 652 */
        peak[k] = scale * light->colour[k] >> 12;                                                /* 2^25.4 * 2^32 */
        while (peak[k] >> drop >> 31)
            drop++;
        diffuse[k] = raster_diffuse_colour(m->kd[k], light->colour[k]);
    }
    for (int k = 0; k < 3; k++)
        specular[k] = (uint32_t)(peak[k] >> drop);
    struct raster_walk walk = {.y = UINT32_MAX};
    for (uint32_t i = first; i < end; i++) {
        struct raster_pixel p;
        if (!raster_walk_pixel(&p, &walk, b, light, i, false))
            continue;
        lit++;
        uint32_t nl = (uint32_t)fx_min(p.nl, (1 << 30) - 1) << 2; /* Q32 */
        uint32_t x = 2 * (uint32_t)(fx_mulhi(p.na, p.na) + fx_mulhi(p.nb, p.nb));
        uint32_t power = fx_mulhi_u(raster_lobe_at(lobe, x) << 5, nl); /* Q32 */
        for (int k = 0; k < 3; k++) {
            uint32_t s = fx_mulhi_u(specular[k], power);
            s = s >> (31 - drop) ? INT32_MAX : s << drop;
            b->radiance[i][k] += raster_limited(s + fx_mulhi_u(diffuse[k], nl)); /* < 2^32 */
        }
    }
    return lit;
}
