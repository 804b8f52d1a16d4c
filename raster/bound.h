/*
 * What a tile takes, known before it is drawn: what its budget guarantees, from which number on it can, and how ticks are best dealt out.
 *
 * The guarantee is asked of the coarsest levels of detail alone, triangle by triangle, each counted with its box in the tile: a tile whose
 * share does not suffice for what the threshold wants falls back to them, and shading to the last rung.
 *
 * Of the levels wanted the largest meshlet's drawing is bounded, so that it is known when to fall back. A meshlet says the area A and the
 * perimeter P of its triangles, summed (scene.h). On the screen, at depth w and an angle phi off the view axis, a surface of area a shows at
 * most a (s/w)^2 / cos(phi) pixels^2, and a line of length l at most l (s/w) / cos(phi) pixels, s pixels per unit at depth 1; its box
 * gives the least w, the picture's corner the largest phi. A triangle of area a and perimeter p holds at most a + p/2 + 1 pixel centres
 * (Nosarzewska 1948), in at most p/2 + 1 rows. Hence
 *   pixels tested <= A_px + P_px/2 + T, rows <= P_px/2 + T, and never more than T times the tile's.
 * Where that exceeds a thirty-second of the frame's budget, the meshlet's triangles are counted as those of the coarsest levels are.
 */
#ifndef RASTER_BOUND_H
#define RASTER_BOUND_H

#include "internal.h"
#include "magnitude.h"

/* That a meshlet touches, inclusive. */
struct raster_tiles {
    int32_t x0, y0, x1, y1;
};

/* Of an object, for its meshlets. */
struct raster_extent {
    struct magnitude corner_secant; /* of the frame: 1/cos(phi) at the picture's corner, at most */
    struct magnitude length;        /* pixels per vertex unit, times W */
    uint32_t pixel_cost;            /* of a pixel shaded at full quality, estimated; ticks, 4 fraction bits */
};

/* What bin.c calls, of frames that have it. */
struct raster_bounds {
    /* Before all meshlets. Out: of *e what is the frame's. */
    void (*clear)(struct raster *r, struct raster_extent *e);
    /* Before those of an object, but for the coarsest levels. */
    void (*object)(struct raster_extent *e, const struct raster *r, const struct raster_object *o);
    /* Adds a meshlet, with its VISIBLE_* flags, to the tiles that it touches; e NULL: one of the coarsest levels. In: nearest, the box's
     * least depth in W; whether it may have to be clipped. */
    void (*meshlet)(struct raster *r, const struct raster_extent *e, const struct raster_object *o,
                    const struct scene_meshlet *m, const struct raster_tiles *tiles, int32_t nearest, uint32_t flags,
                    bool cut);
    /* All meshlets being known: sets r->budget_needed. Whether the frame, with levels of detail coarsened `bias` times, is expected to take more
     * than its budget. */
    bool (*too_much)(struct raster *r, uint32_t bias);
};

/* The least tile_budget that the frame can be given: adds to each tile's `least` what it takes besides drawing, once, and returns the mean,
 * rounded up. */
uint32_t raster_min_tile_budget(struct raster *r);

#endif
