#include "host_envmap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

enum { ROUNDS = 100 }; /* of Lloyd's iteration; the data folder's maps settle within 60 */

/* Weight (luminance times solid angle) and weighted sum of the directions, of any set of pixels. */
struct moment {
    double weight, at[3];
};

static void moment_add(struct moment *sum, const struct moment *m, double sign)
{
    sum->weight += sign * m->weight;
    for (int c = 0; c < 3; c++)
        sum->at[c] += sign * m->at[c];
}

/* Sum of weight |direction - mean|^2. */
static double variance(const struct moment *m)
{
    double square = m->at[0] * m->at[0] + m->at[1] * m->at[1] + m->at[2] * m->at[2];
    return m->weight > 0 ? fmax(m->weight - square / m->weight, 0) : 0;
}

static double luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

/* A pixel that is not black. */
struct sample {
    double direction[3], weight, power[3];
    unsigned cluster;
};

static struct sample sample_of(const struct environment *e, int x, int y)
{
    const float *rgb = e->rgb + 3 * ((size_t)y * (size_t)e->width + (size_t)x);
    const double solid = environment_solid_angle(e, y);
    struct sample s = {.power = {rgb[0] * solid, rgb[1] * solid, rgb[2] * solid}};
    environment_direction(s.direction, e, x + 0.5, y + 0.5);
    s.weight = luminance(s.power);
    return s;
}

static struct moment moment_of(const struct sample *s)
{
    return (struct moment){s->weight,
                           {s->weight * s->direction[0], s->weight * s->direction[1], s->weight * s->direction[2]}};
}

/* --- cutting rectangles --- */

struct rectangle {
    int x0, y0, x1, y1; /* without the last */
};

/* Moments of the rectangles from the map's corner: (width + 1) x (height + 1). */
static struct moment *sums_make(const struct environment *e)
{
    const size_t stride = (size_t)e->width + 1;
    struct moment *sums = xcalloc(stride * ((size_t)e->height + 1), sizeof *sums);
    for (int y = 0; y < e->height; y++) {
        struct moment row = {0}, *out = sums + (size_t)(y + 1) * stride + 1;
        for (int x = 0; x < e->width; x++, out++) {
            const struct sample s = sample_of(e, x, y);
            const struct moment m = moment_of(&s);
            moment_add(&row, &m, 1);
            *out = row;
            moment_add(out, out - stride, 1);
        }
    }
    return sums;
}

static double rectangle_variance(const struct moment *sums, size_t stride, struct rectangle r)
{
    const struct moment *top = sums + (size_t)r.y0 * stride, *end = sums + (size_t)r.y1 * stride;
    struct moment m = end[r.x1];
    moment_add(&m, &end[r.x0], -1);
    moment_add(&m, &top[r.x1], -1);
    moment_add(&m, &top[r.x0], 1);
    return variance(&m);
}

/* The cut that leaves the least. False in a single pixel. */
static bool rectangle_cut(struct rectangle half[2], const struct moment *sums, size_t stride, struct rectangle r)
{
    double least = INFINITY;
    for (int i = r.x0 + 1; i < r.x1 + r.y1 - r.y0 - 1; i++) { /* columns, then rows */
        struct rectangle a = r, b = r;
        if (i < r.x1)
            a.x1 = b.x0 = i;
        else
            a.y1 = b.y0 = r.y0 + 1 + i - r.x1;
        double left = rectangle_variance(sums, stride, a) + rectangle_variance(sums, stride, b);
        if (left < least) {
            least = left;
            half[0] = a;
            half[1] = b;
        }
    }
    return least < INFINITY;
}

