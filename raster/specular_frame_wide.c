/*
 * The specular-frame table over a block, eight pixels at once (wide.h): the bits of specular_frame.c and of the functions that it
 * calls, whose comments are not repeated here.
 */
#if defined(__AVX2__)
#include "func_tables.h"
#include "specular_frame.h"
#include "wide.h"

struct specular_frame_lanes {
    struct wide_pixels p;
    wide x[WIDE_GROUPS], y[WIDE_GROUPS];       /* phi_d is their azimuth */
    wide s[2][WIDE_GROUPS];                    /* sin^2 of half of theta_in, theta_d, from their nearest pole, Q30 */
    wide far[WIDE_GROUPS];                     /* all ones where that is the other pole of theta_d */
    wide f[2][WIDE_GROUPS], z[2][WIDE_GROUPS]; /* s 2^z, 2^30 and above; z is even */
    wide node[2][WIDE_GROUPS];                 /* of func_rsqrt: two */
    wide angle[2][WIDE_GROUPS];
    wide texel_at[WIDE_GROUPS], row[WIDE_GROUPS], slice[WIDE_GROUPS]; /* words: of the first texel, to the others */
    wide fx[WIDE_GROUPS], fy[WIDE_GROUPS], fz[WIDE_GROUPS];           /* of 2^16 */
    struct wide_couples couple[4][WIDE_GROUPS];
};

struct product {
    wide_long even, odd;
};

static inline struct product multiply(wide a, wide b)
{
    return (struct product){
        (wide_long)__builtin_ia32_pmuludq256((wide_int)a, (wide_int)b),
        (wide_long)__builtin_ia32_pmuludq256((wide_int)((wide_long)a >> 32), (wide_int)((wide_long)b >> 32))};
}

static inline wide low_words(wide_long even, wide_long odd)
{
    return __builtin_shufflevector((wide)even, (wide)(odd << 32), 0, 9, 2, 11, 4, 13, 6, 15);
}

/* a b >> 31, signed. */
static inline wide multiply31(wide a, wide b)
{
    const wide_long even = (wide_long)__builtin_ia32_pmuldq256((wide_int)a, (wide_int)b),
                    odd = (wide_long)__builtin_ia32_pmuldq256((wide_int)((wide_long)a >> 32),
                                                              (wide_int)((wide_long)b >> 32));
    return __builtin_shufflevector((wide)(even >> 31), (wide)(odd << 1), 0, 9, 2, 11, 4, 13, 6, 15);
}

/* Eight cells of a function's nodes, as `interpolate` in func.c takes them: g = f - 1, 1.0 = 2^31. */
struct cells {
    wide t1, d1, d2;
};

static inline struct cells cells_load(const int32_t *t)
{
    const wide before = wide_load((const uint32_t *)t), t0 = wide_load((const uint32_t *)t + 1),
               t1 = wide_load((const uint32_t *)t + 2), t2 = wide_load((const uint32_t *)t + 3);
    return (struct cells){t1, t1 - t0, t2 - t1 - t0 + before};
}

static inline wide wide_interpolate(wide t1, wide d1, wide d2, wide g)
{
    const wide bow = wide_mulhi_signed(g, g) + wide_shift_signed(g, 1);
    return t1 + multiply31(d1, g) + wide_mulhi_signed(d2, bow);
}

