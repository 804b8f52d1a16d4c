/*
 * Fits a target's table of costs to what tests/board/calibrate/main.c measured, and writes it as a header: non-negative least squares of
 * relative residuals, step by step, then raised until measurements are within it.
 *
 *   calibrate TARGET MEASURED.txt >TABLE.h
 *
 * Prints on stderr how far measured ticks are from the fit's.
 */
#include "common.h"
#include "quality.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    COLUMNS = 8,
    MAX_VARIABLES = 40,
    SWEEPS = 5000,
    LARGE = 250, /* pixels of a tile whose share a fit is about */
    PLAN =
        27000 /* ticks of what is known before rates are chosen, at most: tests/e2e/test_budget_boards.sh measures fewer */
};

struct line {
    char step[16];
    double ticks, v[COLUMNS];
};

struct lines {
    struct line *line;
    size_t count;
};

static struct lines read_lines(const char *path)
{
    struct lines all = {NULL, 0};
    char text[200];
    bool ended = false;
    FILE *f = fopen(path, "r");
    if (!f)
        die(EXIT_FILE, "%s: cannot be read", path);
    while (fgets(text, sizeof text, f)) {
        if (all.count % 4096 == 0)
            all.line = xrealloc(all.line, (all.count + 4096) * sizeof *all.line);
        struct line *l = &all.line[all.count];
        double *v = l->v;
        memset(l, 0, sizeof *l);
        ended = !strncmp(text, "end ", 4);
        if (ended)
            break;
        if (sscanf(text, "%15s %lf %lf %lf %lf %lf %lf %lf %lf %lf", l->step, &l->ticks, v, v + 1, v + 2, v + 3, v + 4,
                   v + 5, v + 6, v + 7) < 3)
            die(EXIT_BAD_INPUT, "%s: not a measurement: %s", path, text);
        all.count++;
    }
    fclose(f);
    if (!ended)
        die(EXIT_BAD_INPUT, "%s: measurements are cut short; see its last line", path);
    return all;
}

static bool is(const struct line *l, const char *step)
{
    return !strcmp(l->step, step);
}

/* --- fits --- */

struct fit {
    unsigned variables;
    size_t count;
    double *ticks, (*counts)[MAX_VARIABLES];
    double x[MAX_VARIABLES];
};

static void fit_add(struct fit *f, double ticks, const double counts[MAX_VARIABLES])
{
    if (f->count % 1024 == 0) {
        f->ticks = xrealloc(f->ticks, (f->count + 1024) * sizeof *f->ticks);
        f->counts = xrealloc(f->counts, (f->count + 1024) * sizeof *f->counts);
    }
    f->ticks[f->count] = ticks;
    memcpy(f->counts[f->count++], counts, sizeof *f->counts);
}

