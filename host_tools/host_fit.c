#include "host_fit.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

static const double pi = 3.14159265358979323846, degree = 3.14159265358979323846 / 180;

/* --- the models --- */

/* What the models need of two directions. */
struct geometry {
    double nl, nv, nh, lh, vr;
};

struct bounds {
    double lo, hi;
};

/* The exponent is varied as ln(1 + n). */
#define COLOUR                                                                                                         \
    {                                                                                                                  \
        0, 1                                                                                                           \
    }
#define EXPONENT                                                                                                       \
    {                                                                                                                  \
        0, 8.31825 /* ln 4097 */                                                                                       \
    }
static const struct {
    const char *name;
    int count;
    struct bounds bounds[FIT_PARAMETERS];
} models[FIT_MODELS] = {
    [FIT_LAFORTUNE_PHONG] = {"lafortune_phong", 7, {COLOUR, COLOUR, COLOUR, COLOUR, COLOUR, COLOUR, EXPONENT}},
    [FIT_BLINN_PHONG] = {"blinn_phong", 7, {COLOUR, COLOUR, COLOUR, COLOUR, COLOUR, COLOUR, EXPONENT}},
    [FIT_GGX] = {"ggx", 5, {COLOUR, COLOUR, COLOUR, COLOUR, {1.0 / 32, 1}}},
};

enum fit_model fit_model_find(const char *name)
{
    for (int i = 0; i < FIT_MODELS; i++)
        if (!strcmp(name, models[i].name))
            return (enum fit_model)i;
    die(EXIT_USAGE, "--model: '%s' is not lafortune_phong, blinn_phong or ggx", name);
}

static struct geometry geometry_of(const double l[3], const double v[3])
{
    double h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]}, length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    double lv = l[0] * v[0] + l[1] * v[1] + l[2] * v[2];
    return (struct geometry){l[2], v[2], length > 0 ? h[2] / length : 0, length / 2, 2 * l[2] * v[2] - lv};
}

static void phong_value(double rgb[3], const double *p, double diffuse, double lobe)
{
    for (int c = 0; c < 3; c++)
        rgb[c] = p[c] * diffuse + p[3 + c] * lobe;
}

/* James 2022; Hammon 2017 for the visibility; see SPEC.md. */
static void ggx_value(double rgb[3], const double *p, const struct geometry *g)
{
    double alpha = p[4] * p[4], a2 = alpha * alpha, d = g->nh * g->nh * (a2 - 1) + 1;
    double lobe = a2 / (pi * d * d) / 2 / ((1 - alpha) * 2 * g->nl * g->nv + alpha * (g->nl + g->nv));
    double x = 1 - fmin(g->lh, 1), x5 = x * x * x * x * x;
    for (int c = 0; c < 3; c++) {
        double f0 = 0.04 * (1 - p[3]) + p[c] * p[3], f = f0 + (1 - f0) * x5;
        rgb[c] = lobe * f + (1 - f) * (1 - p[3]) * p[c] / pi;
    }
}

/* In: parameters with ln(1 + n) for the exponent. */
static void model_value(double rgb[3], enum fit_model model, const double *p, const struct geometry *g)
{
    if (model == FIT_GGX) {
        ggx_value(rgb, p, g);
    } else if (model == FIT_LAFORTUNE_PHONG) {
        double n = expm1(p[6]);
        phong_value(rgb, p, 1 / pi, (n + 2) / (2 * pi) * pow(fmax(g->vr, 0), n));
    } else {
        phong_value(rgb, p, 1 / pi, pow(fmax(g->nh, 0), expm1(p[6])) / (pi * g->nl));
    }
}

void fit_value(double rgb[3], const struct fit *fit, const double l[3], const double v[3])
{
    struct geometry g = geometry_of(l, v);
    double p[FIT_PARAMETERS];
    memcpy(p, fit->parameter, sizeof p);
    p[6] = log1p(p[6]);
    model_value(rgb, fit->model, p, &g);
}

static void source_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    fit_value(rgb, ctx, l, v);
}

void fit_source(struct brdf_source *out, const struct fit *fit)
{
    *out = (struct brdf_source){.value = source_value, .ctx = (void *)fit, .theta_in = 90, .theta_out = 90};
    strcpy(out->name, models[fit->model].name);
}

