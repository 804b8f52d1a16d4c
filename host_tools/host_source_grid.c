/* A measurement on a grid as a BRDF: between the measured angles of incidence, and beyond them. */
#include "host_source.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common.h"

static const double degrees = 180 / 3.14159265358979323846;

/* v's angles in the frame around the mirror direction of a light at theta, turned to the slice's: the lobe stays where it is while
 * slices are interpolated. The map is its own inverse. */
static void mirror_frame(double out[3], const double d[3], double theta)
{
    double s = sin(theta), c = cos(theta), x = d[0], y = d[1], z = d[2];
    out[0] = -c * x - s * z;
    out[1] = -y;
    out[2] = -s * x + c * z;
}

static void slice_value(double rgb[3], const struct measurement_slice *s, const double around[3])
{
    double v[3];
    mirror_frame(v, around, s->theta_in / degrees);
    double flat = hypot(v[0], v[1]), theta = atan2(flat, v[2]) * degrees;
    measurement_slice_value(rgb, s, theta, flat > 1e-9 ? atan2(v[1], v[0]) * degrees : 0);
}

static void grid_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    const struct measurement_grid *g = ctx;
    const double *in = l[2] < v[2] ? v : l, *out = l[2] < v[2] ? l : v;
    double flat = hypot(in[0], in[1]), theta = atan2(flat, in[2]);
    double c = flat > 1e-9 ? in[0] / flat : 1, s = flat > 1e-9 ? in[1] / flat : 0, around[3];
    const double turned[3] = {c * out[0] + s * out[1], c * out[1] - s * out[0], out[2]};
    mirror_frame(around, turned, theta);

    const struct measurement_slice *slice = g->slices;
    size_t k = 0;
    while (k + 2 < g->count && slice[k + 1].theta_in <= theta * degrees)
        k++;
    slice_value(rgb, &slice[k], around);
    if (g->count < 2)
        return;
    double t = (theta * degrees - slice[k].theta_in) / (slice[k + 1].theta_in - slice[k].theta_in), next[3];
    t = fmin(fmax(t, 0), 1);
    slice_value(next, &slice[k + 1], around);
    for (int i = 0; i < 3; i++)
        rgb[i] = (1 - t) * rgb[i] + t * next[i];
}

static void grid_close(void *ctx)
{
    measurement_grid_free(ctx);
    free(ctx);
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

void source_from_grid(struct brdf_source *out, struct measurement_grid *grid, const char *name)
{
    struct measurement_grid *own = xmalloc(sizeof *own);
    *own = *grid;
    *grid = (struct measurement_grid){0};
    average_over_phi(&own->slices[0]);
    const struct measurement_slice *first = &own->slices[0], *last = &own->slices[own->count - 1];
    *out = (struct brdf_source){.value = grid_value,
                                .ctx = own,
                                .close = grid_close,
                                .theta_in = own->count > 1 ? last->theta_in : 90,
                                .theta_out = first->theta_out[first->theta_count - 1]};
    snprintf(out->name, sizeof out->name, "%s", name);
}