static double fit_at(const struct fit *f, const double counts[MAX_VARIABLES])
{
    double sum = 0;
    for (unsigned k = 0; k < f->variables; k++)
        sum += f->x[k] * counts[k];
    return sum;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Coordinate descent on the normal equations of relative residuals. Returns the most of measured over fitted. */
static double fit_solve(struct fit *f, const char *name)
{
    double h[MAX_VARIABLES][MAX_VARIABLES] = {{0}}, g[MAX_VARIABLES] = {0}, *ratio = xmalloc(f->count * sizeof *ratio);
    for (size_t i = 0; i < f->count; i++)
        for (unsigned j = 0; j < f->variables; j++) {
            const double w = 1 / (f->ticks[i] * f->ticks[i]);
            g[j] += w * f->counts[i][j] * f->ticks[i];
            for (unsigned k = 0; k < f->variables; k++)
                h[j][k] += w * f->counts[i][j] * f->counts[i][k];
        }
    for (int sweep = 0; sweep < SWEEPS; sweep++)
        for (unsigned j = 0; j < f->variables; j++) {
            double rest = g[j];
            for (unsigned k = 0; k < f->variables; k++)
                rest -= h[j][k] * f->x[k];
            f->x[j] = h[j][j] > 0 ? fmax(f->x[j] + rest / h[j][j], 0) : 0;
        }
    for (size_t i = 0; i < f->count; i++)
        ratio[i] = f->ticks[i] / fit_at(f, f->counts[i]);
    qsort(ratio, f->count, sizeof *ratio, by_size);
    const double most = ratio[f->count - 1];
    fprintf(stderr, "%-7s %6zu measurements over fit: 1 %% %.3f, median %.3f, 99 %% %.3f, most %.3f\n", name, f->count,
            ratio[f->count / 100], ratio[f->count / 2], ratio[f->count * 99 / 100], most);
    free(ratio);
    return most;
}

static void fit_scale(struct fit *f, double factor)
{
    for (unsigned k = 0; k < f->variables; k++)
        f->x[k] *= factor;
}

static void fit_free(struct fit *f)
{
    free(f->ticks);
    free(f->counts);
}

/* --- the table --- */

struct table {
    double tile, clear, meshlet, vertex, triangle, general, facing, row, tested, general_facing, general_row,
        general_tested, survey, light, region, flat, part, cell, finished, run, taps[RASTER_TAPS_COUNT],
        texels[RASTER_TAPS_COUNT], bright, broad, slow_point;
    struct {
        double planes, sample, lit, dark, point, flat;
    } shading[RASTER_SHADE_COUNT];
};

static void at_least(double *x, double y)
{
    *x = fmax(*x, y);
}

static void fit_drawing(struct table *t, const struct lines *all)
{
    struct fit f = {.variables = 7};
    for (size_t i = 0; i < all->count; i++) {
        const struct line *l = &all->line[i];
        const double *v = l->v;
        if (is(l, "draw"))
            fit_add(&f, l->ticks, (const double[MAX_VARIABLES]){1, v[0], v[1], v[2] ? 0 : v[1], v[3], v[4], v[5]});
    }
    fit_solve(&f, "draw");
    fit_scale(&f, 1.05);
    const double *x = f.x;
    t->meshlet = x[0], t->vertex = x[1], t->triangle = x[2], t->general = x[3], t->facing = x[4], t->row = x[5],
    t->tested = x[6];
    for (size_t i = 0; i < all->count; i++) {
        const struct line *l = &all->line[i];
        const double *v = l->v, fan = 6; /* triangles that one is cut into */
        if (is(l, "clip"))
            at_least(&t->general, (l->ticks - t->meshlet - t->vertex * v[0] - t->tested * v[5]) / v[1] - t->triangle -
                                      t->facing * fan);
    }
    fit_free(&f);
}

enum { KINDS = RASTER_SHADE_DIFFUSE_ROW, REGION = 4 * KINDS, PART, CELL, SHADE_VARIABLES };

/* Rate flat, under RASTER_LEAST_LIGHTS point lights: an upper bound of any kind's. */
static void fit_flat(struct table *t, const struct lines *all)
{
    struct fit f = {.variables = KINDS + 1};
    for (size_t i = 0; i < all->count; i++) {
        const struct line *l = &all->line[i];
        double counts[MAX_VARIABLES] = {0};
        if (!is(l, "point") || l->v[1] != RASTER_RATE_FLAT)
            continue;
        counts[(int)l->v[0]] = l->v[2];
        counts[KINDS] = l->v[7];
        fit_add(&f, l->ticks, counts);
    }
    fit_solve(&f, "flat");
    for (size_t i = 0; i < f.count; i++)
        at_least(&f.x[KINDS], f.x[KINDS] + (f.ticks[i] - fit_at(&f, f.counts[i])) / f.counts[i][KINDS]);
    for (int k = 0; k < KINDS; k++)
        t->shading[k].flat = f.x[k];
    t->flat = f.x[KINDS];
    fit_free(&f);
}

/* More than what other triangles take. */
static void fit_general(struct table *t, const struct lines *all)
{
    struct fit f = {.variables = 3};
    for (size_t i = 0; i < all->count; i++) {
        const struct line *l = &all->line[i];
        if (is(l, "general") && l->v[1])
            fit_add(&f, l->ticks, (const double[MAX_VARIABLES]){1, l->v[0], l->v[1]});
    }
    fit_solve(&f, "general");
    for (size_t i = 0; i < f.count; i++)
        at_least(&f.x[0], f.x[0] + f.ticks[i] - fit_at(&f, f.counts[i]));
    t->general_facing = fmax(f.x[0] - t->facing, 0);
    t->general_row = fmax(f.x[1] - t->row, 0);
    t->general_tested = fmax(f.x[2] - t->tested, 0);
    fit_free(&f);
}

static void shade_counts(double counts[MAX_VARIABLES], const double v[COLUMNS], unsigned directional)
{
    const int rate = (int)v[1];
    const double samples = v[2], parts = v[6], blocks = v[7];
    double *own = counts + 4 * (int)v[0];
    memset(counts, 0, MAX_VARIABLES * sizeof *counts);
    own[0] = blocks * directional, own[1] = samples, own[2] = v[3], own[3] = v[4];
    counts[REGION] = blocks;
    if (rate)
        counts[PART] = parts, counts[CELL] = samples;
}

static bool is_regular(const struct line *l)
{
    return is(l, "shade") && l->v[1] < RASTER_RATE_FLAT && l->v[7] <= 24;
}

/* What fewer taps save at least, and tables without a re-packed copy, or beyond its loop, take more at most of a light that reaches many
 * pixels; and regions' cost is raised where that is not all. */
static void fit_taps(struct table *t, struct fit *f, const struct lines *all)
{
    double counts[MAX_VARIABLES], all_bright[RASTER_TAPS_COUNT] = {0};
    t->taps[RASTER_TAPS_4] = t->taps[RASTER_TAPS_1] = f->x[2];
    for (int pass = 0; pass < 2; pass++) {
        const struct line *of_eight = NULL;
        for (size_t i = 0; i < all->count; i++) {
            const struct line *l = &all->line[i];
            const int taps = (int)l->v[0];
            const double lit = l->v[1], more = of_eight ? l->ticks - of_eight->ticks : 0;
            const bool bright = is(l, "bright"), texels = bright || is(l, "texels");
            if (!texels && !is(l, "taps")) {
                of_eight = is_regular(l) ? l : is(l, "shade") ? NULL : of_eight;
                continue;
            }
            if (!of_eight || (!pass && lit < LARGE))
                continue;
            if (!pass && bright)
                all_bright[taps] = fmax(all_bright[taps], more / lit);
            else if (!pass && texels)
                t->texels[taps] = fmax(t->texels[taps], more / lit);
            else if (!pass)
                t->taps[taps] = fmin(t->taps[taps], fmax(-more / lit, 0));
            if (!pass)
                continue;
            shade_counts(counts, of_eight->v, (unsigned)((of_eight->v[3] + of_eight->v[4]) / of_eight->v[2]));
            const double fitted =
                fit_at(f, counts) + lit * (texels ? t->texels[taps] + (bright ? t->bright : 0) : -t->taps[taps]);
            at_least(&f->x[REGION], f->x[REGION] + (l->ticks - fitted) / of_eight->v[7]);
        }
        for (int taps = 0; taps < RASTER_TAPS_COUNT; taps++)
            t->bright = fmax(t->bright, all_bright[taps] - t->texels[taps]);
    }
}

static void fit_shading(struct table *t, const struct lines *all)
{
    struct fit f = {.variables = SHADE_VARIABLES};
    double counts[MAX_VARIABLES];
    for (size_t i = 0; i < all->count; i++) {
        const struct line *l = &all->line[i];
        if (is_regular(l) && l->v[5] >= LARGE) {
            shade_counts(counts, l->v, (unsigned)((l->v[3] + l->v[4]) / l->v[2]));
            fit_add(&f, l->ticks, counts);
        }
    }
    fit_scale(&f, fit_solve(&f, "shade"));
    for (size_t i = 0; i < all->count; i++) { /* regions with few pixels take more than their parts */
        const struct line *l = &all->line[i];
        if (!is_regular(l))
            continue;
        shade_counts(counts, l->v, (unsigned)((l->v[3] + l->v[4]) / l->v[2]));
        at_least(&f.x[REGION], f.x[REGION] + (l->ticks - fit_at(&f, counts)) / l->v[7]);
    }
    fit_taps(t, &f, all);
    for (size_t i = 0; i < all->count; i++) {
        const struct line *l = &all->line[i];
        if (!is(l, "broad"))
            continue;
        shade_counts(counts, l->v, (unsigned)((l->v[3] + l->v[4]) / l->v[2]));
        const double planes = RASTER_BROAD_PLANES * counts[4 * (int)l->v[0]];
        at_least(&t->broad, (l->ticks - fit_at(&f, counts)) / (l->v[3] + planes));
    }
    t->region = f.x[REGION], t->part = f.x[PART], t->cell = f.x[CELL];
    for (int k = 0; k < KINDS; k++) {
        const double *x = f.x + 4 * k;
        t->shading[k].planes = x[0], t->shading[k].sample = x[1], t->shading[k].lit = x[2], t->shading[k].dark = x[3];
    }
    for (size_t i = 0; i < all->count; i++) {
        const struct line *l = &all->line[i];
        const int k = (int)l->v[0];
        if (!is(l, "point") || l->v[1] == RASTER_RATE_FLAT || l->v[5] < LARGE)
            continue;
        shade_counts(counts, l->v, 0);
        counts[4 * k + 2] = counts[4 * k + 3] = 0;
        at_least(&t->shading[k].point, (l->ticks - fit_at(&f, counts)) / (l->v[3] + l->v[4]));
    }
    /* What slower ways take more than under directional lights, as a pixel is shaded by itself. */
    for (size_t i = 0; i < all->count; i++) {
        const struct line *l = &all->line[i];
        const int k = (int)l->v[0];
        const double texels = t->texels[RASTER_TAPS_8];
        const double more = is(l, "point_broad")    ? t->broad
                            : is(l, "point_texels") ? texels
                            : is(l, "point_bright") ? texels + t->bright
                                                    : -1;
        if (more < 0 || l->v[1] == RASTER_RATE_FLAT || l->v[5] < LARGE)
            continue;
        shade_counts(counts, l->v, 0);
        counts[4 * k + 2] = counts[4 * k + 3] = 0;
        at_least(&t->slow_point, (l->ticks - fit_at(&f, counts)) / (l->v[3] + l->v[4]) - t->shading[k].point - more);
    }
    fit_free(&f);
}

/* Clearing, surveys and packing. */
static void fit_packing(struct table *t, const struct lines *all)
{
    struct fit f = {.variables = 3};
    double clear = 0;
    for (size_t i = 0; i < all->count; i++) {
        const struct line *l = &all->line[i];
        if (is(l, "survey")) {
            at_least(&clear, l->v[0]);
            at_least(&t->survey, l->ticks / RASTER_TILE_PIXELS);
        } else if (is(l, "finish") && !l->v[1]) {
            fit_add(&f, l->ticks, (const double[MAX_VARIABLES]){l->v[4] / RASTER_TILE_PIXELS, l->v[0], l->v[6]});
        }
    }
    fit_solve(&f, "finish");
    for (size_t i = 0; i < f.count; i++) /* short runs of pixels take more */
        at_least(&f.x[0], f.x[0] + (f.ticks[i] - fit_at(&f, f.counts[i])) / f.counts[i][0]);
    t->clear = clear;
    t->tile = clear + f.x[0];
    t->finished = f.x[1];
    t->run = f.x[2];
    fit_free(&f);
}

/* What is shaded in rows, while it is packed. */
static void fit_rows(struct table *t, const struct lines *all)
{
    struct fit f = {.variables = 6};
    for (size_t i = 0; i < all->count; i++) {
        const struct line *l = &all->line[i];
        const double *v = l->v;
        double counts[MAX_VARIABLES] = {0};
        if (!is(l, "finish") || !v[1] || v[2] < LARGE)
            continue;
        for (int k = 0; k < 3; k++)
            counts[(v[1] == RASTER_SHADE_DIFFUSE_ROW ? 0 : 3) + k] = v[k < 2 ? 2 + k : 5];
        fit_add(&f, l->ticks - (t->tile - t->clear) * v[4] / RASTER_TILE_PIXELS - t->finished * v[0] - t->run * v[6],
                counts);
    }
    fit_scale(&f, fit_solve(&f, "rows"));
    for (int k = 0; k < 2; k++) {
        const double *x = f.x + 3 * k;
        t->shading[KINDS + k].sample = x[0];
        t->shading[KINDS + k].lit = t->shading[KINDS + k].dark = x[1];
        t->shading[KINDS + k].planes = x[2];
    }
    fit_free(&f);
}

static void print_cost(const char *name, double ticks)
{
    printf("    .%s = %u,\n", name, (unsigned)ceil(16 * ticks));
}

static void print_table(const struct table *t, const char *target)
{
    static const char *const shading[RASTER_SHADE_COUNT] = {"HALF_VECTOR",    "SPECULAR_FRAME",     "LAFORTUNE_PHONG",
                                                            "BLINN_PHONG",    "METALLIC_ROUGHNESS", "DIFFUSE_ROW",
                                                            "BLINN_PHONG_ROW"};
    char name[32], upper[32];
    snprintf(name, sizeof name, "%s", target);
    for (char *c = name; *c; c++)
        *c = *c == '-' ? '_' : *c;
    snprintf(upper, sizeof upper, "%s", name);
    for (char *c = upper; *c; c++)
        *c = (char)(*c >= 'a' && *c <= 'z' ? *c - 32 : *c);
    printf("/* What %s takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */\n",
           target);
    printf("#ifndef HAL_COSTS_%s_H\n#define HAL_COSTS_%s_H\n\n#include \"quality.h\"\n\n", upper, upper);
    printf("static const struct raster_costs costs_%s = {\n", name);
    print_cost("tile", t->tile);
    print_cost("clear", t->clear);
    print_cost("meshlet", t->meshlet);
    print_cost("vertex", t->vertex);
    print_cost("triangle", t->triangle);
    print_cost("general", t->general);
    print_cost("facing", t->facing);
    print_cost("row", t->row);
    print_cost("tested", t->tested);
    print_cost("general_facing", t->general_facing);
    print_cost("general_row", t->general_row);
    print_cost("general_tested", t->general_tested);
    print_cost("survey", t->survey);
    print_cost("light", t->light);
    print_cost("region", t->region);
    print_cost("flat", t->flat);
    print_cost("part", t->part);
    print_cost("cell", t->cell);
    print_cost("finished", t->finished);
    print_cost("run", t->run);
    print_cost("plan", PLAN);
    print_cost("broad", t->broad);
    print_cost("bright", t->bright);
    print_cost("slow_point", t->slow_point);
    printf("    .texels = {%.0f, %.0f, %.0f},\n", ceil(16 * t->texels[RASTER_TAPS_8]),
           ceil(16 * t->texels[RASTER_TAPS_4]), ceil(16 * t->texels[RASTER_TAPS_1]));
    printf("    .taps = {0, %.0f, %.0f},\n", floor(16 * t->taps[RASTER_TAPS_4]), floor(16 * t->taps[RASTER_TAPS_1]));
    printf("    .shading =\n        {\n");
    for (int k = 0; k < RASTER_SHADE_COUNT; k++)
        printf("            [RASTER_SHADE_%s] = {%.0f, %.0f, %.0f, %.0f, %.0f, %.0f},\n", shading[k],
               ceil(16 * t->shading[k].planes), ceil(16 * t->shading[k].sample), ceil(16 * t->shading[k].lit),
               ceil(16 * t->shading[k].dark), ceil(16 * t->shading[k].point), ceil(16 * t->shading[k].flat));
    printf("        },\n};\n\n#endif\n");
}

int main(int argc, char **argv)
{
    struct table t = {.light = 200};
    common_set_name("calibrate", NULL);
    if (argc != 3)
        die(EXIT_USAGE, "usage: calibrate TARGET MEASURED.txt");
    const struct lines all = read_lines(argv[2]);
    fit_drawing(&t, &all);
    fit_general(&t, &all);
    fit_flat(&t, &all);
    fit_shading(&t, &all);
    fit_packing(&t, &all);
    fit_rows(&t, &all);
    print_table(&t, argv[1]);
    free(all.line);
    return EXIT_OK;
}
