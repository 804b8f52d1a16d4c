/*
 * Quality of shading against its cost: what a budget chooses between, tile by tile, and the steps in which a tile is made so that it can.
 *
 *   raster_tile_begin(r, index, t, &rect, &stats);
 *   for (bool full = true; full;) {
 *       full = raster_tile_draw(r, t, UINT32_MAX, &stats) == RASTER_NO_SLOT;     else every meshlet is drawn
 *       const struct raster_survey *s = raster_tile_survey(r, t, &rect);
 *       for (uint32_t region = 0; region < s->regions; region++)
 *           raster_tile_shade(r, t, &rect, region, &quality, &stats);
 *       if (full)
 *           raster_tile_free_slots(r, t, &rect, &stats);
 *   }
 *   raster_tile_finish(r, t, &rect, &stats);
 *
 * At full quality this is raster_render_tile, bit for bit. A region is one of the tile's squares of 16 x 16 pixels.
 *
 * Rates. At rate 2^x by 2^y all pixels of one meshlet within a cell of that size are shaded once, by their mean normal: homogeneous
 * normals are linear on the screen, so the mean is the interpolated normal of the pixels' centroid. Edges of objects, materials and
 * meshlets stay as sharp as ever. With 4 samples per pixel a cell has at most 4 x 4 of them. The last rate, flat, shades every meshlet once for the whole tile, by its mean normal: whatever the
 * surface is, at most RASTER_SLOTS - 1 evaluations.
 *
 * Taps. How many texels of a half-vector table a pixel and light are evaluated by.
 *
 * What a rung takes, of a class in a tile, with the costs below: for each material and region of it `region`, and for each of its blocks and
 * directional lights `material`; and samples x (sample + lit lights x (lit - taps) + others x dark + point lights x point), and at rates 2x1 to
 * 4x4 parts x part + samples x cell, parts being its meshlets in cells of 4x4. Flat: `flat` a region, and its meshlets x shading.flat. In rows at 1x1:
 * pixels x (sample + lights x lit) + runs x material.
 *
 * What it errs, measured: six models at 320x240, all surfaces alike, samples and squared error of the picture against full quality; mean dE of the
 * models against their measurements in double precision, 0.19 at full quality (report, chapter 8):
 *   rate     1x1   2x1   2x2   4x2   4x4   flat     1x1 by 4 taps   by 1
 *   samples  1     0.59  0.35  0.22  0.14  0.03     1               1
 *   dB       -     35.1  32.1  29.4  27.9  22.0     59.0            48.5
 *   dE       0.19  1.12  1.75  2.34  3.01  8.20     0.23            0.55
 */
#ifndef RASTER_QUALITY_H
#define RASTER_QUALITY_H

#include "raster.h"

enum raster_rate {
    RASTER_RATE_1X1,
    RASTER_RATE_2X1,
    RASTER_RATE_2X2,
    RASTER_RATE_4X2,
    RASTER_RATE_4X4,
    RASTER_RATE_FLAT,
    RASTER_RATE_COUNT
};

/* Texels of a half-vector table that a pixel and light are interpolated between: two nodes along each axis; of the two azimuths the nearer
 * alone; the nearest node. Where raster_parts has fewer_taps. */
enum raster_taps { RASTER_TAPS_8, RASTER_TAPS_4, RASTER_TAPS_1, RASTER_TAPS_COUNT };

#define RASTER_ALL_LIGHTS   255u
#define RASTER_LEAST_LIGHTS 4u /* of the last rung */

struct raster_quality {
    uint8_t rate[RASTER_CLASSES]; /* enum raster_rate, of each of the survey's classes */
    uint8_t lights; /* how many of a tile's lights are evaluated, the strongest first; RASTER_ALL_LIGHTS: all */
    uint8_t taps;   /* enum raster_taps */
};

/* Begins a tile: as raster_render_tile, before its first meshlet. Out: *rect its place on the screen; *stats zero, but for
 * what an empty tile costs. */
void raster_tile_begin(const struct raster *r, uint32_t index, struct raster_tile *t, struct raster_rect *rect,
                       struct raster_stats *stats);

enum raster_drawing {
    RASTER_DRAWN,   /* no meshlet is left */
    RASTER_NO_SLOT, /* the caller is to shade every region, to free the slots and to go on */
    RASTER_MORE     /* as many as asked for are drawn */
};

/* Draws up to `most` meshlets. */
enum raster_drawing raster_tile_draw(const struct raster *r, struct raster_tile *t, uint32_t most,
                                     struct raster_stats *stats);

