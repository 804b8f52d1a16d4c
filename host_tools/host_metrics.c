#include "host_metrics.h"

#include <math.h>
#include <stdlib.h>

#include "common.h"

static const double pi = 3.14159265358979323846;

/* --- pictures --- */

enum { PICTURE_SIDE = 96, PICTURES = 3, SAMPLES_MAX = PICTURES * PICTURE_SIDE * PICTURE_SIDE };

static double srgb_encode(double x)
{
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}

static double lab_curve(double x)
{
    return x > 0.008856 ? cbrt(x) : 7.787 * x + 16.0 / 116;
}

/* CIE 1976 L*a*b* of linear sRGB (IEC 61966-2-1's matrix; D65 is its row sums). */
static void lab_from_rgb(double lab[3], const double rgb[3])
{
    static const double to_xyz[3][3] = {{0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}};
    double f[3];
    for (int i = 0; i < 3; i++) {
        const double *m = to_xyz[i];
        f[i] = lab_curve((m[0] * rgb[0] + m[1] * rgb[1] + m[2] * rgb[2]) / (m[0] + m[1] + m[2]));
    }
    lab[0] = 116 * f[1] - 16;
    lab[1] = 500 * (f[0] - f[1]);
    lab[2] = 200 * (f[1] - f[2]);
}

double metrics_difference(const double a[3], const double b[3])
{
    double lab_a[3], lab_b[3], sum = 0;
    lab_from_rgb(lab_a, a);
    lab_from_rgb(lab_b, b);
    for (int c = 0; c < 3; c++)
        sum += (lab_a[c] - lab_b[c]) * (lab_a[c] - lab_b[c]);
    return sqrt(sum);
}

/* A pixel of the sphere: l and v in the frame of its normal, x along the projected light. False where it does not count. */
static bool pixel_directions(double l[3], double v[3], int column, int row, double light_angle)
{
    double x = 2.0 * column / (PICTURE_SIDE - 1) - 1, y = 1 - 2.0 * row / (PICTURE_SIDE - 1), r2 = x * x + y * y;
    if (r2 >= 0.998)
        return false;
    double n[3] = {x, y, sqrt(1 - r2)};
    double light[3] = {0.8 * sin(light_angle), 0.6 * sin(light_angle), cos(light_angle)};
    double nl = n[0] * light[0] + n[1] * light[1] + n[2] * light[2];
    if (nl <= 0.01)
        return false;
    double t[3] = {light[0] - nl * n[0], light[1] - nl * n[1], light[2] - nl * n[2]};
    double length = sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
    if (length < 1e-9) { /* light along the normal: any tangent will do */
        t[0] = n[2];
        t[2] = -n[0];
        t[1] = 0;
        length = hypot(t[0], t[2]);
        l[0] = 0;
    } else {
        l[0] = length;
    }
    l[1] = 0;
    l[2] = nl;
    v[0] = t[2] / length; /* the viewer is at +z */
    v[1] = (n[0] * t[1] - n[1] * t[0]) / length;
    v[2] = n[2];
    return true;
}

static void pixel_value(double rgb[3], const struct brdf_source *f, const double l[3], const double v[3])
{
    f->value(rgb, f->ctx, l, v);
    for (int c = 0; c < 3; c++)
        rgb[c] = fmin(fmax(pi * rgb[c] * l[2], 0), 1);
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void metrics_pictures(struct metrics *out, const struct brdf_source *f, const struct brdf_source *truth)
{
    static const double light_degrees[PICTURES] = {30, 80, 140};
    double *de = xmalloc(SAMPLES_MAX * sizeof *de), de_sum = 0, squares = 0;
    size_t count = 0;
    for (int i = 0; i < SAMPLES_MAX; i++) {
        int column = i % PICTURE_SIDE, row = i / PICTURE_SIDE % PICTURE_SIDE;
        double l[3], v[3], got[3], want[3];
        double angle = light_degrees[i / (PICTURE_SIDE * PICTURE_SIDE)] * pi / 180;
        if (!pixel_directions(l, v, column, row, angle))
            continue;
        pixel_value(got, f, l, v);
        pixel_value(want, truth, l, v);
        for (int c = 0; c < 3; c++) {
            double step = srgb_encode(got[c]) - srgb_encode(want[c]);
            squares += step * step;
        }
        de[count] = metrics_difference(got, want);
        de_sum += de[count++];
    }
    qsort(de, count, sizeof *de, compare_doubles);
    out->de_mean = de_sum / (double)count;
    out->de_p99 = de[(count - 1) * 99 / 100];
    out->psnr = -10 * log10(squares / (3.0 * (double)count) + 1e-12);
    free(de);
}

/* --- directions drawn like those that matter --- */

const double metrics_band[METRICS_BANDS][2] = {{0, 60}, {60, 75}, {75, 87}};

enum { SAMPLES = 12000, STRATEGIES = 5 };

/* v is drawn from the cosine, from reflections at GGX-distributed half vectors (Walter et al. 2007) of these roughnesses, or
 * from such reflections turned back towards the light (a negative one): whatever the BRDF, one of them follows it. */
static const double strategy[STRATEGIES] = {0, 0.35, 0.04, 0.004, -0.04};

static double ggx_distribution(double cosine, double sine2, double alpha)
{
    double a2 = alpha * alpha, d = cosine * cosine * a2 + sine2;
    return a2 / (pi * d * d);
}

/* Density over solid angle of v. */
static double strategy_density(double alpha, const double l[3], const double v[3])
{
    if (alpha == 0)
        return v[2] / pi;
    double turn = alpha < 0 ? -1 : 1;
    double h[3] = {l[0] + turn * v[0], l[1] + turn * v[1], l[2] + v[2]};
    double h2 = h[0] * h[0] + h[1] * h[1] + h[2] * h[2], length = sqrt(h2), cosine = h[2] / length;
    /* dh/dv = 1 / (4 l.h), l.h = |l+v| / 2 */
    return ggx_distribution(cosine, (h[0] * h[0] + h[1] * h[1]) / h2, alpha) * cosine / (2 * length);
}

/* False when the direction falls below 88 degrees from the normal. */
static bool strategy_draw(double v[3], double alpha, const double l[3], double u1, double u2)
{
    double tangent = fabs(alpha) * sqrt(u1 / (1 - u1)), phi = 2 * pi * u2, theta = atan(tangent);
    if (alpha == 0) {
        double s = sqrt(u1);
        v[0] = s * cos(phi);
        v[1] = s * sin(phi);
        v[2] = sqrt(1 - u1);
    } else {
        double h[3] = {sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)};
        double lh = l[0] * h[0] + l[1] * h[1] + l[2] * h[2], turn = alpha < 0 ? -1 : 1;
        v[0] = turn * (2 * lh * h[0] - l[0]);
        v[1] = turn * (2 * lh * h[1] - l[1]);
        v[2] = 2 * lh * h[2] - l[2];
        if (lh <= 0)
            return false;
    }
    return v[2] > cos(88 * pi / 180);
}

