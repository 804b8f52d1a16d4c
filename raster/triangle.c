/*
 * One triangle into the tile's surface: exact coverage, depth test, normal.
 *
 * Coverage is exact for the snapped 24.8 vertices under the Direct3D 11 top-left rule. An edge from (x0,y0) down to
 * (x1,y1), dy = y1-y0 > 0, meets the centre line of row r at X; the pixels right of it begin at column
 *   ceil((X-128)/256) = ceil(M/dy),  M = ceil(((x0-128) dy + (256 r + 128 - y0) dx) / 256),
 * because ceil(n/(256 d)) = ceil(ceil(n/256)/d). Centres on a left edge belong to the triangle and centres on a right
 * edge do not, so both sides use the same ceil. A step of one row adds exactly dx to M: quotient and remainder of M/dy are
 * carried along, and nothing is ever rounded. Rows follow the same rule vertically: ceil((y-128)/256).
 *
 * Two ways to the attributes, chosen by the triangle and never by the tile, so that tiles of any size agree:
 *   small   affine gradients in 32 bits, for triangles below 63 px whose shape keeps the gradients bounded;
 *   general barycentric weights per pixel from exact 64-bit edge values, perspective-correct.
 */
#include "internal.h"

struct edge {
    int32_t column; /* ceil(M/dy) */
    int32_t rest;   /* in -dy..-1: how far M + dy - 1 is below the next column, minus dy */
    int32_t step, step_rest, dy;
};

struct spans {
    int32_t first_row, rows; /* inside the tile */
    int32_t *left_count;     /* per row: first column, number of columns (may be 0) */
};

static int32_t floor_div(int32_t *rest, int32_t n, int32_t d)
{
    int32_t q = n / d, r = n - q * d;
    if (r < 0) {
        q--;
        r += d;
    }
    *rest = r;
    return q;
}

/*
 * In: a above b, both relative to the tile; row inside the tile. Coordinates are within +-(2^13 + 2^12) px < 2^22, so
 * products stay below 2^45. |M| beyond 2^30 is clamped to 1.5 * 2^30: over a tile it moves by at most 63 |dx| < 2^29, and
 * no column of the tile reaches 64 dy <= 2^29 either, so the edge lies wholly on one side whatever the exact value.
 */
