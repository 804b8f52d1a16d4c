/* Table files; the specular-frame table after Cezner and Havran (2024), eqs. 14-16, literally. */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "ref_table.h"

static const double pi = 3.14159265358979323846;

static uint64_t number_at(const uint8_t *p, unsigned bytes)
{
    uint64_t x = 0;
    for (unsigned i = 0; i < bytes; i++) {
        x += (uint64_t)p[i] << (8 * i);
    }
    return x;
}

void ref_rgb9e5_decode(double rgb[3], uint32_t word)
{
    int exponent = 0;
    for (int bit = 0; bit < 5; bit++) {
        exponent += (int)(word >> (27 + bit) & 1) << bit;
    }
    for (int c = 0; c < 3; c++) {
        rgb[c] = 0;
        for (int bit = 0; bit < 9; bit++) { /* the mantissa is a fraction of 512, the bias 15 */
            rgb[c] += (word >> (9 * c + bit) & 1) ? ldexp(1, bit - 9 + exponent - 15) : 0;
        }
    }
}

uint32_t ref_rgb9e5_encode(const double rgb[3])
{
    double c[3], largest = 0;
    for (int k = 0; k < 3; k++) {
        c[k] = rgb[k] > 0 ? fmin(rgb[k], 65408) : 0; /* NaN too */
        largest = fmax(largest, c[k]);
    }
    for (int exponent = 0;; exponent++) { /* the smallest whose mantissas fit */
        double unit = ldexp(1, exponent - 24);
        if (floor(largest / unit + 0.5) < 512) {
            uint32_t word = (uint32_t)exponent << 27;
            for (int k = 0; k < 3; k++)
                word |= (uint32_t)floor(c[k] / unit + 0.5) << (9 * k);
            return word;
        }
    }
}

/* The value of a key, or NULL. */
static const uint8_t *key_find(uint64_t *bytes, const uint8_t *p, uint64_t length, const char *key)
{
    for (uint64_t at = 0; at + 4 < length;) {
        uint64_t n = number_at(p + at, 4), name = strlen(key) + 1;
        if (n > length - at - 4) {
            return NULL;
        }
        if (n >= name && memcmp(p + at + 4, key, name) == 0) {
            *bytes = n - name;
            return p + at + 4 + name;
        }
        at += 4 + (n + 3) / 4 * 4;
    }
    return NULL;
}

/* A text value, or NULL when the key is missing or is not text. */
static const char *text_find(const uint8_t *p, uint64_t length, const char *key)
{
    uint64_t n;
    const uint8_t *value = key_find(&n, p, length, key);
    return value && n > 0 && value[n - 1] == 0 ? (const char *)value : NULL;
}

static bool warp_read(double *out, const uint8_t *p, uint64_t length, const char *key, unsigned nodes)
{
    uint64_t n;
    const uint8_t *value = key_find(&n, p, length, key);
    for (unsigned i = 0; value && n == 2 * nodes && i < nodes; i++) {
        out[i] = (double)number_at(value + 2 * i, 2) / 512;
    }
    return value && n == 2 * nodes;
}

/* Reads what each kind says about its axes. */
static bool metadata_read(struct ref_table *t, const uint8_t *p, uint64_t length)
{
    const char *kind = text_find(p, length, "goniotile.kind"), *theta_max = text_find(p, length, "goniotile.theta_max");
    const char *swap = text_find(p, length, "goniotile.swap"), *scale = text_find(p, length, "goniotile.scale");
    if (kind && strcmp(kind, "specular_frame") == 0 && theta_max) {
        t->kind = REF_SPECULAR_FRAME;
        t->theta_max = strtod(theta_max, NULL) / 1000 / 180 * pi;
        t->swap = swap && strcmp(swap, "1") == 0;
        return true;
    }
    t->kind = REF_HALF_VECTOR;
    t->scale = ldexp(1, scale ? atoi(scale) : 0);
    return kind && strcmp(kind, "half_vector") == 0 && warp_read(t->warp_h, p, length, "goniotile.warph", REF_WARP_H) &&
           warp_read(t->warp_d, p, length, "goniotile.warpd", REF_WARP_D);
}

struct ref_table *ref_table_open(const void *bytes, size_t n)
{
    const uint8_t *p = bytes;
    if (n < 104 || memcmp(p, "\xabKTX 20\xbb\r\n\x1a\n", 12) != 0 || number_at(p + 12, 4) != 123) {
        return NULL;
    }
    uint64_t w = number_at(p + 20, 4), h = number_at(p + 24, 4), d = number_at(p + 28, 4);
    uint64_t keys = number_at(p + 56, 4), keys_length = number_at(p + 60, 4), data = number_at(p + 80, 8);
    if (w < 2 || h < 2 || d < 1 || w > 65536 || h > 65536 || d > 65536 || keys + keys_length > n || data > n ||
        w * h * d > (n - data) / 4) {
        return NULL;
    }
    struct ref_table *t = calloc(1, sizeof *t);
    if (!t) {
        abort();
    }
    if (!metadata_read(t, p + keys, keys_length)) {
        free(t);
        return NULL;
    }
    t->width = (unsigned)w;
    t->height = (unsigned)h;
    t->depth = (unsigned)d;
    t->texels = malloc(w * h * d * sizeof *t->texels);
    if (!t->texels) {
        abort();
    }
    for (uint64_t i = 0; i < w * h * d; i++) {
        double rgb[3];
        ref_rgb9e5_decode(rgb, (uint32_t)number_at(p + data + 4 * i, 4));
        for (int c = 0; c < 3; c++) {
            t->texels[i][c] = (float)rgb[c]; /* 9 significant bits: exact */
        }
    }
    return t;
}

