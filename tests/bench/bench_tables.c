/*
 * How far tables of each kind and size are from what they were built from: rows of results.csv on stdout.
 *
 *   bench_tables
 *
 * Materials: those of the folder GONIOTILE_DATA (default ../shared/data); without it only a comment line is printed. merl_60 is
 * the mean over the fits of merl_sgd.csv, rgl_mean that over the four RGL files; rgl_four_angles is the latter when an instrument
 * sees them at theta_in 0, 20, 40, 60 and theta_out up to 75 degrees only, which is all that a specular-frame table ever sees.
 */
#include <stdio.h>
#include <stdlib.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "common.h"
#include "host_half_vector.h"
#include "host_metrics.h"
#include "host_rgb9e5.h"
#include "host_specular_frame.h"

enum { SIZES = 3, FILES = 4, TABLES = SIZES + 2 };
static const uint32_t texels[SIZES] = {16384, 4096, 1024};
static const char *const files[FILES] = {"paper_white", "cc_ibiza_sunset", "satin_rosaline", "colodur_napoli_4f"};

/* One table's figures, or the sum of several's. */
struct figures {
    struct metrics m;
    size_t bytes, count;
};

static void figures_add(struct figures *sum, const struct metrics *m, size_t bytes)
{
    sum->m.de_mean += m->de_mean;
    sum->m.de_p99 += m->de_p99;
    sum->m.psnr += m->psnr;
    for (int i = 0; i < METRICS_BANDS; i++)
        sum->m.band[i] += m->band[i];
    sum->bytes += bytes;
    sum->count++;
}

/* Bytes: the mean where dimensions are the materials' own. */
static void print(const char *material, const char *kind, const struct figures *f, bool bands)
{
    const double values[] = {f->m.de_mean, f->m.de_p99, f->m.psnr, f->m.band[0], f->m.band[1], f->m.band[2]};
    static const char *const names[] = {"de_mean", "de_p99", "psnr", "e_0_60", "e_60_75", "e_75_87"};
    static const char *const units[] = {"CIE76", "CIE76", "dB", "ratio", "ratio", "ratio"};
    for (int i = 0; i < (bands ? 6 : 3); i++)
        printf("shade,host,%s,%s-%zu-8,%s,%.4g,%s\n", material, kind, f->bytes / f->count, names[i],
               values[i] / (double)f->count, units[i]);
    fflush(stdout);
}

static void compare(struct metrics *m, const struct brdf_source *table, const struct brdf_source *truth, bool bands)
{
    (bands ? metrics_compare : metrics_pictures)(m, table, truth);
}

static void half_vector_figures(struct figures *sum, const struct brdf_source *seen, const struct brdf_source *truth,
                                uint32_t budget, const char *material, bool bands)
{
    struct half_vector t;
    struct half_vector_report report;
    struct brdf_source source;
    struct figures one = {0};
    struct metrics m = {0};
    half_vector_build(&t, &report, seen, &(struct half_vector_options){.texels = budget});
    half_vector_source(&source, &t, "table");
    compare(&m, &source, truth, bands);
    figures_add(&one, &m, half_vector_bytes(&t));
    figures_add(sum, &m, half_vector_bytes(&t));
    fprintf(stderr, "%s: %ux%ux%u, dE %.3f (fit says %.3f), %.2f s\n", material ? material : "-", t.h, t.d, t.t,
            m.de_mean, report.de, report.seconds);
    if (material)
        print(material, "half_vector", &one, bands);
    half_vector_free(&t);
}

/* What the instrument of the paper sees. */
static void instrument(struct measurement_grid *grid, const struct brdf_source *truth)
{
    const double degree = 3.14159265358979323846 / 180;
    struct measurement m;
    measurement_init(&m, "instrument");
    for (int i = 0; i <= 60; i += 20)
        for (int o = 0; o <= 75; o++)
            for (int phi = 0; phi < 360; phi++) {
                double l[3] = {sin(i * degree), 0, cos(i * degree)}, rgb[3];
                double v[3] = {sin(o * degree) * cos(phi * degree), sin(o * degree) * sin(phi * degree),
                               cos(o * degree)};
                truth->value(rgb, truth->ctx, l, v);
                struct measurement_point p = {.theta_in = (float)i,
                                              .theta_out = (float)o,
                                              .phi_out = (float)phi,
                                              .rgb = {(float)rgb[0], (float)rgb[1], (float)rgb[2]}};
                measurement_add(&m, &p);
            }
    measurement_grid_make(grid, &m, "instrument");
    measurement_free(&m);
}

