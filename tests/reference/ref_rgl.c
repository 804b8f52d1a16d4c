#include "ref_rgl.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

struct field {
    int shape[5];
    float *data;
};

struct ref_rgl {
    struct field theta_i, ndf, sigma, vndf, rgb;
    double *volume; /* of each vndf slice: its integral with nodes one apart */
    int jacobian;
};

static unsigned long long little(const unsigned char *p, int n)
{
    unsigned long long x = 0;
    while (n--)
        x = 256 * x + p[n];
    return x;
}

static struct field find(const unsigned char *file, const char *name, int element_bytes)
{
    const unsigned char *p = file + 18;
    for (unsigned long long i = little(file + 14, 4); i; i--) {
        size_t length = little(p, 2);
        const unsigned char *text = p + 2, *q = text + length;
        size_t dimensions = little(q, 2);
        p = q + 11 + 8 * dimensions;
        if (length != strlen(name) || memcmp(text, name, length))
            continue;
        struct field f = {{0}, NULL};
        size_t count = 1;
        for (size_t d = 0; d < dimensions; d++)
            count *= (size_t)(f.shape[d] = (int)little(q + 11 + 8 * d, 8));
        f.data = malloc(count * sizeof(float));
        for (size_t k = 0; k < count; k++) {
            const unsigned char *at = file + little(q + 3, 8) + k * (size_t)element_bytes;
            if (element_bytes == 1)
                f.data[k] = *at;
            else
                memcpy(&f.data[k], at, 4);
        }
        return f;
    }
    abort(); /* no such field */
}

static double vndf_node(const struct ref_rgl *r, int slice, int y, int x)
{
    return (double)r->vndf.data[((long)slice * r->vndf.shape[2] + y) * r->vndf.shape[3] + x];
}

struct ref_rgl *ref_rgl_open(const unsigned char *file, size_t bytes)
{
    assert(bytes > 18);
    struct ref_rgl *r = calloc(1, sizeof *r);
    r->theta_i = find(file, "theta_i", 4);
    r->ndf = find(file, "ndf", 4);
    r->sigma = find(file, "sigma", 4);
    r->vndf = find(file, "vndf", 4);
    r->rgb = find(file, "rgb", 4);
    struct field jacobian = find(file, "jacobian", 1);
    r->jacobian = jacobian.data[0] != 0;
    free(jacobian.data);
    int n = r->vndf.shape[1], height = r->vndf.shape[2], width = r->vndf.shape[3];
    r->volume = calloc((size_t)n, sizeof(double));
    for (int s = 0; s < n; s++)
        for (int y = 0; y + 1 < height; y++)
            for (int x = 0; x + 1 < width; x++)
                r->volume[s] += (vndf_node(r, s, y, x) + vndf_node(r, s, y, x + 1) + vndf_node(r, s, y + 1, x) +
                                 vndf_node(r, s, y + 1, x + 1)) /
                                4;
    return r;
}

void ref_rgl_close(struct ref_rgl *r)
{
    free(r->theta_i.data);
    free(r->ndf.data);
    free(r->sigma.data);
    free(r->vndf.data);
    free(r->rgb.data);
    free(r->volume);
    free(r);
}

/* Density of visible normals at a node, for an incidence a share t of the way from slice s to the next; every slice scaled to a
 * total of 1. */
static double density(const struct ref_rgl *r, int s, double t, int y, int x)
{
    double first = vndf_node(r, s, y, x) / r->volume[s];
    return t > 0 ? (1 - t) * first + t * vndf_node(r, s + 1, y, x) / r->volume[s + 1] : first;
}

/* Integral over x from 0 to `to` (in node spacings) of the density in row `y` of nodes, a share v towards the next row. */
static double row_integral(const struct ref_rgl *r, int s, double t, int y, double v, double to)
{
    double sum = 0;
    for (int x = 0; x + 1 < r->vndf.shape[3] && x < to; x++) {
        double a = density(r, s, t, y, x), b = density(r, s, t, y, x + 1);
        if (v > 0) {
            a += v * (density(r, s, t, y + 1, x) - a);
            b += v * (density(r, s, t, y + 1, x + 1) - b);
        }
        double d = fmin(to - x, 1);
        sum += d * (a + (b - a) * d / 2);
    }
    return sum;
}

