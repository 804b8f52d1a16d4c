/*
 * The specular-frame table over a block (Cezner and Havran 2024, eqs. 14-16): with q = (1 - v.r)/2 = (n.a)^2 + (n.b cos theta_d)^2 and
 * s = sin theta_d (block.h),
 *   sin^2 of half of the table's theta_d is q, and its phi_d the azimuth of (n.l - n.v - 2 q n.l, -2 s n.b cos theta_d),
 * the components of the paper's rotated view direction times sin theta_in.
 */
#include "specular_frame.h"
#include "func.h"

/* sin^2(x/2), 1.0 = 2^30, to x. */
static uint32_t angle_of(uint32_t s)
{
    return s <= 1u << 29 ? lut_angle_from_sin2_half(s) : (1u << 28) - lut_angle_from_sin2_half((1u << 30) - s);
}

/* c * 2^e * irradiance, 20 fraction bits, saturating. c < 2^31, irradiance uq16_16. */
static uint32_t contribution(uint32_t c, int32_t e, uq16_16_t irradiance)
{
    uint64_t p = (uint64_t)c * irradiance; /* < 2^63; fraction bits: 16 - e, wanted: 20 */
    int32_t down = -e - 4;
    if (down >= 0)
        p = down > 63 ? 0 : p >> down;
    else
        p = down < -63 || p >> (64 + down) ? UINT64_MAX : p << -down;
    return fx_sat31(p);
}

static uint32_t shade_specular_frame(struct raster_batch *b, uint32_t first, uint32_t end, const struct raster *r,
                                     const struct raster_block_light *light)
{
    const struct lut_table *t = r->frame.tables[r->frame.materials[b->material].slot];
#ifdef RASTER_WIDE
    if (!first && end >= 8)
        return raster_specular_frame_wide(b, end, t, light);
#endif
    struct raster_walk walk = {.y = UINT32_MAX};
    uint32_t lit = 0;
    for (uint32_t i = first; i < end; i++) {
        struct raster_pixel p;
        if (!raster_walk_pixel(&p, &walk, b, light, i, false))
            continue;
        lit++;
        const uint32_t cosine = (uint32_t)fx_min(p.nl, (1 << 30) - 1) << 2;                                    /* Q32 */
        int32_t nl = fx_min(p.nl, 1 << 30), nv = fx_min(b->pixel[i].nv, 1 << 30), sine = (int32_t)p.term << 3; /* Q30 */
        uint32_t q = (uint32_t)(fx_mulhi(p.na, p.na) + fx_mulhi(p.nb, p.nb)), half_in;                         /* Q28 */
        q = q > 1u << 28 ? 1u << 28 : q;
        if (t->swap && nl < nv) { /* a and b change their signs with l and v */
            int32_t swapped = nl;
            nl = nv;
            nv = swapped;
            sine = -sine;
            half_in = (uint32_t)((1 << 30) - nl) >> 1;
        } else { /* |n-l|^2 / 4, at most 2 / 4 */
            half_in = fx_square(lane_low(b->pixel[i].normal_xy) - lane_low(light->l_xy)) / 4 +
                      fx_square(lane_high(b->pixel[i].normal_xy) - lane_high(light->l_xy)) / 4 +
                      fx_square(b->pixel[i].normal_z - light->l_z) / 4;
        }
        int32_t x = nl - nv - (int32_t)(fx_mulhi_u((uint32_t)nl, q << 3) << 2); /* Q30 */
        int32_t y = -fx_mulhi(p.nb, sine) * 8;
        struct lut_rgb f =
            lut_specular_frame_at(t, lut_angle_from_sin2_half(half_in), angle_of(q << 2), lut_turn(y, x));
        for (int k = 0; k < 3; k++)
            b->radiance[i][k] +=
                raster_limited(contribution(fx_mulhi_u(f.c[k] << 10, cosine), f.e - 10, light->colour[k]));
    }
    return lit;
}

static uint32_t specular_frame_term(const struct lut_table *t, uint32_t sine, uint32_t cosine)
{
    (void)t;
    (void)cosine;
    return sine;
}

const struct raster_model raster_specular_frame_model = {.shading = RASTER_SHADE_SPECULAR_FRAME,
                                                         .shade = shade_specular_frame,
                                                         .term = specular_frame_term,
                                                         .scales_b = true,
                                                         .facing = true};
