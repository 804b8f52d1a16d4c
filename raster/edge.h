/*
 * Exact edges: which columns of each row a triangle covers. Shared by both triangle paths.
 *
 * Coverage follows the Direct3D 11 top-left rule for the snapped 24.8 vertices. An edge from (x0,y0) down to (x1,y1),
 * dy = y1-y0 > 0, meets the centre line of row r at X; the pixels right of it begin at column
 *   ceil((X-128)/256) = ceil(M/dy),  M = ceil(((x0-128) dy + (256 r + 128 - y0) dx) / 256),
 * because ceil(n/(256 d)) = ceil(ceil(n/256)/d). Centres on a left edge belong to the triangle and centres on a right
 * edge do not, so both sides use the same ceil. A step of one row adds exactly dx to M: quotient and remainder of M/dy are
 * carried along, and nothing is ever rounded. Rows follow the same rule vertically: ceil((y-128)/256).
 */
#ifndef RASTER_EDGE_H
#define RASTER_EDGE_H

#include "internal.h"

struct edge {
    int32_t column; /* ceil(M/dy) */
    int32_t rest;   /* in -dy..-1: how far M + dy - 1 is below the next column, minus dy */
    int32_t step, step_rest, dy;
};

static inline int32_t edge_floor_div(int32_t *rest, int32_t n, int32_t d)
{
    int32_t q = n / d, r = n - q * d;
    if (r < 0) {
        q--;
        r += d;
    }
    *rest = r;
    return q;
}

/* In: |m| <= 1.5 * 2^30, |dx| and dy < 2^23, dy > 0. */
static inline void edge_start(struct edge *e, int32_t m, int32_t dx, int32_t dy)
{
    e->column = edge_floor_div(&e->rest, m + dy - 1, dy);
    e->rest -= dy;
    e->step = edge_floor_div(&e->step_rest, dx, dy);
    e->dy = dy;
}

static inline int32_t edge_next(struct edge *e)
{
    int32_t column = e->column;
    e->column += e->step;
    e->rest += e->step_rest;
    if (e->rest >= 0) {
        e->column++;
        e->rest -= e->dy;
    }
    return column;
}

/* First column and number of columns (0 or more) of `rows` rows, cut at the tile. Returns the or of all counts. */
static inline int32_t edge_walk(int32_t *out, int32_t rows, struct edge *left, struct edge *right)
{
    int32_t any = 0;
    for (int32_t *end = out + 2 * rows; out != end; out += 2) {
        int32_t l = fx_max(edge_next(left), 0), n = fx_min(edge_next(right), RASTER_TILE_WIDTH) - l;
        n = fx_max(n, 0);
        any |= n;
        out[0] = l;
        out[1] = n;
    }
    return any;
}

/* First row whose centre is at or below y. */
static inline int32_t edge_first_row(q24_8_t y)
{
    return (y + 127) >> 8;
}

#endif
