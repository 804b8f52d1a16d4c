/*
 * Clipping in homogeneous space (Sutherland and Hodgman 1974) against the near plane and the guard band, before the
 * perspective division. Planes: w = near, and |x| <= guard * w, |y| <= guard * w in the object's own scales.
 */
#include "internal.h"

/* guard * w in X units, where one unit of x/w is 2^(shift_xy - 29) / 512 px: w * 2^(GUARD_BITS + 9 + shift_xy - 29), rounded
 * down; saturates where no x reaches it. */
static int64_t guard_limit(const struct raster_object *o, int32_t w)
{
    int32_t s = GUARD_BITS + 9 - 29 + o->shift_xy;
    if (w <= 0)
        return w < 0 ? -1 : 0; /* behind the eye: whatever x, outside of one side at least */
    return s > 31 ? (int64_t)1 << 62 : s >= 0 ? (int64_t)w << s : s > -31 ? w >> -s : 0;
}

/* Signed distance from a plane, positive inside. |distance| < 2^63: |x| < 2^31, limit <= 2^62. */
static int64_t plane_distance(const struct raster_object *o, const struct raster_clip_vertex *v, unsigned plane)
{
    switch (plane) {
    case CLIP_NEAR:
        return (int64_t)v->w - o->near_w;
    case CLIP_LEFT:
        return guard_limit(o, v->w) + v->x;
    case CLIP_RIGHT:
        return guard_limit(o, v->w) - v->x;
    case CLIP_TOP:
        return guard_limit(o, v->w) + v->y;
    default:
        return guard_limit(o, v->w) - v->y;
    }
}

unsigned raster_clip_code(const struct raster_object *o, const struct raster_clip_vertex *v)
{
    if (v->w < o->near_w)
        return CLIP_NEAR; /* the other planes count from the near plane on */
    int64_t g = guard_limit(o, v->w);
    return (v->x < -g ? CLIP_LEFT : 0u) | (v->x > g ? CLIP_RIGHT : 0u) | (v->y < -g ? CLIP_TOP : 0u) |
           (v->y > g ? CLIP_BOTTOM : 0u);
}

/* a + (b-a) * t, t Q30 in 0..1: |b-a| < 2^32. */
FX_NOINLINE static int32_t lerp(int32_t a, int32_t b, int32_t t)
{
    return a + (int32_t)((((int64_t)b - a) * t + ((int64_t)1 << 29)) >> 30);
}

/* Where the edge from `in` (distance din >= 0) to `out` (dout < 0) meets the plane. Always computed from the inside vertex. */
static struct raster_clip_vertex cut(const struct raster_object *o, const struct raster_clip_vertex *in,
                                     const struct raster_clip_vertex *out, int64_t din, int64_t dout, unsigned plane)
{
    uint64_t whole = (uint64_t)din + ((uint64_t)0 - (uint64_t)dout), part = (uint64_t)din; /* part <= whole < 2^64 */
    uint32_t hi = (uint32_t)(whole >> 32);
    unsigned lead = hi ? fx_clz(hi) : 32 + fx_clz((uint32_t)whole); /* whole >= 1 */
    uint32_t w32 = (uint32_t)(whole << lead >> 32), p32 = (uint32_t)(part << lead >> 32);
    uint32_t q = fx_mulhi_u(p32, fx_recip(w32)); /* part/whole * 2^29 */
    int32_t t = (int32_t)(q > 1u << 29 ? 1u << 30 : q << 1);
    struct raster_clip_vertex v = {lerp(in->x, out->x, t), lerp(in->y, out->y, t), lerp(in->w, out->w, t),
                                   (int16_t)lerp(in->u, out->u, t), (int16_t)lerp(in->v, out->v, t)};
    if (plane == CLIP_NEAR || v.w < o->near_w)
        v.w = o->near_w;
    return v;
}

static unsigned clip_plane(struct raster_clip_vertex *p, unsigned count, unsigned plane, const struct raster_object *o)
{
    struct raster_clip_vertex q[CLIP_MAX_VERTICES];
    unsigned n = 0;
    for (unsigned i = 0; i < count; i++) {
        const struct raster_clip_vertex *a = &p[i], *b = &p[i + 1 == count ? 0 : i + 1];
        int64_t da = plane_distance(o, a, plane), db = plane_distance(o, b, plane);
        if (da >= 0 && n < CLIP_MAX_VERTICES)
            q[n++] = *a;
        if (da >= 0 && db < 0 && n < CLIP_MAX_VERTICES)
            q[n++] = cut(o, a, b, da, db, plane);
        else if (da < 0 && db >= 0 && n < CLIP_MAX_VERTICES)
            q[n++] = cut(o, b, a, db, da, plane);
    }
    for (unsigned i = 0; i < n; i++)
        p[i] = q[i];
    return n < 3 ? 0 : n;
}

unsigned raster_clip_polygon(struct raster_clip_vertex *p, unsigned count, unsigned codes,
                             const struct raster_object *o)
{
    /* The near plane goes first: what it cuts off may lie on any side of the others, so all follow then. */
    if (codes & CLIP_NEAR)
        codes = CLIP_NEAR | CLIP_LEFT | CLIP_RIGHT | CLIP_TOP | CLIP_BOTTOM;
    for (unsigned plane = CLIP_NEAR; plane <= CLIP_BOTTOM && count; plane <<= 1)
        if (codes & plane)
            count = clip_plane(p, count, plane, o);
    return count;
}
