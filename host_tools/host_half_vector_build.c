/* Where the nodes of a half-vector table stand, and the builder that puts them there. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common.h"
#include "host_half_vector_fit.h"

enum {
    SEGMENTS_H = HALF_VECTOR_WARP_H - 1,
    SEGMENTS_D = HALF_VECTOR_WARP_D - 1,
    SURVEY_COLUMNS = 4,
    COLUMNS = 8,
    ROUNDS = 3
};

static double seconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* --- the survey: samples that know nothing of the table yet --- */

static void survey_take(struct fit_samples *out, const struct brdf_source *source)
{
    double rows[2 * SEGMENTS_H + 1], planes[2 * SEGMENTS_D];
    int plane_count = 0;
    for (int i = 0; i <= 2 * SEGMENTS_H; i++)
        rows[i] = half_vector_segment_s2(i / 2.0);
    planes[0] = 0;
    for (int k = 0; k < SEGMENTS_D; k++) { /* finer where l is near v, for retroreflectors */
        int parts = k == 0 ? 4 : k < 3 ? 2 : 1;
        for (int i = 1; i <= parts; i++)
            planes[++plane_count] = (k + (double)i / parts) / SEGMENTS_D;
    }
    fit_samples_take(out, source, rows, 2 * SEGMENTS_H, planes, plane_count, SURVEY_COLUMNS);
}

/* Colour difference per squared distance to the nodes: the second derivative of g by the position p on an axis, weighted. */
static double bend(const struct fit_sample *before, const struct fit_sample *s, const struct fit_sample *after,
                   double p_before, double p, double p_after)
{
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        double slope =
            (double)(after->g[c] - s->g[c]) / (p_after - p) - (double)(s->g[c] - before->g[c]) / (p - p_before);
        sum += slope * slope;
    }
    double weight = (double)(s->pixels[0] * s->slope[0]) + (double)(s->pixels[1] * s->slope[1]);
    return weight * sqrt(sum) / (p_after - p_before);
}

/* The bends of each segment of the two warps, summed over all samples. Neighbours are two apart: the columns of every other
 * cell stand elsewhere. */
static void survey_bends(double *bends_h, double *bends_d, const struct fit_samples *survey)
{
    size_t row = (size_t)survey->columns, plane = row * (size_t)survey->rows;
    memset(bends_h, 0, SEGMENTS_H * sizeof *bends_h);
    memset(bends_d, 0, SEGMENTS_D * sizeof *bends_d);
    for (int j = 0; j < survey->planes; j++)
        for (int i = 0; i < survey->rows; i++)
            for (size_t k = 0; k < row; k++) {
                const struct fit_sample *s = survey->sample + plane * (size_t)j + row * (size_t)i + k;
                if (i >= 2 && i + 2 < survey->rows) {
                    const struct fit_sample *a = s - 2 * row, *b = s + 2 * row;
                    double p = half_vector_segment((double)s->s2);
                    bends_h[(int)p] +=
                        bend(a, s, b, half_vector_segment((double)a->s2), p, half_vector_segment((double)b->s2));
                }
                if (j >= 2 && j + 2 < survey->planes) {
                    const struct fit_sample *a = s - 2 * plane, *b = s + 2 * plane;
                    double p = (double)s->y * SEGMENTS_D;
                    bends_d[(int)p] += bend(a, s, b, (double)a->y * SEGMENTS_D, p, (double)b->y * SEGMENTS_D);
                }
            }
}

/* --- warps --- */

/* A warp whose rise over each segment is in proportion to `density`. */
static void warp_make(uint16_t *warp, const double *density, int segments, uint32_t nodes)
{
    double total = 0, sum = 0, last = 512.0 * (nodes - 1);
    for (int k = 0; k < segments; k++)
        total += density[k];
    warp[0] = 0;
    for (int k = 0; k < segments; k++) {
        sum += density[k];
        warp[k + 1] = (uint16_t)lround(sum / total * last);
    }
    warp[segments] = (uint16_t)last;
    if (warp[segments - 1] == warp[segments]) /* the last step must rise */
        for (int k = segments - 1; k > 0 && warp[k] == warp[segments]; k--)
            warp[k]--;
}