static void directions_find(struct specular_frame_lanes *o, const struct raster_block_light *light, bool swap)
{
    const wide one = wide_all(1u << 30);
    const wide lx = wide_all((uint32_t)lane_low(light->l_xy)), ly = wide_all((uint32_t)lane_high(light->l_xy)),
               lz = wide_all((uint32_t)light->l_z);
    for (uint32_t i = 0; WIDE_LANES * i < o->p.count; i++) {
        const wide x = o->p.at[i] & 255, y = o->p.at[i] >> 8, xy = o->p.normal_xy[i], z = o->p.normal_z[i];
        const wide ab_z = wide_plane(&light->plane[PLANE_AB_Z], x, y);
        const wide na = wide_dot16(xy, wide_plane(&light->plane[PLANE_A_XY], x, y)) + wide_dot16(z & 0xffff, ab_z);
        const wide nb = wide_dot16(xy, wide_plane(&light->plane[PLANE_B_XY], x, y)) + wide_dot16(z << 16, ab_z);
        wide nl = wide_min(o->p.nl[i], one), nv = wide_min(o->p.nv[i], one),
             sine = wide_plane(&light->plane[PLANE_TERM], x, y) << 3;
        const wide q = wide_min(wide_mulhi_signed(na, na) + wide_mulhi_signed(nb, nb), one >> 2);
        const wide dx = wide_shift_signed(xy << 16, 16) - lx, dy = wide_shift_signed(xy, 16) - ly, dz = z - lz;
        wide half_in = (dx * dx >> 2) + (dy * dy >> 2) + (dz * dz >> 2);
        if (swap) {
            const wide less = wide_below(nl, nv), larger = wide_max(nl, nv);
            nv = wide_min(nl, nv);
            nl = larger;
            sine = (sine ^ less) - less;
            half_in = wide_select(less, (one - nl) >> 1, half_in);
        }
        o->x[i] = nl - nv - (wide_mulhi(nl, q << 3) << 2);
        o->y[i] = 0 - wide_mulhi_signed(nb, sine) * 8;
        const wide far = wide_below(one >> 1, q << 2);
        o->far[i] = far;
        o->s[0][i] = wide_min(half_in, one >> 1);
        o->s[1][i] = wide_select(far, one - (q << 2), q << 2);
    }
}

/* s 2^z, for lut_rsqrt. */
static void normalise(struct specular_frame_lanes *o, uint32_t which)
{
    for (uint32_t i = 0; WIDE_LANES * i < o->p.count; i++) {
        wide f = wide_max(o->s[which][i], wide_all(1)), z = wide_all(0);
        for (unsigned step = 16; step > 1; step >>= 1) {
            const wide by = (wide)(f >> (32 - step) == 0) & step;
            f <<= by;
            z += by;
        }
        o->f[which][i] = f;
        o->z[which][i] = z;
        o->node[which][i] = (f >> 26) - 16;
    }
    wide_pad(o->node[which], o->p.count);
    uint32_t *const node = wide_lanes(o->node[which]);
    for (uint32_t i = 0; i < o->p.count; i++)
        __builtin_memcpy(&node[i], func_rsqrt + node[i], 4);
}

/* lut_angle_from_sin2_half */
static void angle_find(struct specular_frame_lanes *o, uint32_t which)
{
    const struct cells cells = cells_load(func_angle);
    for (uint32_t i = 0; WIDE_LANES * i < o->p.count; i++) {
        const wide s2 = o->s[which][i], f = o->f[which][i], z = o->z[which][i] >> 1, node = o->node[which][i];
        const wide a = node & 0xffff, y = (a << 16) - (a - (node >> 16)) * (f >> 10 & 0xffff);
        const wide d = (3u << 28) - wide_mulhi(f, wide_mulhi(y, y));
        const wide m = wide_mulhi(y, d) << 3; /* at most 2^31 */
        const wide root =
            wide_mulhi(f, wide_select((wide)(m >> 30 == 0), wide_all(1u << 30), m)); /* sqrt(s2) 2^(29 + z) */
        const wide at = (s2 - 1) >> 26; /* a node is the end of the cell before it: the same value */
        const wide slope = wide_mulhi(root, wide_interpolate(wide_look_up(cells.t1, at), wide_look_up(cells.d1, at),
                                                             wide_look_up(cells.d2, at), (s2 - ((at + 1) << 26)) << 5));
        const wide angle = (slope + (wide_all(1) << z >> 1)) >> z;
        o->angle[which][i] = angle & ~(wide)(s2 == 0);
    }
}

/* small 2^32/large: as in lut_turn. In: den 2^15 .. 2^16-1, quotient at most 2^17. */
static inline wide quotient(wide num, wide den)
{
    const wide inverse = wide_reciprocal(den);
    wide q = (num >> 16) * inverse >> 15, rest = num - q * den; /* at most 11 too small */
    const wide more = (rest >> 4) * inverse >> 27;
    q += more;
    rest -= more * den;
    return q - ~wide_below(rest, den);
}

