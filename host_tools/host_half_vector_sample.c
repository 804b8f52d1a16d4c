/* What a half-vector table is fitted to: samples of a BRDF over the table's axes, weighted as pictures show them. */
#include "host_half_vector_fit.h"

#include <math.h>
#include <stdlib.h>

#include "common.h"

static const double pi = 3.14159265358979323846;

/* Unit l and v of the given angles, n = z, h in the xz plane; `turn` receives d(azimuth) / d(t2) of l - v around h. */
static void directions(double l[3], double v[3], double *turn, double s2, double sine, double cosine, double t2)
{
    double sh = sqrt(s2), ch = sqrt(fmax(1 - s2, 0)), reach = 1; /* of cos(azimuth) above the horizon */
    if (s2 > cosine * cosine)
        reach = cosine * ch / (sine * sh);
    double ca = reach * sqrt(t2), sa = sqrt(fmax(1 - ca * ca, 0));
    *turn = reach / (2 * sqrt(t2) * fmax(sa, 1e-3));
    const double h[3] = {sh, 0, ch}, a[3] = {-ch * ca, sa, sh * ca};
    for (int k = 0; k < 3; k++) {
        l[k] = cosine * h[k] + sine * a[k];
        v[k] = cosine * h[k] - sine * a[k];
    }
}

/* Keeps a direction a thousandth above the horizon, where every source is defined. */
static void lift(double d[3])
{
    if (d[2] >= 1e-3)
        return;
    double flat = sqrt(1 - 1e-6) / fmax(hypot(d[0], d[1]), 1e-9);
    d[0] *= flat;
    d[1] *= flat;
    d[2] = 1e-3;
}

/* --- colour --- */

/* Derivative of the CIE 1976 lightness function f(x). */
static double lightness_slope(double x)
{
    return x > 0.008856 ? 1 / (3 * cbrt(x * x)) : 7.787;
}

/* Change of the CIE 1976 colour of a pixel per relative change of its value, linear sRGB, D65. Not clipped at white: exposures
 * may be darker, and weights that fall any faster with the value would cost sharp lobes energy. */
static double colour_slope(const double pixel[3])
{
    static const double xyz[3][3] = {{0.4339, 0.3762, 0.1899}, {0.2126, 0.7152, 0.0722}, {0.0177, 0.1095, 0.8729}};
    double f[3];
    for (int i = 0; i < 3; i++) {
        double x = 0;
        for (int c = 0; c < 3; c++)
            x += xyz[i][c] * pixel[c];
        f[i] = lightness_slope(x) * x;
    }
    double l = 116 * f[1], a = 500 * (f[0] - f[1]), b = 200 * (f[1] - f[2]);
    return sqrt(l * l + a * a + b * b);
}

/* --- samples --- */

/* Edges of the pieces a cell is averaged over: one, or, from 0, `most` whose widths halve towards 0. */
static int pieces(double *edge, double low, double high, int most)
{
    int count = low > 0 ? 1 : most;
    edge[0] = low;
    for (int i = count; i > 0; i--, high /= 2)
        edge[i] = high;
    return count;
}

struct place {
    double s2[2], y[2], t2; /* a cell: from, to */
};

static void half_angles(double *sine, double *cosine, double y)
{
    double difference = 1 - 2 * y, sum = sqrt(2 - difference * difference); /* cos theta_d -+ sin theta_d */
    *sine = fmax((sum - difference) / 2, 1e-9);
    *cosine = fmax((sum + difference) / 2, 1e-9);
}

static void take(struct fit_sample *out, const struct brdf_source *source, const struct place *p)
{
    enum { ROW_PIECES = 8, PLANE_PIECES = 4 };
    double rows[ROW_PIECES + 1], planes[PLANE_PIECES + 1], g[3] = {0}, weights = 0, sine, cosine, turn;
    int row_count = pieces(rows, p->s2[0], p->s2[1], ROW_PIECES);
    int plane_count = pieces(planes, p->y[0], p->y[1], PLANE_PIECES);
    double l[3], v[3], f[3];
    for (int j = 0; j < plane_count; j++)
        for (int i = 0; i < row_count; i++) {
            /* Solid angle goes with s2 and, near 0, with y^2. */
            double weight = (rows[i + 1] - rows[i]) * (planes[j + 1] * planes[j + 1] - planes[j] * planes[j]);
            half_angles(&sine, &cosine, (planes[j] + planes[j + 1]) / 2);
            directions(l, v, &turn, (rows[i] + rows[i + 1]) / 2, sine, cosine, p->t2);
            lift(l);
            lift(v);
            source_symmetric(f, source, l, v);
            for (int c = 0; c < 3; c++)
                g[c] += weight * f[c] * (l[2] + v[2]);
            weights += weight;
        }

    double s2 = (p->s2[0] + p->s2[1]) / 2, y = (p->y[0] + p->y[1]) / 2;
    *out = (struct fit_sample){.s2 = (float)s2, .y = (float)y, .t2 = (float)p->t2};
    half_angles(&sine, &cosine, y);
    directions(l, v, &turn, s2, sine, cosine, p->t2);
    lift(l);
    lift(v);
    /* Lights at every angle to the view equally often; normals as a sphere shows them: solid angle times n.v. */
    double measure = (p->s2[1] - p->s2[0]) / sqrt(fmax(1 - s2, 1e-9)) * turn * (p->y[1] - p->y[0]) / (cosine + sine);
    double mean = 0, pixel[3];
    for (int c = 0; c < 3; c++) {
        out->g[c] = (float)(g[c] / weights);
        pixel[c] = fmax(g[c] / weights, 1e-4); /* black must not be free of weight */
        mean += pixel[c] / 3;
    }
    for (int swap = 0; swap < 2; swap++) {
        double nl = swap ? v[2] : l[2], nv = swap ? l[2] : v[2], shade[3];
        for (int c = 0; c < 3; c++)
            shade[c] = pi * pixel[c] * nl / (nl + nv);
        out->pixels[swap] = (float)(measure * nv);
        out->slope[swap] = (float)(colour_slope(shade) / mean);
    }
}

void fit_samples_take(struct fit_samples *out, const struct brdf_source *source, const double *row_edges, int rows,
                      const double *plane_edges, int planes, int columns)
{
    *out = (struct fit_samples){rows, planes, columns, NULL};
    struct fit_sample *sample = out->sample = xmalloc(fit_samples_count(out) * sizeof *sample);
    for (int j = 0; j < planes; j++)
        for (int i = 0; i < rows; i++)
            for (int k = 0; k < columns; k++) {
                /* Every other cell a quarter to the left or right of the column's middle: both sides of every node are seen. */
                double t2 = (k + (((i + j) & 1) ? 0.75 : 0.25)) / columns;
                struct place p = {{row_edges[i], row_edges[i + 1]}, {plane_edges[j], plane_edges[j + 1]}, t2};
                take(sample++, source, &p);
            }
}

void fit_samples_free(struct fit_samples *s)
{
    free(s->sample);
    s->sample = NULL;
}