void ref_table_free(struct ref_table *t)
{
    if (t) {
        free(t->texels);
        free(t);
    }
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double normalise(double out[3], const double a[3])
{
    double length = sqrt(dot(a, a));
    for (int i = 0; i < 3; i++) {
        out[i] = a[i] / length;
    }
    return length;
}

/* Node index and fraction of a coordinate in 0..nodes-1. */
static unsigned cell_find(double *fraction, double x, unsigned nodes)
{
    double last = nodes - 1;
    x = x < 0 ? 0 : x > last ? last : x;
    unsigned i = (unsigned)x;
    *fraction = x - i;
    return i;
}

/* Largest channel from one node below the cell to one above it; phi_d wraps. */
static double largest_around(const struct ref_table *t, const unsigned cell[3])
{
    double largest = 0;
    for (unsigned i = 0; i < 64; i++) {
        long x = (long)cell[0] - 1 + (i & 3), y = (long)cell[1] - 1 + (i >> 2 & 3), z = (long)cell[2] - 1 + (i >> 4);
        x = (x + (long)t->width - 1) % ((long)t->width - 1);
        if (y >= 0 && y < (long)t->height && z >= 0 && z < (long)t->depth) {
            const float *texel = t->texels[((size_t)z * t->height + (size_t)y) * t->width + (size_t)x];
            largest = fmax(largest, fmax(texel[0], fmax(texel[1], texel[2])));
        }
    }
    return largest;
}

static double specular_frame_eval(double rgb[3], const struct ref_table *t, const double n[3], const double l[3],
                                  const double v[3])
{
    double x[3], y[3], nl = dot(n, l);
    /* tangent frame: x is l projected (any direction when l = n), y = n x x */
    for (int i = 0; i < 3; i++) {
        x[i] = l[i] - nl * n[i];
    }
    double sine = sqrt(dot(x, x));
    if (sine < 1e-12) {
        double axis[3] = {0, 0, 0};
        axis[fabs(n[0]) < 0.6 ? 0 : 1] = 1;
        for (int i = 0; i < 3; i++) {
            x[i] = axis[i] - dot(axis, n) * n[i];
        }
    }
    normalise(x, x);
    for (int i = 0; i < 3; i++) {
        y[i] = n[(i + 1) % 3] * x[(i + 2) % 3] - n[(i + 2) % 3] * x[(i + 1) % 3];
    }
    double theta_in = atan2(sine, nl), c = cos(theta_in), s = sin(theta_in);
    double local[3] = {dot(v, x), dot(v, y), dot(v, n)};
    double omega[3] = {-c * local[0] - s * local[2], -local[1], -s * local[0] + c * local[2]};
    double phi_d = atan2(omega[1], omega[0]), theta_d = atan2(hypot(omega[0], omega[1]), omega[2]);
    phi_d = phi_d < 0 ? phi_d + 2 * pi : phi_d;

    const unsigned size[3] = {t->width, t->height, t->depth};
    rgb[0] = rgb[1] = rgb[2] = 0;
    double f[3];
    unsigned cell[3] = {cell_find(&f[0], phi_d / (2 * pi) * (t->width - 1), t->width),
                        cell_find(&f[1], theta_d / pi * (t->height - 1), t->height),
                        cell_find(&f[2], theta_in / t->theta_max * (t->depth - 1), t->depth)};
    for (unsigned tap = 0; tap < 8; tap++) {
        unsigned at[3];
        double weight = 1;
        for (int a = 0; a < 3; a++) {
            bool upper = tap >> a & 1;
            at[a] = upper && cell[a] + 1 < size[a] ? cell[a] + 1 : cell[a];
            weight *= upper ? f[a] : 1 - f[a];
        }
        for (int k = 0; k < 3; k++) {
            rgb[k] += weight * t->texels[((size_t)at[2] * t->height + at[1]) * t->width + at[0]][k];
        }
    }
    return largest_around(t, cell);
}

double ref_table_eval(double rgb[3], const struct ref_table *t, const double n_in[3], const double l_in[3],
                      const double v_in[3])
{
    double n[3], l[3], v[3];
    bool swap = t->swap && dot(n_in, l_in) < dot(n_in, v_in);
    normalise(n, n_in);
    normalise(l, l_in);
    normalise(v, v_in);
    rgb[0] = rgb[1] = rgb[2] = 0;
    if (dot(n, l) <= 0 || dot(n, v) <= 0) {
        return 0;
    }
    if (t->kind == REF_HALF_VECTOR) {
        return ref_half_eval(rgb, t, n, l, v);
    }
    return swap ? specular_frame_eval(rgb, t, n, v, l) : specular_frame_eval(rgb, t, n, l, v);
}
