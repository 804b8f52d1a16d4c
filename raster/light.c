/*
 * Lights of a frame, and of a block: from one light and the corners' view vectors to what block.h's models need.
 */
#include "shade.h"

#include "func.h"
#include "point_light.h"

#define MAX_BLOCK_ANGLE 4 /* 2^-4 radians */
#define LEAST_TRIED     2 /* log2 of the smallest blocks that raster_region_planes looks for: the largest cells */
#define LEAST_CROSS     8 /* of |l x v|, in units of the block's angle */

static size_t align8(size_t bytes)
{
    return (bytes + 7) & ~(size_t)7;
}

static bool has_lobe(const struct raster_frame *f, const struct scene_material *m)
{
    const struct raster_model *model = raster_model_of(f, m);
    return model && model->lobe;
}

size_t raster_light_bytes(const struct raster_frame *f)
{
    uint32_t lobes = 0;
    for (uint32_t i = 0; i < f->scene->header->materials.count; i++)
        lobes += has_lobe(f, &f->materials[i]);
    return align8(f->light_count * sizeof(struct raster_light)) + align8(lobes * sizeof(struct raster_lobe));
}

/* A world direction, Q30, in eye space, Q15. */
static struct vec3 eye_direction(const struct scene_camera *c, const q2_30_t v[3])
{
    int32_t d[3];
    for (int j = 0; j < 3; j++) { /* Q60 */
        int64_t q60 = (int64_t)c->rotation[3 * j] * v[0] + (int64_t)c->rotation[3 * j + 1] * v[1] +
                      (int64_t)c->rotation[3 * j + 2] * v[2];
        d[j] = (int32_t)((q60 + ((int64_t)1 << 44)) >> 45);
    }
    return (struct vec3){d[0], d[1], d[2]};
}

static void add_light(struct raster *r, struct raster_light *out, const struct scene_light *l)
{
    out->radius = l->kind == SCENE_LIGHT_POINT ? l->radius : 0;
    if (out->radius)
        r->frame.parts->point_lights->position(&out->v, r->frame.camera, l->position);
    else
        out->v = eye_direction(r->frame.camera, l->direction);
    for (int j = 0; j < 3; j++) {
        uint64_t e = (uint64_t)l->irradiance[j] * r->frame.output->exposure >> 16;
        out->irradiance[j] = e > UINT32_MAX ? UINT32_MAX : (uint32_t)e;
    }
}

FX_COLD void raster_light_setup(struct raster *r)
{
    const struct raster_frame *f = &r->frame;
    struct raster_light *next = r->lights;
    for (unsigned i = 0; i < f->light_count; i++)
        if (f->lights[i].kind == SCENE_LIGHT_DIRECTIONAL)
            add_light(r, next++, &f->lights[i]);
    r->directional = (uint32_t)(next - r->lights);
    for (unsigned i = 0; i < f->light_count; i++)
        if (f->lights[i].kind != SCENE_LIGHT_DIRECTIONAL)
            add_light(r, next++, &f->lights[i]);

    bool run = f->light_count == r->directional && r->directional <= RASTER_RUN_LIGHTS && !r->sample_shift;
    for (uint32_t i = 0; i < f->scene->header->materials.count; i++) {
        const struct raster_rows *rows = raster_rows_of(f, &f->materials[i]);
        const struct raster_model *model = raster_model_of(f, &f->materials[i]);
        r->in_rows[i] = run && rows && rows->takes(r, &f->materials[i]);
        r->shading[i] = model ? (uint8_t)model->shading : 0;
    }

    uint8_t *end = (uint8_t *)r->lights + align8(f->light_count * sizeof *r->lights);
    r->lobes = (struct raster_lobe *)(void *)end;
    uint8_t count = 0;
    r->slow = 0;
    for (uint32_t i = 0; i < f->scene->header->materials.count; i++) {
        const struct scene_material *m = &f->materials[i];
        const struct raster_model *model = raster_model_of(f, m);
        struct raster_lobe *lobe = NULL;
        if (has_lobe(f, m)) {
            r->lobe_of_material[i] = count;
            lobe = &r->lobes[count++];
            model->lobe(lobe, m);
        }
        if (model && model->slow && f->costs)
            r->slow |= model->slow(r, m, lobe);
    }
}

