/*
 * What the rasterizer's files share. Not for embedders.
 *
 * Scales. Each object carries its transform in two scales of its own, chosen so that int32 sums never overflow and
 * as many bits as possible survive: w = Z * 2^-scale_w in world units, and half sub-pixels (1/512 px) from the
 * picture's centre are (X * 2^-scale_xy) / w. Both are powers of two, so a vertex shared by two meshlets of an object
 * projects to the same bits whichever path draws it.
 */
#ifndef RASTER_INTERNAL_H
#define RASTER_INTERNAL_H

#include "raster.h"

/* Eight pixels at once, see wide.h. The bits are the same. */
#if defined(__AVX2__)
#define RASTER_WIDE
#endif
/* Loops in assembly for Cortex-M of ARMv7-M and later, bit-equal to the C: half_vector_arm.c, phong_arm.c. */
#if defined(__ARM_FEATURE_UNALIGNED) && defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M' &&                    \
    __ARM_ARCH_ISA_THUMB == 2 && !defined(__ARM_BIG_ENDIAN)
#define RASTER_ARM
#endif

/* Guard band: coordinates within +-2^13 px of the picture's centre, thus within +-(2^13 + 2^12) px of any tile. */
#define GUARD_BITS 13
/* A small meshlet's extent in 24.8: below 63 px, so that coordinates from a tile it touches fit 16 bits. */
#define SMALL_EXTENT (63 * 256)
/* ... and its range of 1/w, which bounds depth gradients. */
#define SMALL_DEPTH (1 << 21)
/*
 * Normals in homogeneous form. A vertex' stereographic coordinates (u, v) times its 1/w are linear on the screen, as 1/w is, and
 * a pixel needs no division by 1/w:
 *   n = (2 u, 2 v, 1-s)/(1+s), u = U/D, v = V/D   =>   n = (2 U m, 2 V m, 2 D m - 1), m = D/(D^2+U^2+V^2),
 * one division that any interpolated normal takes. D is 1/w >> a shift that each meshlet has, so that its largest D has
 * NORMAL_BITS bits: U and V are as precise as Q14 at its nearest vertex and lose a bit where w doubles.
 */
#define INV_W_BITS     24 /* inv_w <= 2^23 */
#define NORMAL_BITS    14
#define VIEW_STEP_BITS 14
/* Keeps an interpolated depth above zero: it errs by less than 320, see make_gradient. A multiple of every D's unit. */
#define DEPTH_BIAS 1024u

#define ROW_BITS 16

struct raster_object {
    int32_t row[3][3]; /* X, Y, W from vertex units, with ROW_BITS fraction bits; |entry| < 2^31 */
    int64_t offset[3]; /* likewise; |sum of a row's products + offset| < 2^(31 + ROW_BITS) */
    int32_t scale_w;
    int32_t shift_xy;    /* 29 + scale_xy - scale_w */
    int32_t shift_depth; /* of the reciprocal, see raster_project */
    int32_t near_w;      /* near plane in W units, rounded up, >= 1 */
    int32_t eye[3];      /* eye in vertex units >> eye_shift, |e| < 2^16 */
    uint8_t eye_shift;
    uint8_t material;
    int16_t rotation[9]; /* eye space from object space, Q14 */
    uint32_t max_error; /* of a level of detail, where the frame's threshold allows it: vertex units, 8 fraction bits */
    uint32_t mesh;
};

/*
 * A tile's list: runs from the newest to the oldest, each of up to RUN_BACK + 1 meshlets of one object and of like flags, whose ids rise
 * by less than 256 from one to the next. From the newest on, ids are found by stepping back.
 */
#define RUN_BITS         4
#define RUN_BACK         8
#define RUN_USED(object) ((object) & ((1u << RUN_BITS) - 1))
struct raster_run {
    uint16_t next;          /* the next older run's index + 1, 0 = end */
    uint16_t object;        /* index << RUN_BITS, plus how many of `back` are used */
    uint32_t meshlet;       /* the newest's id, and VISIBLE_* */
    uint8_t back[RUN_BACK]; /* the last first */
};
#define VISIBLE_MESHLET(m)   ((m)&0x7ffffffu)
#define VISIBLE_SMALL        0x80000000u               /* drawn by small.c */
#define VISIBLE_SHIFT(shift) ((uint32_t)(shift) << 27) /* from inv_w to D, see NORMAL_BITS */
#define VISIBLE_GET_SHIFT(m) ((unsigned)((m) >> 27) & 15)
_Static_assert(SCENE_MAX_OBJECTS << RUN_BITS <= 1u << 16 && RUN_BACK < 1 << RUN_BITS, "objects of runs");
_Static_assert(SCENE_MAX_BYTES / sizeof(struct scene_meshlet) < 1u << 27 && INV_W_BITS - NORMAL_BITS < 16,
               "meshlets of runs");

