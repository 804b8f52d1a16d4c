/*
 * The half-vector table by its angles: theta_h of the half vector from the normal, theta_d of the light from the half vector,
 * phi the azimuth of the normal from the light, both around the half vector.
 */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "ref_table.h"

static const double pi = 3.14159265358979323846;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Between directions of any length but 0. */
static double angle(const double a[3], const double b[3])
{
    double c[3];
    cross(c, a, b);
    return atan2(sqrt(dot(c, c)), dot(a, b));
}

/* Where node k of the warp of the rows stands: x = sin^2(theta_h) + 2^-16. */
static double warp_h_node(unsigned k)
{
    return ldexp(1 + k % 8 / 8.0, (int)(k / 8) - 16);
}

static double warp_d_node(unsigned k)
{
    return k / 64.0;
}

/* Linear between the nodes (ascending), constant beyond. */
static double piecewise(double x, double (*node)(unsigned), const double *value, unsigned nodes)
{
    unsigned lo = 0, hi = nodes - 1;
    while (hi - lo > 1) {
        unsigned middle = (lo + hi) / 2;
        *(node(middle) <= x ? &lo : &hi) = middle;
    }
    double share = (x - node(lo)) / (node(hi) - node(lo));
    return value[lo] + (value[hi] - value[lo]) * fmin(fmax(share, 0), 1);
}

static double row_of(const struct ref_table *t, double theta_h)
{
    return piecewise(sin(theta_h) * sin(theta_h) + ldexp(1, -16), warp_h_node, t->warp_h, REF_WARP_H);
}

static double plane_of(const struct ref_table *t, double theta_d)
{
    return piecewise((1 + sin(theta_d) - cos(theta_d)) / 2, warp_d_node, t->warp_d, REF_WARP_D);
}

/* Every azimuth from 0 to 90 degrees is possible where theta_h + theta_d <= 90, elsewhere up to where one direction is on the horizon. */
static double column_of(const struct ref_table *t, double theta_h, double theta_d, double phi)
{
    double x = cos(phi);
    if (theta_h + theta_d > pi / 2)
        x *= tan(theta_h) * tan(theta_d);
    return fmin(x * x, 1) * (t->width - 1);
}

static const float *texel_at(const struct ref_table *t, long k, long i, long j)
{
    return t->texels[((size_t)j * t->height + (size_t)i) * t->width + (size_t)k];
}

/* Largest channel of the nodes less than two away. */
static double largest_around(const struct ref_table *t, const double at[3])
{
    double largest = 0;
    for (long j = (long)at[2] - 1; j <= (long)at[2] + 2; j++)
        for (long i = (long)at[1] - 1; i <= (long)at[1] + 2; i++)
            for (long k = (long)at[0] - 1; k <= (long)at[0] + 2; k++)
                if (i >= 0 && j >= 0 && k >= 0 && k < (long)t->width && i < (long)t->height && j < (long)t->depth) {
                    const float *texel = texel_at(t, k, i, j);
                    largest = fmax(largest, fmax(texel[0], fmax(texel[1], texel[2])));
                }
    return largest;
}

double ref_half_eval(double rgb[3], const struct ref_table *t, const double n[3], const double l[3], const double v[3])
{
    double h[3], across_l[3], across_n[3];
    for (int c = 0; c < 3; c++)
        h[c] = l[c] + v[c];
    double theta_h = angle(n, h), theta_d = angle(l, v) / 2, phi = 0;
    cross(across_l, h, l);
    cross(across_n, h, n);
    if (dot(across_l, across_l) > 0 && dot(across_n, across_n) > 0)
        phi = angle(across_l, across_n);

    double at[3] = {column_of(t, theta_h, theta_d, phi), row_of(t, theta_h), plane_of(t, theta_d)};
    double factor = t->scale / (dot(n, l) + dot(n, v));
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (unsigned corner = 0; corner < 8; corner++) {
        double weight = 1;
        long node[3];
        for (int a = 0; a < 3; a++) {
            double fraction = at[a] - floor(at[a]);
            bool upper = corner >> a & 1;
            node[a] = (long)floor(at[a]) + upper;
            weight *= upper ? fraction : 1 - fraction;
        }
        for (int c = 0; c < 3 && weight > 0; c++)
            rgb[c] += factor * weight * (double)texel_at(t, node[0], node[1], node[2])[c];
    }
    return factor * largest_around(t, at);
}