/* Returns the number of rectangles: `count`, or fewer when each is a single pixel. */
static unsigned map_cut(struct rectangle *out, unsigned count, const struct environment *e)
{
    const size_t stride = (size_t)e->width + 1;
    struct moment *sums = sums_make(e);
    double left[ENVMAP_MAX_LIGHTS] = {INFINITY};
    unsigned used = 1;
    out[0] = (struct rectangle){0, 0, e->width, e->height};
    while (used < count) {
        struct rectangle half[2];
        unsigned k = 0;
        for (unsigned i = 1; i < used; i++)
            if (left[i] > left[k])
                k = i;
        if (left[k] < 0)
            break;
        if (!rectangle_cut(half, sums, stride, out[k])) {
            left[k] = -1;
            continue;
        }
        out[k] = half[0];
        left[k] = rectangle_variance(sums, stride, half[0]);
        out[used] = half[1];
        left[used++] = rectangle_variance(sums, stride, half[1]);
    }
    free(sums);
    return used;
}

/* --- clusters --- */

static size_t samples_collect(struct sample *out, const struct environment *e, const struct rectangle *r,
                              unsigned count)
{
    size_t used = 0;
    for (unsigned k = 0; k < count; k++)
        for (int y = r[k].y0; y < r[k].y1; y++)
            for (int x = r[k].x0; x < r[k].x1; x++) {
                out[used] = sample_of(e, x, y);
                out[used].cluster = k;
                used += out[used].weight > 0;
            }
    return used;
}

/* Gives each sample to the nearest of the clusters' means. Returns whether any changed. */
static bool samples_assign(struct sample *samples, size_t n, const double (*mean)[3], unsigned count)
{
    bool changed = false;
    for (struct sample *s = samples; s < samples + n; s++) {
        double least = INFINITY;
        unsigned nearest = s->cluster;
        for (unsigned k = 0; k < count; k++) {
            double x = s->direction[0] - mean[k][0], y = s->direction[1] - mean[k][1], z = s->direction[2] - mean[k][2];
            double square = x * x + y * y + z * z;
            if (square < least) {
                least = square;
                nearest = k;
            }
        }
        changed |= nearest != s->cluster;
        s->cluster = nearest;
    }
    return changed;
}

static void clusters_settle(struct sample *samples, size_t n, unsigned count)
{
    double mean[ENVMAP_MAX_LIGHTS][3] = {{0}};
    for (int round = 0; round < ROUNDS; round++) {
        struct moment sums[ENVMAP_MAX_LIGHTS] = {{0}};
        for (size_t i = 0; i < n; i++) {
            const struct moment m = moment_of(&samples[i]);
            moment_add(&sums[samples[i].cluster], &m, 1);
        }
        for (unsigned k = 0; k < count; k++)
            for (int c = 0; c < 3; c++)
                mean[k][c] = sums[k].weight > 0 ? sums[k].at[c] / sums[k].weight : 9; /* far from every sample */
        if (!samples_assign(samples, n, (const double(*)[3])mean, count))
            break;
    }
}

static int compare_lights(const void *a, const void *b)
{
    double x = luminance(((const struct envmap_light *)a)->irradiance),
           y = luminance(((const struct envmap_light *)b)->irradiance);
    return (x < y) - (x > y);
}

unsigned envmap_lights(struct envmap_light *out, unsigned count, const struct environment *e)
{
    struct rectangle rectangles[ENVMAP_MAX_LIGHTS];
    struct sample *samples = xmalloc((size_t)e->width * (size_t)e->height * sizeof *samples);
    unsigned used = 0;
    count = map_cut(rectangles, count, e);
    size_t n = samples_collect(samples, e, rectangles, count);
    clusters_settle(samples, n, count);
    memset(out, 0, count * sizeof *out);
    for (size_t i = 0; i < n; i++) {
        struct envmap_light *l = &out[samples[i].cluster];
        for (int c = 0; c < 3; c++) {
            l->irradiance[c] += samples[i].power[c];
            l->direction[c] += samples[i].weight * samples[i].direction[c];
        }
    }
    for (unsigned k = 0; k < count; k++) {
        struct envmap_light l = out[k];
        double length =
            sqrt(l.direction[0] * l.direction[0] + l.direction[1] * l.direction[1] + l.direction[2] * l.direction[2]);
        if (length <= 0) /* no light */
            continue;
        for (int c = 0; c < 3; c++)
            l.direction[c] /= length;
        out[used++] = l;
    }
    qsort(out, used, sizeof *out, compare_lights);
    free(samples);
    return used;
}