/* A vertex' normal coordinate in homogeneous form: times D. |u| <= 2^14. */
static inline int32_t raster_homogeneous(int32_t u, uint32_t inv_w, unsigned shift)
{
    return (u * (int32_t)(inv_w >> shift) + (1 << 13)) >> 14;
}

/* A surface's normal in its meshlet's frame is (U m, V m, D m) * 2^-28 - (0, 0, 1). */
struct raster_normal {
    int32_t u, v, d; /* any common multiple, so that 2^28 <= u^2+v^2+d^2 < 2^30 */
    int32_t m;       /* 2^29 d/(d^2+u^2+v^2) within 2^-16 of it: d m <= 2^29.1, |u m|, |v m| <= 2^28.1 */
};
static inline struct raster_normal raster_decode_normal(const struct raster_surface *s, unsigned shift)
{
    /* d: without the slot, rounded to nearest, the depth's bias off, below which an interpolated depth may err. */
    const int32_t offset = (1 << shift >> 1) - (int32_t)DEPTH_BIAS;
    struct raster_normal n = {(int16_t)(s->normal & 0xffff), (int16_t)(s->normal >> 16),
                              ((int32_t)(s->depth_slot >> 8) + offset) >> shift, 0};
    n.d = fx_max(n.d, 64);
    uint32_t den = (uint32_t)(n.d * n.d) + (uint32_t)(n.u * n.u) + (uint32_t)(n.v * n.v); /* 2^12 .. 2^30 */
    unsigned k = (fx_clz(den) - 2) >> 1; /* the same direction, with den in 2^28..2^30 */
    n.u *= 1 << k;
    n.v *= 1 << k;
    n.d *= 1 << k;
    den <<= 2 * k;
    n.m = (int32_t)(((uint32_t)n.d << 17) / ((den + (1 << 11)) >> 12));
    return n;
}

/* A surface's normal in eye space, Q15, rounded down: of unit length by construction, whatever its coordinates were interpolated
 * to. In: its slot's frame and normal_shift. */
static inline struct vec3 raster_eye_normal(const int16_t f[9], unsigned shift, const struct raster_surface *s)
{
    struct raster_normal n = raster_decode_normal(s, shift);
    int32_t x = n.u * n.m, y = n.v * n.m, z = n.d * n.m - (1 << 28); /* Q28: <= 2^28.1 */
    return (struct vec3){(int32_t)(((int64_t)f[0] * x + (int64_t)f[1] * y + (int64_t)f[2] * z) >> 27),
                         (int32_t)(((int64_t)f[3] * x + (int64_t)f[4] * y + (int64_t)f[5] * z) >> 27),
                         (int32_t)(((int64_t)f[6] * x + (int64_t)f[7] * y + (int64_t)f[8] * z) >> 27)};
}

/* transform.c */
void raster_object_setup(struct raster_object *o, const struct raster_frame *f, const struct scene_object *so);
void raster_view_setup(struct raster_view *v, const struct scene_camera *c, uint16_t width, uint16_t height);
/* Towards the eye from the surface seen at pixel (x, y), eye space; unit within 2^-14. */
struct vec3 raster_view_vector(const struct raster *r, uint32_t x, uint32_t y);

/* Vertex to X, Y, W. */
static inline void raster_transform(struct raster_clip_vertex *c, const struct raster_object *o,
                                    const struct scene_vertex *v)
{
    int64_t x = v->x, y = v->y, z = v->z;
    c->x = (int32_t)((o->row[0][0] * x + o->row[0][1] * y + o->row[0][2] * z + o->offset[0]) >> ROW_BITS);
    c->y = (int32_t)((o->row[1][0] * x + o->row[1][1] * y + o->row[1][2] * z + o->offset[1]) >> ROW_BITS);
    c->w = (int32_t)((o->row[2][0] * x + o->row[2][1] * y + o->row[2][2] * z + o->offset[2]) >> ROW_BITS);
    c->u = v->u;
    c->v = v->v;
}

/* Perspective division and snapping to 1/256 px, rounded to nearest. In: w >= near_w, |result| inside the guard band (it
 * is clamped there); centre_x2/y2 = the picture's centre relative to the tile's corner in 1/512 px, plus 1 (rounding). */