/* Begins a tile again, with the coarsest level of every object, of a frame with bounds: for a tile whose time does not suffice. */
void raster_tile_restart(const struct raster *r, uint32_t index, struct raster_tile *t);

/* Counts the pixels that wait for their shading, sorted into classes, and finds the lights that may reach them. The result lives in the tile until
 * its slots are freed or it is finished. */
const struct raster_survey *raster_tile_survey(const struct raster *r, struct raster_tile *t,
                                               const struct raster_rect *rect);

/* Shades what waits in a region, after raster_tile_survey. Each region once. Rates but 1x1 and fewer lights than there are need cells among the
 * frame's parts. Surfaces of rate 1x1 that are shaded in rows wait on,
 * for raster_tile_finish or raster_tile_free_slots. */
void raster_tile_shade(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect, uint32_t region,
                       const struct raster_quality *q, struct raster_stats *stats);

/* All regions having been shaded: keeps their colours and frees all slots. */
void raster_tile_free_slots(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                            struct raster_stats *stats);

/* All regions having been shaded: packs the finished pixels, to raster_tile_pixels. */
void raster_tile_finish(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                        struct raster_stats *stats);

/* How a material is shaded: costs and errors go by it. */
enum raster_shading {
    RASTER_SHADE_HALF_VECTOR,
    RASTER_SHADE_SPECULAR_FRAME,
    RASTER_SHADE_LAFORTUNE_PHONG,
    RASTER_SHADE_BLINN_PHONG,
    RASTER_SHADE_METALLIC_ROUGHNESS,
    RASTER_SHADE_DIFFUSE_ROW,     /* in rows, at rate 1x1 only */
    RASTER_SHADE_BLINN_PHONG_ROW, /* likewise */
    RASTER_SHADE_COUNT
};
/* Bits of raster.slow: of Phong's models broad lobes or much light, of half-vector tables those without a re-packed copy or too tall for its
 * loop, and those that may be brighter than it takes. */
#define RASTER_SLOW(shading) (1u << (shading))
#define RASTER_SLOW_BRIGHT   RASTER_SLOW(RASTER_SHADE_COUNT)
static inline enum raster_shading raster_shading_of(const struct raster *r, uint32_t material, enum raster_rate rate)
{
    const enum raster_shading blocks = (enum raster_shading)r->shading[material];
    return rate != RASTER_RATE_1X1 || !r->in_rows[material] ? blocks
           : blocks == RASTER_SHADE_BLINN_PHONG             ? RASTER_SHADE_BLINN_PHONG_ROW
                                                            : RASTER_SHADE_DIFFUSE_ROW;
}

/*
 * What a rate errs, expected: squared 8-bit steps of the displayed pixel, summed over pixels and colours; at most 2^28. Shading a cell by
 * one sample errs by the gradient times the distance from it: gradients are what the last frame of the same surfaces had
 * (raster_memory), a constant where that is not known.
 */
uint32_t raster_class_error(const struct raster_survey *s, uint32_t class_id, enum raster_rate rate);
/* Likewise, of pixels of half-vector tables, whatever their rate: what fewer taps err. In: pixels < 2^26. */
uint32_t raster_taps_error(enum raster_taps taps, uint32_t pixels);

/*
 * What a target takes, in ticks of hal.clock with 4 fraction bits: at most, for scenes without surprises, as measured by make
 * calibrate. One table for each target. A sample's and a part's are below 2^17, all others at most 2^20.
 */