void raster_lobe_setup(struct raster_lobe *l, uint32_t m)
{
    l->shift = 0;
    while (l->shift < 12 && m > 1u << (16 + l->shift))
        l->shift++;
    l->offset = 1u << 23 >> l->shift;
    l->exponent = m;
    for (uint32_t k = 0; k < LOBE_NODES; k++) {
        uint32_t y = k == LOBE_NODES - 1 ? UINT32_MAX : (16 + k % 16) << 19 << k / 16; /* 1.0 = 2^28; below 16 */
        uint32_t x = (y >> l->shift) - l->offset, power = m ? 0 : 1u << 30;
        if (x < 1u << 28 && m) {
            uint64_t e = (uint64_t)((28u << 25) - lut_log2((1u << 28) - x)) * m >> 16; /* < 2^30 2^12 */
            power = lut_exp2_neg(e > UINT32_MAX ? UINT32_MAX : (uint32_t)e);           /* 1.0 = 2^30 */
        }
        l->node[k] = (uint16_t)(((uint64_t)power * 65535 + (1u << 29)) >> 30);
    }
}

void raster_find_lights(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect)
{
    for (uint32_t i = 0; i < SCENE_MAX_LIGHTS / 32; i++)
        t->light_reaches[i] = 0;
    if (r->directional < r->frame.light_count)
        r->frame.parts->point_lights->find_box(r, t, rect);
    t->light_count = 0;
    for (uint32_t i = 0; i < r->frame.light_count; i++)
        if (i < r->directional ||
            r->frame.parts->point_lights->reaches(&t->m.shading.box, &r->lights[i].v, r->lights[i].radius)) {
            t->light_reaches[i / 32] |= 1u << i % 32;
            t->light_count++;
        }
    t->chosen_count = UINT32_MAX;
}

/* No surface of the tile gets more of it, in any colour. */
static uint32_t light_strength(const struct raster *r, const struct raster_tile *t, uint32_t index)
{
    const struct raster_light *l = &r->lights[index];
    uint32_t most = 0;
    for (int k = 0; k < 3; k++)
        most = l->irradiance[k] > most ? l->irradiance[k] : most;
    if (!l->radius)
        return most;
    return (uint32_t)((uint64_t)most * r->frame.parts->point_lights->attenuation(&t->m.shading.box, &l->v, l->radius) >>
                      30);
}

void raster_choose_lights(const struct raster *r, struct raster_tile *t, uint32_t count)
{
    if (count == t->chosen_count)
        return;
    t->chosen_count = count;
    if (count < t->light_count)
        r->frame.parts->cells->choose_lights(r, t, count);
    else
        __builtin_memcpy(t->light_chosen, t->light_reaches, sizeof t->light_chosen);
}

void raster_strongest_lights(const struct raster *r, struct raster_tile *t, uint32_t count)
{
    uint32_t *strength = t->batch.radiance[0];
    _Static_assert(sizeof t->batch.radiance >= SCENE_MAX_LIGHTS * sizeof *strength, "room for every light");
    for (uint32_t i = 0; i < r->frame.light_count; i++) /* one more: 0 is for those that are out */
        strength[i] = t->light_reaches[i / 32] >> i % 32 & 1 ? fx_add_sat(light_strength(r, t, i), 1) : 0;
    __builtin_memset(t->light_chosen, 0, sizeof t->light_chosen);
    for (; count; count--) {
        uint32_t best = 0;
        for (uint32_t i = 1; i < r->frame.light_count; i++)
            if (strength[i] > strength[best])
                best = i;
        t->light_chosen[best / 32] |= 1u << best % 32;
        strength[best] = 0;
    }
}

uint32_t raster_lobe_exact(const struct raster_lobe *l, uint32_t x)
{
    if (!l->exponent)
        return 65535u << 15;
    if (x >= 1u << 28)
        return 0;
    uint32_t y = (uint32_t)((uint64_t)((28u << 25) - lut_log2((1u << 28) - x)) * l->exponent >> 16); /* < 2^30 */
    uint32_t power = lut_exp2_neg(y) << 1;
    return power < 65535u << 15 ? power : 65535u << 15;
}

uint8_t raster_block_shift(const struct raster_view *v)
{
    /* A pixel's angle is at most 2 step / axis, the step with VIEW_STEP_BITS more bits. */
    uint8_t shift = RASTER_BLOCK_SHIFT;
    while (shift > 0 && (uint64_t)v->step << (shift + 1 + MAX_BLOCK_ANGLE) >> VIEW_STEP_BITS > (uint32_t)v->axis)
        shift--;
    return shift;
}

