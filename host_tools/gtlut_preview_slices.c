/* Slices of a table or measurement as pictures (gtlut_preview.h). */
#include "gtlut_preview.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_preview_internal.h"

/* What is the same in all slices but for the values. */
struct montage {
    int columns, width, height; /* of the arrangement; of one picture on the page */
    const char *across, *down;  /* axes */
    double first[2], last[2];   /* at their ends */
    double exposure;
};

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* One over twice the median of the luminances. Sorts them. */
static double exposure_of(double *luminances, size_t count)
{
    qsort(luminances, count, sizeof *luminances, compare);
    double median = count ? luminances[count / 2] : 0;
    return median > 0 ? 0.5 / median : 1;
}

static uint8_t tone(double exposure, double value)
{
    double x = exposure * value;
    return preview_srgb(x / (1 + x));
}

enum { GAP = 34, LEFT = 76, HEAD = 70, FOOT = 90, TITLE = 24 };

static void montage_begin(struct gnuplot *g, const struct montage *m, int count, const struct preview *p,
                          const char *quantity, const char *path)
{
    int rows = (count + m->columns - 1) / m->columns;
    gnuplot_begin(g, path, LEFT + m->columns * (m->width + GAP), HEAD + FOOT + rows * (m->height + GAP + TITLE));
    fputs("set multiplot title ", g->to);
    char *title = xasprintf("%s: sRGB of x/(1+x), x = %.4g · %s", p->title, m->exposure, quantity);
    gnuplot_text(g, title);
    free(title);
    fprintf(g->to, " noenhanced font big\nunset key\nset tics out nomirror\nset xrange [%g:%g]\nset yrange [%g:%g]\n",
            m->first[0], m->last[0], m->last[1], m->first[1]);
}

static void montage_picture(struct gnuplot *g, const struct montage *m, int number, int count, const char *title,
                            int width, int height, const uint8_t *rgb)
{
    int rows = (count + m->columns - 1) / m->columns, row = number / m->columns, column = number % m->columns;
    double wide = LEFT + m->columns * (m->width + GAP), tall = HEAD + FOOT + rows * (m->height + GAP + TITLE);
    double left = LEFT + column * (m->width + GAP), top = HEAD + TITLE + row * (m->height + GAP + TITLE);
    bool lowest = number + m->columns >= count;
    fprintf(g->to,
            "set lmargin at screen %.9g\nset rmargin at screen %.9g\nset tmargin at screen %.9g\nset bmargin at screen "
            "%.9g\nset title '%s'\nset xlabel '%s'\nset ylabel '%s'\nset format x '%s'\nset format y '%s'\nplot ",
            left / wide, (left + m->width) / wide, 1 - top / tall, 1 - (top + m->height) / tall, title,
            lowest ? m->across : "", column ? "" : m->down, lowest ? "%g" : "", column ? "" : "%g");
    gnuplot_picture(g, width, height, 3, m->first[0], m->last[0], m->last[1], m->first[1]);
    fputc('\n', g->to);
    gnuplot_pixels(g, width, height, 3, rgb);
    fputc('\n', g->to);
}

static void montage_end(struct gnuplot *g, unsigned marks)
{
    preview_legend(g, marks);
    fputs("set lmargin at screen 0\nset rmargin at screen 1\nunset title\nunset xlabel\nunset ylabel\nunset "
          "border\nunset "
          "tics\nplot NaN notitle\nunset multiplot\n",
          g->to);
    gnuplot_end(g);
}

/* --- table --- */

static void texel(double rgb[3], const struct table_file *t, size_t i)
{
    struct lut_rgb c = lut_rgb9e5_decode(t->table.texels[i]);
    int scale = t->table.kind == LUT_HALF_VECTOR ? t->table.scale : 0;
    for (int k = 0; k < 3; k++)
        rgb[k] = ldexp(c.c[k], c.e + scale);
}

static void slice_title(char *out, size_t bytes, const struct table_file *t, uint32_t z)
{
    if (t->table.kind == LUT_HALF_VECTOR)
        snprintf(out, bytes, "θ_d = %.3g°", table_theta_d(&t->half_vector, z));
    else
        snprintf(out, bytes, "θ_{in} = %.3g°", table_theta_in(&t->specular_frame, z));
}