void raster_project(struct raster_vertex *p, const struct raster_object *o, const struct raster_clip_vertex *c,
                    int32_t centre_x2, int32_t centre_y2);

/* clip.c: which planes a vertex is outside of. */
enum { CLIP_NEAR = 1, CLIP_LEFT = 2, CLIP_RIGHT = 4, CLIP_TOP = 8, CLIP_BOTTOM = 16 };
#define CLIP_MAX_VERTICES 8 /* 3 + one for each plane */
unsigned raster_clip_code(const struct raster_object *o, const struct raster_clip_vertex *v);
/* Clips the polygon p (count vertices, room for CLIP_MAX_VERTICES) against the planes in `codes`; returns the new count,
 * 0 when nothing is left. An edge shared by two triangles is cut at the same point whichever way it runs. */
unsigned raster_clip_polygon(struct raster_clip_vertex *p, unsigned count, unsigned codes,
                             const struct raster_object *o);

/* small.c: transforms the vertices of a meshlet marked VISIBLE_SMALL, whose box touches the tile; centre as for
 * raster_project, but from the tile's first pixel centre. */
void raster_transform_small(struct raster_small *out, const struct raster_object *o, const struct scene_vertex *v,
                            uint32_t count, unsigned normal_shift, int32_t centre_x2, int32_t centre_y2);
/* Draws the front-facing of `count` triangles. In: vertices within 127 px of the tile's corner, 63 px of each other. */
void raster_draw_small(struct raster_tile *t, const struct raster_small *vertices,
                       const struct scene_triangle *triangles, uint32_t count, uint32_t slot,
                       struct raster_stats *stats);

/* One of them, known to face the eye: clockwise on the screen (y down), area = twice its area in 1/65536 px^2, > 0. */
void raster_fill_small(struct raster_tile *t, const struct raster_small *a, const struct raster_small *b,
                       const struct raster_small *c, uint32_t area, uint32_t slot, struct raster_stats *stats);

/* general.c: draws one triangle when it faces the eye. In: vertices inside the guard band, counter-clockwise as the scene
 * says. */
void raster_draw_general(struct raster_tile *t, const struct raster_vertex *a, const struct raster_vertex *b,
                         const struct raster_vertex *c, uint32_t slot, struct raster_stats *stats);
/* The same for one known to face the eye, as for raster_fill_small. */
void raster_fill_general(struct raster_tile *t, const struct raster_vertex *a, const struct raster_vertex *b,
                         const struct raster_vertex *c, uint64_t area, uint32_t slot, struct raster_stats *stats);

/*
 * With 4 samples per pixel everything up to the surface works on a grid of samples, two by two in a pixel, as if they were pixels:
 * a tile covers a quarter of the area with the same memory.
 */
static inline unsigned raster_sample_shift(const struct raster_frame *f)
{
    return f->samples == 4;
}

static inline uint32_t raster_slot_of(const struct raster_surface *s)
{
    return s->depth_slot & 255;
}

/* Those of four surfaces side by side in a word, the first highest; 128 in each byte that is not `slot`. */
#define EACH_SLOT 0x01010101u
_Static_assert(RASTER_SLOTS <= 128, "slots are told apart by sums of seven bits");
static inline uint32_t raster_four_slots(const struct raster_surface *s)
{
    uint32_t w = s[0].depth_slot; /* what is above its slot is shifted out */
    w = w << 8 | raster_slot_of(&s[1]);
    w = w << 8 | raster_slot_of(&s[2]);
    return w << 8 | raster_slot_of(&s[3]);
}
static inline uint32_t raster_slots_differ(uint32_t four, uint32_t slot)
{
    return ((four ^ slot * EACH_SLOT) + 127 * EACH_SLOT) & 128 * EACH_SLOT;
}
/* The first of four that is not 0. In: there is one. */
static inline uint32_t raster_first_slot(uint32_t four)
{
    return four >> (24 - (fx_clz(four) & 24u));
}
/* Those that differ, others 0. */
static inline uint32_t raster_keep_slots(uint32_t four, uint32_t differs)
{
    return four & (differs - (differs >> 7));
}

/* A finished pixel or sample in its surface's place. */
static inline void raster_put_colour(struct raster_surface *s, uint32_t value)
{
    s->normal = value;
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    *(uint8_t *)&s->depth_slot = 0;
#else
    s->depth_slot &= ~(uint32_t)255;
#endif
}