/* What depends on l and v. */
struct corner {
    int32_t unit[6]; /* a and b, Q15, at most 2^15 + 1 */
};
enum { A_X, A_Y, A_Z, B_X, B_Y, B_Z };

/* (|l+v|/2)^2 and (|l-v|/2)^2, Q30, at least 1: cos^2 and sin^2 of theta_d. Exact but for their last bit, as sums of squares of Q15. */
static inline void squares_find(uint32_t *cosine2, uint32_t *sine2, struct vec3 l, struct vec3 v)
{
    const int32_t lv = fx_dot(l, v), mean = (int32_t)(((uint32_t)fx_dot(l, l) + (uint32_t)fx_dot(v, v)) / 2);
    *cosine2 = (uint32_t)fx_max((mean >> 1) + (lv >> 1), 1); /* <= 2^30 (1 + 2^-12) */
    *sine2 = (uint32_t)fx_max((mean >> 1) - (lv >> 1), 1);
}

/* a b - c d, Q30 to Q15; 2^31 is not reached by unit vectors within 2^-12. */
static inline int32_t cross15(int32_t a, int32_t b, int32_t c, int32_t d)
{
    return (a * b - c * d + (1 << 14)) >> 15;
}

/* h 2^(16-cs) mc to h/(2 cos), Q15. */
static inline int32_t unit15(int32_t h, int32_t mc)
{
    return (fx_mulhi(h * 32, mc) + 8) >> 4;
}

/* x y - z w, Q30, times up, times k, from Q25 to Q15. |x y - z w| up < 2^31, k <= 2^28. */
static inline int32_t cross_unit(int32_t x, int32_t y, int32_t z, int32_t w, int32_t up, int32_t k)
{
    return (fx_mulhi((x * y - z * w) * up, k) + 512) >> 10;
}

static void corner_find(struct corner *out, struct raster_angle *angle, struct vec3 l, struct vec3 v)
{
    uint32_t c2, s2;
    unsigned cs, ss; /* 1/cos = mc 2^-(14+cs), 2^15 cos in 2^(cs-1) .. 2^cs; likewise the sine; cs + ss <= 30 */
    squares_find(&c2, &s2, l, v);
    const int32_t mc = (int32_t)(lut_rsqrt(c2, &cs) >> 1), ms = (int32_t)(lut_rsqrt(s2, &ss) >> 1); /* 2^29 .. 2^30 */
    angle->cosine = fx_mulhi_u(c2 << (32 - 2 * cs), (uint32_t)mc) >> (17 - cs);
    angle->sine = fx_mulhi_u(s2 << (32 - 2 * ss), (uint32_t)ms) >> (17 - ss);
    /* b = l x v / (2 sin cos); |l x v|, Q30, is below 2^(cs+ss+1) */
    const int32_t up = 1 << (30 - cs - ss), k = fx_mulhi(mc, ms), up_c = 1 << (16 - cs);
    const struct vec3 b = {cross_unit(l.y, v.z, l.z, v.y, up, k), cross_unit(l.z, v.x, l.x, v.z, up, k),
                           cross_unit(l.x, v.y, l.y, v.x, up, k)};
    const struct vec3 h = {unit15((l.x + v.x) * up_c, mc), unit15((l.y + v.y) * up_c, mc), /* <= 2^17 */
                           unit15((l.z + v.z) * up_c, mc)};
    out->unit[A_X] = cross15(h.y, b.z, h.z, b.y);
    out->unit[A_Y] = cross15(h.z, b.x, h.x, b.z);
    out->unit[A_Z] = cross15(h.x, b.y, h.y, b.x);
    out->unit[B_X] = b.x;
    out->unit[B_Y] = b.y;
    out->unit[B_Z] = b.z;
}

static uint32_t term_find(const struct raster_model *model, const struct lut_table *t, struct raster_angle a)
{
    return model->term ? model->term(t, a.sine, a.cosine) : 0;
}

/* The largest it may be anywhere in a block. */
FX_NOINLINE static int32_t term_limit(const struct raster_model *model, const struct lut_table *t)
{
    return model->shading == RASTER_SHADE_HALF_VECTOR ? (int32_t)((t->depth - 1) << TERM_D_BITS) - 1 : 1 << 27;
}