static void table_slices(const struct preview *p, const struct table_file *t, const char *path)
{
    size_t w = t->table.width, h = t->table.height, count = w * h * t->table.depth;
    bool half = t->table.kind == LUT_HALF_VECTOR;
    struct montage m = {.columns = half ? 16 : 2, .width = half ? 60 : 480, .height = half ? 190 : 240};
    double *luminances = xmalloc(count * sizeof *luminances), rgb[3];
    uint8_t *pixels = xmalloc(3 * w * h);
    int slices = (int)t->table.depth;
    struct gnuplot g;
    for (size_t i = 0; i < count; i++) {
        texel(rgb, t, i);
        luminances[i] = preview_luminance(rgb);
    }
    m.exposure = exposure_of(luminances, count);
    m.columns = slices < m.columns ? slices : m.columns;
    m.across = half ? "φ_d, node" : "φ_d, degrees";
    m.down = half ? "θ_h, node" : "θ_d, degrees";
    for (int k = 0; k < 2; k++) { /* nodes are at the middle of pixels */
        double nodes = (double)(k ? h : w), last = half ? nodes - 1 : k ? 180 : 360;
        m.first[k] = -last / (nodes - 1) / 2;
        m.last[k] = last - m.first[k];
    }
    montage_begin(&g, &m, slices, p, half ? "BRDF · (n·l + n·v) in 1/sr" : "BRDF in 1/sr", path);
    fprintf(g.to, half ? "set xtics %zu\nset ytics 8\n" : "set xtics 90\nset ytics 45\n", w - 1);
    for (int z = 0; z < slices; z++) {
        char title[64];
        for (size_t i = 0; i < w * h; i++) {
            texel(rgb, t, (size_t)z * w * h + i);
            for (int c = 0; c < 3; c++)
                pixels[3 * i + (size_t)c] = tone(m.exposure, rgb[c]);
        }
        slice_title(title, sizeof title, t, (uint32_t)z);
        montage_picture(&g, &m, z, slices, title, (int)w, (int)h, pixels);
    }
    montage_end(&g, 0);
    free(luminances);
    free(pixels);
}

/* --- measurement --- */

static double samples_exposure(const struct measurement_grid *g)
{
    size_t count = 0, used = 0;
    for (size_t k = 0; k < g->count; k++)
        count += g->slices[k].theta_count * g->slices[k].phi_count;
    double *luminances = xmalloc(count * sizeof *luminances);
    for (size_t k = 0; k < g->count; k++)
        for (size_t i = 0; i < g->slices[k].theta_count * g->slices[k].phi_count; i++)
            luminances[used++] = preview_luminance(g->slices[k].rgb + 3 * i);
    double exposure = exposure_of(luminances, count);
    free(luminances);
    return exposure;
}

/* theta_out may be unevenly spaced: the picture has a row per step of the axis, each from the nearest sample. */
static void slice_pixels(uint8_t *rgb, int rows, int columns, const struct measurement_slice *s,
                         const struct montage *m, unsigned *marks)
{
    for (int y = 0; y < rows; y++) {
        double theta = m->first[1] + (y + 0.5) * (m->last[1] - m->first[1]) / rows;
        size_t row = 0;
        while (row + 1 < s->theta_count && s->theta_out[row + 1] - theta < theta - s->theta_out[row])
            row++;
        for (int x = 0; x < columns; x++) {
            size_t i = row * s->phi_count + (size_t)x % s->phi_count;
            uint8_t *out = rgb + 3 * (y * columns + x);
            for (int c = 0; c < 3; c++)
                out[c] = tone(m->exposure, s->rgb[3 * i + (size_t)c]);
            preview_hatch(out, s->mark[i], x, y);
            *marks |= 1u << s->mark[i];
        }
    }
}

static void sample_slices(const struct preview *p, const char *path)
{
    const struct measurement_grid *grid = &p->samples;
    const struct measurement_slice *s = grid->slices;
    int count = (int)grid->count;
    double last = s->theta_out[s->theta_count - 1], step = s->theta_count > 1 ? last / (double)(s->theta_count - 1) : 1;
    struct montage m = {.columns = count > 6   ? 3
                                   : count > 1 ? 2
                                               : 1,
                        .width = count > 6 ? 320 : 480,
                        .height = count > 6 ? 160 : 240,
                        .across = "φ_{out}, degrees (180: the mirror side)",
                        .down = "θ_{out}, degrees",
                        .exposure = samples_exposure(grid)};
    struct gnuplot g;
    unsigned marks = 0;
    m.first[0] = s->phi_first - 180.0 / (double)s->phi_count;
    m.last[0] = m.first[0] + 360;
    m.first[1] = -step / 2;
    m.last[1] = last + step / 2;
    montage_begin(&g, &m, count, p, "BRDF in 1/sr", path);
    fputs("set xtics 90\nset ytics 30\n", g.to);
    for (int k = 0; k < count; k++, s++) {
        char title[64];
        /* gnuplot draws no picture of fewer than 2 x 2 */
        int rows = (int)lround(fmax((m.last[1] - m.first[1]) / step, 2));
        int columns = s->phi_count > 1 ? (int)s->phi_count : 2;
        uint8_t *rgb = xmalloc(3 * (size_t)rows * (size_t)columns);
        slice_pixels(rgb, rows, columns, s, &m, &marks);
        snprintf(title, sizeof title, "θ_{in} = %.3g°", s->theta_in);
        montage_picture(&g, &m, k, count, title, columns, rows, rgb);
        free(rgb);
    }
    montage_end(&g, marks);
}

void preview_slices(const struct preview_input *in, const char *path)
{
    if (in->is_table)
        table_slices(&in->preview, &in->table, path);
    else if (in->preview.samples.count)
        sample_slices(&in->preview, path);
    else
        die(EXIT_USAGE, "slices: %s is a function, neither table nor samples; gtlut build or import it first",
            in->preview.title);
}
