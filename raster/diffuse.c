/*
 * Diffuse materials: kd/pi for every direction. Lights are turned into the meshlet's frame once a run, where the normal is
 * m (U, V, D) - (0, 0, 1), so that n.l = m (U lx + V ly + D lz) - lz.
 */
#include "internal.h"

void raster_diffuse_setup(struct raster_diffuse *d, const struct raster *r, const struct raster_slot *slot)
{
    const struct scene_material *m = &r->frame.materials[slot->material];
    const int16_t *f = slot->frame;
    d->light_count = r->frame.light_count;
    for (unsigned i = 0; i < d->light_count; i++) {
        const struct raster_light *light = &r->lights[i];
        struct vec3 l = light->direction; /* Q15 times Q14: sums <= sqrt(3) * 2^29 */
        d->light[i].direction = (struct vec3){(f[0] * l.x + f[3] * l.y + f[6] * l.z + (1 << 13)) >> 14,
                                              (f[1] * l.x + f[4] * l.y + f[7] * l.z + (1 << 13)) >> 14,
                                              (f[2] * l.x + f[5] * l.y + f[8] * l.z + (1 << 13)) >> 14};
        for (int k = 0; k < 3; k++)
            d->light[i].colour[k] = raster_diffuse_colour(m->kd[k], light->irradiance[k]);
    }
}

void raster_diffuse_shade(uq12_20_t radiance[3], const struct raster_diffuse *d, const struct raster_normal *n)
{
    radiance[0] = radiance[1] = radiance[2] = 0;
    for (unsigned i = 0; i < d->light_count; i++) {
        const struct vec3 l = d->light[i].direction;
        int32_t dot = n->u * l.x + n->v * l.y + n->d * l.z; /* |(u,v,d)| <= 2^14.9, |l| <= 2^15.01: 2^29.9 */
        int32_t nl = (int32_t)(((int64_t)dot * n->m) >> 17) - l.z * 2048; /* Q26, the product <= 2^44.1 */
        if (nl <= 0)
            continue;
        uint32_t q32 = nl >= 1 << 26 ? UINT32_MAX : (uint32_t)nl << 6;
        for (int c = 0; c < 3; c++)
            radiance[c] = fx_add_sat(radiance[c], fx_mulhi_u(d->light[i].colour[c], q32));
    }
}