/* --- the samples --- */

struct sample {
    struct geometry g;
    double cosine, shown[3], weight; /* the square root of what its squared error counts */
};

struct samples {
    enum fit_model model;
    size_t count;
    struct sample *sample;
};

static uint64_t random_next(uint64_t *state) /* splitmix64, Steele et al. 2014 */
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

static double random_unit(uint64_t *state)
{
    return (double)(random_next(state) >> 11) * 0x1p-53;
}

/* As bright as it looks, nearly: plain values would leave all to a mirror's peak, which no display shows, and to grazing light. */
static double shown(double value, double cosine)
{
    return cbrt(fmax(value, 0) * cosine + 0.001);
}

static void add_slice(struct samples *out, const struct measurement_slice *s)
{
    double l[3] = {sin(s->theta_in * degree), 0, cos(s->theta_in * degree)};
    for (size_t row = 0; row < s->theta_count; row++) {
        double theta = s->theta_out[row], low = row ? (s->theta_out[row - 1] + theta) / 2 : theta;
        double high = row + 1 < s->theta_count ? (theta + s->theta_out[row + 1]) / 2 : theta;
        double solid = (cos(low * degree) - cos(high * degree)) / (double)s->phi_count, cosine = cos(theta * degree);
        for (size_t k = 0; k < s->phi_count; k++) {
            size_t cell = row * s->phi_count + k;
            if (s->mark[cell] == MEASUREMENT_EXTRAPOLATED || theta > 89)
                continue;
            double phi = (s->phi_first + (double)k * 360 / (double)s->phi_count) * degree;
            double v[3] = {sin(theta * degree) * cos(phi), sin(theta * degree) * sin(phi), cosine};
            struct sample *x = &out->sample[out->count++];
            *x = (struct sample){.g = geometry_of(l, v), .cosine = cosine, .weight = sqrt(solid)};
            for (int c = 0; c < 3; c++)
                x->shown[c] = shown(s->rgb[3 * cell + (size_t)c], cosine);
        }
    }
}

static void sample_errors(double out[3], const struct sample *x, enum fit_model model, const double *p)
{
    double rgb[3];
    model_value(rgb, model, p, &x->g);
    for (int c = 0; c < 3; c++)
        out[c] = x->weight * (shown(rgb[c], x->cosine) - x->shown[c]);
}

static double squared_error(const struct samples *s, const double *p)
{
    double sum = 0, e[3];
    for (size_t i = 0; i < s->count; i++) {
        sample_errors(e, &s->sample[i], s->model, p);
        sum += e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
    }
    return sum;
}

enum { COARSE = 1000, FINE = 5000 };

/* About `limit` random samples near the lobe and as many others, weighted for those left out. */
static void thin_out(struct samples *out, const struct samples *all, double limit, uint64_t *random)
{
    size_t near = 0;
    for (size_t i = 0; i < all->count; i++)
        near += all->sample[i].g.vr > 0.98;
    double rest = (double)(all->count - near), keep = fmin(1, limit / fmax(rest, 1));
    double keep_near = fmin(1, limit / fmax((double)near, 1));
    *out = (struct samples){.model = all->model, .sample = xmalloc(all->count * sizeof *out->sample)};
    for (size_t i = 0; i < all->count; i++) {
        double share = all->sample[i].g.vr > 0.98 ? keep_near : keep;
        if (random_unit(random) > share)
            continue;
        out->sample[out->count] = all->sample[i];
        out->sample[out->count++].weight /= sqrt(share);
    }
}

/* --- the search --- */

/* x is any number; the parameter swings between its bounds. */
static void parameters_of(double p[FIT_PARAMETERS], enum fit_model model, const gsl_vector *x)
{
    for (int i = 0; i < models[model].count; i++) {
        struct bounds b = models[model].bounds[i];
        p[i] = b.lo + (b.hi - b.lo) * (1 + sin(gsl_vector_get(x, (size_t)i))) / 2;
    }
}

