/*
 * A sphere under an environment map and under the lights made from it, in double precision: orthographic pictures along -z and +z,
 * ENVLIGHT_SIDE x ENVLIGHT_SIDE pixels, exposed so that the map's mean luminance is 0.18 of display white (middle grey). What lights differ by is
 * the mean CIE 1976 difference over the sphere's pixels of both.
 */
#ifndef TESTS_UNIT_ENVLIGHT_FIXTURE_H
#define TESTS_UNIT_ENVLIGHT_FIXTURE_H

#include <math.h>
#include <stddef.h>

#include "host_envmap.h"
#include "host_metrics.h"

enum { ENVLIGHT_SIDE = 32, ENVLIGHT_MAX_PIXELS = 2 * ENVLIGHT_SIDE * ENVLIGHT_SIDE };

static const double envlight_pi = 3.14159265358979323846;

struct envlight_picture {
    double normal[ENVLIGHT_MAX_PIXELS][3], view[ENVLIGHT_MAX_PIXELS][3],
        rgb[ENVLIGHT_MAX_PIXELS][3]; /* as shown, 0..1 */
    size_t pixels;
    double exposure;
};

static inline void envlight_white(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    (void)ctx;
    (void)l;
    (void)v;
    rgb[0] = rgb[1] = rgb[2] = 1 / envlight_pi;
}

static inline double envlight_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void envlight_show(double rgb[3], double exposure)
{
    for (int c = 0; c < 3; c++)
        rgb[c] = fmin(rgb[c] * exposure, 1);
}

/* Every `step`-th pixel of each row and column, by numerical integration. */
static inline void envlight_reference(struct envlight_picture *p, const struct environment *e,
                                      const struct brdf_source *f, int step)
{
    double mean = 0;
    for (int i = 0; i < e->width * e->height; i++)
        mean +=
            environment_solid_angle(e, i / e->width) / (4 * envlight_pi) *
            (0.2126 * (double)e->rgb[3 * i] + 0.7152 * (double)e->rgb[3 * i + 1] + 0.0722 * (double)e->rgb[3 * i + 2]);
    p->exposure = 0.18 / mean;
    p->pixels = 0;
    for (int i = 0; i < ENVLIGHT_MAX_PIXELS; i++) {
        const int column = i % ENVLIGHT_SIDE, row = i / ENVLIGHT_SIDE % ENVLIGHT_SIDE;
        const double x = (2 * column + 1.0) / ENVLIGHT_SIDE - 1, y = 1 - (2 * row + 1.0) / ENVLIGHT_SIDE;
        const double z = 1 - x * x - y * y, side = i < ENVLIGHT_MAX_PIXELS / 2 ? 1 : -1;
        if (z <= 0 || column % step || row % step)
            continue;
        const double normal[3] = {x, y, side * sqrt(z)}, view[3] = {0, 0, side};
        for (int c = 0; c < 3; c++) {
            p->normal[p->pixels][c] = normal[c];
            p->view[p->pixels][c] = view[c];
        }
        environment_reflect(p->rgb[p->pixels], e, f, normal, view, 1);
        envlight_show(p->rgb[p->pixels++], p->exposure);
    }
}

/* Adds what one directional light makes a surface send to the viewer. */
static inline void envlight_add(double rgb[3], const struct brdf_source *f, const double n[3], const double view[3],
                                const struct envmap_light *light)
{
    const double *l = light->direction;
    const double nl = envlight_dot(n, l), nv = envlight_dot(n, view);
    double x[3], y[3], value[3];
    if (nl <= 1e-9)
        return;
    for (int c = 0; c < 3; c++)
        x[c] = view[c] - nv * n[c];
    double length = sqrt(envlight_dot(x, x));
    if (length < 1e-6) { /* seen along the normal, which is +z or -z */
        x[0] = length = 1;
        x[1] = x[2] = 0;
    }
    for (int c = 0; c < 3; c++)
        x[c] /= length;
    for (int c = 0; c < 3; c++)
        y[c] = n[(c + 1) % 3] * x[(c + 2) % 3] - n[(c + 2) % 3] * x[(c + 1) % 3];
    const double to_light[3] = {envlight_dot(l, x), envlight_dot(l, y), nl};
    const double to_view[3] = {envlight_dot(view, x), envlight_dot(view, y), nv};
    f->value(value, f->ctx, to_light, to_view);
    for (int c = 0; c < 3; c++)
        rgb[c] += value[c] * nl * light->irradiance[c];
}

/* Mean difference of the same picture under lights. */
static inline double envlight_difference(const struct envlight_picture *p, const struct envmap_light *lights,
                                         unsigned count, const struct brdf_source *f)
{
    double sum = 0;
    for (size_t i = 0; i < p->pixels; i++) {
        double rgb[3] = {0};
        for (unsigned k = 0; k < count; k++)
            envlight_add(rgb, f, p->normal[i], p->view[i], &lights[k]);
        envlight_show(rgb, p->exposure);
        sum += metrics_difference(rgb, p->rgb[i]);
    }
    return sum / (double)p->pixels;
}

#endif
