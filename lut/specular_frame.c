/*
 * The specular-frame table (Cezner and Havran 2024, eqs. 14-16), in integers and without a tangent frame.
 *
 * With r = 2 (n.l)/(n.n) n - l, the mirror direction of l, and t = l x n, |t| = sin(theta_in), the paper's rotated view
 * direction S v has the components (v.(t x r), v.t) / |t| in the plane across r and v.r along it. Hence
 * theta_d follows from |v - r|, and phi_d from the first two, whose common factor cancels. All differences are
 * taken between vectors, before squaring, so that small angles keep their bits.
 */
#include "func.h"
#include "interpolate.h"
#include "kinds.h"

struct coordinates { /* 180 degrees = 2^28, a full turn of phi_d = 2^28 */
    uint32_t phi_d, theta_d, theta_in;
};

static int32_t cross_wrapping(int32_t a, int32_t b, int32_t c, int32_t d)
{
    return (int32_t)((uint32_t)(a * b) - (uint32_t)(c * d));
}

static int64_t dot64(struct vec3 a, struct vec3 b)
{
    return (int64_t)a.x * b.x + (int64_t)a.y * b.y + (int64_t)a.z * b.z;
}

/* In: |component| <= 2^20. Out: |a|^2 / 4 with 1.0 = 2^30 for a with 1.0 = 2^17. */
static uint32_t quarter_square(int32_t x, int32_t y, int32_t z)
{
    struct vec3 a = {x, y, z};
    return (uint32_t)(dot64(a, a) >> 6);
}

static void coordinates_find(struct coordinates *out, int32_t nl, struct vec3 n, struct vec3 l, struct vec3 v)
{
    /* n.l / n.n, by 1/x = 2 - x near 1: a normal's length error would otherwise count fourfold in r */
    int32_t q = (int32_t)(((int64_t)nl * (int32_t)((1u << 31) - (uint32_t)dot_wrapping(n, n))) >> 30);
    /* r, 1.0 = 2^17: q 2^30 * n 2^15 * 2^5 / 2^32 = 2 q n / 2 * 2^18; |component| < 2^20 for any q */
    struct vec3 r = {fx_mulhi(q, n.x * 32) - l.x * 4, fx_mulhi(q, n.y * 32) - l.y * 4, fx_mulhi(q, n.z * 32) - l.z * 4};
    uint32_t s2 = quarter_square(v.x * 4 - r.x, v.y * 4 - r.y, v.z * 4 - r.z);
    if (s2 <= 1u << 29) {
        out->theta_d = lut_angle_from_sin2_half(s2);
    } else {
        s2 = quarter_square(v.x * 4 + r.x, v.y * 4 + r.y, v.z * 4 + r.z);
        out->theta_d = (1u << 28) - lut_angle_from_sin2_half(s2);
    }
    out->theta_in = lut_angle_from_sin2_half(quarter_square((n.x - l.x) * 4, (n.y - l.y) * 4, (n.z - l.z) * 4));

    struct vec3 t = {cross_wrapping(l.y, n.z, l.z, n.y), cross_wrapping(l.z, n.x, l.x, n.z),
                     cross_wrapping(l.x, n.y, l.y, n.x)}; /* 1.0 = 2^30 */
    struct vec3 u = {(int32_t)(((int64_t)t.y * r.z - (int64_t)t.z * r.y) >> 17),
                     (int32_t)(((int64_t)t.z * r.x - (int64_t)t.x * r.z) >> 17),
                     (int32_t)(((int64_t)t.x * r.y - (int64_t)t.y * r.x) >> 17)}; /* t x r, 1.0 = 2^30 */
    /* 1.0 = 2^30: within int32 for unit vectors, lut_turn takes anything for others */
    out->phi_d = lut_turn((int32_t)(dot64(v, t) >> 15), (int32_t)(dot64(v, u) >> 15));
}

struct lut_rgb lut_specular_frame_at(const struct lut_table *t, uint32_t theta_in, uint32_t theta_d, uint32_t phi_d)
{
    /* angle 2^28 * (nodes-1) 2^16 / 2^32 = coordinate 2^12; nodes <= 2^12 */
    struct lut_rgb f = lut_interpolate(t->texels, t->width, t->height,
                                       lut_cell_find(fx_mulhi_u(phi_d, (t->width - 1) << 16), 12, t->width),
                                       lut_cell_find(fx_mulhi_u(theta_d, (t->height - 1) << 16), 12, t->height),
                                       lut_cell_find(fx_mulhi_u(theta_in, t->slice_scale), 12, t->depth));
    for (int k = 0; k < 3; k++) {
        f.c[k] = (f.c[k] + 128) >> 8; /* <= 511 * 2^12 */
    }
    f.e += 8;
    return f;
}

struct lut_rgb lut_specular_frame(const struct lut_table *t, struct vec3 n, struct vec3 l, struct vec3 v)
{
    struct coordinates at;
    int32_t nl = dot_wrapping(n, l);
    if (t->swap && nl < dot_wrapping(n, v)) {
        struct vec3 w = l;
        l = v;
        v = w;
        nl = dot_wrapping(n, l);
    }
    coordinates_find(&at, nl, n, l, v);
    return lut_specular_frame_at(t, at.theta_in, at.theta_d, at.phi_d);
}