static inline wide add_saturating(wide a, wide b)
{
    const wide sum = a + b, sign = wide_all(1u << 31);
    return sum | wide_below(sum ^ sign, a ^ sign);
}

/* lut_turn of y and x. */
static inline wide turn(wide y, wide x, const struct cells *low, const struct cells *high)
{
    const wide sign = wide_all(1u << 31), x_minus = wide_shift_signed(x, 31), y_minus = wide_shift_signed(y, 31);
    const wide ax = (x ^ x_minus) - x_minus, ay = (y ^ y_minus) - y_minus;
    const wide steep = wide_below(ax ^ sign, ay ^ sign);
    wide small = wide_select(steep, ax, ay), large = wide_select(steep, ay, ax);
    const wide none = (wide)(large == 0);
    large |= none & 1;
    for (unsigned step = 16; step; step >>= 1) {
        const wide by = (wide)(large >> (32 - step) == 0) & step;
        large <<= by;
        small <<= by;
    }
    const wide d = add_saturating(large, wide_all(1u << 15)) >> 16;
    const wide q = wide_min(quotient(add_saturating(small, d >> 1), d), wide_all(65535));
    const wide at = q >> 12, upper = wide_below(wide_all(7), at), g = ((q & 4095) << 19) ^ sign;
    wide a = wide_interpolate(wide_select(upper, wide_look_up(high->t1, at), wide_look_up(low->t1, at)),
                              wide_select(upper, wide_look_up(high->d1, at), wide_look_up(low->d1, at)),
                              wide_select(upper, wide_look_up(high->d2, at), wide_look_up(low->d2, at)), g);
    a = wide_select(steep, (1u << 26) - a, a);
    a = wide_select(x_minus, (1u << 27) - a, a);
    a = wide_select(y_minus, (1u << 28) - a, a) & ((1u << 28) - 1);
    return a & ~none;
}

struct axis {
    wide node, step, fraction; /* step: all ones where there is a next node */
};

/* lut_cell_find of angle scale 2^-32, 12 bits. */
static inline struct axis axis_find(wide angle, uint32_t scale, uint32_t nodes)
{
    const wide x = wide_mulhi(angle, wide_all(scale)), inside = wide_below(x, wide_all((nodes - 1) << 12));
    return (struct axis){wide_select(inside, x >> 12, wide_all(nodes - 1)), inside, (x << 4 & 65535) & inside};
}

static void texels_find(struct specular_frame_lanes *o, const struct lut_table *t)
{
    const struct cells low = cells_load(func_atan), high = cells_load(func_atan + 8);
    for (uint32_t i = 0; WIDE_LANES * i < o->p.count; i++) {
        const wide theta_d = wide_select(o->far[i], (1u << 28) - o->angle[1][i], o->angle[1][i]);
        const struct axis x = axis_find(turn(o->y[i], o->x[i], &low, &high), (t->width - 1) << 16, t->width),
                          y = axis_find(theta_d, (t->height - 1) << 16, t->height),
                          z = axis_find(o->angle[0][i], t->slice_scale, t->depth);
        o->texel_at[i] = (z.node * t->height + y.node) * t->width + x.node;
        o->row[i] = y.step & t->width;
        o->slice[i] = z.step & t->width * t->height;
        o->fx[i] = x.fraction;
        o->fy[i] = y.fraction;
        o->fz[i] = z.fraction;
    }
    wide_pad(o->texel_at, o->p.count);
    wide_pad(o->row, o->p.count);
    wide_pad(o->slice, o->p.count);
}

/* phi_d is below a full turn, so that there is always a next node. */
static void texels_fetch(struct specular_frame_lanes *o, const struct lut_table *t)
{
    static const uint8_t place[WIDE_LANES] = {0, 1, 4, 5, 2, 3, 6, 7};
    const uint32_t *const at = wide_lanes(o->texel_at), *const row = wide_lanes(o->row),
                          *const slice = wide_lanes(o->slice);
    for (uint32_t i = 0; WIDE_LANES * i < o->p.count; i++)
#pragma GCC unroll 8
        for (uint32_t j = 0; j < WIDE_LANES; j++) {
            const uint32_t k = WIDE_LANES * i + j;
            const uint32_t *p = t->texels + at[k], *q = p + slice[k];
            __builtin_memcpy(o->couple[0][i].texel[place[j]], p, 8);
            __builtin_memcpy(o->couple[1][i].texel[place[j]], p + row[k], 8);
            __builtin_memcpy(o->couple[2][i].texel[place[j]], q, 8);
            __builtin_memcpy(o->couple[3][i].texel[place[j]], q + row[k], 8);
        }
}

