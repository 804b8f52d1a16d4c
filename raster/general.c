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

/* An attribute's differences b-a and c-a with three fraction bits, |d| <= 2^26. */
struct change {
    int32_t b, c;
};

static inline struct change change_of(int32_t a, int32_t b, int32_t c)
{
    return (struct change){(b - a) * 8, (c - a) * 8};
}

/* The sum of differences by weights in Q29, rounded. A weight that rounding takes beyond one is above it by 1, and the other is below 4
 * then: both together move the sum by less than 2^29, and half is 2^31. */
static inline uint32_t blend(struct change d, int32_t wb, int32_t wc)
{
    const uint64_t sum = (uint64_t)((int64_t)d.b * wb + (int64_t)d.c * wc);
    return (uint32_t)(sum >> 32) + ((uint32_t)sum >> 31);
}

/* n of a vertex over the area: n/area << (64 - lead) without what is lost beyond, exact modulo 2^64; the high word is what is needed. */
struct weight {
    uint64_t n, dx, dy; /* at column 0 of a row; changes per column and row */
};

/* In: from vertex a to the first row's first pixel centre, the edge opposite from a: n = x dy - y dx. */
static inline struct weight weight_setup(int32_t x, int32_t y, int32_t dx, int32_t dy, unsigned lead)
{
    return (struct weight){(uint64_t)((int64_t)x * dy - (int64_t)y * dx) << lead, (uint64_t)((int64_t)dy * 256) << lead,
                           (uint64_t)((int64_t)dx * -256) << lead};
}

void raster_fill_general(struct raster_tile *t, const struct raster_vertex *a, const struct raster_vertex *b,
                         const struct raster_vertex *c, uint64_t area, uint32_t slot, struct raster_stats *stats)
{
    const struct spans s = triangle_spans(t, a, b, c);
    if (!s.rows)
        return;
    const uint32_t hi = (uint32_t)(area >> 32);
    const unsigned lead = hi ? fx_clz(hi) : 32 + fx_clz((uint32_t)area);
    const uint32_t recip = fx_recip((uint32_t)(area << lead >> 32));
    const int32_t x = 128 - a->x, y = 256 * s.first_row + 128 - a->y;
    struct weight mb = weight_setup(x, y, c->x - a->x, c->y - a->y, lead); /* >= 0 where covered, sum <= area < 2^47 */
    struct weight mc = weight_setup(x, y, a->x - b->x, a->y - b->y, lead);
    const struct change d = change_of((int32_t)a->inv_w, (int32_t)b->inv_w, (int32_t)c->inv_w),
                        u = change_of(a->u, b->u, c->u), v = change_of(a->v, b->v, c->v);
    const uint32_t key_a = (a->inv_w + DEPTH_BIAS) << 8 | slot, u_a = (uint32_t)a->u, v_a = (uint32_t)a->v;
    struct raster_surface *line = t->surface + s.first_row * RASTER_TILE_WIDTH;
    for (const int32_t *span = t->m.spans, *last = span + 2 * s.rows; span != last; span += 2) {
        const uint32_t left = (uint32_t)span[0], count = (uint32_t)span[1];
        uint64_t nb = mb.n + left * mb.dx, nc = mc.n + left * mc.dx;
        stats->tested += count;
        stats->general += count;
        for (struct raster_surface *p = line + left, *end = p + count; p != end; p++) {
            const int32_t wb = (int32_t)fx_mulhi_u((uint32_t)(nb >> 32), recip),
                          wc = (int32_t)fx_mulhi_u((uint32_t)(nc >> 32), recip);
            const uint32_t key = key_a + (blend(d, wb, wc) << 8);
            nb += mb.dx;
            nc += mc.dx;
            if (p->depth_slot >= key)
                continue;
            p->depth_slot = key;
            p->normal = ((u_a + blend(u, wb, wc)) & 0xffff) | (v_a + blend(v, wb, wc)) << 16;
        }
        mb.n += mb.dy;
        mc.n += mc.dy;
        line += RASTER_TILE_WIDTH;
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
