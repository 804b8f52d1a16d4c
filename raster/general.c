/*
 * The general triangle path: any size and shape. Edges are set up in 64 bits, attributes come from barycentric weights per pixel,
 * exact edge values over the area. Chosen by the triangle and never by the tile, as the small path is, so that tiles of any
 * size agree.
 */
#include "edge.h"

struct spans {
    int32_t first_row, rows; /* inside the tile; rows = 0: nothing to draw */
};

/*
 * In: a above b, both relative to the tile; row inside the tile. Coordinates are within +-(2^13 + 2^12) px < 2^22, so
 * products stay below 2^45. |M| beyond 2^30 is clamped to 1.5 * 2^30: over a tile it moves by at most 63 |dx| < 2^29, and
 * no column of the tile reaches 64 dy <= 2^29 either, so the edge lies wholly on one side whatever the exact value.
 */
static void start(struct edge *e, const struct raster_vertex *a, const struct raster_vertex *b, int32_t row)
{
    const int32_t far = 3 << 29;
    int32_t dx = b->x - a->x, dy = b->y - a->y;
    int64_t n = (int64_t)(a->x - 128) * dy + (int64_t)(256 * row + 128 - a->y) * dx;
    n = (n + 255) >> 8;
    edge_start(e, n > 1 << 30 ? far : n < -(1 << 30) ? -far : (int32_t)n, dx, dy);
}

/* Fills t->m.spans. In: a, b, c clockwise on the screen (y down). */
static struct spans triangle_spans(struct raster_tile *t, const struct raster_vertex *a, const struct raster_vertex *b,
                                   const struct raster_vertex *c)
{
    struct spans s = {0, 0};
    /* Turn the triangle so that a is on top: then b follows on the right side and c on the left. */
    const struct raster_vertex *swap;
    if (b->y < a->y || c->y < a->y) {
        swap = a;
        if (b->y <= c->y)
            a = b, b = c, c = swap;
        else
            a = c, c = b, b = swap;
    }
    const struct raster_vertex *middle = b->y < c->y ? b : c, *bottom = b->y < c->y ? c : b;
    int32_t r0 = fx_max(edge_first_row(a->y), 0), r1 = edge_first_row(middle->y);
    int32_t r2 = fx_min(edge_first_row(bottom->y), RASTER_TILE_HEIGHT);
    if (r2 <= r0)
        return s;
    s.first_row = r0;
    s.rows = r2 - r0;
    struct edge left, right;
    int32_t upper = fx_clamp(r1 - r0, 0, s.rows);
    if (upper > 0) { /* both sides start at a */
        start(&left, a, c, r0);
        start(&right, a, b, r0);
        edge_walk(t->m.spans, upper, &left, &right);
    }
    if (upper < s.rows) { /* below the middle vertex one side changes its edge */
        int32_t row = r0 + upper;
        if (middle == b) {
            start(&right, b, c, row);
            if (!upper)
                start(&left, a, c, row);
        } else {
            start(&left, c, b, row);
            if (!upper)
                start(&right, a, b, row);
        }
        edge_walk(t->m.spans + 2 * upper, s.rows - upper, &left, &right);
    }
    return s;
}

/* n/area in Q29 for 0 <= n <= area: n << lead < 2^64. */
static inline uint32_t weight(int64_t n, unsigned lead, uint32_t recip)
{
    uint32_t w = fx_mulhi_u((uint32_t)((uint64_t)n << lead >> 32), recip);
    return w > 1u << 29 ? 1u << 29 : w;
}

/* a + wb (b-a) + wc (c-a), weights Q29, rounded. |differences| <= 2^23. */
static inline int32_t blend(int32_t a, int32_t db, int32_t dc, uint32_t wb, uint32_t wc)
{
    return a + (int32_t)(((int64_t)db * (int32_t)wb + (int64_t)dc * (int32_t)wc + (1 << 28)) >> 29);
}

