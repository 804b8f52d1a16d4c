#include "host_specular_frame.h"

#include <math.h>
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

static void texel_add(double rgb[3], uint32_t word, double weight)
{
    struct lut_rgb t = lut_rgb9e5_decode(word);
    for (int c = 0; c < 3; c++)
        rgb[c] += weight * ldexp(t.c[c], t.e);
}

void specular_frame_albedo(double rgb[3], const uint32_t *slice, uint32_t width, uint32_t height, double theta_in)
{
    /* Half a degree: whole ones overstate a one-node lobe at the pole by 9 %, halves by 2 %. */
    const double step = 0.5;
    memset(rgb, 0, 3 * sizeof *rgb);
    for (int i = 0; i < 90 / step; i++) {
        double s0 = sin(i * step * degree), s1 = sin((i + 1) * step * degree);
        double weight = (s1 * s1 - s0 * s0) / 2 * step * degree;
        for (int k = 0; k < 360 / step; k++) {
            double theta_d, phi_d;
            to_angles(&theta_d, &phi_d, reflect_frame(from_angles((i + 0.5) * step, (k + 0.5) * step), theta_in));
            double fx = (phi_d < 0 ? phi_d + 360 : phi_d) / 360 * (width - 1), fy = theta_d / 180 * (height - 1);
            uint32_t x = (uint32_t)fmin(fx, width - 2), y = (uint32_t)fmin(fy, height - 2);
            const uint32_t *t = slice + (size_t)y * width + x;
            double u = fx - x, v = fy - y;
            texel_add(rgb, t[0], weight * (1 - u) * (1 - v));
            texel_add(rgb, t[1], weight * u * (1 - v));
            texel_add(rgb, t[width], weight * (1 - u) * v);
            texel_add(rgb, t[width + 1], weight * u * v);
        }
    }
}
