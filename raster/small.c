/*
 * The small triangle path: meshlets less than 63 px wide and high, which is nearly all of them. Vertices are packed
 * 16-bit coordinates from the tile's first pixel centre, edges and areas fit 32 bits.
 *
 * A triangle that is too thin for bounded gradients goes to the general path: a choice by the triangle alone, so that tiles
 * of any size agree.
 */
#include "edge.h"

/* Per-triangle factors for gradients: K, edge vectors over the area, |K| <= 2^28. */
struct gradient {
    int32_t dx1, minus_dy1, minus_dx2, dy2;
    unsigned shift; /* lead - 3, 1..28 */
    int32_t fx, fy; /* vertex a from its pixel's centre, 0..255 */
    int32_t px, py; /* from that pixel to (column 0, first row) */
};

static inline int32_t low(uint32_t xy)
{
    return (int16_t)(xy & 0xffff);
}

static inline int32_t high(uint32_t xy)
{
    return (int32_t)xy >> 16;
}

void raster_transform_small(struct raster_small *out, const struct raster_object *o, const struct scene_vertex *v,
                            uint32_t count, unsigned normal_shift, int32_t centre_x2, int32_t centre_y2)
{
    for (const struct scene_vertex *end = v + count; v != end; v++, out++) {
        struct raster_clip_vertex c;
        raster_transform(&c, o, v);
        unsigned lead = fx_clz((uint32_t)c.w);
        uint32_t recip = fx_recip((uint32_t)c.w << lead);
        unsigned s = (unsigned)o->shift_xy - lead; /* 0..31, see box_coverage */
        int32_t x = ((fx_mulhi(c.x, (int32_t)recip) >> s) + centre_x2) >> 1;
        int32_t y = ((fx_mulhi(c.y, (int32_t)recip) >> s) + centre_y2) >> 1;
        out->xy = ((uint32_t)x & 0xffff) | (uint32_t)y << 16;
        out->inv_w = recip >> ((unsigned)o->shift_depth - lead);
        out->uv = ((uint32_t)raster_homogeneous(v->u, out->inv_w, normal_shift) & 0xffff) |
                  (uint32_t)raster_homogeneous(v->v, out->inv_w, normal_shift) << 16;
    }
}

/* In: packed ends of an edge, a above b; |x| < 2^15, dy <= 2^14, row at or below a: |n| < 2^30. */
static inline void start_small(struct edge *e, uint32_t a, uint32_t b, int32_t row)
{
    int32_t dx = low(b) - low(a), dy = high(b) - high(a);
    int32_t n = low(a) * dy + (256 * row - high(a)) * dx;
    edge_start(e, (n + 255) >> 8, dx, dy);
}

/* Fills t->m.spans from *first_row on; returns the number of rows, 0 when no pixel is covered. In: packed vertices,
 * clockwise on the screen. */
static int32_t make_spans(struct raster_tile *t, int32_t *first_row, uint32_t a, uint32_t b, uint32_t c)
{
    /* Turn the triangle so that a is on top: then b follows on the right side and c on the left. */
    if (high(b) < high(a)) {
        uint32_t top = high(c) < high(b) ? c : b, next = top == c ? a : c;
        c = top == c ? b : a;
        b = next;
        a = top;
    } else if (high(c) < high(a)) {
        uint32_t top = c;
        c = b;
        b = a;
        a = top;
    }
    bool b_first = high(b) < high(c);
    /* Coordinates count from the first pixel's centre: the first row at or below y is ceil(y/256). */
    int32_t r0 = fx_max((high(a) + 255) >> 8, 0), r1 = ((b_first ? high(b) : high(c)) + 255) >> 8;
    int32_t rows = fx_min(((b_first ? high(c) : high(b)) + 255) >> 8, RASTER_TILE_HEIGHT) - r0;
    if (rows <= 0)
        return 0;
    *first_row = r0;
    struct edge left, right;
    int32_t upper = fx_min(r1 - r0, rows), any = 0;
    if (upper > 0) {
        start_small(&left, a, c, r0);
        start_small(&right, a, b, r0);
        any = edge_walk(t->m.spans, upper, &left, &right);
        if (upper == rows)
            return any ? rows : 0;
        if (b_first)
            start_small(&right, b, c, r0 + upper);
        else
            start_small(&left, c, b, r0 + upper);
    } else {
        upper = 0;
        start_small(&left, b_first ? a : c, b_first ? c : b, r0);
        start_small(&right, b_first ? b : a, b_first ? c : b, r0);
    }
    any |= edge_walk(t->m.spans + 2 * upper, rows - upper, &left, &right);
    return any ? rows : 0;
}

/* An attribute over the tile: its value at (column 0, first row) and its changes per column and row, modulo 2^32. Integer steps are
 * exact, so the value at a pixel does not depend on where the tile starts. */
