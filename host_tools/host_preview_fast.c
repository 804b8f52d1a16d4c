/* A material sampled finely, for pictures that evaluate it millions of times (host_preview_internal.h). */
#include "host_preview_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_parallel.h"

/*
 * Nodes over what is quickly found from two directions: the half angle, at (1 - cos theta_h)^(1/4), close together towards 0; the
 * difference angle, at (1 - cos theta_d)^(1/2), in about equal steps; and its azimuth phi_d, along a square instead of a circle, which
 * closes. Any isotropic BRDF, reciprocal or not (Rusinkiewicz 1998, "A new change of variables for efficient BRDF representation").
 * Values are times (n.l + n.v), which keeps them finite at the horizon, and last the share of extrapolated ones.
 */
struct preview_fast {
    const struct preview *preview;
    int h, d, p;
    float (*value)[4];
};

/* Around the square |x| + |y| = 1, 0..4, as its angle. */
static double square_angle(double x, double y)
{
    double sum = fabs(x) + fabs(y);
    if (!(sum > 0))
        return 0;
    return y >= 0 ? 1 - x / sum : 3 + x / sum;
}

/* l and v for coordinates in 0..1; what is below the horizon is raised to it. */
static void node_directions(double l[3], double v[3], double h, double d, double p)
{
    double ch = 1 - h * h * h * h, sh = sqrt(1 - ch * ch), cd = 1 - d * d, sd = sqrt(1 - cd * cd);
    double x = p < 0.5 ? 1 - 4 * p : 4 * p - 3, y = (p < 0.5 ? 1 : -1) * (1 - fabs(x)), length = sqrt(x * x + y * y);
    x *= sd / length;
    y *= sd / length;
    const double along[3] = {cd * sh, 0, cd * ch}, off[3] = {x * ch, y, -x * sh};
    for (int side = 0; side < 2; side++) {
        double *out = side ? v : l, norm = 0;
        for (int c = 0; c < 3; c++)
            out[c] = along[c] + (side ? -off[c] : off[c]);
        out[2] = fmax(out[2], 0.003);
        for (int c = 0; c < 3; c++)
            norm += out[c] * out[c];
        for (int c = 0; c < 3; c++)
            out[c] /= sqrt(norm);
    }
}

static void sample_row(void *ctx, int i)
{
    const struct preview_fast *t = ctx;
    const struct brdf_source *f = &t->preview->source;
    for (int j = 0; j < t->d; j++)
        for (int k = 0; k < t->p; k++) {
            float *out = t->value[(i * t->d + j) * t->p + k];
            double l[3], v[3], rgb[3];
            node_directions(l, v, (double)i / (t->h - 1), (double)j / (t->d - 1), (double)k / t->p);
            f->value(rgb, f->ctx, l, v);
            for (int c = 0; c < 3; c++)
                out[c] = (float)(rgb[c] * (l[2] + v[2]));
            out[3] = preview_mark(t->preview, l, v) == MEASUREMENT_EXTRAPOLATED;
        }
}

struct preview_fast *preview_fast_make(const struct preview *p, int quality, int threads)
{
    struct preview_fast *t = xmalloc(sizeof *t);
    *t = (struct preview_fast){p, 64 * quality, 32 * quality, 32 * quality, NULL};
    t->value = xmalloc((size_t)t->h * (size_t)t->d * (size_t)t->p * sizeof *t->value);
    parallel_for(threads, t->h, sample_row, t);
    return t;
}

void preview_fast_free(struct preview_fast *t)
{
    free(t->value);
    free(t);
}

static void read(double out[4], const struct preview_fast *t, const double l[3], const double v[3])
{
    double h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]}, flat2 = h[0] * h[0] + h[1] * h[1], flat = sqrt(flat2);
    double length = sqrt(flat2 + h[2] * h[2]), rise = flat2 / (length * (length + h[2])); /* 1 - cos theta_h */
    /* Direction of l around h; (1, 0) is the plane of h and n, away from n. */
    double x = flat > 1e-12 ? (h[2] * (h[0] * l[0] + h[1] * l[1]) / flat - flat * l[2]) / length : l[0];
    double y = flat > 1e-12 ? (h[0] * l[1] - h[1] * l[0]) / flat : l[1];
    double at[3] = {sqrt(sqrt(rise)) * (t->h - 1), sqrt(fmax(1 - length / 2, 0)) * (t->d - 1),
                    square_angle(x, y) / 4 * t->p};
    int i = (int)fmin(at[0], t->h - 2), j = (int)fmin(at[1], t->d - 2), k = (int)at[2];
    double u = at[0] - i, w = at[1] - j, r = at[2] - k;
    for (int c = 0; c < 4; c++)
        out[c] = 0;
    for (int corner = 0; corner < 8; corner++) {
        int a = corner & 1, b = corner >> 1 & 1, e = corner >> 2;
        const float *value = t->value[((i + a) * t->d + j + b) * t->p + (k + e) % t->p];
        double weight = (a ? u : 1 - u) * (b ? w : 1 - w) * (e ? r : 1 - r);
        for (int c = 0; c < 4; c++)
            out[c] += weight * value[c];
    }
    for (int c = 0; c < 3; c++)
        out[c] /= h[2];
}

static void fast_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    double all[4];
    read(all, ctx, l, v);
    memcpy(rgb, all, 3 * sizeof *rgb);
}

static void extrapolated_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    double all[4];
    read(all, ctx, l, v);
    for (int c = 0; c < 3; c++)
        rgb[c] = all[c] * all[3];
}

void preview_fast_source(struct brdf_source *out, const struct preview_fast *t)
{
    *out = (struct brdf_source){.value = fast_value, .ctx = (void *)t, .theta_in = 90, .theta_out = 90};
}

void preview_fast_extrapolated(struct brdf_source *out, const struct preview_fast *t)
{
    preview_fast_source(out, t);
    out->value = extrapolated_value;
}
