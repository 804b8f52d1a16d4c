/*
 * The half-vector table, evaluated for any three directions. Everything is even in l - v and symmetric in l + v, so
 * exchanging l and v gives the same bits. sin^2 theta_h is |n x h|^2, whose small values keep their bits where
 * 1 - (n.h)^2 would lose them.
 */
#include "func.h"
#include "interpolate.h"
#include "kinds.h"

/* m * 2^e, 2^31 <= m < 2^32; zero: m = 0. */
struct real {
    uint32_t m;
    int32_t e;
};

static struct real real_make(uint64_t x)
{
    if (x == 0) {
        return (struct real){0, 0};
    }
    uint32_t high = (uint32_t)(x >> 32), low = (uint32_t)x;
    unsigned zeros = high ? fx_clz(high) : 32 + fx_clz(low);
    return (struct real){(uint32_t)(x << zeros >> 32), 32 - (int32_t)zeros};
}

static struct real real_mul(struct real a, struct real b)
{
    struct real p = real_make((uint64_t)a.m * b.m);
    p.e += a.e + b.e;
    return p;
}

/* Relative error <= 2^-26. In: b not zero. */
static struct real real_div(struct real a, struct real b)
{
    struct real q = real_make((uint64_t)a.m * fx_recip(b.m)); /* 2^61 / b.m */
    q.e += a.e - b.e - 61;
    return q;
}

/* x * 2^bits rounded down, at most `most`. */
static uint32_t real_fixed(struct real x, int32_t bits, uint32_t most)
{
    int32_t e = x.e + bits;
    uint32_t y = e > 0 ? most : e < -31 ? 0 : x.m >> -e;
    return y > most ? most : y;
}

struct vec3_64 {
    int64_t x, y, z;
};

static uint64_t square64(struct vec3_64 a)
{
    return (uint64_t)(a.x * a.x + a.y * a.y + a.z * a.z);
}

static int64_t dot_vec3_64(struct vec3_64 a, struct vec3_64 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* Brought to unit length: 1.0 = 2^29. In: 1.0 = 2^15. 1/|a| is 1 + (1 - |a|^2)/2 near 1; components at most 2^15 + 64
 * leave |correction| <= 2^-1. */
static struct vec3_64 unit(struct vec3 a)
{
    int64_t k = ((int64_t)1 << 30) - ((int64_t)a.x * a.x + (int64_t)a.y * a.y + (int64_t)a.z * a.z);
    k += (int64_t)1 << 31; /* 1.0 = 2^31, below 2^32 */
    return (struct vec3_64){(a.x * k) >> 17, (a.y * k) >> 17, (a.z * k) >> 17};
}

/* sqrt(x), 1.0 = 2^27, of x with 1.0 = 2^56, x <= 2^57 */
static uint32_t root(uint64_t x)
{
    uint32_t y = (uint32_t)(x >> 26); /* 1.0 = 2^30, at most 2^31 */
    unsigned shift;
    if (y == 0) {
        return 0;
    }
    uint32_t m = lut_rsqrt(y, &shift); /* sqrt(y) = y m 2^-(30 + shift), with 15 fraction bits */
    return (uint32_t)((uint64_t)y * m >> (30 + shift - 12));
}

/* Between nodes k and k+1 of a warp; fraction of 2^32. Out: 24 fraction bits, at most 2^31. */
static uint32_t warp_between(const uint16_t *w, uint32_t k, uint32_t fraction)
{
    return ((uint32_t)w[k] << 15) + fx_mulhi_u(((uint32_t)w[k + 1] - w[k]) << 15, fraction);
}

/* In: sin^2 theta_h, 1.0 = 2^31. */
static uint32_t h_coordinate(const struct lut_table *t, uint32_t s2)
{
    uint32_t x = s2 + (1u << 15);
    if (x >= 1u << 31) {
        return (uint32_t)t->warp_h[LUT_WARP_H_NODES - 1] << 15;
    }
    unsigned zeros = fx_clz(x); /* 1 .. 16: x in 2^-zeros .. 2^(1-zeros) */
    x <<= zeros;
    return warp_between(t->warp_h, 8 * (16 - zeros) + (x >> 28 & 7), x << 4);
}

uint32_t lut_d_coordinate(const struct lut_table *t, uint32_t sine, uint32_t cosine)
{
    int32_t y = fx_clamp((1 << 27) + (int32_t)sine - (int32_t)cosine, 0, (1 << 28) - 1); /* 1.0 = 2^28 */
    return warp_between(t->warp_d, (uint32_t)y >> 22, (uint32_t)y << 10);
}

struct lut_rgb lut_half_vector(const struct lut_table *t, struct vec3 n, struct vec3 l, struct vec3 v)
{
    struct vec3_64 n1 = unit(n), l1 = unit(l), v1 = unit(v); /* sin^2 theta_h near 1 feels the length of n, too */
    struct vec3_64 h = {l1.x + v1.x, l1.y + v1.y, l1.z + v1.z}, d = {l1.x - v1.x, l1.y - v1.y, l1.z - v1.z};
    struct vec3_64 c = {(n1.y * h.z - n1.z * h.y) >> 29, (n1.z * h.x - n1.x * h.z) >> 29,
                        (n1.x * h.y - n1.y * h.x) >> 29};
    uint64_t h2 = square64(h), d2 = square64(d); /* 1.0 = 2^58, sum 4 */
    struct real nh = real_make(fx_magnitude(dot_vec3_64(n1, h))),
                nd = real_make(fx_magnitude(dot_vec3_64(n1, d))); /* 1.0 = 2^58 */
    struct real c2 = real_make(square64(c));
    uint32_t s2 = 0, t2 = 0;
    if (!nh.m) /* n.l and n.v of a unit in the last place */
        return (struct lut_rgb){{0, 0, 0}, 0};
    if (c2.m && h2)
        s2 = real_fixed(real_div(c2, real_make(h2)), 31, 1u << 31);
    uint32_t cosine2 = (uint32_t)(h2 >> 29); /* 1.0 = 2^31 */
    if (nd.m && s2 > cosine2) {
        struct real q = real_div(nd, nh);
        t2 = real_fixed(real_mul(q, q), 24, 1u << 24);
    } else if (nd.m && c2.m && d2) { /* (n.d)^2/d^2 / (c^2/h^2) */
        struct real q = real_div(real_mul(nd, nd), real_make(d2));
        q = real_div(real_mul(q, real_make(h2)), c2);
        t2 = real_fixed(q, 24 - 58, 1u << 24);
    }
    struct lut_rgb g =
        lut_interpolate(t->texels, t->width, t->height, lut_cell_find(t2 * (t->width - 1), 24, t->width),
                        lut_cell_find(h_coordinate(t, s2), 24, t->height),
                        lut_cell_find(lut_d_coordinate(t, root(d2 >> 4), root(h2 >> 4)), LUT_D_BITS, t->depth));
    /* f = g / (n.l + n.v): the sum is nh.m 2^(nh.e - 58), its reciprocal r 2^(-61 + 58 - nh.e), r <= 2^30 */
    uint32_t r = fx_recip(nh.m) << 2; /* wraps to 0 for 2^30 alone */
    r = r ? r : UINT32_MAX;
    for (int k = 0; k < 3; k++)
        g.c[k] = (fx_mulhi_u(g.c[k], r) + 128) >> 8; /* < 2^21 */
    g.e += 32 + 8 - 2 - 61 + 58 - nh.e + t->scale;
    return g;
}