struct plane {
    uint32_t value, dx, dy;
};

/* In: the value at vertex a; e1, e2: differences b-a and c-a with two fraction bits less, |e| <= 2^28. The sums are at most
 * 2 * 2^28 * 2^28 and their shifted high words below 2^31, see make_gradient. The changes are
 * rounded to multiples of `step`, a power of two. */
FX_NOINLINE static void make_plane(struct plane *p, const struct gradient *g, uint32_t value, int32_t e1, int32_t e2,
                                   uint32_t step)
{
    int32_t dx = (int32_t)((((int64_t)e1 * g->dy2 + (int64_t)e2 * g->minus_dy1) >> 32));
    int32_t dy = (int32_t)((((int64_t)e2 * g->dx1 + (int64_t)e1 * g->minus_dx2) >> 32));
    dx = (int32_t)((((uint32_t)dx << g->shift) + (step >> 1)) & (uint32_t) - (int32_t)step);
    dy = (int32_t)((((uint32_t)dy << g->shift) + (step >> 1)) & (uint32_t) - (int32_t)step);
    uint32_t back = (uint32_t)(dx >> 8) * (uint32_t)g->fx + (uint32_t)(dy >> 8) * (uint32_t)g->fy;
    p->value = value - back + (uint32_t)dx * (uint32_t)g->px + (uint32_t)dy * (uint32_t)g->py;
    p->dx = (uint32_t)dx;
    p->dy = (uint32_t)dy;
}

/*
 * In: area = twice the area in 1/65536 px^2, below 2^28. K = d * q / 2^16 with q = 2^61/(area << lead), so that per pixel an
 * attribute e changes by
 *   256 (e1 dy2 - e2 dy1)/area = (e1 K2 - e2 K1) 2^(lead-37),
 * which is the high word of the sum << (lead-3) when e comes pre-scaled by 2^n and the result has n+2 fraction bits.
 * Returns t = 0 for a triangle at least a pixel thick, no edge longer than area/256, that is all |K| < 2^(37-lead), and otherwise the least t
 * with |K| < 2^(37-lead+t). Then |gradient| <= 2^(t+1) |e|, and the high word's rounding, at most 2^(lead-3) a pixel over at
 * most 2^(16-lead+t) px, adds up to below 2^(14+t) of the result's units: 64 << t of the depth's, 1 << t of a normal's. Rounding the
 * depth's gradients to whole units adds half a unit a pixel and axis, 63: less than 320 for t <= 2.
 */
static inline unsigned make_gradient(struct gradient *g, uint32_t a, uint32_t b, uint32_t c, uint32_t area)
{
    unsigned lead = fx_clz(area); /* 4..31 */
    int32_t q = (int32_t)fx_recip(area << lead);
    g->dx1 = fx_mulhi((low(b) - low(a)) * 65536, q);
    g->minus_dy1 = fx_mulhi((high(a) - high(b)) * 65536, q);
    g->minus_dx2 = fx_mulhi((low(a) - low(c)) * 65536, q);
    g->dy2 = fx_mulhi((high(c) - high(a)) * 65536, q);
    g->shift = lead - 3;
    uint32_t all = (uint32_t)((g->dx1 ^ g->dx1 >> 31) | (g->minus_dy1 ^ g->minus_dy1 >> 31) |
                              (g->minus_dx2 ^ g->minus_dx2 >> 31) | (g->dy2 ^ g->dy2 >> 31)); /* < 2^28 */
    return lead <= 9 || all >> (37 - lead) == 0 ? 0 : lead - fx_clz(all) - 5;
}

static struct raster_vertex unpack(const struct raster_small *s)
{
    return (struct raster_vertex){low(s->xy) + 128, high(s->xy) + 128, s->inv_w, (int16_t)low(s->uv),
                                  (int16_t)high(s->uv)};
}

/* |x| < 2^bits, or x = -2^bits. */
static inline bool fits(int32_t x, unsigned bits)
{
    return (uint32_t)(x + (1 << bits)) < 2u << bits;
}

/* A triangle down to a quarter of a pixel thick, t of make_gradient, whose attributes change little enough for its gradients. */
FX_NOINLINE static bool thin_fits(unsigned t, const int32_t e[4], int32_t d1, int32_t d2)
{
    return t <= 2 && fits(e[0], 13 - t) && fits(e[1], 13 - t) && fits(e[2], 13 - t) && fits(e[3], 13 - t) &&
           fits(d1, 21 - t) && fits(d2, 21 - t);
}

