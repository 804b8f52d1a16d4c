/* The reflection lobe as a surface (host_preview.h). */
#include "host_preview_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

enum { WIDTH = 900, HEIGHT = 560, HEAD = 60, RADIUS = 400, SAMPLES = 2 };
static const double elevation = 22, azimuth = 68; /* of the viewer; the light's azimuth is 0 */

/* Screen: right, up, towards the viewer. */
struct screen {
    double axis[3][3];
};

static void screen_make(struct screen *s)
{
    preview_direction(s->axis[2], 90 - elevation, azimuth);
    preview_direction(s->axis[0], 90, azimuth + 90);
    preview_direction(s->axis[1], elevation, azimuth + 180);
}

/* In pixels from the lower left corner. */
static void screen_point(double out[3], const struct screen *s, const double d[3], double radius)
{
    for (int k = 0; k < 3; k++)
        out[k] = radius * (s->axis[k][0] * d[0] + s->axis[k][1] * d[1] + s->axis[k][2] * d[2]);
    out[0] += WIDTH / 2.0;
    out[1] += 145;
}

/* Angles that cover first..last in even steps, and finely what is near `peak`. Ascending. */
static int angles(double *out, double first, double last, double step, double peak, double near, double fine)
{
    int count = 0;
    for (double a = first; a < last - 1e-9;) {
        out[count++] = a;
        double next = a + (fabs(a - peak) < near ? fine : step);
        if (a < peak - near && next > peak - near)
            next = peak - near + 1e-6;
        a = next;
    }
    out[count++] = last;
    return count;
}

enum { MAX_ROWS = 256, MAX_COLUMNS = 512 };

struct lobe {
    int rows, columns;
    double theta[MAX_ROWS], phi[MAX_COLUMNS];
    double (*rgb)[3], (*direction)[3]; /* [rows][columns] */
    double most;                       /* luminance */
};

static void lobe_sample(struct lobe *o, const struct preview *p, double theta_in)
{
    double l[3];
    o->rows = angles(o->theta, 0.01, 89.5, 1.5, theta_in, 6, 0.15);
    o->columns = angles(o->phi, 0, 360, 2, 180, 10, 0.4);
    size_t count = (size_t)o->rows * (size_t)o->columns;
    o->rgb = xmalloc(count * sizeof *o->rgb);
    o->direction = xmalloc(count * sizeof *o->direction);
    o->most = 0;
    preview_direction(l, theta_in, 0);
    for (size_t i = 0; i < count; i++) {
        preview_direction(o->direction[i], o->theta[i / (size_t)o->columns], o->phi[i % (size_t)o->columns]);
        p->source.value(o->rgb[i], p->source.ctx, l, o->direction[i]);
        o->most = fmax(o->most, preview_luminance(o->rgb[i]));
    }
}

static unsigned *lobe_triangles(size_t *count, const struct lobe *o)
{
    unsigned *out = xmalloc(6 * sizeof *out * (size_t)(o->rows - 1) * (size_t)(o->columns - 1)), *p = out;
    for (int i = 0; i + 1 < o->rows; i++)
        for (int j = 0; j + 1 < o->columns; j++) {
            unsigned a = (unsigned)(i * o->columns + j), b = a + (unsigned)o->columns;
            const unsigned quad[6] = {a, b, a + 1, a + 1, b, b + 1};
            memcpy(p, quad, sizeof quad);
            p += 6;
        }
    *count = (size_t)(p - out);
    return out;
}

/* Where a sample hits: the direction on the lobe, and the reflected colour there, its largest channel 1. */
static void hit_read(double direction[3], double colour[3], const struct lobe *o, const unsigned *corner,
                     const double share[3])
{
    double length = 0, most = 1e-30;
    for (int c = 0; c < 3; c++) {
        direction[c] = colour[c] = 0;
        for (int k = 0; k < 3; k++) {
            direction[c] += share[k] * o->direction[corner[k]][c];
            colour[c] += share[k] * o->rgb[corner[k]][c];
        }
        length += direction[c] * direction[c];
        most = fmax(most, colour[c]);
    }
    for (int c = 0; c < 3; c++) {
        direction[c] /= sqrt(length);
        colour[c] /= most;
    }
}

