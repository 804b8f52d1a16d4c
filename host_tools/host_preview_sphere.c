/* A sphere or a mesh under an environment (host_preview.h). */
#include "host_preview_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_image.h"
#include "host_parallel.h"

static const double viewer[3] = {0, 0, 1};

/* --- light --- */

static double smooth(double edge, double width, double x)
{
    double t = fmin(fmax((x - edge) / width, 0), 1);
    return t * t * (3 - 2 * t);
}

void preview_studio(struct environment *out)
{
    enum { WIDTH = 128, HEIGHT = 64 };
    static const double key[3] = {-0.55, 0.6, 0.58}, rim[3] = {0.85, 0.35, -0.4};
    static float rgb[HEIGHT][WIDTH][3];
    struct environment shape = {.width = WIDTH, .height = HEIGHT};
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            double d[3], sky, lamps;
            environment_direction(d, &shape, x + 0.5, y + 0.5);
            sky = smooth(-0.06, 0.12, d[1]);
            lamps = 14 * smooth(0.955, 0.02, d[0] * key[0] + d[1] * key[1] + d[2] * key[2]) +
                    7 * smooth(0.94, 0.03, d[0] * rim[0] + d[1] * rim[1] + d[2] * rim[2]);
            const double ground[3] = {0.13, 0.12, 0.11}, high[3] = {0.36, 0.42, 0.52}, low[3] = {0.75, 0.76, 0.78};
            for (int c = 0; c < 3; c++)
                rgb[y][x][c] =
                    (float)(ground[c] + sky * (low[c] + (high[c] - low[c]) * fmax(d[1], 0) - ground[c]) + lamps);
        }
    environment_make(out, WIDTH, HEIGHT, rgb[0][0]);
}

/* --- normals --- */

static void normalize(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int c = 0; c < 3; c++)
        v[c] /= length > 0 ? length : 1;
}

static void sphere_normals(struct preview_image *out, double (*normals)[3], int size)
{
    double radius = size / 2.0 - 0.5;
    for (int i = 0; i < size * size; i++) {
        double x = (i % size + 0.5 - size / 2.0) / radius, y = (size / 2.0 - i / size - 0.5) / radius;
        double r = hypot(x, y), inside = fmin(r, 0.995) / fmax(r, 1e-9);
        out->coverage[i] = (float)fmin(fmax((1 - r) * radius + 0.5, 0), 1);
        normals[i][0] = x * inside;
        normals[i][1] = y * inside;
        normals[i][2] = sqrt(fmax(1 - inside * inside * r * r, 0));
    }
}

enum { SAMPLES = 3 }; /* along each side of a pixel */

static void turn(double out[3], const float in[3], double degrees)
{
    const double degree = 0.017453292519943295, pitch = 12 * degree;
    double yaw = degrees * degree, x = cos(yaw) * in[0] + sin(yaw) * in[2], z = cos(yaw) * in[2] - sin(yaw) * in[0];
    out[0] = x;
    out[1] = cos(pitch) * in[1] - sin(pitch) * z;
    out[2] = cos(pitch) * z + sin(pitch) * in[1];
}

/* Points in samples from the lower left corner; sets the image's size. */
static double (*mesh_place(struct preview_image *out, const struct preview_view *view))[3]
{
    const struct mesh *m = view->mesh;
    double(*points)[3] = xmalloc((m->vertex_count + 1) * sizeof *points);
    double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < m->vertex_count; i++) {
        turn(points[i], m->vertices[i].position, view->turn);
        for (int c = 0; c < 3; c++) {
            lo[c] = fmin(lo[c], points[i][c]);
            hi[c] = fmax(hi[c], points[i][c]);
        }
    }
    double scale = (view->size - 4) / fmax(fmax(hi[0] - lo[0], hi[1] - lo[1]), 1e-30);
    out->width = (int)ceil(scale * (hi[0] - lo[0])) + 4;
    out->height = (int)ceil(scale * (hi[1] - lo[1])) + 4;
    for (size_t i = 0; i < m->vertex_count; i++)
        for (int c = 0; c < 3; c++)
            points[i][c] = SAMPLES * (scale * (points[i][c] - lo[c]) + 2);
    return points;
}