FX_NOINLINE static void scale_b(struct corner *c, struct raster_angle angle)
{
    const int32_t k = (int32_t)(angle.cosine >> 12); /* Q15 */
    for (int i = B_X; i <= B_Z; i++)
        c->unit[i] = c->unit[i] * k >> 15;
}

/* A plane by least squares through the values at the corners (0,0), (e,0), (0,e), (e,e), e = 2^shift, kept within lo .. hi at
 * the pixels 0 .. e-1. In: shift >= 1. */
struct slope {
    int32_t base, dx, dy;
};

static inline struct slope slope_fit(int32_t p0, int32_t p1, int32_t p2, int32_t p3, unsigned shift, int32_t lo,
                                     int32_t hi)
{
    const int32_t last = (1 << shift) - 1, down = p3 - p0, across = p1 - p2, half = 1 << shift;
    struct slope s; /* |p| <= 2^28 */
    s.dx = (down + across + half) >> (shift + 1);
    s.dy = (down - across + half) >> (shift + 1);
    s.base = ((p0 + p1 + p2 + p3 + 2) >> 2) - (s.dx + s.dy) * (half >> 1);
    const int32_t least = s.base + last * (fx_min(s.dx, 0) + fx_min(s.dy, 0));
    const int32_t most = s.base + last * (fx_max(s.dx, 0) + fx_max(s.dy, 0));
    if (least < lo)
        s.base += lo - least;
    else if (most > hi)
        s.base += hi - most;
    return s;
}

/* What a's or b's corners (from unit[first] on) are multiplied by, less 1, Q15: a plane through unit vectors is shorter than 1
 * between them, in the middle by (1 - |mean|^2)/2, on average by two thirds of that. */
FX_NOINLINE static int32_t shortfall(const struct corner c[4], int first)
{
    int32_t s = 1 << 30;
    for (int i = first; i < first + 3; i++) {
        const int32_t mean = (c[0].unit[i] + c[1].unit[i] + c[2].unit[i] + c[3].unit[i]) >> 2;
        s -= mean * mean; /* |mean vector| <= 2^15 (1 + 2^-12) */
    }
    return s / 3 >> 15;
}

static inline struct slope slope_of_unit(const struct corner c[4], int i, int32_t k, unsigned shift)
{
    const int32_t p0 = c[0].unit[i], p1 = c[1].unit[i], p2 = c[2].unit[i], p3 = c[3].unit[i];
    return slope_fit(p0 + (p0 * k >> 15), p1 + (p1 * k >> 15), p2 + (p2 * k >> 15), p3 + (p3 * k >> 15), shift, -32767,
                     32767);
}

/* Of two components, multiplied by 1 + k, in the halves of a word. */
FX_NOINLINE static void plane_lanes(struct raster_plane *out, const struct corner c[4], int low, int32_t k_low,
                                    int high, int32_t k_high, unsigned shift)
{
    const struct slope l = slope_of_unit(c, low, k_low, shift), h = slope_of_unit(c, high, k_high, shift);
    *out = (struct raster_plane){(uint32_t)l.base + ((uint32_t)h.base << 16), (uint32_t)l.dx + ((uint32_t)h.dx << 16),
                                 (uint32_t)l.dy + ((uint32_t)h.dy << 16)};
}

FX_NOINLINE static uint32_t unit_lanes(int32_t low, int32_t high)
{
    return lanes(fx_clamp(low, -32767, 32767), fx_clamp(high, -32767, 32767));
}

/* One corner's: no slopes. */
static void planes_constant(struct raster_block_light *out, const struct corner *c)
{
    out->plane[PLANE_A_XY] = (struct raster_plane){unit_lanes(c->unit[A_X], c->unit[A_Y]), 0, 0};
    out->plane[PLANE_B_XY] = (struct raster_plane){unit_lanes(c->unit[B_X], c->unit[B_Y]), 0, 0};
    out->plane[PLANE_AB_Z] = (struct raster_plane){unit_lanes(c->unit[A_Z], c->unit[B_Z]), 0, 0};
}

static void term_constant(struct raster_block_light *out, const struct raster_model *model, const struct lut_table *t,
                          struct raster_angle a)
{
    const uint32_t term = fx_min_u(term_find(model, t, a), (uint32_t)term_limit(model, t));
    out->plane[PLANE_TERM] = (struct raster_plane){term, 0, 0};
}