/* Normals at the points: sums over the triangles around them; malloc'd. */
static double (*point_normals(const double (*points)[3], size_t count, const unsigned *indices, size_t index_count))[3]
{
    double(*out)[3] = xcalloc(count, sizeof *out);
    for (size_t i = 0; i < index_count; i += 3) {
        const double *p[3] = {points[indices[i]], points[indices[i + 1]], points[indices[i + 2]]};
        double a[3], b[3];
        for (int c = 0; c < 3; c++) {
            a[c] = p[1][c] - p[0][c];
            b[c] = p[2][c] - p[0][c];
        }
        for (int k = 0; k < 3; k++)
            for (int c = 0; c < 3; c++)
                out[indices[i + (size_t)k]][c] += a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
    }
    return out;
}

/* Diffuse light from beside the viewer. */
static double brightness(const double (*normals)[3], const unsigned *corner, const double share[3])
{
    static const double light[3] = {-0.48, 0.62, 0.62};
    double n[3] = {0}, length = 1e-30, facing = 0;
    for (int c = 0; c < 3; c++) {
        for (int k = 0; k < 3; k++)
            n[c] += share[k] * normals[corner[k]][c];
        length += n[c] * n[c];
        facing += n[c] * light[c];
    }
    return 0.3 + 0.65 * fmax(copysign(1, n[2]) * facing / sqrt(length), 0); /* what is seen faces the viewer */
}

/* RGBA, top row first; returns the marks shown. */
static unsigned lobe_shade(uint8_t *pixels, const struct preview *p, const struct lobe *o, double theta_in,
                           const struct screen *screen)
{
    size_t count = (size_t)o->rows * (size_t)o->columns, index_count;
    double(*points)[3] = xmalloc(count * sizeof *points), l[3];
    for (size_t i = 0; i < count; i++) {
        screen_point(points[i], screen, o->direction[i],
                     o->most > 0 ? RADIUS * cbrt(preview_luminance(o->rgb[i]) / o->most) : 0);
        for (int c = 0; c < 3; c++)
            points[i][c] *= SAMPLES;
    }
    unsigned *indices = lobe_triangles(&index_count, o), marks = 0;
    double(*normals)[3] = point_normals((const double(*)[3])points, count, indices, index_count);
    struct preview_hit *hits =
        preview_rasterize(SAMPLES * WIDTH, SAMPLES * HEIGHT, (const double(*)[3])points, indices, index_count);
    preview_direction(l, theta_in, 0);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            uint8_t *pixel = pixels + 4 * (y * WIDTH + x);
            double sum[3] = {0}, direction[3], colour[3];
            int covered = 0;
            enum measurement_mark mark = MEASURED;
            for (int s = 0; s < SAMPLES * SAMPLES; s++) {
                const struct preview_hit *hit =
                    &hits[(SAMPLES * y + s / SAMPLES) * SAMPLES * WIDTH + SAMPLES * x + s % SAMPLES];
                if (!hit->triangle)
                    continue;
                const unsigned *corner = indices + hit->triangle - 1;
                const double share[3] = {1.0 - hit->share[0] - hit->share[1], hit->share[0], hit->share[1]};
                double light = brightness((const double(*)[3])normals, corner, share);
                hit_read(direction, colour, o, corner, share);
                for (int c = 0; c < 3; c++)
                    sum[c] += light * colour[c];
                if (!covered++)
                    mark = preview_mark(p, l, direction);
            }
            for (int c = 0; c < 3; c++)
                pixel[c] = covered ? preview_srgb(sum[c] / covered) : 255;
            pixel[3] = (uint8_t)(255 * covered / (SAMPLES * SAMPLES));
            preview_hatch(pixel, mark, x, y);
            marks |= 1u << mark;
        }
    free(points);
    free(normals);
    free(indices);
    free(hits);
    return marks;
}

/* --- what surrounds it --- */

