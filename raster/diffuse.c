/*
 * Diffuse materials: kd/pi for every direction. Lights are turned into the meshlet's frame once a run, where the normal is
 * m (U, V, D) - (0, 0, 1), so that n.l = m (U lx + V ly + D lz) - lz.
 */
#include "internal.h"

uint32_t raster_diffuse_colour(uq16_16_t kd, uq16_16_t irradiance)
{
    return fx_sat31((uint64_t)fx_over_pi(kd << 12) * irradiance >> 24); /* 2^26.4 * 2^32 before the shift */
}

static void colour_setup(struct raster_batch *b, const struct raster *r, uint32_t material)
{
    const struct scene_material *m = &r->frame.materials[material];
    for (unsigned i = 0; i < r->frame.light_count; i++)
        for (int k = 0; k < 3; k++)
            b->diffuse_colour[i][k] =
                fx_sat31(2 * (uint64_t)raster_diffuse_colour(m->kd[k], r->lights[i].irradiance[k]));
    b->diffuse_material = material + 1;
}

/* A light in the meshlet's frame, Q15: Q15 times Q14, sums <= sqrt(3) * 2^29. */
static struct vec3 light_local(const int16_t f[9], struct vec3 l)
{
    return (struct vec3){(f[0] * l.x + f[3] * l.y + f[6] * l.z + (1 << 13)) >> 14,
                         (f[1] * l.x + f[4] * l.y + f[7] * l.z + (1 << 13)) >> 14,
                         (f[2] * l.x + f[5] * l.y + f[8] * l.z + (1 << 13)) >> 14};
}

/* max(n.l, 0), Q31: |dot| <= 2^30.01 as |(u,v,d)| < 2^15 and |l| <= 2^15.01, its product with m <= 2^15 below 2^45.1. */
static inline uint32_t cosine(const struct raster_surface *s, unsigned shift, struct vec3 l)
{
    struct raster_normal n = raster_decode_normal(s, shift);
    int32_t dot = n.u * l.x + n.v * l.y + n.d * l.z;
    int32_t nl = (int32_t)(((int64_t)dot * n.m) >> 17) - l.z * 2048; /* Q26 */
    return (uint32_t)fx_max(nl, 0) << 5;
}

static bool is_diffuse(const struct raster *r, const struct scene_material *m)
{
    (void)r;
    return !(m->ks[0] | m->ks[1] | m->ks[2]);
}

static void shade_diffuse_row(struct raster_batch *b, const struct raster *r, const struct raster_slot *slot,
                              const struct raster_surface *s, uint32_t x, uint32_t y, uint32_t count)
{
    (void)x;
    (void)y;
    const unsigned shift = slot->normal_shift, lights = r->frame.light_count;
    if (b->diffuse_material != slot->material + 1u)
        colour_setup(b, r, slot->material);
    for (unsigned i = 0; i < lights; i++) {
        const struct vec3 l = light_local(slot->frame, r->lights[i].v);
        const uint32_t red = b->diffuse_colour[i][0], green = b->diffuse_colour[i][1], blue = b->diffuse_colour[i][2];
        uq12_20_t *out = b->radiance[0], *end = b->radiance[count];
        const struct raster_surface *p = s;
        if (!i) {
            do {
                uint32_t q = cosine(p++, shift, l);
                out[0] = fx_mulhi_u(red, q);
                out[1] = fx_mulhi_u(green, q);
                out[2] = fx_mulhi_u(blue, q);
                out += 3;
            } while (out != end);
        } else {
            do {
                uint32_t q = cosine(p++, shift, l);
                out[0] = fx_add_sat(out[0], fx_mulhi_u(red, q));
                out[1] = fx_add_sat(out[1], fx_mulhi_u(green, q));
                out[2] = fx_add_sat(out[2], fx_mulhi_u(blue, q));
                out += 3;
            } while (out != end);
        }
    }
    if (!lights)
        for (uint32_t i = 0; i < count; i++)
            b->radiance[i][0] = b->radiance[i][1] = b->radiance[i][2] = 0;
}

const struct raster_rows raster_diffuse_rows = {is_diffuse, shade_diffuse_row};
