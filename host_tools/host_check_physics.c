/* What physics asks of a BRDF: energy, reciprocity, and that it is one (host_check.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_check_internal.h"

static const double pi = 3.14159265358979323846, degree = 3.14159265358979323846 / 180;

/* Degrees from column k to the next one. */
static double gap_after(const struct check_slice *s, size_t k)
{
    return k + 1 < s->phi_count ? s->phi_out[k + 1] - s->phi_out[k] : s->phi_out[0] + 360 - s->phi_out[k];
}

/* With light along the normal one azimuth is as good as another. */
static bool along_the_normal(const struct check_slice *s)
{
    return s->theta_in < 1e-3;
}

/* Azimuth that column k stands for, radians: a scan of one plane is none of the hemisphere. */
static double column_width(const struct check_slice *s, size_t k)
{
    double left = gap_after(s, k ? k - 1 : s->phi_count - 1), right = gap_after(s, k);
    double most = along_the_normal(s) ? 360 : CHECK_PHI_GAP;
    return (fmin(left, most) + fmin(right, most)) / 2 * degree;
}

static void integrate(struct check_slice *s)
{
    for (size_t row = 0; row < s->theta_count; row++) {
        double theta = s->theta_out[row], low = row ? (s->theta_out[row - 1] + theta) / 2 : 0;
        double high = row + 1 < s->theta_count ? (theta + s->theta_out[row + 1]) / 2 : theta;
        double s0 = sin(low * degree), s1 = sin(high * degree), strip = (s1 * s1 - s0 * s0) / 2;
        double beyond = row + 1 < s->theta_count ? 0 : (1 - s1 * s1) / 2, width = 0, sum[3] = {0};
        for (size_t k = 0; k < s->phi_count; k++) {
            size_t cell = row * s->phi_count + k;
            if (!check_usable(s->state[cell]) && s->state[cell] != CHECK_EXTRAPOLATED)
                continue;
            double w = column_width(s, k);
            width += w;
            s->covered += check_usable(s->state[cell]) ? w * strip / pi : 0;
            for (int c = 0; c < 3; c++)
                sum[c] += w * s->rgb[cell][c];
        }
        for (int c = 0; c < 3 && width > 0; c++) {
            s->albedo[c] += strip * 2 * pi * sum[c] / width;
            s->albedo_carried[c] += (strip + beyond) * 2 * pi * sum[c] / width;
        }
    }
}

static void judge_coverage(struct check *c)
{
    double where = 0;
    c->covered_least = 1;
    for (size_t i = 0; i < c->count; i++) {
        const struct check_slice *s = &c->slices[i];
        bool measured = false;
        for (size_t k = 0; k < s->theta_count * s->phi_count && !measured; k++)
            measured = s->state[k] != CHECK_EXTRAPOLATED;
        if (measured && s->covered < c->covered_least) {
            c->covered_least = s->covered;
            where = s->theta_in;
        }
        for (size_t k = 0; k < s->phi_count && !along_the_normal(s); k++)
            c->phi_gap = fmax(c->phi_gap, gap_after(s, k));
    }
    if (c->phi_gap > CHECK_PHI_GAP + 1e-3)
        c->coverage_problem =
            xasprintf("phi_out lie up to %g degrees apart, nothing is known between; measure every %d", c->phi_gap,
                      CHECK_PHI_GAP);
    else if (c->covered_least < 0.2)
        c->coverage_problem =
            xasprintf("only %.1f %% of the hemisphere measured at theta_in %g; measure more, and in degrees",
                      100 * c->covered_least, where);
}

double check_albedo_max(const struct check *c)
{
    double max = 0;
    for (size_t i = 0; i < c->count; i++)
        for (int k = 0; k < 3; k++)
            max = fmax(max, c->slices[i].albedo_carried[k]);
    return max;
}

/* The pair of grid lines around x and the second one's weight; false outside. */
static bool bracket(size_t *lo, size_t *hi, double *t, const double *axis, size_t count, double x)
{
    if (x < axis[0] - 1e-3 || x > axis[count - 1] + 1e-3)
        return false;
    *lo = 0;
    while (*lo + 1 < count && axis[*lo + 1] <= x + 1e-9)
        ++*lo;
    *hi = *lo + 1 < count ? *lo + 1 : *lo;
    *t = *hi > *lo ? fmin(fmax((x - axis[*lo]) / (axis[*hi] - axis[*lo]), 0), 1) : 0;
    return true;
}