/* Direction pair number i of SAMPLES with theta_in (degrees) in [lo, hi) and its weight, the reciprocal of the density of v;
 * 0 when it does not count. A Kronecker sequence (Roberts 2018's R3) spreads them evenly. */
static double pair_draw(double l[3], double v[3], int i, double lo, double hi)
{
    double u[3], base = 1;
    for (int k = 0; k < 3; k++) {
        base /= 1.22074408460575947536;
        u[k] = (i / STRATEGIES + 0.5) * base;
        u[k] -= floor(u[k]);
    }
    double theta = (lo + (hi - lo) * u[0]) * pi / 180;
    l[0] = sin(theta);
    l[1] = 0;
    l[2] = cos(theta);
    if (!strategy_draw(v, strategy[i % STRATEGIES], l, u[1], u[2]))
        return 0;
    double density = 0;
    for (int k = 0; k < STRATEGIES; k++)
        density += strategy_density(strategy[k], l, v);
    return STRATEGIES / density;
}

static void squares_add(double *difference, double *whole, const double a[3], const double b[3], double cosine,
                        double weight)
{
    for (int c = 0; c < 3; c++) {
        double d = (a[c] - b[c]) * cosine, w = b[c] * cosine;
        *difference += weight * d * d;
        *whole += weight * w * w;
    }
}

void metrics_compare(struct metrics *out, const struct brdf_source *f, const struct brdf_source *truth)
{
    metrics_pictures(out, f, truth);
    for (int b = 0; b < METRICS_BANDS; b++) {
        double difference = 0, whole = 0;
        for (int i = 0; i < SAMPLES; i++) {
            double l[3], v[3], got[3], want[3], weight = pair_draw(l, v, i, metrics_band[b][0], metrics_band[b][1]);
            if (weight == 0)
                continue;
            f->value(got, f->ctx, l, v);
            truth->value(want, truth->ctx, l, v);
            squares_add(&difference, &whole, got, want, v[2], weight);
        }
        out->band[b] = whole > 0 ? sqrt(difference / whole) : difference > 0 ? INFINITY : 0;
    }
}

double metrics_reciprocity(const struct brdf_source *f)
{
    double difference = 0, whole = 0;
    for (int i = 0; i < SAMPLES; i++) {
        double l[3], v[3], there[3], back[3], weight = pair_draw(l, v, i, 0, 75);
        if (weight == 0)
            continue;
        f->value(there, f->ctx, l, v);
        f->value(back, f->ctx, v, l);
        squares_add(&difference, &whole, back, there, v[2], weight);
    }
    return whole > 0 ? sqrt(difference / whole) : 0;
}

/* --- albedo --- */

void metrics_albedo(double rgb[3], const struct brdf_source *f, double theta_in)
{
    /* Rings around the mirror direction at angle pi x^3: the narrowest lobe spans many. */
    enum { RINGS = 160, SECTORS = 160 };
    double theta = theta_in * pi / 180, s = sin(theta), c = cos(theta), l[3] = {s, 0, c}, sum[3] = {0}, whole = 0;
    for (int i = 0; i < RINGS; i++) {
        double x0 = (double)i / RINGS, x1 = (i + 1.0) / RINGS, x = (i + 0.5) / RINGS, ring = pi * x * x * x;
        double solid = cos(pi * x0 * x0 * x0) - cos(pi * x1 * x1 * x1);
        for (int k = 0; k < SECTORS; k++) {
            double phi = (k + 0.5) * 2 * pi / SECTORS, a = sin(ring) * cos(phi), b = sin(ring) * sin(phi);
            double v[3] = {c * a - s * cos(ring), b, s * a + c * cos(ring)}, one[3];
            if (v[2] <= 0)
                continue;
            f->value(one, f->ctx, l, v);
            for (int channel = 0; channel < 3; channel++)
                sum[channel] += one[channel] * v[2] * solid;
            whole += v[2] * solid;
        }
    }
    for (int channel = 0; channel < 3; channel++)
        rgb[channel] = pi * sum[channel] / whole;
}
