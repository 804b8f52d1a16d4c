/*
 * Blinn-Phong for exponents 2, 4, ... 64, a run of pixels at a time: the comparison frame's kernel.
 *
 * r is the ray towards the eye in the unit that raster_view has, p = |r|, v = r/p. No direction is normalised:
 *   (n.h)^2 = (n.l + n.v)^2 / |l+v|^2 = (p n.l + n.r)^2 / (2 p (p + l.r)),
 * one 32-bit division; the exponent's half is reached by squaring. l.r is linear along a row.
 * Errors: the lobe within 2^-9 at exponents up to 32 and 2^-8 at 64, but for lights within 14 degrees of opposite to the view, where h
 * loses bits; lobes below 2^-16 count as nothing.
 */
#include "internal.h"
#include "func.h"

#define MAX_SQUARINGS 5
#define MIN_AXIS      (1 << 14) /* rays at most three times as long as the axis, see ray_length */
#define WHITE         (1u << 20)
#define SHRINK_BITS   9          /* SHRINK = 1 / (1 + 2^-9) */
#define MAX_LIGHT     (1u << 25) /* 32 display whites */

/* log2(exponent / 2), or more than MAX_SQUARINGS. */
static uint32_t squarings_of(uq16_16_t exponent)
{
    return exponent >= 2 << 16 && !(exponent & (exponent - 1)) ? 14 - fx_clz(exponent) : MAX_SQUARINGS + 1;
}

static bool takes_exponent(const struct raster *r, const struct scene_material *m)
{
    return squarings_of(m->exponent) <= MAX_SQUARINGS && r->view.axis >= MIN_AXIS;
}

struct run_light {
    struct vec3 l; /* eye space, Q15 */
    int32_t row;   /* l.r but for r's x component, and a little more lest p + l.r be 0 for l = -v */
    int32_t e[3];  /* irradiance/pi, 22 fraction bits, <= MAX_LIGHT << 2 */
};

struct run {
    const struct raster_slot *slot;
    const struct raster_surface *s, *end;
    int32_t fine_x; /* r's x component at the first pixel, negated, with VIEW_STEP_BITS fraction bits */
    int32_t step;
    int32_t y, z; /* r's other components */
    uint32_t squarings;
    uint32_t kd[3], ks[3]; /* 1.0 = 2^32 - 1 and 2^30 */
    uint32_t ambient;      /* 20 fraction bits */
    const struct run_light *lights_end;
    struct run_light light[RASTER_RUN_LIGHTS];
};

/* The same number, of which the compiler knows nothing: not that it is the half of a 64-bit product, which it would go on to multiply
 * as such, nor that what follows could be computed earlier. */
static inline uint32_t narrow(uint32_t x)
{
    __asm__("" : "+r"(x));
    return x;
}

/* sqrt(w) * 2^15, relative error below 2^-16. In: w in axis^2 .. 9 axis^2, slope = 2^32 * 0.268 / axis: a chord that is within 7 %,
 * then two of Heron's steps, of which the last keeps its half. */
static inline uint32_t ray_length(uint32_t w, uint32_t start, uint32_t slope)
{
    uint32_t g = start + fx_mulhi_u(w, slope);
    g = (g + w / g) >> 1;
    return (g + w / g) << 14; /* < 2^31 */
}

/* (n.h)^exponent * SHRINK^(exponent / 2), 1.0 = 2^32. In: 16 num/den = (n.h)^2 * SHRINK but for rounding, below 1 however inexact
 * the scene's unit vectors are. */
static inline uint32_t lobe(uint32_t num, uint32_t den, uint32_t squarings)
{
    uint32_t p = 32767u << 17;
    if (num < den >> 4) { /* else l is near -v, where h has few bits, and den may be 0: no more than 1 */
        const unsigned z = fx_clz(den);
        p = fx_min_u((num << 3 << z) / (den << z >> 16), 32767) << 17;
    }
    switch (squarings) {
    case 5:
        p = narrow(fx_mulhi_u(p, p)); /* fall through */
    case 4:
        p = narrow(fx_mulhi_u(p, p)); /* fall through */
    case 3:
        p = narrow(fx_mulhi_u(p, p)); /* fall through */
    case 2:
        p = narrow(fx_mulhi_u(p, p)); /* fall through */
    case 1:
        p = narrow(fx_mulhi_u(p, p)); /* fall through */
    default:
        return p;
    }
}

/* 20 fraction bits in d, 22 in s, which with 16 lights of MAX_LIGHT are below 2^29 and 2^31. */
static inline uq12_20_t reflected(uint32_t kd, uint32_t d, uint32_t ks, uint32_t s)
{
    uint32_t sum = (uint32_t)(((uint64_t)kd * d + (uint64_t)ks * s) >> 32);
    return sum < WHITE ? sum : WHITE;
}

