/* Disney's image slices, side by side (host_preview.h). */
#include "host_preview_internal.h"

#include <math.h>
#include <stdlib.h>

#include "common.h"

enum { SIDE = 180, PANEL = 2 * SIDE, GAP = 30 };

/* Of one BRDF: rows of theta_d from 90 degrees down, columns of theta_h. */
struct slice {
    double rgb[SIDE][SIDE][3];
    uint8_t mark[SIDE][SIDE];
};

/* phi_d = 90 degrees: both directions as far from the normal. */
static void directions(double l[3], double v[3], int row, int column)
{
    double half = 90 * (column + 0.5) / SIDE, difference = 90 * (SIDE - row - 0.5) / SIDE, h[3], d[3];
    preview_direction(h, half, 0);
    preview_direction(d, difference, 90);
    for (int c = 0; c < 3; c++) {
        double across = c == 1 ? d[1] : 0;
        l[c] = d[2] * h[c] + across;
        v[c] = d[2] * h[c] - across;
    }
}

static void slice_sample(struct slice *out, const struct preview *p, const struct preview *marks)
{
    double l[3], v[3];
    for (int row = 0; row < SIDE; row++)
        for (int column = 0; column < SIDE; column++) {
            directions(l, v, row, column);
            p->source.value(out->rgb[row][column], p->source.ctx, l, v);
            out->mark[row][column] = (uint8_t)preview_mark(marks, l, v);
        }
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Shows the median as a middle grey. */
static double exposure_of(const struct slice *s)
{
    double *all = xmalloc(SIDE * SIDE * sizeof *all);
    for (int i = 0; i < SIDE * SIDE; i++)
        all[i] = preview_luminance(s->rgb[i / SIDE][i % SIDE]);
    qsort(all, SIDE * SIDE, sizeof *all, compare);
    double median = all[SIDE * SIDE / 2];
    free(all);
    return median > 0 ? 0.25 / median : 1;
}

static void panel(struct gnuplot *g, int number, int panels, const char *title, const struct slice *s,
                  const struct slice *minus, double exposure, unsigned *marks)
{
    static uint8_t pixels[SIDE][SIDE][3];
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            for (int c = 0; c < 3; c++)
                pixels[y][x][c] =
                    preview_srgb(exposure * (minus ? fabs(s->rgb[y][x][c] - minus->rgb[y][x][c]) : s->rgb[y][x][c]));
            preview_hatch(pixels[y][x], s->mark[y][x], x, y);
            *marks |= 1u << s->mark[y][x];
        }
    double width = panels * (PANEL + (double)GAP) + 70, left = 70 + number * (PANEL + (double)GAP);
    fprintf(g->to, "set lmargin at screen %g\nset rmargin at screen %g\nset title ", left / width,
            (left + PANEL) / width);
    gnuplot_text(g, title);
    fprintf(g->to, " noenhanced\nset ylabel '%s'\nset format y '%s'\nplot ",
            number ? "" : "difference angle θ_d, degrees", number ? "" : "%g");
    gnuplot_picture(g, SIDE, SIDE, 3, 0, 90, 0, 90);
    fputc('\n', g->to);
    gnuplot_pixels(g, SIDE, SIDE, 3, pixels[0][0]);
    fputc('\n', g->to);
}

/* Where measured; both weighted with n.v, or the horizon, where a BRDF may be anything, would be all. */
static double relative_error(const struct slice *a, const struct slice *b)
{
    double difference = 0, whole = 0, l[3], v[3];
    for (int i = 0; i < SIDE * SIDE; i++) {
        directions(l, v, i / SIDE, i % SIDE);
        for (int c = 0; c < 3 && a->mark[i / SIDE][i % SIDE] != MEASUREMENT_EXTRAPOLATED; c++) {
            double x = v[2] * a->rgb[i / SIDE][i % SIDE][c], y = v[2] * b->rgb[i / SIDE][i % SIDE][c];
            difference += (x - y) * (x - y);
            whole += y * y;
        }
    }
    return whole > 0 ? sqrt(difference / whole) : 0;
}

void preview_image_slices(const struct preview *p, const struct preview *against, const char *path)
{
    struct slice *own = xmalloc(sizeof *own), *other = xmalloc(sizeof *other);
    struct gnuplot g;
    int panels = against ? 3 : 1;
    unsigned marks = 0;
    slice_sample(own, p, against ? against : p);
    if (against)
        slice_sample(other, against, against);
    double exposure = exposure_of(against ? other : own);
    gnuplot_begin(&g, path, panels * (PANEL + GAP) + 70, PANEL + 160);
    fprintf(
        g.to,
        "set multiplot title 'Image slices at φ_d = 90°: sRGB of %.3g · BRDF in 1/sr'\nunset key\nset tmargin at "
        "screen "
        "%g\nset bmargin at screen %g\nset xrange [0:90]\nset yrange [0:90]\nset xtics 30\nset ytics 30\nset tics out "
        "nomirror\nset xlabel 'half angle θ_h, degrees'\n",
        exposure, 1 - 70.0 / (PANEL + 160), 90.0 / (PANEL + 160));
    panel(&g, 0, panels, p->title, own, NULL, exposure, &marks);
    if (against) {
        char title[96];
        panel(&g, 1, panels, against->title, other, NULL, exposure, &marks);
        snprintf(title, sizeof title, "10 × difference; n·v-weighted RMS %.3g %%", 100 * relative_error(own, other));
        panel(&g, 2, panels, title, own, other, 10 * exposure, &marks);
    }
    preview_legend(&g, marks);
    fputs("set lmargin at screen 0\nset rmargin at screen 1\nunset title\nunset xlabel\nunset ylabel\nunset "
          "border\nunset "
          "tics\nplot NaN notitle\nunset multiplot\n",
          g.to);
    gnuplot_end(&g);
    free(own);
    free(other);
}
