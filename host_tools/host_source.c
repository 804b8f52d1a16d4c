/* BRDF sources: opening by content, and the kinds that are short. The measurement is host_source_grid.c. */
#include "host_source.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common.h"
#include "host_half_vector.h"
#include "host_rgl.h"
#include "host_specular_frame.h"
#include "ktx2.h"
#include "lut.h"

static const double pi = 3.14159265358979323846;
static const size_t max_file_bytes = (size_t)1 << 30;

static void set_name(struct brdf_source *s, const char *path)
{
    struct measurement m; /* reduces a path to what a file may carry */
    measurement_init(&m, path);
    memcpy(s->name, m.source, sizeof s->name);
    measurement_free(&m);
}

/* theta of both in radians, and the azimuth of v from that of l; from x where l is the normal, whose azimuth is any. */
static void polar(double *theta_l, double *theta_v, double *phi, const double l[3], const double v[3])
{
    *theta_l = atan2(hypot(l[0], l[1]), l[2]);
    *theta_v = atan2(hypot(v[0], v[1]), v[2]);
    double c = l[0], s = l[1];
    if (hypot(c, s) < 1e-9) {
        c = 1;
        s = 0;
    }
    *phi = atan2(c * v[1] - s * v[0], c * v[0] + s * v[1]);
}

/* --- RGL --- */

static void rgl_source_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    double theta_l, theta_v, phi;
    polar(&theta_l, &theta_v, &phi, l, v);
    rgl_value(rgb, ctx, theta_l, fmin(theta_v, pi / 2 - 1e-4), phi); /* the file stores f cos(theta_v) */
}

static void rgl_source_close(void *ctx)
{
    rgl_close(ctx);
}

/* --- specular-frame table --- */

struct frame_source {
    uint8_t *file;
    struct specular_frame_table table;
};

static void frame_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    specular_frame_value(rgb, &((const struct frame_source *)ctx)->table, l, v);
}

static void frame_close(void *ctx)
{
    struct frame_source *f = ctx;
    free(f->file);
    free(f);
}

/* --- table of either kind --- */

static void half_vector_source_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    half_vector_value(rgb, ctx, l, v);
}

static void half_vector_source_close(void *ctx)
{
    half_vector_free(ctx);
    free(ctx);
}

void source_from_table(struct brdf_source *out, const char *path, uint8_t *data, size_t bytes)
{
    struct ktx2_view view;
    struct lut_table table;
    enum lut_status status = ktx2_open(&view, data, bytes);
    if (status == LUT_OK)
        status = lut_open(&table, data, bytes);
    if (status != LUT_OK)
        die(EXIT_BAD_INPUT, "%s: %s; build the table again", path, lut_status_text(status));
    if (table.kind == LUT_HALF_VECTOR) {
        struct half_vector *t = xmalloc(sizeof *t);
        half_vector_read(t, &view);
        *out = (struct brdf_source){.value = half_vector_source_value,
                                    .ctx = t,
                                    .close = half_vector_source_close,
                                    .theta_in = 90,
                                    .theta_out = 90,
                                    .symmetric = true};
        free(data);
        set_name(out, path);
        return;
    }
    struct frame_source *f = xmalloc(sizeof *f);
    f->file = data;
    specular_frame_read(&f->table, &view);
    *out = (struct brdf_source){
        .value = frame_value, .ctx = f, .close = frame_close, .theta_in = f->table.theta_max, .theta_out = 90};
    set_name(out, path);
}

/* --- shifted-gamma fits --- */

enum fit_parameter { RHO_D, RHO_S, ALPHA, P, F0, F1, KAP, LAM, C, K, THETA0, FIT_PARAMETERS };
static const char *const fit_names[FIT_PARAMETERS] = {"rhoD", "rhoS", "alpha", "p", "f0",    "f1",
                                                      "kap",  "lam",  "c",     "k", "theta0"};
struct fit {
    char name[64];
    double p[FIT_PARAMETERS][3];
};

static double fit_masking(const struct fit *f, int c, double cosine)
{
    double beyond = fmax(0, acos(fmin(cosine, 1)) - f->p[THETA0][c]);
    return fmin(fmax(1 + f->p[LAM][c] * (1 - exp(f->p[C][c] * pow(beyond, f->p[K][c]))), 0), 1);
}

/* Bagher, Soler and Holzschuch 2012, "Accurate fitting of measured reflectances using a shifted gamma micro-facet distribution". */
static void fit_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    const struct fit *f = ctx;
    double h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]}, length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    double cd = fmin(length / 2, 1), ch2 = fmax(h[2] * h[2] / (length * length), 1e-8);
    double t2 = (h[0] * h[0] + h[1] * h[1]) / (length * length) / ch2, away = pow(1 - cd, 5);
    for (int c = 0; c < 3; c++) {
        double fresnel = f->p[F0][c] - cd * f->p[F1][c] + away * (1 - f->p[F0][c]);
        double a = f->p[ALPHA][c] + t2 / f->p[ALPHA][c];
        double lobe = f->p[KAP][c] * exp(-a) / (pi * pow(a, f->p[P][c]) * ch2 * ch2);
        double masking = fit_masking(f, c, l[2]) * fit_masking(f, c, v[2]);
        rgb[c] = fmax(0, f->p[RHO_D][c] + f->p[RHO_S][c] * fresnel * lobe * masking / (l[2] * v[2])) / pi;
    }
}