/* Bilinear luminance; false where a sample it needs is not usable. */
static bool slice_luminance(double *out, const struct check_slice *s, double theta, double phi)
{
    size_t lo, hi, left, right;
    double t, u;
    if (!bracket(&lo, &hi, &t, s->theta_out, s->theta_count, theta))
        return false;
    phi -= 360 * floor(phi / 360);
    if (!bracket(&left, &right, &u, s->phi_out, s->phi_count, phi)) { /* between the last column and the first */
        left = s->phi_count - 1;
        right = 0;
        double from = s->phi_out[left], width = s->phi_out[0] + 360 - from, at = phi < from ? phi + 360 : phi;
        u = width > 0 ? (at - from) / width : 0;
    }
    const size_t cell[4] = {lo * s->phi_count + left, lo * s->phi_count + right, hi * s->phi_count + left,
                            hi * s->phi_count + right};
    const double weight[4] = {(1 - t) * (1 - u), (1 - t) * u, t * (1 - u), t * u};
    *out = 0;
    for (int k = 0; k < 4; k++) {
        if (weight[k] > 1e-9 && !check_usable(s->state[cell[k]]))
            return false;
        *out += weight[k] > 1e-9 ? weight[k] * check_luminance(s->rgb[cell[k]]) : 0;
    }
    return true;
}

/* Pairs of measured angles of incidence: what one slice holds at the other's angle, and the other way round. */
static void compare_reciprocal(struct check *c)
{
    double above[3] = {0}, below[3] = {0}, *exponents = NULL;
    size_t room = 0, used = 0;
    for (size_t i = 0; i < c->count; i++)
        for (size_t j = i + 1; j < c->count; j++) {
            const struct check_slice *s = &c->slices[i], *t = &c->slices[j];
            double ci = cos(s->theta_in * degree), cj = cos(t->theta_in * degree), tilt = log(cj / ci);
            for (size_t k = 0; k < s->phi_count; k++) {
                double a, b, phi = s->phi_out[k];
                if (!slice_luminance(&a, s, t->theta_in, phi) || !slice_luminance(&b, t, s->theta_in, -phi))
                    continue;
                c->reciprocal_pairs++;
                /* As stored, divided by cos(theta_out), multiplied by it. */
                const double fa[3] = {1, 1 / cj, cj}, fb[3] = {1, 1 / ci, ci};
                for (int h = 0; h < 3; h++) {
                    double x = a * fa[h], y = b * fb[h];
                    above[h] += ci * cj * (x - y) * (x - y);
                    below[h] += ci * cj * (x + y) * (x + y) / 4;
                }
                if (a > 0 && b > 0 && fabs(tilt) > 0.1) {
                    if (used == room)
                        exponents = xrealloc(exponents, (room = room ? 2 * room : 1024) * sizeof *exponents);
                    exponents[used++] = log(a / b) / tilt;
                }
            }
        }
    for (int h = 0; h < 3; h++)
        c->reciprocity[h] = below[h] > 0 ? sqrt(above[h] / below[h]) : 0;
    c->exponent = used ? check_median(exponents, used) : NAN;
    free(exponents);
}

/* Least-squares slope of ln f over ln cos(theta_out) in the smallest angle of incidence, away from the plane of incidence and the
 * mirror direction. */
static double grazing_trend(const struct check_slice *s)
{
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (size_t i = 0; i < s->theta_count * s->phi_count; i++) {
        double theta = s->theta_out[i / s->phi_count], phi = s->phi_out[i % s->phi_count],
               f = check_luminance(s->rgb[i]);
        bool aside = s->theta_in < 1 || fabs(cos(phi * degree)) < 0.75;
        if (!check_usable(s->state[i]) || theta < 40 || theta > 82 || !aside || !(f > 0) ||
            check_distance(s->theta_in, theta, phi, true) < 25)
            continue;
        double x = log(cos(theta * degree)), y = log(f);
        n++;
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    double d = n * sxx - sx * sx;
    return n >= 8 && d > 1e-6 * n * n ? (n * sxy - sx * sy) / d : NAN;
}

enum { PAIRS_ENOUGH = 12 };

static enum check_quantity quantity_of(const struct check *c)
{
    double e = c->reciprocal_pairs >= PAIRS_ENOUGH ? c->exponent : NAN, t = c->trend;
    if (isnan(e)) /* the trend alone: real BRDFs seldom leave -0.8..0.7 */
        return isnan(t) ? CHECK_UNCLEAR : t > 0.7 ? CHECK_TIMES_COSINE : t < -0.8 ? CHECK_OVER_COSINE : CHECK_BRDF;
    /* A median of ratios: neither lobes, which dominate the error, nor a trend of the material's own move it much. */
    return fabs(e) <= 0.5 ? CHECK_BRDF : fabs(e) > 1.5 ? CHECK_UNCLEAR : e > 0 ? CHECK_TIMES_COSINE : CHECK_OVER_COSINE;
}

void check_physics(struct check *c)
{
    for (size_t i = 0; i < c->count; i++)
        integrate(&c->slices[i]);
    judge_coverage(c);
    compare_reciprocal(c);
    c->trend = c->count ? grazing_trend(&c->slices[0]) : NAN;
    c->quantity = quantity_of(c);
}