static void put_arrow(struct gnuplot *g, const struct screen *s, const double d[3], double from, double to,
                      const char *style, const char *text)
{
    double a[3], b[3];
    screen_point(a, s, d, from);
    screen_point(b, s, d, to);
    fprintf(g->to, "set arrow from %.1f,%.1f to %.1f,%.1f %s\n", a[0], a[1], b[0], b[1], style);
    screen_point(a, s, d, fmax(from, to) + 18);
    fprintf(g->to, "set label '%s' at %.1f,%.1f center front\n", text, a[0], a[1]);
}

/* Circles in the surface at powers of ten. */
static void put_floor(struct gnuplot *g, const struct screen *s, double most)
{
    int circles = 0;
    for (double f = pow(10, floor(log10(most))); cbrt(f / most) > 0.12; f /= 10, circles++) {
        double radius = RADIUS * cbrt(f / most), d[3], at[3];
        fprintf(g->to, "$circle%d << E\n", circles);
        for (int phi = 0; phi <= 360; phi += 4) {
            preview_direction(d, 90, phi);
            screen_point(at, s, d, radius);
            fprintf(g->to, "%.1f %.1f\n", at[0], at[1]);
        }
        fputs("E\n", g->to);
        preview_direction(d, 90, azimuth - 25);
        screen_point(at, s, d, radius);
        fprintf(g->to, "set label '%g' at %.1f,%.1f center font small tc rgb '#555555' front\n", f, at[0], at[1] - 7);
    }
    fputs("plot ", g->to);
    for (int i = 0; i < circles; i++)
        fprintf(g->to, "$circle%d with lines lc rgb '#b0b0b0' notitle, ", i);
}

void preview_lobe(const struct preview *p, double theta_in, const char *path)
{
    struct lobe *o = xmalloc(sizeof *o);
    struct screen screen;
    struct gnuplot g;
    double d[3];
    uint8_t *pixels = xmalloc(4 * WIDTH * HEIGHT);
    screen_make(&screen);
    lobe_sample(o, p, theta_in);
    unsigned marks = lobe_shade(pixels, p, o, theta_in, &screen);
    double most = o->most > 0 ? o->most : 1;
    gnuplot_begin(&g, path, WIDTH, HEIGHT + HEAD);
    fprintf(g.to,
            "set lmargin at screen 0\nset rmargin at screen 1\nset bmargin at screen 0\nset tmargin at screen %g\n"
            "unset border\nunset tics\nunset key\nset xrange [0:%d]\nset yrange [0:%d]\nset label ",
            (double)HEIGHT / (HEIGHT + HEAD), WIDTH, HEIGHT);
    gnuplot_text(&g, p->title);
    fprintf(g.to,
            " at screen 0.5,0.965 center noenhanced font big front\nset label 'Light from θ_{in} = %g°. Distance: cube "
            "root of the BRDF’s "
            "luminance (circles: 1/sr; largest value %.3g). Colour: that of the reflected light.' at "
            "screen 0.5,0.92 center front\n",
            theta_in, o->most);
    preview_legend(&g, marks);
    preview_direction(d, 0, 0);
    put_arrow(&g, &screen, d, 0, 1.02 * RADIUS, "lw 1.2 lc rgb '#333333' front", "n");
    preview_direction(d, theta_in, 180);
    put_arrow(&g, &screen, d, 0, 1.02 * RADIUS, "nohead dt (6,4) lc rgb '#333333' back", "mirror");
    preview_direction(d, theta_in, 0);
    put_arrow(&g, &screen, d, 1.02 * RADIUS, 0, "lw 2 lc rgb '#e0a000' front", "light");
    put_floor(&g, &screen, most);
    gnuplot_picture(&g, WIDTH, HEIGHT, 4, 0, WIDTH, 0, HEIGHT);
    fputc('\n', g.to);
    gnuplot_pixels(&g, WIDTH, HEIGHT, 4, pixels);
    gnuplot_end(&g);
    free(pixels);
    free(o->rgb);
    free(o->direction);
    free(o);
}
