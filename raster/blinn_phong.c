/*
 * Blinn-Phong (Blinn 1977) as James 2022 renders it, eq. 1.6 and listing E.1.2:
 *   c = 0.02 kd + sum over lights of (kd max(n.l, 0) + ks max(n.h, 0)^n) c_light,  h = (l + v) / |l + v|,
 * neither normalised nor multiplied by n.l, and clamped to display white. c_light is irradiance/pi here, so that a white
 * diffuse surface looks the same in every model; the ambient light is exposed as the others are. n.h is taken from
 * |n-h|^2 = 2 - 2 n.h: near the lobe's centre the difference keeps its bits, the product would not.
 */
#include "internal.h"
#include "func.h"

/* max(n.h, 0)^exponent, 1.0 = 2^30; 0 for l = -v. */
static uint32_t lobe(struct vec3 n, struct vec3 l, struct vec3 v, uq16_16_t exponent)
{
    const int32_t most = 65535; /* l + v, Q15: two for l = v but for the least bit, so that squares fit */
    struct vec3 h = {fx_clamp(l.x + v.x, -most, most), fx_clamp(l.y + v.y, -most, most),
                     fx_clamp(l.z + v.z, -most, most)};
    uint32_t h2 = fx_square(h.x) / 4 + fx_square(h.y) / 4 + fx_square(h.z) / 4; /* |h/2|^2, 1.0 = 2^30 */
    if (!h2 || fx_dot(n, l) / 2 + fx_dot(n, v) / 2 <= 0)
        return 0;
    unsigned shift;
    int32_t k = (int32_t)(lut_rsqrt(h2, &shift) >> 1); /* 1/|h/2| = k * 2^-(29 + shift) */
    shift += 15;
    int64_t half = (int64_t)1 << (shift - 1);
    /* Q15, shorter than sqrt(2): squares sum to less than 2^31 but for rounding */
    int32_t dx = n.x - (int32_t)((h.x * (int64_t)k + half) >> shift);
    int32_t dy = n.y - (int32_t)((h.y * (int64_t)k + half) >> shift);
    int32_t dz = n.z - (int32_t)((h.z * (int64_t)k + half) >> shift);
    uint32_t half_d2 = fx_square(dx) / 2 + fx_square(dy) / 2 + fx_square(dz) / 2;
    if (half_d2 >= 1u << 30)
        return 0;
    uint32_t y = (30u << 25) - lut_log2((1u << 30) - half_d2); /* -log2(n.h) */
    uint64_t ny = (uint64_t)y * exponent >> 16;                /* 2^30 * 2^28 before the shift */
    return lut_exp2_neg(ny > UINT32_MAX ? UINT32_MAX : (uint32_t)ny);
}

uint32_t raster_shade_blinn_phong(struct raster_batch *b, const struct scene_material *m,
                                  const struct raster_light *light)
{
    uint32_t diffuse[3], specular[3];
    for (int k = 0; k < 3; k++) {
        diffuse[k] = raster_diffuse_colour(m->kd[k], light->irradiance[k]);
        specular[k] = raster_diffuse_colour(m->ks[k], light->irradiance[k]);
    }
    for (uint32_t i = 0; i < b->count; i++) {
        struct vec3 n = b->normal[i];
        uint32_t nl = (uint32_t)fx_clamp(fx_dot(n, light->direction), 0, 1 << 30);
        uint32_t power = lobe(n, light->direction, b->view[i], m->exponent);
        for (int k = 0; k < 3; k++) { /* 2 * 2^31 * 2^30 */
            uint32_t c = fx_sat31(((uint64_t)diffuse[k] * nl + (uint64_t)specular[k] * power) >> 30);
            b->radiance[i][k] = fx_add_sat(b->radiance[i][k], c);
        }
    }
    return b->count;
}

void raster_finish_blinn_phong(struct raster_batch *b, const struct scene_material *m, uq16_16_t exposure)
{
    uint32_t ambient[3];
    for (int k = 0; k < 3; k++)
        ambient[k] = raster_diffuse_colour(m->kd[k], fx_mulhi_u(exposure, 269860937)); /* 0.02 pi */
    for (uint32_t i = 0; i < b->count; i++)
        for (int k = 0; k < 3; k++) {
            uint32_t c = fx_add_sat(b->radiance[i][k], ambient[k]);
            b->radiance[i][k] = c > 1u << 20 ? 1u << 20 : c;
        }
}
