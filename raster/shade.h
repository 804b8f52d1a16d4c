/*
 * Shading of a region's surfaces of one material in one pass: what shade.c and cells.c share.
 */
#ifndef RASTER_SHADE_H
#define RASTER_SHADE_H

#include "block.h"

/* A region is gone through for each material once for what is shaded pixel by pixel and once by cells, and for all once flat. */
enum pass { PASS_PIXELS, PASS_CELLS, PASS_FLAT };

/* A rate's cell: log2 of its edges, in samples, at most 2. */
struct shading_cell {
    uint8_t x, y;
    bool mean;     /* its meshlets are shaded by their mean normal, not by their first sample's */
    uint32_t mask; /* of sixteen samples: the first cell's, see cells.c */
};

/* Surfaces of one material being shaded, and the region they are in. */
struct shading {
    const struct raster *r;
    struct raster_tile *t;
    uint32_t x0, y0;        /* the tile's first pixel */
    uint32_t width, height; /* of the tile, pixels */
    const struct raster_quality *quality;
    uint32_t material;
    const struct raster_model *model; /* its */
    enum pass pass;
    struct raster_block *block; /* the last one, which may be the next material's or pass's, too */
    uint32_t other;             /* slot of another material or pass that was met, too; 0: none */
    uint8_t format;             /* of a finished value */
    uint32_t least; /* log2 of the smallest block's edge in cells' pass, pixels: that of the largest cell's */
    struct shading_cell cells[RASTER_RATE_FLAT];
};

/* What 4 samples per pixel take, and shading at less than full quality: samples by cells. */
struct raster_cells {
    /* Cells for the quality. */
    void (*choose)(struct shading *o);
    /* A block's samples. */
    void (*gather)(struct shading *o, struct raster_block *k, uint32_t width, uint32_t height,
                   struct raster_stats *stats);
    /* A region at rate flat. */
    void (*flat)(struct shading *o, uint32_t x0, uint32_t y0, struct raster_stats *stats);
    /* The batch's values to where they belong. */
    void (*put)(const struct shading *o, const uint32_t *value);
    /* Each pixel's four samples become one, the tile's pixels. */
    void (*finish)(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                   struct raster_stats *stats);
    void (*choose_lights)(const struct raster *r, struct raster_tile *t, uint32_t count);
    void (*remember)(struct raster_tile *t);
};

/* shade.c: lights the batch, all of the block's, and puts what it shows. */
void raster_flush(const struct shading *o, struct raster_block *k, struct raster_stats *stats);
/*
 * Interpolation turns normals of visible pixels away from the eye, near silhouettes. Tables and microfacets have no value there, and a
 * black pixel beside a bright one would flicker with the least movement: the normal is turned back to where n.v is 1/128.
 */
struct vec3 raster_face_viewer(struct vec3 n, struct vec3 v, int32_t nv);

/* Towards the eye at pixel (x, y) of a block, Q15 with VIEW_PLANE_BITS more. */
static inline struct vec3 block_view(const struct shading *o, const struct raster_block *k, uint32_t x, uint32_t y)
{
    const struct raster_plane *p = k->plane;
    const uint32_t half = 1u << (VIEW_PLANE_BITS - 1);
    if (k->exact) {
        const struct vec3 v = raster_view_vector(o->r, o->x0 + k->x + x, o->y0 + k->y + y);
        return (struct vec3){v.x * (1 << VIEW_PLANE_BITS), v.y * (1 << VIEW_PLANE_BITS), v.z * (1 << VIEW_PLANE_BITS)};
    }
    return (struct vec3){(int32_t)(p[0].base + x * p[0].dx + y * p[0].dy + half),
                         (int32_t)(p[1].base + x * p[1].dx + y * p[1].dy + half),
                         (int32_t)(p[2].base + x * p[2].dx + y * p[2].dy + half)};
}

/* The same so many columns on, where planes hold; of an exact block, which is not as wide, nothing. */
static inline struct vec3 view_after(struct vec3 v, const struct raster_block *k, uint32_t columns)
{
    return (struct vec3){(int32_t)((uint32_t)v.x + columns * k->plane[0].dx),
                         (int32_t)((uint32_t)v.y + columns * k->plane[1].dx),
                         (int32_t)((uint32_t)v.z + columns * k->plane[2].dx)};
}

/* A batch's pixel: the normal of a surface of a slot with that frame, seen from `view`. */
__attribute__((always_inline)) static inline void set_pixel(struct raster_batch_pixel *p, const int16_t frame[9],
                                                            unsigned normal_shift, bool facing, struct raster_surface s,
                                                            struct vec3 view, uint32_t at)
{
    struct vec3 n = raster_eye_normal(frame, normal_shift, &s);
    const struct vec3 v = {view.x >> VIEW_PLANE_BITS, view.y >> VIEW_PLANE_BITS, view.z >> VIEW_PLANE_BITS};
    int32_t nv = fx_dot(n, v);
    if (nv < 1 << 23 && facing) {
        n = raster_face_viewer(n, v, nv);
        nv = fx_max(fx_dot(n, v), 1 << 22);
    }
    n = (struct vec3){fx_clamp_signed(n.x, 16), fx_clamp_signed(n.y, 16), fx_clamp_signed(n.z, 16)};
    p->normal_xy = lanes(n.x, n.y);
    p->normal_z = n.z;
    p->nv = nv;
    p->at = at;
}

/* A tile's, before anything of it is shaded. */
static inline struct shading tile_shading(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect)
{
    return (struct shading){.r = r,
                            .t = t,
                            .x0 = rect->x,
                            .y0 = rect->y,
                            .width = rect->width,
                            .height = rect->height,
                            .format = raster_value_format(r)};
}

static inline void set_material(struct shading *o, uint32_t material)
{
    o->material = o->t->batch.material = material;
    o->model = raster_model_of(&o->r->frame, &o->r->frame.materials[material]);
}

static inline bool waits_for_rows(const struct shading *o, const struct raster_slot *slot)
{
    return o->r->in_rows[slot->material] && o->quality->rate[slot->class_id] == RASTER_RATE_1X1;
}

static inline enum pass pass_of(const struct shading *o, const struct raster_slot *slot)
{
    const unsigned rate = o->quality->rate[slot->class_id];
    return rate == RASTER_RATE_FLAT ? PASS_FLAT : rate == RASTER_RATE_1X1 ? PASS_PIXELS : PASS_CELLS;
}

/* Whether a surface is of the material and pass being shaded. Takes note of others. */
static inline bool is_wanted(struct shading *o, uint32_t slot)
{
    if (!slot)
        return false;
    const struct raster_slot *info = &o->t->slots[slot];
    if (info->material == o->material && pass_of(o, info) == o->pass)
        return true;
    if (!waits_for_rows(o, info))
        o->other = slot;
    return false;
}

/* Where the slot's run from s on ends. */
static inline const struct raster_surface *run_end(const struct raster_surface *s, const struct raster_surface *end)
{
    const uint32_t slot = raster_slot_of(s);
    do
        s++;
    while (s != end && raster_slot_of(s) == slot);
    return s;
}

#endif