/* Value of an image over the unit square, nodes at both ends. */
static double image(const float *data, int height, int width, double x, double y)
{
    double sum = 0;
    for (int j = 0; j < height; j++)
        for (int i = 0; i < width; i++) {
            double wx = 1 - fabs(x * (width - 1) - i), wy = 1 - fabs(y * (height - 1) - j);
            if (wx > 0 && wy > 0)
                sum += wx * wy * (double)data[j * width + i];
        }
    return sum;
}

void ref_rgl_value(double rgb[3], const struct ref_rgl *r, const double wi[3], const double wo[3])
{
    double m[3] = {wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
    double theta_i = atan2(sqrt(wi[0] * wi[0] + wi[1] * wi[1]), wi[2]);
    double theta_m = atan2(sqrt(m[0] * m[0] + m[1] * m[1]), m[2]);
    double phi = atan2(m[1], m[0]) - atan2(wi[1], wi[0]);
    double ux = sqrt(2 * theta_m / pi), uy = fmod(phi / (2 * pi) + 1.5, 1);

    int n = r->theta_i.shape[0], s = 0;
    double t = 0;
    for (int i = 0; i + 1 < n; i++) {
        double a = (double)r->theta_i.data[i], b = (double)r->theta_i.data[i + 1];
        if (theta_i >= a) {
            s = i;
            t = fmin((theta_i - a) / (b - a), 1);
        }
    }

    int height = r->vndf.shape[2], width = r->vndf.shape[3], row = (int)(uy * (height - 1));
    double v = uy * (height - 1) - row, end = width - 1, below = 0;
    for (int y = 0; y < row; y++)
        below += (row_integral(r, s, t, y, 0, end) + row_integral(r, s, t, y + 1, 0, end)) / 2;
    double low = row_integral(r, s, t, row, 0, end), here = row_integral(r, s, t, row, v, end);
    double sx = row_integral(r, s, t, row, v, ux * end) / here, sy = below + v * (low + here) / 2;

    double scale = 1 / wo[2];
    if (r->jacobian)
        scale *= image(r->ndf.data, r->ndf.shape[0], r->ndf.shape[1], ux, uy) / 4 /
                 image(r->sigma.data, r->sigma.shape[0], r->sigma.shape[1], sqrt(2 * theta_i / pi), 0.5);
    int plane = r->rgb.shape[3] * r->rgb.shape[4];
    for (int c = 0; c < 3; c++) {
        const float *data = r->rgb.data + (3 * s + c) * plane;
        double x = image(data, r->rgb.shape[3], r->rgb.shape[4], sx, sy);
        if (t > 0)
            x += t * (image(data + 3 * plane, r->rgb.shape[3], r->rgb.shape[4], sx, sy) - x);
        rgb[c] = fmax(x * scale, 0);
    }
}

double ref_rgl_angle(const struct ref_rgl *r, int index)
{
    return (double)r->theta_i.data[index];
}

void ref_rgl_terms(double terms[3], const struct ref_rgl *r, double theta_i, double theta_m, double phi)
{
    double u = sqrt(2 * theta_m / pi), v = fmod(phi / (2 * pi) + 1.5, 1);
    int s = 0, height = r->vndf.shape[2], width = r->vndf.shape[3];
    for (int i = 0; i < r->theta_i.shape[0]; i++)
        if (fabs((double)r->theta_i.data[i] - theta_i) < fabs((double)r->theta_i.data[s] - theta_i))
            s = i;
    /* per unit of u and v, and d omega = sin(theta_m) d theta d phi with theta = pi u^2/2, phi = 2 pi v */
    double per_uv =
        image(r->vndf.data + (long)s * height * width, height, width, u, v) / r->volume[s] * (height - 1) * (width - 1);
    terms[0] = per_uv / (2 * pi * pi * u * sin(theta_m));
    terms[1] = image(r->ndf.data, r->ndf.shape[0], r->ndf.shape[1], u, v);
    terms[2] = image(r->sigma.data, r->sigma.shape[0], r->sigma.shape[1], sqrt(2 * theta_i / pi), 0.5);
}