/* A piecewise linear axis of spacing 1/density leaves an error of sum bend / density^2: least for bends^(1/3). The exponent that
 * fits best is a little above, as the curvature itself is smoothed; a tenth stays even, so that no part is without nodes. */
static void density_from_bends(double *density, const double *bends, int segments)
{
    double mean = 0, smooth[SEGMENTS_H];
    memcpy(density, bends, (size_t)segments * sizeof *density);
    for (int pass = 0; pass < 2; pass++) {
        for (int k = 0; k < segments; k++)
            smooth[k] = (density[k ? k - 1 : 0] + 2 * density[k] + density[k + 1 < segments ? k + 1 : k]) / 4;
        memcpy(density, smooth, (size_t)segments * sizeof *density);
    }
    for (int k = 0; k < segments; k++) {
        density[k] = pow(density[k], 0.4);
        mean += density[k] / segments;
    }
    for (int k = 0; k < segments; k++)
        density[k] = mean > 0 ? 0.9 * density[k] / mean + 0.1 : 1;
}

/* Moves rows to where the last fit left more error than elsewhere: the density of every row cell times the fifth root of its
 * error relative to the mean. */
static void density_from_errors(double *density, const uint16_t *warp, const double *row_error, uint32_t cells)
{
    double mean = 0;
    for (uint32_t i = 0; i < cells; i++)
        mean += row_error[i] / cells;
    for (int k = 0; k < SEGMENTS_H; k++) {
        double from = warp[k] / 512.0, to = warp[k + 1] / 512.0;
        density[k] = 0;
        while (from < to) {
            uint32_t i = (uint32_t)fmin(from, cells - 1);
            double end = fmin(to, i + 1 < cells ? i + 1 : cells);
            double before = row_error[i ? i - 1 : 0], after = row_error[i + 1 < cells ? i + 1 : i];
            double error = mean > 0 ? (before + 2 * row_error[i] + after) / 4 / mean : 1;
            density[k] += (end - from) * pow(fmax(error, 0.05), 0.2);
            from = end;
        }
    }
}

/* Planes at equal steps of cos theta_d, what most materials without a backward lobe are well served by. */
static void density_of_cosine(double *density)
{
    double last = 1; /* cosine at y = k/64 */
    for (int k = 0; k < SEGMENTS_D; k++) {
        double difference = 1 - 2 * (k + 1.0) / SEGMENTS_D;
        double cosine = (difference + sqrt(2 - difference * difference)) / 2;
        density[k] = (last - cosine) * SEGMENTS_D;
        last = cosine;
    }
}

/* Densities of both axes, tried on a small table: the planes' by the survey's bends, by the cosine, or their mean, whichever leaves
 * the least error; the rows' by the survey, then moved TRIALS times, of which the best stands. */
static void densities_find(double *density_h, double *density_d, const struct fit_samples *survey,
                           const struct half_vector *t)
{
    enum { CANDIDATES = 3, TRIALS = 4, TRIAL_H = 32, TRIAL_D = 16, TRIAL_T = 4 };
    double bends_h[SEGMENTS_H], bends_d[SEGMENTS_D], trial[SEGMENTS_H], planes[CANDIDATES][SEGMENTS_D];
    double row_error[HALF_VECTOR_MAX_H], best_error[HALF_VECTOR_MAX_H], least = INFINITY;
    survey_bends(bends_h, bends_d, survey);
    density_from_bends(density_h, bends_h, SEGMENTS_H);
    density_from_bends(planes[0], bends_d, SEGMENTS_D);
    density_of_cosine(planes[1]);
    for (int k = 0; k < SEGMENTS_D; k++)
        planes[2][k] = (planes[0][k] + planes[1][k]) / 2;

    struct half_vector small = {.h = t->h < TRIAL_H ? t->h : TRIAL_H,
                                .d = t->d < TRIAL_D ? t->d : TRIAL_D,
                                .t = t->t < TRIAL_T ? t->t : TRIAL_T};
    warp_make(small.warp_h, density_h, SEGMENTS_H, small.h);
    for (int i = 0; i < CANDIDATES; i++) {
        warp_make(small.warp_d, planes[i], SEGMENTS_D, small.d);
        double error = half_vector_fit(&small, row_error, survey, 1);
        if (error < least) {
            least = error;
            memcpy(density_d, planes[i], sizeof planes[i]);
            memcpy(best_error, row_error, sizeof row_error);
        }
    }
    warp_make(small.warp_d, density_d, SEGMENTS_D, small.d);
    for (int i = 0; i < TRIALS; i++) {
        density_from_errors(trial, small.warp_h, i ? row_error : best_error, small.h - 1);
        warp_make(small.warp_h, trial, SEGMENTS_H, small.h);
        double error = half_vector_fit(&small, row_error, survey, 1);
        if (error < least) {
            least = error;
            memcpy(density_h, trial, sizeof trial);
        }
    }
    half_vector_free(&small);
}