/* `coloured`: whether a light is not white. Compiled once for each. */
__attribute__((always_inline)) static inline void run_shade(uq12_20_t *out, const struct run *run, const bool coloured)
{
    const uint32_t yz = (uint32_t)(run->y * run->y) + (uint32_t)(run->z * run->z);
    const uint32_t start = (uint32_t)run->z * 52691u >> 16, slope = 1151051235u / (uint32_t)run->z; /* 0.804, 0.268 */
    /* lobe <= 2^-16 where (n.h)^2 / 16 <= 2^-negligible */
    const uint32_t negligible = (run->squarings < MAX_SQUARINGS ? 16u >> run->squarings : 1) + 4;
    const unsigned normal_shift = run->slot->normal_shift;
    int32_t fine_x = run->fine_x;
    for (const struct raster_surface *s = run->s; s != run->end; s++, out += 3, fine_x += run->step) {
        struct vec3 n = raster_eye_normal(run->slot->frame, normal_shift, s);
        int32_t rx = fine_x >> VIEW_STEP_BITS;
        int32_t p = (int32_t)ray_length((uint32_t)(rx * rx) + yz, start, slope);
        uint32_t p2 = ((uint32_t)p << 1) + ((uint32_t)p >> (SHRINK_BITS - 1)); /* 2 p / SHRINK */
        int32_t nr = (n.y * run->y + n.z * run->z - n.x * rx) >> 2;            /* |n.r| <= 2^30.8; 2^13 */
        uint32_t d0 = run->ambient, d1 = d0, d2 = d0;                          /* diffuse light, 20 fraction bits */
        uint32_t s0 = 0, s1 = 0, s2 = 0;                                       /* in the lobes, 22 */
        for (const struct run_light *l = run->light; l != run->lights_end; l++) {
            int32_t nl = fx_dot(n, l->l);
            uint32_t x = (uint32_t)fx_max(fx_mulhi(nl, p) + nr, 0); /* p n.l + n.r, 2^13: < 2^29.8 */
            uint32_t num = fx_mulhi_u(x, x);                        /* its square / 2^6 */
            uint32_t den =
                fx_mulhi_u(p2, (uint32_t)p + (uint32_t)l->row - (uint32_t)(l->l.x * rx)); /* p (p + l.r) / 2 / SHRINK */
            int32_t lambert = fx_max(nl, 0);
            d0 += (uint32_t)fx_mulhi(lambert, l->e[0]);
            if (coloured) {
                d1 += (uint32_t)fx_mulhi(lambert, l->e[1]);
                d2 += (uint32_t)fx_mulhi(lambert, l->e[2]);
            }
            if (num <= den >> negligible)
                continue;
            uint32_t power = lobe(narrow(num), narrow(den), run->squarings);
            s0 += fx_mulhi_u((uint32_t)l->e[0], power);
            if (coloured) {
                s1 += fx_mulhi_u((uint32_t)l->e[1], power);
                s2 += fx_mulhi_u((uint32_t)l->e[2], power);
            }
        }
        out[0] = reflected(run->kd[0], d0, run->ks[0], s0);
        out[1] = reflected(run->kd[1], coloured ? d1 : d0, run->ks[1], coloured ? s1 : s0);
        out[2] = reflected(run->kd[2], coloured ? d2 : d0, run->ks[2], coloured ? s2 : s0);
    }
}

static void run_colour_setup(struct raster_batch *b, const struct raster *r, uint32_t material)
{
    b->diffuse_material = material + 1;
    for (unsigned i = 0; i < r->frame.light_count; i++)
        for (int k = 0; k < 3; k++) {
            uint32_t e = raster_diffuse_colour(1 << 16, r->lights[i].irradiance[k]);
            b->diffuse_colour[i][k] = e < MAX_LIGHT ? e : MAX_LIGHT;
        }
}

static void shade_blinn_phong_row(struct raster_batch *b, const struct raster *r, const struct raster_slot *slot,
                                  const struct raster_surface *s, uint32_t x, uint32_t y, uint32_t count)
{
    const struct scene_material *m = &r->frame.materials[slot->material];
    const struct raster_view *v = &r->view;
    struct run run;
    if (b->diffuse_material != slot->material + 1u)
        run_colour_setup(b, r, slot->material);
    run.slot = slot;
    run.s = s;
    run.end = s + count;
    run.fine_x = (2 * (int32_t)x + 1 - r->frame.width) * v->step;
    run.y = ((2 * (int32_t)y + 1 - r->frame.height) * v->step) >> VIEW_STEP_BITS;
    run.z = v->axis;
    run.step = 2 * v->step;
    run.squarings = squarings_of(m->exponent);
    run.ambient = fx_mulhi_u(r->frame.output->exposure, 1374389535); /* 0.02 * 2^4 */
    uint32_t grown = (1u << 31) + (1u << (31 - SHRINK_BITS)); /* SHRINK^-(exponent/2), 1.0 = 2^31, at most 1.065 */
    for (uint32_t i = 0; i < run.squarings; i++)
        grown = fx_mulhi_u(grown, grown) << 1;
    for (int k = 0; k < 3; k++) {
        run.kd[k] = (m->kd[k] << 16) - (m->kd[k] >> 16);
        run.ks[k] = fx_mulhi_u(m->ks[k] << 15, grown);
    }
    run.lights_end = run.light + r->frame.light_count;
    uint32_t coloured = 0;
    struct run_light *l = run.light;
    for (uint32_t i = 0; l != run.lights_end; i++, l++) {
        const uint32_t *e = b->diffuse_colour[i];
        l->l = r->lights[i].v;
        l->row = l->l.y * run.y + l->l.z * run.z + 2048; /* 2^15 * 2^15.8 */
        for (int k = 0; k < 3; k++)
            l->e[k] = (int32_t)(e[k] << 2);
        coloured |= (e[0] ^ e[1]) | (e[0] ^ e[2]);
    }
    if (coloured)
        run_shade(b->radiance[0], &run, true);
    else
        run_shade(b->radiance[0], &run, false);
}

const struct raster_rows raster_blinn_phong_rows = {takes_exponent, shade_blinn_phong_row};
