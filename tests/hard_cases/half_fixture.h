/*
 * Half-vector tables made by hand, opened by the product and by the reference.
 */
#ifndef HALF_FIXTURE_H
#define HALF_FIXTURE_H

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lut.h"
#include "ref_table.h"

static const double degree = 3.14159265358979323846 / 180;
static const struct vec3 up = {0, 0, 32768};
static uint64_t half_seed = 1;

static inline uint32_t half_random(void)
{
    half_seed = half_seed * 6364136223846793005u + 1442695040888963407u;
    uint32_t x = (uint32_t)(half_seed >> 33);
    return x * 2654435761u ^ x >> 15;
}

static inline double half_uniform(double low, double high)
{
    return low + (high - low) * half_random() * 0x1p-32;
}

/* Nearest q17_15_t components of a direction of any length. */
static inline struct vec3 half_quantise(double x, double y, double z)
{
    double s = 32768 / sqrt(x * x + y * y + z * z);
    return (struct vec3){(int32_t)lrint(x * s), (int32_t)lrint(y * s), (int32_t)lrint(z * s)};
}

/* Polar angle from `up`, azimuth from x; degrees. */
static inline struct vec3 half_direction(double theta, double phi)
{
    double s = sin(theta * degree);
    return half_quantise(s * cos(phi * degree), s * sin(phi * degree), cos(theta * degree));
}

static inline struct vec3 half_any(void)
{
    double z = half_uniform(-1, 1), a = half_uniform(0, 360);
    return half_direction(acos(z) / degree, a);
}

struct half_table {
    uint32_t *texels;
    void *file;
    struct lut_table lut;
    struct ref_table *ref;
};

/* Takes over f->texels. The file lies in a heap block of its size that ends with the last texel. */
static inline struct half_table half_open(const struct ref_half *f)
{
    struct half_table t = {.texels = (uint32_t *)f->texels};
    size_t bytes;
    t.file = ref_half_make(f, &bytes);
    assert_string_equal(lut_status_text(lut_open(&t.lut, t.file, bytes)), lut_status_text(LUT_OK));
    t.ref = ref_table_open(t.file, bytes);
    assert_non_null(t.ref);
    return t;
}

static inline void half_close(struct half_table *t)
{
    free(t->texels);
    free(t->file);
    ref_table_free(t->ref);
}

/* Noise between these exponents, constant in t where the azimuth is undefined: at l = v and at h = n. */
static inline struct half_table half_noise(unsigned h, unsigned d, unsigned t, unsigned exponent_low,
                                           unsigned exponents, double width)
{
    struct ref_half f = {.t = t, .h = h, .d = d};
    uint32_t *texels = malloc(sizeof *texels * t * h * d);
    for (unsigned i = 0; i < t * h * d; i++) {
        bool constant = i % t > 0 && (i / t < h || i / t % h == 0);
        texels[i] = constant ? texels[i - 1]
                             : (half_random() & 0x7ffffff) | 0x100u << half_random() % 3 * 9 |
                                   (exponent_low + half_random() % exponents) << 27;
    }
    f.texels = texels;
    ref_half_warp(&f, width);
    return half_open(&f);
}

static inline struct half_table half_sampled(unsigned h, unsigned d, unsigned t, double width, ref_brdf_function *brdf,
                                             const void *context)
{
    struct ref_half f = {.t = t, .h = h, .d = d};
    ref_half_warp(&f, width);
    ref_half_sample(&f, brdf, context);
    return half_open(&f);
}

/* The product's evaluation of a struct half_table as a BRDF in double precision; vectors are quantised. */
static inline void half_product(double rgb[3], const void *table, const double n[3], const double l[3],
                                const double v[3])
{
    struct lut_rgb out;
    lut_eval(&out, &((const struct half_table *)table)->lut, half_quantise(n[0], n[1], n[2]),
             half_quantise(l[0], l[1], l[2]), half_quantise(v[0], v[1], v[2]));
    for (int c = 0; c < 3; c++)
        rgb[c] = ldexp(out.c[c], out.e);
}

/* Error in units of the largest node around. In: n.l, n.v > 0. */
static inline double half_error(const struct half_table *t, struct vec3 n, struct vec3 l, struct vec3 v)
{
    struct lut_rgb out;
    double exact[3], worst = 0;
    double dn[3] = {n.x, n.y, n.z}, dl[3] = {l.x, l.y, l.z}, dv[3] = {v.x, v.y, v.z};
    double largest = ref_table_eval(exact, t->ref, dn, dl, dv);
    assert_int_equal(lut_eval(&out, &t->lut, n, l, v), 8);
    for (int c = 0; c < 3; c++)
        worst = fmax(worst, fabs(ldexp(out.c[c], out.e) - exact[c]));
    return worst / largest;
}

#endif
