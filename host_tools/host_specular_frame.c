#include "host_specular_frame.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "ktx2.h"
#include "rgb9e5.h"

static const double degree = 3.14159265358979323846 / 180;

struct direction {
    double x, y, z;
};

static struct direction from_angles(double theta, double phi)
{
    return (struct direction){sin(theta * degree) * cos(phi * degree), sin(theta * degree) * sin(phi * degree),
                              cos(theta * degree)};
}

/* At a pole the azimuth is undefined; it is taken as 0. */
static void to_angles(double *theta, double *phi, struct direction d)
{
    double s = hypot(d.x, d.y);
    *theta = atan2(s, d.z) / degree;
    *phi = s > 1e-9 ? atan2(d.y, d.x) / degree : 0;
}

/* Between the tangent frame (z the normal, x the light projected) and the frame around the mirror direction of a light at
 * theta_in; the matrix is its own inverse. */
static struct direction reflect_frame(struct direction d, double theta_in)
{
    double s = sin(theta_in * degree), c = cos(theta_in * degree);
    return (struct direction){-c * d.x - s * d.z, -d.y, -s * d.x + c * d.z};
}

/* y of the quadratic Bezier (0,0), (l,1-l), (1,1) at abscissa x. */
static double bezier(double x, double l)
{
    double t = x > 0 ? x / (l + sqrt(l * l + (1 - 2 * l) * x)) : 0;
    return 2 * (1 - t) * t * (1 - l) + t * t;
}

static void node_value(double rgb[3], const struct measurement_slice *s, double theta_d, double phi_d,
                       const struct specular_frame_options *o)
{
    double theta, phi, last = s->theta_out[s->theta_count - 1];
    to_angles(&theta, &phi, reflect_frame(from_angles(theta_d, phi_d), s->theta_in));
    measurement_slice_value(rgb, s, theta, phi);
    if (theta <= last)
        return;
    double a = theta >= 90 ? 1 : bezier((theta - last) / (90 - last), o->l);
    for (int c = 0; c < 3; c++)
        rgb[c] *= 1 - a + a * o->p;
}

/* With the light along the normal the azimuth is arbitrary, yet real files depend on it: rows become their means. */
static void average_over_phi(struct measurement_slice *s)
{
    for (size_t row = 0; row < s->theta_count; row++) {
        double sum[3] = {0};
        for (size_t k = 0; k < s->phi_count; k++)
            for (int c = 0; c < 3; c++)
                sum[c] += s->rgb[3 * (row * s->phi_count + k) + c];
        for (int c = 0; c < 3; c++)
            s->rgb[3 * row + c] = sum[c] / (double)s->phi_count;
    }
    s->phi_count = 1;
}

void specular_frame_build(struct specular_frame *out, struct measurement_grid *grid,
                          const struct specular_frame_options *o, const char *path)
{
    size_t texels = (size_t)o->width * o->height * grid->count;
    if (grid->count > KTX2_MAX_EXTENT || texels > (size_t)1 << 24)
        die(EXIT_USAGE,
            "%s: %u x %u x %zu texels, the limits are %u per axis and 16777216 in all; give a smaller --size", path,
            o->width, o->height, grid->count, KTX2_MAX_EXTENT);
    *out = (struct specular_frame){o->width, o->height, (uint32_t)grid->count, grid->slices[grid->count - 1].theta_in,
                                   xmalloc(3 * texels * sizeof(double))};
    if (grid->count == 1)
        out->theta_max = 90;
    double *rgb = out->rgb;
    for (size_t z = 0; z < grid->count; z++) {
        struct measurement_slice *s = &grid->slices[z];
        if (z == 0)
            average_over_phi(s);
        for (uint32_t y = 0; y < o->height; y++) {
            double theta_d = 180.0 * y / (o->height - 1), *row = rgb;
            for (uint32_t x = 0; x + 1 < o->width; x++, rgb += 3)
                node_value(rgb, s, theta_d, 360.0 * x / (o->width - 1), o);
            memcpy(rgb, row, 3 * sizeof *rgb); /* 360 degrees is 0 degrees, to the bit */
            rgb += 3;
        }
    }
}

void specular_frame_free(struct specular_frame *t)
{
    free(t->rgb);
    t->rgb = NULL;
}

/* --- encoded tables --- */

void specular_frame_read(struct specular_frame_table *out, const struct ktx2_view *file)
{
    uint32_t bytes, swap_bytes;
    const uint8_t *text = ktx2_find(file, "goniotile.theta_max", &bytes),
                  *swap = ktx2_find(file, "goniotile.swap", &swap_bytes);
    long thousandths = 0; /* digits only: lut_open has checked */
    for (uint32_t i = 0; i < bytes; i++)
        thousandths = 10 * thousandths + (text[i] - '0');
    *out = (struct specular_frame_table){file->texels,
                                         file->width,
                                         file->height,
                                         file->depth,
                                         1e-3 * (double)thousandths,
                                         swap && swap_bytes == 1 && swap[0] == '1'};
}

/* A coordinate of `nodes` nodes over 0..1 as node and fraction. */
struct tap {
    uint32_t node, step; /* the next node is node + step */
    double fraction;
};

static struct tap tap_at(double x, uint32_t nodes)
{
    double at = fmin(fmax(x, 0), 1) * (nodes - 1);
    struct tap t = {(uint32_t)fmin(at, nodes > 1 ? nodes - 2 : 0), nodes > 1, 0};
    t.fraction = at - t.node;
    return t;
}

void specular_frame_value(double rgb[3], const struct specular_frame_table *t, const double l[3], const double v[3])
{
    if (t->swap && l[2] < v[2]) {
        const double *other = l;
        l = v;
        v = other;
    }
    double s = hypot(l[0], l[1]), x = s > 1e-12 ? l[0] / s : 1, y = s > 1e-12 ? l[1] / s : 0, theta_d, phi_d;
    double theta_in = atan2(s, l[2]) / degree;
    struct direction out = {v[0] * x + v[1] * y, v[1] * x - v[0] * y, v[2]};
    to_angles(&theta_d, &phi_d, reflect_frame(out, theta_in));
    struct tap a = tap_at((phi_d < 0 ? phi_d + 360 : phi_d) / 360, t->width), b = tap_at(theta_d / 180, t->height),
               c = tap_at(theta_in / t->theta_max, t->depth);
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int i = 0; i < 8; i++) {
        size_t node =
            (a.node + (i & 1 ? a.step : 0)) +
            (size_t)t->width * ((b.node + (i & 2 ? b.step : 0)) + (size_t)t->height * (c.node + (i & 4 ? c.step : 0)));
        double weight = (i & 1 ? a.fraction : 1 - a.fraction) * (i & 2 ? b.fraction : 1 - b.fraction) *
                        (i & 4 ? c.fraction : 1 - c.fraction);
        struct lut_rgb texel = lut_rgb9e5_decode(t->texels[node]);
        for (int channel = 0; channel < 3; channel++)
            rgb[channel] += weight * ldexp(texel.c[channel], texel.e);
    }
}

static void source_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    specular_frame_value(rgb, ctx, l, v);
}

void specular_frame_source(struct brdf_source *out, const struct specular_frame_table *t, const char *name)
{
    /* The context is only read. */
    *out = (struct brdf_source){.value = source_value, .ctx = (void *)t, .theta_in = 90, .theta_out = 90};
    snprintf(out->name, sizeof out->name, "%s", name);
}