static void specular_frame_figures(struct figures sum[2], const struct brdf_source *truth, const char *material,
                                   bool bands)
{
    struct measurement_grid grid;
    struct specular_frame frame;
    instrument(&grid, truth);
    specular_frame_build(&frame, &grid, &(struct specular_frame_options){361, 181, 1, 0.3}, "instrument");
    size_t count = (size_t)frame.width * frame.height * frame.depth;
    uint32_t *words = xmalloc(count * sizeof *words);
    for (size_t i = 0; i < count; i++)
        words[i] = rgb9e5_encode(frame.rgb + 3 * i);
    for (int swap = 0; swap < 2; swap++) {
        struct specular_frame_table t = {words, frame.width, frame.height, frame.depth, frame.theta_max, swap};
        struct brdf_source source;
        struct figures one = {0};
        struct metrics m = {0};
        specular_frame_source(&source, &t, "table");
        compare(&m, &source, truth, bands);
        figures_add(&one, &m, 4 * count);
        figures_add(&sum[swap], &m, 4 * count);
        if (material)
            print(material, swap ? "specular_frame_swap" : "specular_frame", &one, bands);
    }
    free(words);
    specular_frame_free(&frame);
    measurement_grid_free(&grid);
}

static void print_all(const char *material, const struct figures sum[TABLES], bool bands)
{
    for (int i = 0; i < SIZES; i++)
        print(material, "half_vector", &sum[i], bands);
    print(material, "specular_frame", &sum[SIZES], bands);
    print(material, "specular_frame_swap", &sum[SIZES + 1], bands);
}

static void rgl_rows(const char *folder)
{
    struct figures all[TABLES] = {0}, four[TABLES] = {0};
    for (int i = 0; i < FILES; i++) {
        char *path = xasprintf("%s/brdf/%s_rgb.bsdf", folder, files[i]);
        struct brdf_source file, seen, truth;
        struct measurement_grid grid;
        source_open(&file, path);
        source_make_symmetric(&truth, &file);
        instrument(&grid, &truth);
        source_from_grid(&seen, &grid, files[i]);
        for (int k = 0; k < SIZES; k++) {
            half_vector_figures(&all[k], &file, &truth, texels[k], files[i], true);
            half_vector_figures(&four[k], &seen, &truth, texels[k], NULL, true);
        }
        specular_frame_figures(all + SIZES, &truth, files[i], true);
        source_close(&seen);
        source_close(&file);
        free(path);
    }
    memcpy(four + SIZES, all + SIZES, 2 * sizeof *all);
    print_all("rgl_mean", all, true);
    print_all("rgl_four_angles", four, true);
}

static void fit_rows(const char *folder)
{
    struct figures all[TABLES] = {0};
    char *path = xasprintf("%s/brdf/merl_sgd.csv", folder), (*names)[64];
    size_t count = source_fit_names(&names, path);
    for (size_t i = 0; i < count; i++) {
        char *fit = xasprintf("%s:%s", path, names[i]);
        struct brdf_source source;
        source_open(&source, fit);
        for (int k = 0; k < SIZES; k++)
            half_vector_figures(&all[k], &source, &source, texels[k], NULL, false);
        specular_frame_figures(all + SIZES, &source, NULL, false);
        source_close(&source);
        free(fit);
    }
    print_all("merl_60", all, false);
    free(names);
    free(path);
}

int main(void)
{
    common_set_name("bench_tables", NULL);
    const char *folder = getenv("GONIOTILE_DATA");
    folder = folder ? folder : "../shared/data";
    char *probe = xasprintf("%s/brdf/merl_sgd.csv", folder);
    if (access(probe, R_OK)) {
        printf("# shade: no %s; set GONIOTILE_DATA for the rows of measured materials\n", probe);
    } else {
        rgl_rows(folder);
        fit_rows(folder);
    }
    free(probe);
    return EXIT_OK;
}