/* The format in which it is put there: the frame's, but RGB888 where samples will be averaged. */
static inline uint8_t raster_value_format(const struct raster *r)
{
    return r->sample_shift ? RASTER_RGB888 : r->frame.format;
}

typedef uint16_t __attribute__((may_alias)) raster_pixel16; /* two of them in a word of the surface */

/* Finished pixels from the tile's `at`-th on to where its pixels begin; values are `step` words apart. */
static inline void raster_put_pixels(const struct raster *r, struct raster_tile *t, uint32_t at, const uint32_t *value,
                                     uint32_t step, uint32_t count)
{
    if (r->frame.format == RASTER_RGB565) {
        raster_pixel16 *out = (raster_pixel16 *)t->surface + at;
        for (; count; count--, value += step)
            *out++ = (uint16_t)*value;
        return;
    }
    uint8_t *out = (uint8_t *)t->surface + 3 * at;
    for (; count; count--, value += step, out += 3) {
        const uint32_t v = *value;
        out[0] = (uint8_t)v;
        out[1] = (uint8_t)(v >> 8);
        out[2] = (uint8_t)(v >> 16);
    }
}

/* shade.c: shades what waits for it and is not shaded in rows, at full quality. No survey is needed. */
void raster_shade_regions(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                          struct raster_stats *stats);
/* The same, and finishes the tile. */
void raster_shade_tile(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                       struct raster_stats *stats);

/* survey.c: puts what the tile's shading showed into its memory, and forgets the latter. */
void raster_remember(struct raster_tile *t);

/* log2 of the edge of a rate's cells along an axis, samples: 1x1, 2x1, 2x2, 4x2, 4x4, of 4 samples per pixel twice as many and no more than
 * four. Rates but flat. */
static inline uint8_t raster_cell_shift(const struct raster *r, unsigned rate, unsigned axis)
{
    return (uint8_t)fx_min_u((rate + 1 - axis) / 2 + r->sample_shift, 2);
}

/* light.c: bytes of arena for lights and lobes, and filling them; the largest shading block's edge is 2^shift pixels. */
size_t raster_light_bytes(const struct raster_frame *f);
void raster_light_setup(struct raster *r);
uint8_t raster_block_shift(const struct raster_view *v);
/* Finds the lights that may reach a surface of the tile, which has some. */
void raster_find_lights(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect);
/* Chooses the `count` of them that may be strongest, of equals the first ones; the second, where they are more. The tile's batch is empty. */
void raster_choose_lights(const struct raster *r, struct raster_tile *t, uint32_t count);
void raster_strongest_lights(const struct raster *r, struct raster_tile *t, uint32_t count);

/* A way of shading a material in runs, under directional lights: its finished radiance. */
struct raster_rows {
    bool (*takes)(const struct raster *r, const struct scene_material *m);
    /* `count` pixels of one slot, from (x, y) on the screen and s on, into the batch's radiance from its start; at most RASTER_BATCH. */
    void (*shade)(struct raster_batch *b, const struct raster *r, const struct raster_slot *slot,
                  const struct raster_surface *s, uint32_t x, uint32_t y, uint32_t count);
};

/* What may shade the material in rows, or NULL. */
static inline const struct raster_rows *raster_rows_of(const struct raster_frame *f, const struct scene_material *m)
{
    return m->kind == SCENE_MATERIAL_LAFORTUNE_PHONG ? f->parts->diffuse_rows
           : m->kind == SCENE_MATERIAL_BLINN_PHONG   ? f->parts->blinn_phong_rows
                                                     : NULL;
}

/* kd/pi * irradiance with 20 fraction bits, saturated. In: kd uq16_16 <= 1. */
uint32_t raster_diffuse_colour(uq16_16_t kd, uq16_16_t irradiance);

/* tone.c: exposed linear radiance of `count` pixels to finished ones in `format`, each in 32 bits: RGB565, or 0x00BBGGRR for RGB888. In
 * place: out may be where radiance is. */
void raster_finish_pixels(uint32_t *out, uq12_20_t radiance[][3], uint32_t count, uint8_t tone_curve, uint8_t format);
/* tone_wide.c, where RASTER_WIDE: lut_srgb8 of `count` signed values, and of what follows them up to a multiple of eight. */
void raster_srgb_wide(uint8_t code[3 * RASTER_BATCH], const uint32_t *linear, uint32_t count);
/* Display bytes 0x00BBGGRR in `format`. */
uint32_t raster_pack(uint32_t bgr, uint8_t format);
uint32_t raster_background(const struct raster_frame *f, uint8_t format);

#endif