/* --- the samples of the final fit --- */

/* The position, 0 .. nodes-1, whose warp value is `value`. */
static double warp_inverse(const uint16_t *warp, int nodes, double value)
{
    int k = 0;
    while (k < nodes - 2 && warp[k + 1] <= value * 512)
        k++;
    return k + fmin((value * 512 - warp[k]) / (warp[k + 1] - warp[k]), 1);
}

static int parts_per_cell(uint32_t nodes, int samples)
{
    int parts = (samples + (int)nodes - 2) / ((int)nodes - 1);
    return parts > 2 ? parts : 2;
}

/* At least two samples per cell and axis. */
static void samples_take(struct fit_samples *out, const struct brdf_source *source, const struct half_vector *t)
{
    int row_parts = parts_per_cell(t->h, SEGMENTS_H), plane_parts = parts_per_cell(t->d, SEGMENTS_D);
    int rows = ((int)t->h - 1) * row_parts, planes = ((int)t->d - 1) * plane_parts;
    double row_edges[2 * HALF_VECTOR_MAX_H], plane_edges[2 * HALF_VECTOR_MAX_D];
    for (int i = 0; i <= rows; i++)
        row_edges[i] = half_vector_segment_s2(warp_inverse(t->warp_h, HALF_VECTOR_WARP_H, (double)i / row_parts));
    for (int j = 0; j <= planes; j++)
        plane_edges[j] = warp_inverse(t->warp_d, HALF_VECTOR_WARP_D, (double)j / plane_parts) / SEGMENTS_D;
    int columns = (int)t->t - 1 > COLUMNS ? (int)t->t - 1 : COLUMNS;
    fit_samples_take(out, source, row_edges, rows, plane_edges, planes, columns);
}

/* Shares a budget of texels out: twice as many rows as planes. */
static void dimensions_choose(struct half_vector *t, uint32_t texels)
{
    t->t = (uint32_t)fmax(0.33 * cbrt(texels), 2);
    t->d = (uint32_t)fmin(fmax(round(sqrt(texels / t->t / 2.0)), 2), HALF_VECTOR_MAX_D);
    t->h = texels / t->t / t->d;
}

void half_vector_build(struct half_vector *out, struct half_vector_report *report, const struct brdf_source *source,
                       const struct half_vector_options *options)
{
    double start = seconds_now(), density_h[SEGMENTS_H], density_d[SEGMENTS_D], row_error[HALF_VECTOR_MAX_H];
    *out = (struct half_vector){.h = options->h, .d = options->d, .t = options->t};
    if (!out->h)
        dimensions_choose(out, options->texels);
    struct fit_samples samples;
    survey_take(&samples, source);
    densities_find(density_h, density_d, &samples, out);
    fit_samples_free(&samples);
    warp_make(out->warp_h, density_h, SEGMENTS_H, out->h);
    warp_make(out->warp_d, density_d, SEGMENTS_D, out->d);
    samples_take(&samples, source, out);
    report->de = half_vector_fit(out, row_error, &samples, ROUNDS);
    fit_samples_free(&samples);
    half_vector_limit_energy(out, source);
    report->seconds = seconds_now() - start;
}
