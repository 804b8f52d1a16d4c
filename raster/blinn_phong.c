/*
 * Blinn-Phong (Blinn 1977) as James 2022 renders it, eq. 1.6 and listing E.1.2:
 *   c = 0.02 kd + sum over lights of (kd max(n.l, 0) + ks max(n.h, 0)^n) c_light,  h = (l + v) / |l + v|,
 * neither normalised nor multiplied by n.l, and clamped to display white. c_light is irradiance/pi here, so that a white
 * diffuse surface looks the same in every model; the ambient light is exposed as the others are.
 * (n.h)^n = (1 - sin^2 theta_h)^(n/2), see block.h.
 */
#include "block.h"

static uint32_t shade_blinn_phong(struct raster_batch *b, uint32_t first, uint32_t end, const struct raster *r,
                                  const struct raster_block_light *light)
{
    const struct scene_material *m = &r->frame.materials[b->material];
    const struct raster_lobe *lobe = &r->lobes[r->lobe_of_material[b->material]];
    uint32_t diffuse[3], specular[3], lit = 0;
    for (int k = 0; k < 3; k++) {
        diffuse[k] = raster_diffuse_colour(m->kd[k], light->colour[k]);
        specular[k] = raster_diffuse_colour(m->ks[k], light->colour[k]);
    }
    struct raster_walk walk = {.y = UINT32_MAX};
    for (uint32_t i = first; i < end; i++) {
        struct raster_pixel p;
        raster_walk_pixel(&p, &walk, b, light, i, true);
        lit += p.nl > 0;
        uint32_t nl = (uint32_t)fx_clamp(p.nl, 0, (1 << 30) - 1) << 2, power = 0; /* Q32 */
        if ((p.nl >> 1) + (b->pixel[i].nv >> 1) > 0)                              /* n.h > 0 */
            power = raster_lobe_at(lobe, (uint32_t)(fx_mulhi(p.na, p.na) + fx_mulhi(p.nb, p.nb))) << 1;
        uint32_t *out = b->radiance[i];
        out[0] += raster_limited(fx_mulhi_u(diffuse[0], nl) + fx_mulhi_u(specular[0], power));
        out[1] += raster_limited(fx_mulhi_u(diffuse[1], nl) + fx_mulhi_u(specular[1], power));
        out[2] += raster_limited(fx_mulhi_u(diffuse[2], nl) + fx_mulhi_u(specular[2], power));
    }
    return lit;
}

/* (n.h)^n is (1 - sin^2)^(n/2). */
static void blinn_lobe(struct raster_lobe *l, const struct scene_material *m)
{
    raster_lobe_setup(l, m->exponent >> 1);
}

static void blinn_ambient(struct raster_batch *b, const struct scene_material *m, uq16_16_t exposure)
{
    raster_add_ambient(b, m, fx_mulhi_u(exposure, 269860937), 1u << 20); /* 0.02 pi */
}

static uint32_t blinn_slow(const struct raster *r, const struct scene_material *m, const struct raster_lobe *l)
{
    (void)r;
    (void)m;
    return l->shift ? 0 : RASTER_SLOW(RASTER_SHADE_BLINN_PHONG);
}

const struct raster_model raster_blinn_phong_model = {.shading = RASTER_SHADE_BLINN_PHONG,
                                                      .shade = shade_blinn_phong,
                                                      .lobe = blinn_lobe,
                                                      .slow = blinn_slow,
                                                      .ambient = blinn_ambient};
