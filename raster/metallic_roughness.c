/*
 * Metallic-roughness as James 2022 renders it (section 2.2): with alpha = roughness^2, F0 = mix(0.04, base colour, metalness),
 *   f = D V F + (1 - F) (1 - metalness) base colour / pi, and an ambient light of 0.05 base colour;
 *   D = alpha^2 / (pi ((n.h)^2 (alpha^2 - 1) + 1)^2)                        (GGX: Walter et al. 2007)
 *   V = 1 / (2 mix(2 n.l n.v, n.l + n.v, alpha))                            (Hammon 2017)
 *   F = F0 + (1 - F0) (1 - l.h)^5                                           (Schlick 1994)
 * (n.h)^2 is 1 - sin^2 theta_h, so that D's denominator is alpha^2 + sin^2 theta_h (1 - alpha^2); (1 - l.h)^5 is the block's term.
 */
#include "block.h"

struct material {
    uint32_t a2;      /* alpha^2, Q28 */
    uint32_t a2_rest; /* 1 - alpha^2, Q32 */
    uint32_t alpha;   /* Q16 */
    uint32_t k;       /* alpha^2/(2 pi) = k 2^-k_down, 2^31 <= k < 2^32 */
    int32_t k_down;
    uint32_t f0[3], rest[3]; /* F0 and 1 - F0 times irradiance: times 2^colour_up, Q31 */
    int32_t colour_up;
    uint32_t diffuse[3]; /* what it reflects for n.l = 1 and F = F0, 20 fraction bits */
};

static void material_setup(struct material *o, const struct scene_material *m, const uq16_16_t irradiance[3])
{
    o->alpha = (uint32_t)((uint64_t)m->roughness * m->roughness >> 16); /* 2^6 .. 2^16 */
    uint64_t a2 = (uint64_t)o->alpha * o->alpha;                        /* Q32, 2^12 .. 2^32 */
    o->a2 = (uint32_t)(a2 >> 4);
    o->a2_rest = (uint32_t)(((uint64_t)1 << 32) - a2 < UINT32_MAX ? ((uint64_t)1 << 32) - a2 : UINT32_MAX);
    uint64_t k = a2 * 2734261102u; /* 2^34 / (2 pi): below 2^64 */
    o->k_down = 34;
    while (!(k >> 63)) {
        k <<= 1;
        o->k_down++;
    }
    o->k = (uint32_t)(k >> 32); /* a2 2^-32 2734261102 2^-34 = k 2^32 2^-66 */
    uint32_t largest = irradiance[0] | irradiance[1] | irradiance[2] | 1;
    int32_t lead = (int32_t)fx_clz(largest);
    o->colour_up = 16 - lead;
    for (int i = 0; i < 3; i++) {
        uint32_t e = irradiance[i] << lead >> 1; /* Q31 */
        uint32_t f0 =
            2621 + (uint32_t)(((int64_t)((int32_t)m->kd[i] - 2621) * (int32_t)m->metalness) >> 16); /* Q16, 0.04 */
        o->f0[i] = (uint32_t)((uint64_t)e * f0 >> 16);
        o->rest[i] = e - o->f0[i];
        uint32_t albedo = (uint32_t)((uint64_t)m->kd[i] * ((1 << 16) - m->metalness) >> 16);
        o->diffuse[i] = raster_diffuse_colour((uint32_t)((uint64_t)albedo * ((1 << 16) - f0) >> 16), irradiance[i]);
    }
}

static uint32_t shade_metallic_roughness(struct raster_batch *b, uint32_t first, uint32_t end, const struct raster *r,
                                         const struct raster_block_light *light)
{
    struct material m;
    uint32_t lit = 0;
    material_setup(&m, &r->frame.materials[b->material], light->colour);
    struct raster_walk walk = {.y = UINT32_MAX};
    for (uint32_t i = first; i < end; i++) {
        struct raster_pixel p;
        if (!raster_walk_pixel(&p, &walk, b, light, i, false))
            continue;
        lit++;
        /* below 1, so that n.l + n.v stays above 2 n.l n.v */
        const uint32_t nl = (uint32_t)fx_min(p.nl, (1 << 30) - 1), nv = (uint32_t)fx_min(b->pixel[i].nv, (1 << 30) - 1);
        uint32_t s2 = (uint32_t)(fx_mulhi(p.na, p.na) + fx_mulhi(p.nb, p.nb)); /* Q28, <= 2^28.01 */
        uint32_t q = m.a2 + fx_mulhi_u(s2, m.a2_rest) + 1;                     /* Q28, >= 2^8 */
        uint32_t both = fx_mulhi_u(nl << 1, nv << 1) << 1;                     /* 2 n.l n.v, Q30 */
        uint32_t mix =
            both + (uint32_t)(((uint64_t)(nl + nv - both) * m.alpha) >> 16) + 1; /* Q30; n.l + n.v >= 2 n.l n.v */
        unsigned zq = fx_clz(q), zm = fx_clz(mix);
        q <<= zq;
        uint32_t w = fx_mulhi_u(fx_mulhi_u(q, q), mix << zm) >> 16; /* 2^13 .. 2^16: 1/(q^2 mix) = 1/w 2^(6+2 zq+zm) */
        uint32_t d =
            fx_mulhi_u(fx_mulhi_u(m.k, nl << 2), UINT32_MAX / w << 13); /* D V n.l = d 2^(2 zq + zm - 7 - k_down) */
        int32_t down = fx_max(m.k_down - 14 - m.colour_up - (int32_t)(2 * zq + zm), -30); /* to 20 fraction bits */
        uint32_t diffuse_left = fx_mulhi_u(nl << 2, UINT32_MAX - (p.term << 5)); /* (1 - (1 - l.h)^5) n.l, Q32 */
        for (int k = 0; k < 3; k++) {
            uint32_t s = fx_mulhi_u(d, m.f0[k] + fx_mulhi_u(m.rest[k], p.term << 5));
            if (down >= 0)
                s = down > 31 ? 0 : s >> down;
            else
                s = s >> (31 + down) ? INT32_MAX : s << -down;
            s = s < INT32_MAX ? s : INT32_MAX;
            b->radiance[i][k] += raster_limited(s + fx_mulhi_u(m.diffuse[k], diffuse_left));
        }
    }
    return lit;
}

/* Schlick's (1 - l.h)^5, Q27. */
static uint32_t schlick_term(const struct lut_table *t, uint32_t sine, uint32_t cosine)
{
    (void)t;
    (void)sine;
    uint32_t x = (1u << 27) - fx_min_u(cosine, 1u << 27);
    uint32_t x2 = fx_mulhi_u(x << 4, x << 1), x4 = fx_mulhi_u(x2 << 4, x2 << 1);
    return fx_mulhi_u(x4 << 4, x << 1);
}

static void metallic_ambient(struct raster_batch *b, const struct scene_material *m, uq16_16_t exposure)
{
    raster_add_ambient(b, m, fx_mulhi_u(exposure, 674652343), INT32_MAX); /* 0.05 pi */
}

const struct raster_model raster_metallic_roughness_model = {.shading = RASTER_SHADE_METALLIC_ROUGHNESS,
                                                             .shade = shade_metallic_roughness,
                                                             .term = schlick_term,
                                                             .ambient = metallic_ambient,
                                                             .facing = true};