#define RASTER_COST_BITS    4u
#define RASTER_BROAD_PLANES 16u /* pixels' worth of `broad` that it takes for each light's planes, too */
struct raster_costs {
    uint32_t tile;     /* clearing, finishing an empty one */
    uint32_t clear;    /* of that */
    uint32_t meshlet;  /* set-up */
    uint32_t vertex;   /* transform */
    uint32_t triangle; /* one of a meshlet, facing or not */
    uint32_t general;  /* what it takes more in a meshlet too large or too deep for 16-bit coordinates */
    uint32_t facing;   /* ... in one that faces the eye */
    uint32_t row;      /* of a triangle's pixels */
    uint32_t tested;   /* a pixel whose depth is compared */
    uint32_t general_facing, general_row,
        general_tested; /* ... what these take more in a triangle that is large, thin or sharply bent */
    uint32_t survey;    /* a surface counted */
    uint32_t light;     /* a light tried in a survey */
    uint32_t region;    /* gone through, for each material once by pixels and once by cells, with its first block */
    uint32_t flat;      /* gone through at rate flat, once for all materials */
    uint32_t part;      /* a meshlet in a cell of 4 x 4 pixels, where cells are shaded */
    uint32_t cell;      /* what a cell's sample takes more than a pixel's */
    uint32_t finished;  /* a pixel of a surface packed */
    uint32_t run;       /* pixels of surfaces side by side, with background about them, packed */
    uint32_t plan;      /* what is found out after a survey, before rates are chosen */
    uint32_t taps[RASTER_TAPS_COUNT]; /* what a half-vector table takes less, of `lit`, with fewer */
    uint32_t texels
        [RASTER_TAPS_COUNT]; /* what it takes more of that, by so many, where raster.slow says so: from its texels */
    uint32_t bright;         /* ... and on top where it may be brighter than the loop for the re-packed copy takes */
    uint32_t broad;      /* what Phong's models do: with lobes of a power up to 1, or light beyond their loop's range */
    uint32_t slow_point; /* what any of these take more still, under a point light */
    struct raster_shading_cost {
        uint32_t material; /* per region and directional light: planes; in rows: a run of one meshlet */
        uint32_t sample;   /* gathering, tone curve */
        uint32_t lit;      /* under a directional light that reaches it */
        uint32_t dark;     /* ... that does not */
        uint32_t point;    /* under a point light, at most */
        uint32_t flat;     /* a meshlet at rate flat, under RASTER_LEAST_LIGHTS lights of any kind */
    } shading[RASTER_SHADE_COUNT];
};

/* A way of shading in a frame, which has costs. */
static inline struct raster_shading_cost raster_shading_cost_of(const struct raster *r, enum raster_shading shading,
                                                                enum raster_taps taps)
{
    const struct raster_costs *costs = r->frame.costs;
    struct raster_shading_cost c = costs->shading[shading];
    uint32_t more = 0; /* of a light */
    if (shading == RASTER_SHADE_HALF_VECTOR && !(r->slow & RASTER_SLOW(shading))) {
        c.lit -= costs->taps[taps];
    } else if (shading == RASTER_SHADE_HALF_VECTOR) {
        more = costs->texels[RASTER_TAPS_8] + (r->slow & RASTER_SLOW_BRIGHT ? costs->bright : 0);
        c.lit -= costs->texels[RASTER_TAPS_8] - costs->texels[taps];
    } else if (r->slow & RASTER_SLOW(shading)) {
        more = costs->broad;
        c.material += RASTER_BROAD_PLANES * more;
    }
    c.lit += more;
    more += more ? costs->slow_point : 0;
    c.point += more;
    c.flat += RASTER_LEAST_LIGHTS * more;
    return c;
}

/* What a tile is expected to take, at the levels of detail wanted, by its bounds and what was learnt: shading at full quality, and all else. */
struct raster_expected {
    uint32_t shading, besides;
};
struct raster_expected raster_tile_expected(const struct raster *r, uint32_t tile);

/* For raster_frame.bounds: a program that does without budgets is linked without it. */
extern const struct raster_bounds raster_tile_bounds;

/* Of a meshlet at rate flat, under at most RASTER_LEAST_LIGHTS of the frame's directional and `points` point lights: at most; and what a
 * region takes besides for each material that has some, for planes. */
uint32_t raster_flat_cost(const struct raster *r, uint32_t material, uint32_t points);
uint32_t raster_flat_planes(const struct raster *r, uint32_t material);
/* Samples of a class's area at a rate: at most (at rates 1x1 of one sample per pixel, 4x4 and in areas of whole cells this many); and what is
 * likely, for all rates, without light or colour being known. */
uint32_t raster_samples_most(const struct raster *r, const struct raster_survey *s, uint32_t class_id,
                             const struct raster_area *a, enum raster_rate rate);
void raster_samples_likely(uint32_t samples[RASTER_RATE_COUNT], const struct raster *r, const struct raster_survey *s,
                           uint32_t class_id, const struct raster_area *a);

/* log2 of the edge of blocks, pixels, over each of which planes hold: a region's at best; 0: for some pixels there are none, near directions that a
 * light comes from or goes to. And into how many blocks such a region is cut at most at a rate: no smaller than its cells, and exact where planes
 * do not hold. */
unsigned raster_region_planes(const struct raster *r, const struct raster_rect *rect, uint32_t region);
uint32_t raster_region_blocks(const struct raster *r, unsigned planes, enum raster_rate rate);

#endif