/* In: count > 0. */
static inline void fill_span(struct raster_surface *p, int32_t count, uint32_t d, uint32_t u, uint32_t v, uint32_t ddx,
                             uint32_t udx, uint32_t vdx)
{
    struct raster_surface *end = p + count;
    do {
        if (p->depth_slot < d) {
            p->depth_slot = d;
            p->normal = (v & 0xffff0000) | u >> 16;
        }
        d += ddx;
        u += udx;
        v += vdx;
    } while (++p != end);
}

void raster_fill_small(struct raster_tile *t, const struct raster_small *a, const struct raster_small *b,
                       const struct raster_small *c, uint32_t area, uint32_t slot, struct raster_stats *stats)
{
    int32_t row, rows = make_spans(t, &row, a->xy, b->xy, c->xy);
    if (!rows)
        return;
    int32_t u0 = low(a->uv), u1 = low(b->uv) - u0, u2 = low(c->uv) - u0;
    int32_t v0 = high(a->uv), v1 = high(b->uv) - v0, v2 = high(c->uv) - v0;
    struct gradient g;
    int32_t d1 = (int32_t)(b->inv_w - a->inv_w), d2 = (int32_t)(c->inv_w - a->inv_w); /* <= SMALL_DEPTH */
    unsigned t_thin = make_gradient(&g, a->xy, b->xy, c->xy, area);
    /* Coordinates that change by less than 2^13: their gradients fit with 16 fraction bits. */
    bool smooth = fits(u1, 13) && fits(u2, 13) && fits(v1, 13) && fits(v2, 13);
    if (!smooth || (t_thin && !thin_fits(t_thin, (const int32_t[4]){u1, u2, v1, v2}, d1, d2))) {
        const struct raster_vertex va = unpack(a), vb = unpack(b), vc = unpack(c);
        raster_fill_general(t, &va, &vb, &vc, area, slot, stats);
        return;
    }
    g.fx = low(a->xy) & 255;
    g.fy = high(a->xy) & 255;
    g.px = -(low(a->xy) >> 8);
    g.py = row - (high(a->xy) >> 8);
    /* Depth 24.8 in whole units, |d| <= SMALL_DEPTH: the byte below holds the slot and is not touched by the steps. Normals Q14, plus
     * half a unit, with 16 more bits. */
    struct plane d, u, v;
    make_plane(&d, &g, (a->inv_w + DEPTH_BIAS) << 8, d1 * 64, d2 * 64, 256);
    make_plane(&u, &g, ((uint32_t)u0 << 16) + (1 << 15), u1 * 16384, u2 * 16384, 1);
    make_plane(&v, &g, ((uint32_t)v0 << 16) + (1 << 15), v1 * 16384, v2 * 16384, 1);
    d.value = (d.value & ~(uint32_t)255) | slot;

    struct raster_surface *line = t->surface + row * RASTER_TILE_WIDTH;
    for (const int32_t *s = t->m.spans, *last = s + 2 * rows; s != last; s += 2) {
        int32_t count = s[1];
        if (count) {
            uint32_t left = (uint32_t)s[0];
            stats->tested += (uint32_t)count;
            fill_span(line + left, count, d.value + left * d.dx, u.value + left * u.dx, v.value + left * v.dx, d.dx,
                      u.dx, v.dx);
        }
        line += RASTER_TILE_WIDTH;
        d.value += d.dy;
        u.value += u.dy;
        v.value += v.dy;
    }
}

void raster_draw_small(struct raster_tile *t, const struct raster_small *vertices,
                       const struct scene_triangle *triangles, uint32_t count, uint32_t slot,
                       struct raster_stats *stats)
{
    /* Both halves at once: all three left of or above the first pixel centre, or right of or below the last. A borrow of the
     * low half moves the limit of the high half by one, which is why it is one too far. All vertices are within 127 px of
     * the tile's corner and 63 px of each other, so a wrapped difference only marks triangles that are outside anyway. */
    const uint32_t sign = 0x80008000u,
                   last = ((RASTER_TILE_HEIGHT - 1) * 256u + 1) << 16 | (RASTER_TILE_WIDTH - 1) * 256u;
    for (const struct scene_triangle *end = triangles + count; triangles != end; triangles++) {
        /* Counter-clockwise with y up is clockwise with y down once b and c are exchanged. */
        const struct raster_small *a = vertices + triangles->v[0], *b = vertices + triangles->v[2],
                                  *c = vertices + triangles->v[1];
        uint32_t pa = a->xy, pb = b->xy, pc = c->xy;
        if (((pa & pb & pc) | ((last - pa) & (last - pb) & (last - pc))) & sign)
            continue;
        /* edge vectors < 2^14: products < 2^28 */
        int32_t area = (low(pb) - low(pa)) * (high(pc) - high(pa)) - (low(pc) - low(pa)) * (high(pb) - high(pa));
        if (area <= 0)
            continue;
        stats->triangles++;
        raster_fill_small(t, a, b, c, (uint32_t)area, slot, stats);
    }
}
