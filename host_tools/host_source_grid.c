/* A measurement on a grid as a BRDF: between the measured angles of incidence, and beyond them. */
#include "host_source.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

static const double degrees = 180 / 3.14159265358979323846;

struct grid_source {
    struct measurement_grid grid;
    double base[3];
    double *cosine, *sine; /* of the slices' theta_in */
};

/* A pair in the frame where the direction that stands for the incident one has azimuth 0. */
struct pair {
    double in[3], out[3];
};

/* Cosine of half the angle between two directions, the second raised to `lowest` above the horizon. */
static double half_cosine(const double a[3], const double b[3], double lowest)
{
    double z = fmax(b[2], lowest), flat = b[2] < lowest ? sqrt((1 - z * z) / (1 - b[2] * b[2])) : 1;
    return sqrt(fmax((1 + flat * (a[0] * b[0] + a[1] * b[1]) + a[2] * z) / 2, 1e-4));
}

/* The value at p that slice k stands for: that of the pair with the same half vector, carried over. */
static void slice_value(double rgb[3], const struct grid_source *g, size_t k, const struct pair *p)
{
    const struct measurement_slice *s = &g->grid.slices[k];
    const double in[3] = {g->sine[k], 0, g->cosine[k]};
    double h[3], h2 = 0, along = 0, out[3], mirrored[3];
    for (int i = 0; i < 3; i++) {
        h[i] = p->in[i] + p->out[i];
        h2 += h[i] * h[i];
        along += in[i] * h[i];
    }
    for (int i = 0; i < 3; i++)
        out[i] = 2 * along / h2 * h[i] - in[i];
    double flat = hypot(out[0], out[1]), theta = atan2(flat, out[2]) * degrees;
    double phi = flat > 1e-9 ? atan2(out[1], out[0]) * degrees : 0;
    measurement_slice_value(rgb, s, theta, phi);
    measurement_slice_value(mirrored, s, theta, -phi);

    double lowest = cos(s->theta_out[s->theta_count - 1] / degrees), last = g->cosine[g->grid.count - 1];
    double growth = half_cosine(in, out, lowest) / half_cosine(p->in, p->out, lowest), fall = 1;
    growth = fmin(growth * growth * sqrt(growth), 8);
    if (p->in[2] < last && p->out[2] < last)
        fall = fmin(cbrt((p->in[2] + p->out[2]) / (in[2] + fmax(out[2], lowest))), 1);
    for (int c = 0; c < 3; c++) {
        double value = (rgb[c] + mirrored[c]) / 2, base = fmin(g->base[c], value);
        rgb[c] = base * fall + (value - base) * growth;
    }
}

/* The value with `in` as the measured direction; returns how unreliable it is: 0 at a measured angle. */
static double reading(double rgb[3], const struct grid_source *g, const double in[3], const double out[3])
{
    double flat = hypot(in[0], in[1]), c = flat > 1e-9 ? in[0] / flat : 1, s = flat > 1e-9 ? in[1] / flat : 0, next[3];
    const struct pair p = {{flat, 0, in[2]}, {c * out[0] + s * out[1], c * out[1] - s * out[0], out[2]}};
    const struct measurement_slice *slice = g->grid.slices;
    double theta = atan2(flat, in[2]) * degrees, last_out = slice->theta_out[slice->theta_count - 1];
    size_t k = 0;
    while (k + 2 < g->grid.count && slice[k + 1].theta_in <= theta)
        k++;
    slice_value(rgb, g, k, &p);
    if (g->grid.count < 2)
        return 0;
    double t = (theta - slice[k].theta_in) / (slice[k + 1].theta_in - slice[k].theta_in), inside = fmin(t, 1);
    slice_value(next, g, k + 1, &p);
    for (int i = 0; i < 3; i++)
        rgb[i] = (1 - inside) * rgb[i] + inside * next[i];
    double beyond = fmax(acos(fmin(out[2], 1)) * degrees - last_out, 0) / (90 - fmin(last_out, 89));
    return (t > 1 ? 0.1 + (t - 1) : t * (1 - t)) + 0.1 * beyond;
}

static void grid_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    double swapped[3], a = reading(rgb, ctx, l, v) + 0.02, b = reading(swapped, ctx, v, l) + 0.02;
    double weight = b * b * b * b / (a * a * a * a + b * b * b * b);
    for (int c = 0; c < 3; c++)
        rgb[c] = weight * rgb[c] + (1 - weight) * swapped[c];
}

static void grid_close(void *ctx)
{
    struct grid_source *g = ctx;
    measurement_grid_free(&g->grid);
    free(g->cosine);
    free(g->sine);
    free(g);
}

/* With the light along the normal the azimuth is arbitrary, yet real files depend on it. */
static void average_over_phi(struct measurement_slice *s)
{
    for (size_t row = 0; row < s->theta_count; row++)
        for (int c = 0; c < 3; c++) {
            double sum = 0, *first = s->rgb + 3 * row * s->phi_count + c;
            for (size_t k = 0; k < s->phi_count; k++)
                sum += first[3 * k];
            for (size_t k = 0; k < s->phi_count; k++)
                first[3 * k] = sum / (double)s->phi_count;
        }
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The lowest hundredth of a channel's values, not the least: one bad sample must not decide. */
static double find_base(const struct measurement_grid *g, int channel)
{
    size_t count = 0;
    for (size_t k = 0; k < g->count; k++)
        count += g->slices[k].theta_count * g->slices[k].phi_count;
    double *all = xmalloc(count * sizeof *all), *p = all;
    for (size_t k = 0; k < g->count; k++)
        for (size_t i = 0; i < g->slices[k].theta_count * g->slices[k].phi_count; i++)
            *p++ = g->slices[k].rgb[3 * i + (size_t)channel];
    qsort(all, count, sizeof *all, compare_doubles);
    double base = all[count / 100];
    free(all);
    return base;
}

void source_from_grid(struct brdf_source *out, struct measurement_grid *grid, const char *name)
{
    struct grid_source *g = xmalloc(sizeof *g);
    *g = (struct grid_source){.grid = *grid,
                              .cosine = xmalloc(grid->count * sizeof *g->cosine),
                              .sine = xmalloc(grid->count * sizeof *g->sine)};
    memset(grid, 0, sizeof *grid);
    average_over_phi(&g->grid.slices[0]);
    for (size_t k = 0; k < g->grid.count; k++) {
        g->cosine[k] = cos(g->grid.slices[k].theta_in / degrees);
        g->sine[k] = sin(g->grid.slices[k].theta_in / degrees);
    }
    for (int c = 0; c < 3; c++)
        g->base[c] = find_base(&g->grid, c);
    double theta_in = 0, theta_out = 90; /* what was extrapolated already is no measurement */
    for (size_t k = 0; k < g->grid.count; k++) {
        const struct measurement_slice *s = &g->grid.slices[k];
        if (s->theta_measured < 0)
            continue;
        theta_in = s->theta_in;
        theta_out = fmin(theta_out, s->theta_measured);
    }
    *out = (struct brdf_source){.value = grid_value,
                                .ctx = g,
                                .close = grid_close,
                                .theta_in = theta_in,
                                .theta_out = theta_out,
                                .symmetric = true};
    snprintf(out->name, sizeof out->name, "%s", name);
}