static int residuals(const gsl_vector *x, void *data, gsl_vector *out)
{
    const struct samples *s = data;
    double p[FIT_PARAMETERS], e[3];
    parameters_of(p, s->model, x);
    for (size_t i = 0; i < s->count; i++) {
        sample_errors(e, &s->sample[i], s->model, p);
        for (size_t c = 0; c < 3; c++)
            gsl_vector_set(out, 3 * i + c, e[c]);
    }
    return GSL_SUCCESS;
}

/* From the parameters in p to the best near them. */
static void descend(double p[FIT_PARAMETERS], struct samples *s, size_t iterations)
{
    size_t count = (size_t)models[s->model].count;
    gsl_multifit_nlinear_parameters options = gsl_multifit_nlinear_default_parameters();
    gsl_multifit_nlinear_fdf f = {.f = residuals, .n = 3 * s->count, .p = count, .params = s};
    gsl_multifit_nlinear_workspace *w = gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &options, f.n, count);
    gsl_vector *x = gsl_vector_alloc(count);
    if (!w || !x)
        die(EXIT_INTERNAL, "out of memory: %zu residuals", f.n);
    for (size_t i = 0; i < count; i++) {
        struct bounds b = models[s->model].bounds[i];
        gsl_vector_set(x, i, asin(fmin(fmax(2 * (p[i] - b.lo) / (b.hi - b.lo) - 1, -0.98), 0.98)));
    }
    int info;
    gsl_multifit_nlinear_init(x, &f, w);
    gsl_multifit_nlinear_driver(iterations, 1e-7, 1e-9, 0, NULL, NULL, &info,
                                w); /* what it reached counts, converged or not */
    parameters_of(p, s->model, w->x);
    gsl_vector_free(x);
    gsl_multifit_nlinear_free(w);
}

void fit_make(struct fit *out, enum fit_model model, const struct measurement_grid *grid, uint64_t seed,
              const char *path)
{
    gsl_set_error_handler_off();
    struct samples all = {.model = model}, few, fewer;
    size_t room = 0;
    for (size_t i = 0; i < grid->count; i++)
        room += grid->slices[i].theta_count * grid->slices[i].phi_count;
    all.sample = xmalloc(room * sizeof *all.sample);
    for (size_t i = 0; i < grid->count; i++)
        add_slice(&all, &grid->slices[i]);
    double energy = 0, brightest = 0;
    for (size_t i = 0; i < all.count; i++)
        for (int c = 0; c < 3; c++) {
            const struct sample *x = &all.sample[i];
            energy += x->weight * x->weight * x->shown[c] * x->shown[c];
            brightest = fmax(brightest, x->weight * (x->shown[c] - shown(0, 1)));
        }
    if (all.count < 8 || !(brightest > 0))
        die(EXIT_BAD_INPUT, "%s: %zu measured samples, black or all at the horizon; nothing to fit", path, all.count);
    thin_out(&few, &all, FINE, &seed);
    thin_out(&fewer, &all, COARSE, &seed);

    const int count = models[model].count;
    double best[FIT_PARAMETERS] = {0}, errors[FIT_STARTS];
    size_t winner = 0;
    for (size_t start = 0; start < FIT_STARTS; start++) {
        double p[FIT_PARAMETERS] = {0};
        for (int i = 0; i < count; i++) {
            struct bounds b = models[model].bounds[i];
            /* The last parameter, the lobe's width, is where the minima are: spread evenly. */
            double u = i == count - 1 ? ((double)start + 0.5) / FIT_STARTS : 0.05 + 0.9 * random_unit(&seed);
            p[i] = b.lo + (b.hi - b.lo) * u;
        }
        descend(p, &fewer, 40);
        errors[start] = squared_error(&fewer, p);
        if (errors[start] < errors[winner] || !start) {
            winner = start;
            memcpy(best, p, sizeof best);
        }
    }
    *out = (struct fit){.model = model, .count = count, .samples = all.count};
    for (int i = 0; i < FIT_STARTS; i++)
        out->agreed += errors[i] <= 1.0201 * errors[winner] + 1e-12 * energy;
    descend(best, &few, 80);
    out->error = sqrt(squared_error(&all, best) / energy);
    memcpy(out->parameter, best, sizeof best);
    if (model != FIT_GGX)
        out->parameter[6] = expm1(best[6]);
    free(few.sample);
    free(fewer.sample);
    free(all.sample);
}
