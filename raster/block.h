/*
 * Shading of a block: up to 16 x 16 pixels, aligned to the picture's corner, of one material, by one light at a time.
 *
 * Every model here is a function of n.l, n.v and of the normal's components along two directions that depend on l and v
 * alone: with h = (l+v)/|l+v| and theta_d the angle between l and h,
 *   a = (l-v)/|l-v|, b = (l x v)/|l x v|, orthonormal together with h:   l, v = cos(theta_d) h +- sin(theta_d) a
 *   sin^2 theta_h    = (n.a)^2 + (n.b)^2                                 Blinn-Phong, microfacets, half-vector table
 *   1 - v.r          = 2 ((n.a)^2 + cos^2(theta_d) (n.b)^2)              r the mirror direction of l: Phong, specular frame
 * so that no difference of near-equal numbers, no root and no tangent frame is needed at a pixel, and the lobe's centre keeps
 * its bits. a, b and what else depends on v alone are found at the block's four corners and taken as linear between them
 * (a plane through them by least squares), v itself never as constant.
 *
 * Bound: a block is as large as makes v turn by at most 2^-4 over its edge, and a and b, which turn by that over |l x v|, by at most
 * 1/8. A chord is off by at most 1/8 of the turn's square: v by 2^-11, a and b by 2^-9 of their length, of which planes are made up
 * for the mean. Where |l x v| is too small for any block, and for point lights, every pixel is a block of its own.
 */
#ifndef RASTER_BLOCK_H
#define RASTER_BLOCK_H

#include "internal.h"
#include "quality.h"

/* A quantity at pixel (x, y) of the block: base + x dx + y dy. Two of 16 bits in one word: the carry out of the lower is kept,
 * which is worth one unit of the upper. */
struct raster_plane {
    uint32_t base, dx, dy;
};

#define RASTER_BLOCK_SHIFT  RASTER_REGION_SHIFT /* the largest block's edge is 2^this */
#define RASTER_BLOCK_LIGHTS 4                   /* lights whose planes are kept for a block */
#define VIEW_PLANE_BITS     10                  /* more than Q15 */
#define TERM_D_BITS         16                  /* of the half-vector table's d coordinate */

enum { PLANE_A_XY, PLANE_B_XY, PLANE_AB_Z, PLANE_TERM, PLANE_COUNT };

/* Between l, v and the direction amid them: of theta_d, 1.0 = 2^27. */
struct raster_angle {
    uint32_t sine, cosine;
};

struct raster_block_light {
    struct raster_plane
        plane[PLANE_COUNT]; /* a and b: Q15, x and a.z in the low halves; the term: see term_find, light.c */
    uint32_t l_xy;          /* Q15 */
    int32_t l_z;
    uq16_16_t colour[3];          /* irradiance at the pixels; attenuated for point lights */
    struct raster_angle angle[4]; /* at the block's corners, of planes that are kept */
};

/* What models are evaluated from; see above. */
struct raster_pixel {
    int32_t nl;     /* Q30 */
    int32_t na, nb; /* Q30; b scaled for some models */
    uint32_t term;
};

static inline int32_t lane_low(uint32_t x)
{
    return (int16_t)(uint16_t)x;
}

static inline int32_t lane_high(uint32_t x)
{
    return (int32_t)x >> 16;
}

static inline uint32_t lanes(int32_t low, int32_t high)
{
    return ((uint32_t)low & 0xffff) | (uint32_t)high << 16;
}

/* Walks over a batch: planes at the current row's first pixel. */
struct raster_walk {
    uint32_t row[PLANE_COUNT];
    uint32_t y; /* of the row, UINT32_MAX at first */
};

/* False for a pixel that the light does not reach, unless `behind` asks for those too. |n.l|, |n.a|, |n.b| <= 2^30 (1 + 2^-12) for vectors of Q15 that are of unit
 * length within 2^-13. */
static inline bool raster_walk_pixel(struct raster_pixel *p, struct raster_walk *w, const struct raster_batch *b,
                                     const struct raster_block_light *light, uint32_t i, bool behind)
{
    const struct raster_batch_pixel *n = &b->pixel[i];
    const int32_t nx = lane_low(n->normal_xy), ny = lane_high(n->normal_xy), nz = n->normal_z;
    p->nl = nx * lane_low(light->l_xy) + ny * lane_high(light->l_xy) + nz * light->l_z;
    if (p->nl <= 0 && !behind)
        return false;
    const uint32_t x = n->at & 255, y = n->at >> 8;
    if (y != w->y) {
        w->y = y;
        for (int k = 0; k < PLANE_COUNT; k++)
            w->row[k] = light->plane[k].base + y * light->plane[k].dy;
    }
    const uint32_t a_xy = w->row[PLANE_A_XY] + x * light->plane[PLANE_A_XY].dx;
    const uint32_t b_xy = w->row[PLANE_B_XY] + x * light->plane[PLANE_B_XY].dx;
    const uint32_t ab_z = w->row[PLANE_AB_Z] + x * light->plane[PLANE_AB_Z].dx;
    p->na = nx * lane_low(a_xy) + ny * lane_high(a_xy) + nz * lane_low(ab_z);
    p->nb = nx * lane_low(b_xy) + ny * lane_high(b_xy) + nz * lane_high(ab_z);
    p->term = w->row[PLANE_TERM] + x * light->plane[PLANE_TERM].dx;
    return true;
}

/* (1-x)^m for x = 0..1 by table: with y = 2^shift x, 2^shift the power of two at or above m, nodes stand at
 * y + 2^-5 = 2^(k/16 - 5) (1 + (k%16)/16); linear between, 0 from 16 on. Error below 4e-4 of the peak. shift is 0 for m <= 1. */