/* weight_split of interpolate.c */
static inline wide split(wide *w, wide fraction)
{
    const struct product p = multiply(*w, fraction);
    const wide upper = low_words((p.even + 32768) >> 16, (p.odd + 32768) >> 16);
    *w -= upper;
    return upper;
}

/* c irradiance 2^-down, limited to what a light may add. */
static inline wide wide_contribution(wide c, uint32_t irradiance, wide down)
{
    const struct product p = multiply(c, wide_all(irradiance));
    const wide_long most = (wide_long)(wide_all(RASTER_LIGHT_LIMIT) & (wide){~0u, 0, ~0u, 0, ~0u, 0, ~0u, 0});
    const wide_long even = p.even >> ((wide_long)down & 0xffffffff), odd = p.odd >> ((wide_long)down >> 32);
    const wide_long even_over = (wide_long)(even > most), odd_over = (wide_long)(odd > most);
    return low_words((most & even_over) | (even & ~even_over), (most & odd_over) | (odd & ~odd_over));
}

static void wide_shade(struct raster_batch *b, struct specular_frame_lanes *o, const struct raster_block_light *light)
{
    for (uint32_t i = 0; WIDE_LANES * i < o->p.count; i++) {
        wide w[4] = {wide_all(1u << 20)}, texel[8], largest = wide_all(0), s[3] = {largest, largest, largest}, x[3];
        w[2] = split(&w[0], o->fz[i]);
        w[1] = split(&w[0], o->fy[i]);
        w[3] = split(&w[2], o->fy[i]);
#pragma GCC unroll 4
        for (int k = 0; k < 4; k++) {
            const wide a = wide_load(o->couple[k][i].texel[0]), c = wide_load(o->couple[k][i].texel[4]);
            texel[2 * k] = __builtin_shufflevector(a, c, 0, 2, 8, 10, 4, 6, 12, 14);
            texel[2 * k + 1] = __builtin_shufflevector(a, c, 1, 3, 9, 11, 5, 7, 13, 15);
            largest = wide_max(largest, wide_max(texel[2 * k] >> 27, texel[2 * k + 1] >> 27));
        }
#pragma GCC unroll 4
        for (int k = 0; k < 4; k++) {
            const wide upper = split(&w[k], o->fx[i]);
            const wide weight[2] = {w[k], upper};
#pragma GCC unroll 2
            for (int j = 0; j < 2; j++) {
                const wide t = texel[2 * k + j], share = weight[j] >> (largest - (t >> 27));
                s[0] += (t & 511) * share;
                s[1] += (t >> 9 & 511) * share;
                s[2] += (t >> 18 & 511) * share;
            }
        }
        const wide cosine = wide_min(o->p.nl[i], wide_all((1u << 30) - 1)) << 2;
#pragma GCC unroll 3
        for (int k = 0; k < 3; k++)
            x[k] = wide_contribution(wide_mulhi((s[k] + 128) >> 8 << 10, cosine), light->colour[k], 42 - largest);
        wide_add_radiance(b, &o->p, WIDE_LANES * i, x);
    }
}

uint32_t raster_specular_frame_wide(struct raster_batch *b, uint32_t end, const struct lut_table *t,
                                    const struct raster_block_light *light)
{
    struct specular_frame_lanes o;
    wide_gather(&o.p, b, end, light);
    if (!o.p.count)
        return 0;
    directions_find(&o, light, t->swap);
    for (uint32_t which = 0; which < 2; which++) {
        normalise(&o, which);
        angle_find(&o, which);
    }
    texels_find(&o, t);
    texels_fetch(&o, t);
    wide_shade(b, &o, light);
    return o.p.count;
}
#endif