static void fit_header_check(const char *path, const char *line)
{
    char want[512] = "material", *end = want + strlen(want);
    for (int i = 0; i < FIT_PARAMETERS; i++)
        end += sprintf(end, ",%s_r,%s_g,%s_b", fit_names[i], fit_names[i], fit_names[i]);
    if (strcmp(line, want))
        die(EXIT_BAD_INPUT, "%s:1: not a table of shifted-gamma fits; the header must be %s", path, want);
}

static void fit_parse(struct fit *out, const char *path, size_t number, const char *line)
{
    size_t name = strcspn(line, ",");
    snprintf(out->name, sizeof out->name, "%.*s", (int)name, line);
    const char *p = line + name;
    for (int i = 0; i < 3 * FIT_PARAMETERS; i++) {
        char *end = (char *)p;
        double x = *p == ',' ? strtod(p + 1, &end) : NAN;
        if (!*p || end == p + 1 || !isfinite(x))
            die(EXIT_BAD_INPUT, "%s:%zu: value %d is missing or not a finite number; %d are wanted", path, number,
                i + 1, 3 * FIT_PARAMETERS);
        out->p[i / 3][i % 3] = x;
        p = end;
    }
    if (*p)
        die(EXIT_BAD_INPUT, "%s:%zu: more than %d values; remove the rest", path, number, 3 * FIT_PARAMETERS);
}

/* All materials of the file, malloc'd. */
static size_t fits_read(struct fit **out, const char *path)
{
    size_t bytes, count = 0, number = 0;
    char *data = read_file(path, 1 << 24, &bytes), *rest = data;
    *out = NULL;
    for (char *line; (line = strsep(&rest, "\n"));) {
        line[strcspn(line, "\r")] = 0;
        if (!number++)
            fit_header_check(path, line);
        else if (*line) {
            *out = xrealloc(*out, (count + 1) * sizeof **out);
            fit_parse(&(*out)[count++], path, number, line);
        }
    }
    free(data);
    return count;
}

size_t source_fit_names(char (**names)[64], const char *path)
{
    struct fit *fits;
    size_t count = fits_read(&fits, path);
    *names = xmalloc((count + 1) * sizeof **names);
    for (size_t i = 0; i < count; i++)
        memcpy((*names)[i], fits[i].name, sizeof **names);
    free(fits);
    return count;
}

static void open_fit(struct brdf_source *out, const char *path, const char *name)
{
    struct fit *fits, *one = xmalloc(sizeof *one);
    size_t count = fits_read(&fits, path), i = 0;
    while (i < count && strcmp(fits[i].name, name))
        i++;
    if (i == count)
        die(EXIT_BAD_INPUT, "%s: none of its %zu materials is '%s'; see its first column", path, count, name);
    *one = fits[i];
    free(fits);
    *out = (struct brdf_source){
        .value = fit_value, .ctx = one, .close = free, .theta_in = 90, .theta_out = 90, .symmetric = true};
}

/* --- any --- */

static void open_file(struct brdf_source *out, const char *path)
{
    size_t bytes;
    uint8_t *data = read_file(path, max_file_bytes, &bytes);
    if (bytes >= 6 && !memcmp(data, "\xabKTX 2", 6)) {
        source_from_table(out, path, data, bytes);
    } else if (rgl_recognise(data, bytes)) {
        struct rgl *r = rgl_open(path, data, bytes);
        *out = (struct brdf_source){.value = rgl_source_value,
                                    .ctx = r,
                                    .close = rgl_source_close,
                                    .theta_in = rgl_theta_in(r),
                                    .theta_out = 90};
        free(data);
        set_name(out, path);
    } else {
        struct measurement m;
        struct measurement_grid grid;
        measurement_load(&m, path, data, bytes);
        measurement_grid_make(&grid, &m, path);
        source_from_grid(out, &grid, m.source);
        measurement_free(&m);
        free(data);
    }
}

void source_open(struct brdf_source *out, const char *path)
{
    char *file = xstrdup(path), *colon = strrchr(file, ':');
    if (colon && access(path, F_OK)) {
        *colon = 0;
        open_fit(out, file, colon + 1);
        set_name(out, path);
    } else {
        open_file(out, path);
    }
    free(file);
}

void source_close(struct brdf_source *s)
{
    if (s->close)
        s->close(s->ctx);
    *s = (struct brdf_source){0};
}

void source_symmetric(double rgb[3], const struct brdf_source *s, const double l[3], const double v[3])
{
    const double ml[3] = {l[0], -l[1], l[2]}, mv[3] = {v[0], -v[1], v[2]};
    double one[3];
    s->value(rgb, s->ctx, l, v);
    if (s->symmetric)
        return;
    s->value(one, s->ctx, v, l);
    for (int c = 0; c < 3; c++)
        rgb[c] += one[c];
    s->value(one, s->ctx, ml, mv);
    for (int c = 0; c < 3; c++)
        rgb[c] += one[c];
    s->value(one, s->ctx, mv, ml);
    for (int c = 0; c < 3; c++)
        rgb[c] = (rgb[c] + one[c]) / 4;
}

static void symmetric_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    source_symmetric(rgb, ctx, l, v);
}

void source_make_symmetric(struct brdf_source *out, const struct brdf_source *s)
{
    *out = *s;
    out->value = symmetric_value;
    out->ctx = (void *)s;
    out->close = NULL;
    out->symmetric = true;
}