void ref_half_warp(struct ref_half *f, double width)
{
    const double horizon = 0.25; /* the share of rows in equal steps of cos(theta_h), which g follows at the horizon */
    for (unsigned k = 0; k < REF_WARP_H; k++) {
        double square = fmin(warp_h_node(k) - warp_h_node(0), 1), last = 1 - warp_h_node(0);
        double lobe = asinh(sqrt(square) / width) / asinh(sqrt(last) / width);
        double row = (1 - horizon) * lobe + horizon * (1 - sqrt(1 - square)) / (1 - sqrt(1 - last));
        f->warp_h[k] = (uint16_t)lrint(512 * (f->h - 1) * row);
    }
    for (unsigned k = 0; k < REF_WARP_D; k++)
        f->warp_d[k] = (uint16_t)lrint(512 * (f->d - 1) * warp_d_node(k));
}

/* Where a warp reaches node `index`. */
static double unwarp(const uint16_t *warp, unsigned nodes, double (*node)(unsigned), unsigned index)
{
    double wanted = 512.0 * index;
    for (unsigned k = 1; k < nodes; k++)
        if (warp[k] >= wanted && warp[k] > warp[k - 1])
            return node(k - 1) + (node(k) - node(k - 1)) * fmax(wanted - warp[k - 1], 0) / (warp[k] - warp[k - 1]);
    return node(nodes - 1);
}

/* theta_d with (1 + sin - cos)/2 = y: sqrt(2) sin(theta_d - 45 degrees) = 2y - 1. */
static double theta_d_of(double y)
{
    return pi / 4 + asin((2 * y - 1) / sqrt(2));
}

/* The directions of a node in the frame whose z is the half vector and whose x leans to the light. */
static void node_directions(double n[3], double l[3], double v[3], const struct ref_half *f, unsigned k, unsigned i,
                            unsigned j)
{
    const double horizon = 1e-4; /* nothing is sampled closer to it than this, in cosines */
    double x = unwarp(f->warp_h, REF_WARP_H, warp_h_node, i) - ldexp(1, -16);
    double theta_h = fmin(asin(sqrt(fmin(fmax(x, 0), 1))), pi / 2 - 2 * horizon);
    double theta_d = fmin(theta_d_of(unwarp(f->warp_d, REF_WARP_D, warp_d_node, j)), pi / 2 - 2 * horizon);
    double cosine = sqrt(k / (f->t - 1.0));
    if (theta_h + theta_d > pi / 2)
        cosine /= tan(theta_h) * tan(theta_d);
    double phi = acos(cosine), lowest = cos(theta_d) * cos(theta_h) - sin(theta_d) * sin(theta_h) * cosine;
    if (lowest < horizon) {
        double most = (cos(theta_d) * cos(theta_h) - horizon) / (sin(theta_d) * sin(theta_h));
        phi = acos(fmax(most, 0));
    }
    n[0] = sin(theta_h) * cos(phi), n[1] = sin(theta_h) * sin(phi), n[2] = cos(theta_h);
    l[0] = sin(theta_d), l[1] = 0, l[2] = cos(theta_d);
    v[0] = -sin(theta_d), v[1] = 0, v[2] = cos(theta_d);
}

void ref_half_sample(struct ref_half *f, ref_brdf_function *brdf, const void *context)
{
    uint32_t *texels = malloc(sizeof *texels * f->t * f->h * f->d);
    if (!texels)
        abort();
    for (unsigned j = 0; j < f->d; j++)
        for (unsigned i = 0; i < f->h; i++)
            for (unsigned k = 0; k < f->t; k++) {
                double n[3], l[3], v[3], g[3];
                node_directions(n, l, v, f, k, i, j);
                brdf(g, context, n, l, v);
                for (int c = 0; c < 3; c++)
                    g[c] = ldexp(g[c] * (dot(n, l) + dot(n, v)), -f->scale);
                texels[k + f->t * (i + f->h * j)] = ref_rgb9e5_encode(g);
            }
    f->texels = texels;
}