static void set_direction(struct raster_block_light *out, struct vec3 l)
{
    out->l_xy = unit_lanes(l.x, l.y);
    out->l_z = fx_clamp(l.z, -32767, 32767);
}

/* All but the term's plane. */
static void light_planes(struct raster_block_light *out, const struct raster_light *light,
                         const struct raster_block *block)
{
    const unsigned shift = block->shift;
    struct corner c[4];
    for (int k = 0; k < 3; k++)
        out->colour[k] = light->irradiance[k];
    set_direction(out, light->v);
    for (int i = 0; i < (shift ? 4 : 1); i++)
        corner_find(&c[i], &out->angle[i], light->v, block->view[i]);
    if (!shift) {
        if (block->scaled)
            scale_b(&c[0], out->angle[0]);
        planes_constant(out, &c[0]);
        return;
    }
    const int32_t a = shortfall(c, A_X), b = shortfall(c, B_X);
    for (int i = 0; i < 4 && block->scaled; i++)
        scale_b(&c[i], out->angle[i]);
    plane_lanes(&out->plane[PLANE_A_XY], c, A_X, a, A_Y, a, shift);
    plane_lanes(&out->plane[PLANE_B_XY], c, B_X, b, B_Y, b, shift);
    plane_lanes(&out->plane[PLANE_AB_Z], c, A_Z, a, B_Z, b, shift);
}

static void term_plane(struct raster_block_light *out, const struct raster_model *model, const struct lut_table *t,
                       unsigned shift)
{
    int32_t term[4];
    if (!shift) {
        term_constant(out, model, t, out->angle[0]);
        return;
    }
    for (int i = 0; i < 4; i++)
        term[i] = (int32_t)term_find(model, t, out->angle[i]);
    const struct slope s = slope_fit(term[0], term[1], term[2], term[3], shift, 0, term_limit(model, t));
    out->plane[PLANE_TERM] = (struct raster_plane){(uint32_t)s.base, (uint32_t)s.dx, (uint32_t)s.dy};
}

/* Exactly what a corner has, at every pixel of the batch in turn. Point lights reach with what their distance leaves. */
FX_COLD static uint32_t shade_pixels(struct raster_tile *t, const struct raster *r, uint32_t x0, uint32_t y0,
                                     const struct raster_light *light, const struct raster_model *model,
                                     const struct lut_table *table)
{
    struct raster_batch *b = &t->batch;
    struct raster_block_light out;
    uint32_t lit = 0;
    for (uint32_t i = 0; i < b->count; i++) {
        const struct raster_surface *s = &t->surface[b->surface[i] & 0xffff];
        const uint32_t x = x0 + (b->pixel[i].at & 255), y = y0 + (b->pixel[i].at >> 8);
        uint32_t attenuation = 1u << 30;
        struct vec3 l = light->v;
        struct corner c;
        if (light->radius && !r->frame.parts->point_lights->at(&l, &attenuation, r, light, x, y, s->depth_slot >> 8))
            continue;
        for (int k = 0; k < 3; k++)
            out.colour[k] = (uint32_t)((uint64_t)light->irradiance[k] * attenuation >> 30);
        corner_find(&c, &out.angle[0], l, raster_view_vector(r, x, y));
        term_constant(&out, model, table, out.angle[0]);
        if (model->scales_b)
            scale_b(&c, out.angle[0]);
        planes_constant(&out, &c);
        set_direction(&out, l);
        lit += model->shade(b, i, i + 1, r, &out);
    }
    return lit;
}

uint32_t raster_shade_light(struct raster_tile *t, struct raster_block *block, const struct raster *r, uint32_t x0,
                            uint32_t y0, uint32_t index, const struct raster_model *model)
{
    const struct raster_light *light = &r->lights[index];
    struct raster_batch *b = &t->batch;
    const struct lut_table *table = r->frame.tables[r->frame.materials[b->material].slot]; /* of a measured one */
    if (light->radius || block->exact)
        return shade_pixels(t, r, x0 + block->x, y0 + block->y, light, model, table);
    const uint32_t place = index % RASTER_BLOCK_LIGHTS, kept = index < RASTER_BLOCK_LIGHTS ? 1u << index : 0;
    if (block->material != b->material) {
        block->material = b->material;
        block->terms = 0;
        block->ready = block->scaled == model->scales_b ? block->ready : 0;
        block->scaled = model->scales_b;
    }
    if (!(block->ready & kept))
        light_planes(&block->light[place], light, block);
    if (!(block->ready & block->terms & kept))
        term_plane(&block->light[place], model, table, block->shift);
    block->ready = (block->ready & ~(1u << place)) | kept;
    block->terms = (block->terms & ~(1u << place)) | kept;
    return model->shade(b, 0, b->count, r, &block->light[place]);
}