/* The mean of the normals that a pixel's samples see. */
static double (*mesh_normals(struct preview_image *out, const struct preview_view *view))[3]
{
    const struct mesh *m = view->mesh;
    double(*points)[3] = mesh_place(out, view);
    int width = SAMPLES * out->width, height = SAMPLES * out->height;
    struct preview_hit *hits = preview_rasterize(width, height, (const double(*)[3])points, m->indices, m->index_count);
    size_t pixels = (size_t)out->width * (size_t)out->height;
    double(*normals)[3] = xcalloc(pixels, sizeof *normals);
    out->coverage = xcalloc(pixels, sizeof *out->coverage);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const struct preview_hit *hit = &hits[(size_t)y * (size_t)width + (size_t)x];
            size_t pixel = (size_t)(y / SAMPLES * out->width + x / SAMPLES);
            if (!hit->triangle)
                continue;
            const double share[3] = {1.0 - hit->share[0] - hit->share[1], hit->share[0], hit->share[1]};
            double normal[3] = {0};
            for (int k = 0; k < 3; k++) {
                double one[3];
                turn(one, m->vertices[m->indices[hit->triangle - 1 + (unsigned)k]].normal, view->turn);
                for (int c = 0; c < 3; c++)
                    normal[c] += share[k] * one[c];
            }
            normal[2] = fmax(normal[2], 0.02); /* an interpolated normal may point away where the surface does not */
            normalize(normal);
            for (int c = 0; c < 3; c++)
                normals[pixel][c] += normal[c];
            out->coverage[pixel] += 1.0f / (SAMPLES * SAMPLES);
        }
    for (size_t i = 0; i < pixels; i++)
        normalize(normals[i]);
    free(hits);
    free(points);
    return normals;
}

/* --- radiance --- */

struct work {
    struct preview_image *image;
    const struct preview_view *view;
    const double (*normals)[3];
    const struct brdf_source *source, *extrapolated; /* the latter NULL when nothing is */
};

static void render_row(void *ctx, int y)
{
    const struct work *w = ctx;
    const struct preview_view *view = w->view;
    for (int x = 0; x < w->image->width; x++) {
        size_t i = (size_t)y * (size_t)w->image->width + (size_t)x;
        double *radiance = w->image->radiance[i], part[3];
        if (!(w->image->coverage[i] > 0))
            continue;
        environment_reflect(radiance, view->environment, w->source, w->normals[i], viewer, view->coarseness);
        if (!w->extrapolated)
            continue;
        environment_reflect(part, view->environment, w->extrapolated, w->normals[i], viewer, 3 * view->coarseness);
        w->image->extrapolated[i] = preview_luminance(part) > 0.5 * preview_luminance(radiance);
    }
}

static bool may_be_extrapolated(const struct preview *p)
{
    return p->samples.count || p->source.theta_in < 90 || p->source.theta_out < 90;
}

static void render_pixels(struct work *work, const struct preview *p, bool exact)
{
    int threads = work->view->threads;
    if (exact) {
        work->source = &p->source;
        parallel_for(threads, work->image->height, render_row, work);
        return;
    }
    struct preview_fast *fast = preview_fast_make(p, work->view->size > 128 ? 2 : 1, threads);
    struct brdf_source all, extrapolated;
    preview_fast_source(&all, fast);
    preview_fast_extrapolated(&extrapolated, fast);
    work->source = &all;
    work->extrapolated = may_be_extrapolated(p) ? &extrapolated : NULL;
    parallel_for(threads, work->image->height, render_row, work);
    preview_fast_free(fast);
}

void preview_render(struct preview_image *out, const struct preview *p, const struct preview_view *view, bool exact)
{
    double(*normals)[3];
    *out = (struct preview_image){.width = view->size, .height = view->size};
    if (view->mesh) {
        normals = mesh_normals(out, view);
    } else {
        size_t pixels = (size_t)view->size * (size_t)view->size;
        normals = xmalloc(pixels * sizeof *normals);
        out->coverage = xmalloc(pixels * sizeof *out->coverage);
        sphere_normals(out, normals, view->size);
    }
    size_t pixels = (size_t)out->width * (size_t)out->height;
    out->radiance = xcalloc(pixels, sizeof *out->radiance);
    out->extrapolated = xcalloc(pixels, 1);
    struct work work = {.image = out, .view = view, .normals = (const double(*)[3])normals};
    render_pixels(&work, p, exact);
    free(normals);
}