#define LOBE_NODES 145
struct raster_lobe {
    uint16_t node[LOBE_NODES]; /* 1.0 = 65535 */
    uint16_t shift;
    uint32_t offset;   /* 2^-5 in x, 1.0 = 2^28 */
    uint32_t exponent; /* m, uq16_16 */
};

/* The same without the table, for m <= 1: there (1-x)^m ends in a kink, or steeper, which nodes would round off. */
uint32_t raster_lobe_exact(const struct raster_lobe *l, uint32_t x);

/* In: m uq16_16, at most 2^12. */
void raster_lobe_setup(struct raster_lobe *l, uint32_t m);

/* 1.0 = 65535 << 15. In: x with 1.0 = 2^28, at most 8. */
static inline uint32_t raster_lobe_at(const struct raster_lobe *l, uint32_t x)
{
    if (!l->shift)
        return raster_lobe_exact(l, x);
    x += l->offset;
    if (x >> (32 - l->shift))
        return 0;
    x <<= l->shift;
    unsigned zeros = fx_clz(x); /* 0 .. 8 */
    x <<= zeros;
    const uint16_t *node = l->node + 16 * (8 - zeros) + (x >> 27 & 15);
    return ((uint32_t)node[0] << 15) - (uint32_t)(node[0] - node[1]) * (x >> 12 & 0x7fff);
}

/* A light adds less than 128 display whites to a pixel, so that 16 of them stay below 2^31 and need no test. */
#define RASTER_LIGHT_LIMIT ((1u << 27) - 1)

static inline uint32_t raster_limited(uint32_t x)
{
    return x < RASTER_LIGHT_LIMIT ? x : RASTER_LIGHT_LIMIT;
}

/* A way of shading a material. Functions are NULL where a model has no use for them. */
struct raster_model {
    /* Adds one light's reflected radiance, at most RASTER_LIGHT_LIMIT, to pixels first .. end-1 of a batch and returns how many of them
     * it reaches. */
    uint32_t (*shade)(struct raster_batch *b, uint32_t first, uint32_t end, const struct raster *r,
                      const struct raster_block_light *light);
    /* The quantity besides a and b that it takes from l and v, at most 2^27. In: sine and cosine of theta_d, 1.0 = 2^27; the table of a
     * measured material. */
    uint32_t (*term)(const struct lut_table *t, uint32_t sine, uint32_t cosine);
    /* The power function that it takes, once a frame. */
    void (*lobe)(struct raster_lobe *l, const struct scene_material *m);
    /* Light that comes from everywhere, after all others, and what follows it. */
    void (*ambient)(struct raster_batch *b, const struct scene_material *m, uq16_16_t exposure);
    /* Whether a material, with its table or power function, takes a slower way under some light: bits of raster.slow. */
    uint32_t (*slow)(const struct raster *r, const struct scene_material *m, const struct raster_lobe *l);
    enum raster_shading shading;
    bool scales_b; /* it takes b cos(theta_d) */
    bool facing;   /* its lobe needs the surface to face the viewer */
};

/* That of a material; NULL: the frame's parts are without, or a measured one has no table. */
const struct raster_model *raster_model_of(const struct raster_frame *f, const struct scene_material *m);

/* Adds kd/pi times an irradiance to what is in the batch, up to `most`. */
void raster_add_ambient(struct raster_batch *b, const struct scene_material *m, uq16_16_t irradiance, uint32_t most);

/* A block being shaded; first, all but `material` are of no block. */
struct raster_block {
    uint32_t x, y;       /* its first pixel in the tile */
    unsigned shift;      /* its edge is 2^shift pixels; 0: planes have no slopes, and are those of a region's middle */
    bool exact;          /* planes do not hold: what they stand for is found at every pixel */
    bool scaled;         /* planes of b are multiplied by cos(theta_d) */
    struct vec3 view[4]; /* towards the eye at its corners (0,0), (e,0), (0,e), (e,e) */
    struct raster_plane plane[3]; /* of their components, Q15 with VIEW_PLANE_BITS more */
    struct raster_block_light light[RASTER_BLOCK_LIGHTS];
    uint32_t ready;    /* bit i: light[i] holds frame light i's planes of a and b */
    uint32_t terms;    /* ... and that of its term for the material, of those that are ready */
    uint32_t material; /* of the last batch */
};

/* gather_wide.c, where RASTER_WIDE: eight pixels of a batch from surfaces of one slot side by side, whose first is at `at`;
 * view as wide as its planes are, at the first pixel. Returns four bits for each pixel whose n.v is below 2^-7. */
uint32_t raster_gather_wide(struct raster_batch_pixel out[8], const struct raster_surface s[8],
                            const struct raster_slot *slot, const int32_t view[3], const struct raster_plane plane[3],
                            uint32_t at);

/* light.c: whether planes hold over the block of 2^shift pixels at (x, y) on the screen under every directional light. */
bool raster_block_regular(const struct raster *r, uint32_t x, uint32_t y, unsigned shift);
/* Sets up another block, or leaves it as it is. In: (x, y) in the tile whose first pixel on the screen is (x0, y0). */
void raster_block_setup(struct raster_block *out, const struct raster *r, uint32_t x0, uint32_t y0, uint32_t x,
                        uint32_t y, unsigned shift, bool exact);
/* Lights the tile's batch, all of the block's, by light `index`. Returns pixels lit. */
uint32_t raster_shade_light(struct raster_tile *t, struct raster_block *block, const struct raster *r, uint32_t x0,
                            uint32_t y0, uint32_t index, const struct raster_model *model);

#endif