/* Whether the view at a pixel is turned from every light, and from where it goes to, by the angle of so many pixels: 2 step / axis each. */
static bool is_clear(const struct raster *r, uint32_t x, uint32_t y, uint32_t pixels)
{
    const struct vec3 v = raster_view_vector(r, x, y);
    const uint32_t need =
        fx_min_u((uint32_t)((uint64_t)r->view.step * pixels << 16 >> VIEW_STEP_BITS) / (uint32_t)r->view.axis,
                 1u << 15); /* Q15 */
    for (uint32_t i = 0; i < r->directional; i++) {
        const struct vec3 l = r->lights[i].v;
        uint32_t c2, s2;
        squares_find(&c2, &s2, l, v);
        uint32_t cross2 = fx_mulhi_u(c2, s2); /* |l x v|^2 / 4, 2^28 */
        if (cross2 >> 1 <= need * need >> 5)  /* 2^27 on the left, of a quarter */
            return false;
    }
    return true;
}

bool raster_block_regular(const struct raster *r, uint32_t x, uint32_t y, unsigned shift)
{
    const uint32_t half = 1u << shift >> 1;
    return is_clear(r, x + half, y + half, LEAST_CROSS << shift);
}

unsigned raster_region_planes(const struct raster *r, const struct raster_rect *rect, uint32_t region)
{
    const uint32_t columns = RASTER_REGIONS(rect->width), half = 1u << RASTER_REGION_SHIFT >> 1;
    const uint32_t x = rect->x + (region % columns << RASTER_REGION_SHIFT) + half,
                   y = rect->y + (region / columns << RASTER_REGION_SHIFT) + half;
    for (unsigned shift = r->block_shift; shift >= LEAST_TRIED;
         shift--) /* a block is amid less than 3/4 of an edge away */
        if (is_clear(r, x, y, (LEAST_CROSS << shift) + (shift == RASTER_REGION_SHIFT ? 0 : 12)))
            return shift;
    return 0;
}

void raster_block_setup(struct raster_block *out, const struct raster *r, uint32_t x0, uint32_t y0, uint32_t x,
                        uint32_t y, unsigned shift, bool exact)
{
    const uint32_t middle = shift ? 0 : 1u << RASTER_REGION_SHIFT >> 1;
    if (out->shift == shift && out->x == x && out->y == y && out->exact == exact)
        return;
    out->x = x;
    out->y = y;
    out->shift = shift;
    out->exact = exact;
    out->ready = 0;
    for (uint32_t i = 0; i < (exact ? 0u : shift ? 4u : 1u); i++)
        out->view[i] =
            raster_view_vector(r, x0 + x + middle + ((i & 1) << shift), y0 + y + middle + ((i >> 1) << shift));
    for (int k = 0; k < 3 && !exact; k++) {
        int32_t p[4];
        for (int i = 0; i < (shift ? 4 : 1); i++)
            p[i] = (k == 0 ? out->view[i].x : k == 1 ? out->view[i].y : out->view[i].z) * (1 << VIEW_PLANE_BITS);
        struct slope s =
            shift ? slope_fit(p[0], p[1], p[2], p[3], shift, INT32_MIN, INT32_MAX) : (struct slope){p[0], 0, 0};
        out->plane[k] = (struct raster_plane){(uint32_t)s.base, (uint32_t)s.dx, (uint32_t)s.dy};
    }
}

void raster_add_ambient(struct raster_batch *b, const struct scene_material *m, uq16_16_t irradiance, uint32_t most)
{
    uint32_t ambient[3];
    for (int k = 0; k < 3; k++)
        ambient[k] = raster_diffuse_colour(m->kd[k], irradiance);
    for (uint32_t i = 0; i < b->count; i++)
        for (int k = 0; k < 3; k++)
            b->radiance[i][k] = fx_min_u(fx_add_sat(b->radiance[i][k], ambient[k]), most);
}