static void edge_start(struct edge *e, const struct raster_vertex *a, const struct raster_vertex *b, int32_t row)
{
    const int32_t far = 3 << 29;
    int32_t dx = b->x - a->x, dy = b->y - a->y;
    int64_t n = (int64_t)(a->x - 128) * dy + (int64_t)(256 * row + 128 - a->y) * dx;
    n = (n + 255) >> 8;
    int32_t m = n > 1 << 30 ? far : n < -(1 << 30) ? -far : (int32_t)n;
    e->column = floor_div(&e->rest, m + dy - 1, dy); /* < 2^31: dy < 2^23 */
    e->rest -= dy;
    e->step = floor_div(&e->step_rest, dx, dy);
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

static void walk_edges(int32_t *out, int32_t rows, struct edge *left, struct edge *right)
{
    for (int32_t i = 0; i < rows; i++) {
        int32_t l = fx_max(edge_next(left), 0), n = fx_min(edge_next(right), RASTER_TILE_WIDTH) - l;
        out[2 * i] = l;
        out[2 * i + 1] = n > 0 ? n : 0;
    }
}

/* First row whose centre is at or below y. */
static inline int32_t first_row(q24_8_t y)
{
    return (y + 127) >> 8;
}

/* Fills t->spans; rows = 0 when no row of the tile is touched. In: a, b, c clockwise on the screen (y down). */
static struct spans triangle_spans(struct raster_tile *t, const struct raster_vertex *a, const struct raster_vertex *b,
                                   const struct raster_vertex *c)
{
    struct spans s = {0, 0, t->spans};
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
    int32_t r0 = fx_max(first_row(a->y), 0), r1 = first_row(middle->y);
    int32_t r2 = fx_min(first_row(bottom->y), RASTER_TILE_HEIGHT);
    if (r2 <= r0)
        return s;
    s.first_row = r0;
    s.rows = r2 - r0;
    struct edge left, right;
    int32_t upper = fx_clamp(r1 - r0, 0, s.rows);
    if (upper > 0) { /* both sides start at a */
        edge_start(&left, a, c, r0);
        edge_start(&right, a, b, r0);
        walk_edges(t->spans, upper, &left, &right);
    }
    if (upper < s.rows) { /* below the middle vertex one side changes its edge */
        int32_t row = r0 + upper;
        if (middle == b) {
            edge_start(&right, b, c, row);
            if (!upper)
                edge_start(&left, a, c, row);
        } else {
            edge_start(&left, c, b, row);
            if (!upper)
                edge_start(&right, a, b, row);
        }
        walk_edges(t->spans + 2 * upper, s.rows - upper, &left, &right);
    }
    return s;
}

/* An attribute over the screen: value at a pixel centre and its change per column and row, modulo 2^32. Exact in its
 * integer steps, so that the value at a pixel does not depend on the tile. */
struct plane {
    uint32_t value, dx, dy;
};

/* Per-triangle factors for gradients: 2^k * (edge vector) / area. */
struct gradient {
    int32_t dx1, dy1, dx2, dy2; /* |.| <= 2^28 */
    unsigned shift;             /* lead - 3, 1..12 */
    int32_t fx, fy;             /* vertex a from its pixel's centre, -128..127 */
    int32_t px, py;             /* from that pixel to (first column, first row) */
};

/* e1, e2: the attribute's differences b-a and c-a with two fraction bits less than `value`, |e| <= 2^27. */
static struct plane plane_make(const struct gradient *g, uint32_t value, int32_t e1, int32_t e2)
{
    /* |sum| <= 2 * 2^27 * 2^28; the shifted high word is at most 2^30, see draw_small */
    int32_t gx = (int32_t)((uint32_t)(((int64_t)e1 * g->dy2 - (int64_t)e2 * g->dy1) >> 32) << g->shift);
    int32_t gy = (int32_t)((uint32_t)(((int64_t)e2 * g->dx1 - (int64_t)e1 * g->dx2) >> 32) << g->shift);
    int32_t back = (gx >> 8) * g->fx + (gy >> 8) * g->fy; /* <= 2 * 2^22 * 2^7 */
    struct plane p = {value - (uint32_t)back + (uint32_t)gx * (uint32_t)g->px + (uint32_t)gy * (uint32_t)g->py,
                      (uint32_t)gx, (uint32_t)gy};
    return p;
}

/*
 * In: area = twice the area in 1/65536 px^2, 2^8 * longest extent <= area < 2^28: at least a pixel high everywhere.
 * Gradients: K = d * q / 2^16 with q = 2^61/(area << lead), so that per pixel an attribute e changes by
 *   256 (e1 dy2 - e2 dy1)/area = (e1 K2 - e2 K1) 2^(lead-37),
 * which is the high word of the sum << (lead-3) when e comes pre-scaled by 2^n and the result has n+2 fraction bits. The
 * shape bounds it to 2 |e|. The high word's rounding, at most 2^(lead-3) a pixel over at most 2^(16-lead) px, adds up to
 * below 2^14 of the result's units: 64 of the depth's.
 */
static void draw_small(struct raster_tile *t, const struct raster_vertex *a, const struct raster_vertex *b,
                       const struct raster_vertex *c, uint32_t area, uint32_t slot, struct raster_stats *stats)
{
    struct spans s = triangle_spans(t, a, b, c);
    if (!s.rows)
        return;
    unsigned lead = fx_clz(area); /* 4..15 */
    int32_t q = (int32_t)raster_recip(area << lead);
    struct gradient g = {fx_mulhi((b->x - a->x) * 65536, q),
                         fx_mulhi((b->y - a->y) * 65536, q),
                         fx_mulhi((c->x - a->x) * 65536, q),
                         fx_mulhi((c->y - a->y) * 65536, q),
                         lead - 3,
                         (a->x & 255) - 128,
                         (a->y & 255) - 128,
                         -(a->x >> 8),
                         s.first_row - (a->y >> 8)};
    /* depth: 24.8 as the surface holds it; inv_w <= 2^23 varies by at most 1/32 of it in a small triangle */
    int32_t d1 = (int32_t)(b->inv_w - a->inv_w) * 64, d2 = (int32_t)(c->inv_w - a->inv_w) * 64;
    struct plane depth = plane_make(&g, (a->inv_w + DEPTH_BIAS) << 8, d1, d2);
    /* normal: Q28, plus half a unit of the Q14 it is stored as */
    struct plane u = plane_make(&g, ((uint32_t)a->u << 14) + (1 << 13), (b->u - a->u) * 4096, (c->u - a->u) * 4096);
    struct plane v = plane_make(&g, ((uint32_t)a->v << 14) + (1 << 13), (b->v - a->v) * 4096, (c->v - a->v) * 4096);

    struct raster_surface *row = t->surface + s.first_row * RASTER_TILE_WIDTH;
    for (int32_t i = 0; i < s.rows; i++, row += RASTER_TILE_WIDTH) {
        int32_t left = s.left_count[2 * i], count = s.left_count[2 * i + 1];
        uint32_t d = depth.value + (uint32_t)left * depth.dx;
        uint32_t nu = u.value + (uint32_t)left * u.dx, nv = v.value + (uint32_t)left * v.dx;
        stats->tested += (uint32_t)count;
        for (struct raster_surface *p = row + left, *end = p + count; p != end; p++) {
            uint32_t key = (d & ~(uint32_t)255) | slot;
            if (p->depth_slot < key) {
                p->depth_slot = key;
                p->normal = (nu >> 14 & 0xffff) | (nv << 2 & 0xffff0000);
            }
            d += depth.dx;
            nu += u.dx;
            nv += v.dx;
        }
        depth.value += depth.dy;
        u.value += u.dy;
        v.value += v.dy;
    }
}

/* n/area in Q29 for 0 <= n <= area: n << lead < 2^64. */
static inline uint32_t weight(int64_t n, unsigned lead, uint32_t recip)
{
    uint32_t w = fx_mulhi_u((uint32_t)((uint64_t)n << lead >> 32), recip);
    return w > 1u << 29 ? 1u << 29 : w;
}

/* The share n of a vertex in the pixel's 1/w, both with 29 more bits, in Q29. n <= inv_w * 2^29 but for rounding; recip is that
 * of inv_w << up, up 9..31. */
static inline uint32_t share(uint64_t n, unsigned up, uint32_t recip)
{
    n = up <= 29 ? n >> (29 - up) : n << (up - 29);
    return fx_mulhi_u(n > UINT32_MAX ? UINT32_MAX : (uint32_t)n, recip);
}

/* a + wb (b-a) + wc (c-a), weights Q29, rounded. |differences| <= 2^23. */
static inline int32_t blend(int32_t a, int32_t db, int32_t dc, uint32_t wb, uint32_t wc)
{
    return a + (int32_t)(((int64_t)db * (int32_t)wb + (int64_t)dc * (int32_t)wc + (1 << 28)) >> 29);
}

static void draw_general(struct raster_tile *t, const struct raster_vertex *a, const struct raster_vertex *b,
                         const struct raster_vertex *c, uint64_t area, uint32_t slot, struct raster_stats *stats)
{
    struct spans s = triangle_spans(t, a, b, c);
    if (!s.rows)
        return;
    uint32_t hi = (uint32_t)(area >> 32);
    unsigned lead = hi ? fx_clz(hi) : 32 + fx_clz((uint32_t)area);
    uint32_t recip = raster_recip((uint32_t)(area << lead >> 32));
    int64_t dx1 = b->x - a->x, dy1 = b->y - a->y, dx2 = c->x - a->x, dy2 = c->y - a->y; /* < 2^23 */
    int32_t db = (int32_t)(b->inv_w - a->inv_w), dc = (int32_t)(c->inv_w - a->inv_w);
    bool flat = a->u == b->u && a->u == c->u && a->v == b->v && a->v == c->v;
    for (int32_t i = 0; i < s.rows; i++) {
        int32_t row = s.first_row + i, left = s.left_count[2 * i], count = s.left_count[2 * i + 1];
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
            int32_t u = a->u, v = a->v;
            if (!flat && inv_w) { /* perspective: weights times own 1/w over the pixel's 1/w; products <= 2^52 */
                unsigned up = fx_clz(inv_w);
                uint32_t r = raster_recip(inv_w << up);
                wb = share((uint64_t)wb * b->inv_w, up, r);
                wc = share((uint64_t)wc * c->inv_w, up, r);
                u = blend(u, b->u - a->u, c->u - a->u, wb, wc);
                v = blend(v, b->v - a->v, c->v - a->v, wb, wc);
            }
            p->depth_slot = key;
            p->normal = ((uint32_t)u & 0xffff) | (uint32_t)v << 16;
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

void raster_draw_triangle(struct raster_tile *t, const struct raster_vertex *a, const struct raster_vertex *c,
                          const struct raster_vertex *b, uint32_t slot, bool small, struct raster_stats *stats)
{
    /* Counter-clockwise with y up is clockwise with y down, once b and c are exchanged: area > 0 faces the eye. */
    if (outside(a, b, c))
        return;
    if (small) {
        int32_t dx1 = b->x - a->x, dy1 = b->y - a->y, dx2 = c->x - a->x, dy2 = c->y - a->y; /* < 2^14 */
        int32_t area = dx1 * dy2 - dx2 * dy1;                                               /* < 2^29 */
        if (area <= 0)
            return;
        stats->triangles++;
        int32_t extent = fx_max(fx_max(dx1 < 0 ? -dx1 : dx1, dx2 < 0 ? -dx2 : dx2),
                                fx_max(dy1 < 0 ? -dy1 : dy1, dy2 < 0 ? -dy2 : dy2));
        if (area >= extent * 256)
            draw_small(t, a, b, c, (uint32_t)area, slot, stats);
        else
            draw_general(t, a, b, c, (uint64_t)area, slot, stats);
        return;
    }
    int64_t area = (int64_t)(b->x - a->x) * (c->y - a->y) - (int64_t)(c->x - a->x) * (b->y - a->y);
    if (area <= 0)
        return;
    stats->triangles++;
    draw_general(t, a, b, c, (uint64_t)area, slot, stats);
}
