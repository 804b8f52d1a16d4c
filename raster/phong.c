/*
 * Lafortune-Phong: f = kd/pi + ks (n+2)/(2 pi) max(v.r, 0)^n (Lafortune and Willems 1994; Cezner 2024, eq. 6), r the mirror
 * direction of l. v.r is taken from |v-r|^2 = 2 - 2 v.r: near the lobe's centre the difference keeps its bits, the
 * product would not.
 */
#include "internal.h"
#include "func.h"

uint32_t raster_shade_lafortune_phong(struct raster_batch *b, const struct scene_material *m,
                                      const struct raster_light *light)
{
    /* Reflected radiance per n.l, 20 fraction bits; ks <= 2^16, irradiance < 2^32. */
    uint64_t diffuse[3], specular[3];
    unsigned drop[3]; /* bits off the lobe's peak to keep it below 2^32 */
    for (int k = 0; k < 3; k++) {
        uint64_t lobe = (uint64_t)fx_over_pi((m->exponent >> 1) + (1u << 16)) * m->ks[k] >> 16; /* uq16_16: <= 652 */
        diffuse[k] = raster_diffuse_colour(m->kd[k], light->irradiance[k]);
        specular[k] = lobe * light->irradiance[k] >> 12; /* 2^25.4 * 2^32 */
        for (drop[k] = 0; specular[k] >> 32; drop[k]++)
            specular[k] >>= 1;
    }
    uint32_t count = 0;
    for (uint32_t i = 0; i < b->count; i++) {
        struct vec3 n = b->normal[i], l = light->direction, v = b->view[i];
        int32_t nl = fx_dot(n, l) >> 15, nv = fx_dot(n, v) >> 15; /* Q15 */
        if (nl <= 0)
            continue;
        count++;
        nl = fx_min(nl, 32768);
        uint32_t power = 0; /* max(v.r, 0)^n, 1.0 = 2^30 */
        if (2 * (nl * nv >> 15) > fx_dot(l, v) >> 15) {
            /* d = r - v, Q15, shorter than sqrt(2) here: squares below 2^31; v.r = 1 - |d|^2/2 */
            int32_t dx = ((nl * n.x + (1 << 13)) >> 14) - l.x - v.x, dy = ((nl * n.y + (1 << 13)) >> 14) - l.y - v.y,
                    dz = ((nl * n.z + (1 << 13)) >> 14) - l.z - v.z;
            uint32_t half_d2 = fx_square(dx) / 2 + fx_square(dy) / 2 + fx_square(dz) / 2;
            if (half_d2 < 1u << 30) {
                uint32_t y = (30u << 25) - lut_log2((1u << 30) - half_d2); /* -log2(v.r) */
                uint64_t ny = (uint64_t)y * m->exponent >> 16;             /* 2^30 * 2^28 before the shift */
                power = lut_exp2_neg(ny > UINT32_MAX ? UINT32_MAX : (uint32_t)ny);
            }
        }
        for (int k = 0; k < 3; k++) {
            uint64_t f = diffuse[k] + (specular[k] * power >> (30 - drop[k])); /* 2^32 * 2^30; drop <= 14 */
            f = f >> 32 ? UINT32_MAX : f;
            b->radiance[i][k] = fx_add_sat(b->radiance[i][k], fx_sat31((f * (uint32_t)nl) >> 15));
        }
    }
    return count;
}