void raster_fill_general(struct raster_tile *t, const struct raster_vertex *a, const struct raster_vertex *b,
                         const struct raster_vertex *c, uint64_t area, uint32_t slot, struct raster_stats *stats)
{
    struct spans s = triangle_spans(t, a, b, c);
    if (!s.rows)
        return;
    uint32_t hi = (uint32_t)(area >> 32);
    unsigned lead = hi ? fx_clz(hi) : 32 + fx_clz((uint32_t)area);
    uint32_t recip = fx_recip((uint32_t)(area << lead >> 32));
    int64_t dx1 = b->x - a->x, dy1 = b->y - a->y, dx2 = c->x - a->x, dy2 = c->y - a->y; /* < 2^23 */
    int32_t db = (int32_t)(b->inv_w - a->inv_w), dc = (int32_t)(c->inv_w - a->inv_w);
    for (int32_t i = 0; i < s.rows; i++) {
        int32_t row = s.first_row + i, left = t->m.spans[2 * i], count = t->m.spans[2 * i + 1];
        int64_t px = 256 * left + 128 - a->x, py = 256 * row + 128 - a->y;
        int64_t nb = px * dy2 - py * dx2, nc = py * dx1 - px * dy1; /* both >= 0 where covered, sum <= area < 2^47 */
        struct raster_surface *p = t->surface + row * RASTER_TILE_WIDTH + left;
        stats->tested += (uint32_t)count;
        for (struct raster_surface *end = p + count; p != end; p++, nb += 256 * dy2, nc -= 256 * dy1) {
            uint32_t wb = weight(nb, lead, recip), wc = weight(nc, lead, recip);
            uint32_t inv_w = (uint32_t)blend((int32_t)a->inv_w, db, dc, wb, wc);
            uint32_t key = (inv_w + DEPTH_BIAS) << 8 | slot;
            if (p->depth_slot >= key)
                continue;
            uint32_t u = (uint32_t)blend(a->u, b->u - a->u, c->u - a->u, wb, wc);
            uint32_t v = (uint32_t)blend(a->v, b->v - a->v, c->v - a->v, wb, wc);
            p->depth_slot = key;
            p->normal = (u & 0xffff) | v << 16;
        }
    }
}

/* All three on one side of the tile's outermost pixel centres. */
static bool outside(const struct raster_vertex *a, const struct raster_vertex *b, const struct raster_vertex *c)
{
    const int32_t right = RASTER_TILE_WIDTH * 256 - 128, bottom = RASTER_TILE_HEIGHT * 256 - 128;
    return (a->x < 128 && b->x < 128 && c->x < 128) || (a->y < 128 && b->y < 128 && c->y < 128) ||
           (a->x > right && b->x > right && c->x > right) || (a->y > bottom && b->y > bottom && c->y > bottom);
}

static struct raster_small pack_vertex(const struct raster_vertex *v)
{
    return (struct raster_small){((uint32_t)(v->x - 128) & 0xffff) | (uint32_t)(v->y - 128) << 16, v->inv_w,
                                 ((uint32_t)v->u & 0xffff) | (uint32_t)v->v << 16};
}

void raster_draw_general(struct raster_tile *t, const struct raster_vertex *a, const struct raster_vertex *c,
                         const struct raster_vertex *b, uint32_t slot, struct raster_stats *stats)
{
    /* Counter-clockwise with y up is clockwise with y down, once b and c are exchanged: area > 0 faces the eye. */
    if (outside(a, b, c))
        return;
    int64_t area = (int64_t)(b->x - a->x) * (c->y - a->y) - (int64_t)(c->x - a->x) * (b->y - a->y);
    if (area <= 0)
        return;
    stats->triangles++;
    int32_t x0 = fx_min(a->x, fx_min(b->x, c->x)), x1 = fx_max(a->x, fx_max(b->x, c->x));
    int32_t y0 = fx_min(a->y, fx_min(b->y, c->y)), y1 = fx_max(a->y, fx_max(b->y, c->y));
    uint32_t near = a->inv_w > b->inv_w ? a->inv_w : b->inv_w, far = a->inv_w < b->inv_w ? a->inv_w : b->inv_w;
    near = near > c->inv_w ? near : c->inv_w;
    far = far < c->inv_w ? far : c->inv_w;
    if (x1 - x0 <= SMALL_EXTENT && y1 - y0 <= SMALL_EXTENT &&
        near - far <= SMALL_DEPTH) { /* and touches the tile: a small one after all */
        const struct raster_small sa = pack_vertex(a), sb = pack_vertex(b), sc = pack_vertex(c);
        raster_fill_small(t, &sa, &sb, &sc, (uint32_t)area, slot, stats);
    } else {
        raster_fill_general(t, a, b, c, (uint64_t)area, slot, stats);
    }
}