void preview_image_free(struct preview_image *i)
{
    free(i->radiance);
    free(i->coverage);
    free(i->extrapolated);
    *i = (struct preview_image){0};
}

/* --- picture --- */

/* Narkowicz 2016's fit to the ACES tone curve. */
static double aces(double x)
{
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

unsigned preview_place(uint8_t *rgb, int stride, int left, int top, const struct preview_image *image,
                       const struct preview_view *view)
{
    double exposure = view->environment->mean > 0 ? 0.6 * view->exposure / view->environment->mean : 1;
    unsigned marks = 0;
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            size_t i = (size_t)y * (size_t)image->width + (size_t)x;
            uint8_t *out = rgb + 3 * ((size_t)(top + y) * (size_t)stride + (size_t)(left + x)), shown[3];
            if (!(image->coverage[i] > 0))
                continue;
            for (int c = 0; c < 3; c++)
                shown[c] = preview_srgb(aces(exposure * image->radiance[i][c]));
            enum measurement_mark mark = image->extrapolated[i] ? MEASUREMENT_EXTRAPOLATED : MEASURED;
            preview_hatch(shown, mark, x, y);
            marks |= 1u << mark;
            for (int c = 0; c < 3; c++)
                out[c] = (uint8_t)lround(out[c] + image->coverage[i] * ((double)shown[c] - out[c]));
        }
    return marks;
}

static void write_radiance(const struct preview_image *image, const char *path)
{
    size_t pixels = (size_t)image->width * (size_t)image->height;
    float *rgb = xmalloc(3 * pixels * sizeof *rgb);
    for (size_t i = 0; i < pixels; i++)
        for (size_t c = 0; c < 3; c++)
            rgb[3 * i + c] = (float)image->radiance[i][c];
    image_write_float(path, image->width, image->height, 3, rgb);
    free(rgb);
}

static void draw_page(const struct preview *p, const struct preview_image *image, const struct preview_view *view,
                      const char *path)
{
    enum { MARGIN = 20, HEAD = 50, FOOT = 40 };
    int width = (int)fmax(image->width + 2 * MARGIN, 340), height = image->height + HEAD + FOOT;
    uint8_t *rgb = xmalloc(3 * (size_t)image->width * (size_t)image->height);
    struct gnuplot g;
    memset(rgb, 255, 3 * (size_t)image->width * (size_t)image->height);
    unsigned marks = preview_place(rgb, image->width, 0, 0, image, view);
    gnuplot_begin(&g, path, width, height);
    fprintf(g.to,
            "set lmargin at screen %.9g\nset rmargin at screen %.9g\nset bmargin at screen %.9g\nset tmargin at screen "
            "%.9g\nunset border\nunset tics\nunset key\nset xrange [0:1]\nset yrange [0:1]\nset title ",
            0.5 - 0.5 * image->width / width, 0.5 + 0.5 * image->width / width, (double)FOOT / height,
            1 - (double)HEAD / height);
    gnuplot_text(&g, p->title);
    fputs(" noenhanced font big\n", g.to);
    preview_legend(&g, marks);
    fputs("plot ", g.to);
    gnuplot_picture(&g, image->width, image->height, 3, 0, 1, 0, 1);
    fputc('\n', g.to);
    gnuplot_pixels(&g, image->width, image->height, 3, rgb);
    gnuplot_end(&g);
    free(rgb);
}

void preview_sphere(const struct preview *p, const struct preview_view *view, const char *path)
{
    struct preview_image image;
    preview_render(&image, p, view, !gnuplot_draws(path));
    if (gnuplot_draws(path))
        draw_page(p, &image, view, path);
    else
        write_radiance(&image, path);
    preview_image_free(&image);
}
