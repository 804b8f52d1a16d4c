#include "host_environment.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_image.h"

static const double pi = 3.14159265358979323846;

/* How far apart (radians) directions may be that count as one: `nearest` plus this share of the half vector's angle to the normal,
 * twice as much between outgoing directions as between half vectors. All but `nearest` times the coarseness: narrow lobes need it. */
static const double share = 0.1, nearest = 0.001, farthest = 0.07, at_horizon = 0.02;
enum { SPLIT = 16 }; /* parts along each side that a pixel is cut into at most */

/* A rectangle of pixels. The first half's node is the next one, the second half's is `second`; 0 in a single pixel. */
struct environment_node {
    double power[3];  /* integral of radiance over its solid angle */
    double moment[3]; /* mean of the directions, weighted by luminance: up to 1 long */
    double direction[3];
    double radius;   /* radians from direction to the farthest point */
    double fineness; /* factor on it: light from bright nodes is split further */
    uint32_t second;
    uint16_t x, y; /* first pixel */
};

void environment_direction(double d[3], const struct environment *e, double x, double y)
{
    double latitude = pi * (0.5 - y / e->height), longitude = pi * (1 - 2 * x / e->width);
    d[0] = cos(latitude) * sin(longitude);
    d[1] = sin(latitude);
    d[2] = cos(latitude) * cos(longitude);
}

/* Of the part of a column between two heights. */
static double band(const struct environment *e, double y0, double y1)
{
    return 2 * pi / e->width * (cos(pi * y0 / e->height) - cos(pi * y1 / e->height));
}

double environment_solid_angle(const struct environment *e, int row)
{
    return band(e, row, row + 1);
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* --- hierarchy --- */

static double luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

static void pixel_make(struct environment_node *n, const struct environment *e, int x, int y)
{
    const float *rgb = e->rgb + 3 * ((size_t)y * (size_t)e->width + (size_t)x);
    double solid = environment_solid_angle(e, y);
    for (int c = 0; c < 3; c++)
        n->power[c] = rgb[c] * solid;
    /* The exact mean over the pixel: of cos^2, sin cos over the latitude, times sin(w)/w over the longitude. */
    double t0 = pi * y / e->height, t1 = pi * (y + 1) / e->height, w = pi / e->width;
    double flat = (t1 - t0 - sin(t1) * cos(t1) + sin(t0) * cos(t0)) / 2 / (cos(t0) - cos(t1)) * sin(w) / w;
    double longitude = pi * (1 - 2 * (x + 0.5) / e->width);
    n->moment[0] = flat * sin(longitude);
    n->moment[1] = (cos(t0) + cos(t1)) / 2;
    n->moment[2] = flat * cos(longitude);
}

/* Direction, radius and fineness, from the sums. */
static void node_measure(struct environment_node *n, const struct environment *e, int x, int y, int w, int h)
{
    /* Errors grow as radiance times radius^2, evaluations as 1/radius^2: least together when radius^4 goes with 1/radiance. */
    double brightness = luminance(n->power) / (w * band(e, y, y + h)) / e->mean;
    n->fineness = e->mean > 0 ? fmin(fmax(sqrt(sqrt(brightness)), 0.5), 4) : 1;
    double length = sqrt(dot(n->moment, n->moment));
    if (length < 1e-3) { /* light from opposite sides */
        environment_direction(n->direction, e, x + w / 2.0, y + h / 2.0);
        n->radius = pi;
        return;
    }
    for (int c = 0; c < 3; c++)
        n->direction[c] = n->moment[c] / length;
    n->radius = w > e->width / 4 ? pi : 0;
    for (int i = 0; i < 9; i++) {
        double corner[3];
        environment_direction(corner, e, x + i % 3 * w / 2.0, y + i / 3 * h / 2.0);
        n->radius = fmax(n->radius, acos(fmin(dot(corner, n->direction), 1)));
    }
}

/* Fills nodes from *used on for the rectangle. */
static void node_build(struct environment *e, uint32_t *used, int x, int y, int w, int h)
{
    struct environment_node *n = &e->nodes[(*used)++];
    *n = (struct environment_node){.x = (uint16_t)x, .y = (uint16_t)y};
    if (w == 1 && h == 1) {
        pixel_make(n, e, x, y);
    } else {
        const struct environment_node *half[2] = {n + 1};
        double wide = 2.0 * w / e->width * sin(pi * (y + h / 2.0) / e->height), high = (double)h / e->height;
        bool across = h == 1 || (w > 1 && wide >= high);
        node_build(e, used, x, y, across ? w / 2 : w, across ? h : h / 2);
        n->second = *used;
        half[1] = &e->nodes[*used];
        if (across)
            node_build(e, used, x + w / 2, y, w - w / 2, h);
        else
            node_build(e, used, x, y + h / 2, w, h - h / 2);
        double weight[2] = {luminance(half[0]->power), luminance(half[1]->power)}, sum = weight[0] + weight[1];
        for (int c = 0; c < 3; c++) {
            n->power[c] = half[0]->power[c] + half[1]->power[c];
            n->moment[c] = sum > 0 ? (weight[0] * half[0]->moment[c] + weight[1] * half[1]->moment[c]) / sum : 0;
        }
    }
    node_measure(n, e, x, y, w, h);
}

void environment_make(struct environment *out, int width, int height, const float *rgb)
{
    size_t pixels = (size_t)width * (size_t)height;
    *out = (struct environment){.width = width,
                                .height = height,
                                .rgb = xmalloc(3 * pixels * sizeof *rgb),
                                .nodes = xmalloc(2 * pixels * sizeof(struct environment_node))};
    memcpy(out->rgb, rgb, 3 * pixels * sizeof *rgb);
    for (size_t i = 0; i < pixels; i++) {
        double pixel[3] = {rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]};
        out->mean += luminance(pixel) * environment_solid_angle(out, (int)(i / (size_t)width)) / (4 * pi);
    }
    uint32_t used = 0;
    node_build(out, &used, 0, 0, width, height);
}

void environment_free(struct environment *e)
{
    free(e->rgb);
    free(e->nodes);
    *e = (struct environment){0};
}

/* --- file --- */

/* Means of factor x factor pixels; what does not fill a block at the right and lower edge goes into the last one. */
static float *average_down(int *width, int *height, const float *rgb, int factor)
{
    int w = *width / factor, h = *height / factor;
    float *out = xmalloc(3 * (size_t)w * (size_t)h * sizeof *out);
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++) {
            double sum[3] = {0};
            int right = x + 1 < w ? (x + 1) * factor : *width, low = y + 1 < h ? (y + 1) * factor : *height, count = 0;
            for (int j = y * factor; j < low; j++)
                for (int i = x * factor; i < right; i++, count++)
                    for (int c = 0; c < 3; c++)
                        sum[c] += rgb[3 * ((size_t)j * (size_t)*width + (size_t)i) + (size_t)c];
            for (int c = 0; c < 3; c++)
                out[3 * ((size_t)y * (size_t)w + (size_t)x) + (size_t)c] = (float)(sum[c] / count);
        }
    *width = w;
    *height = h;
    return out;
}

void environment_read(struct environment *out, const char *path)
{
    int width, height;
    float *rgb = image_read_rgb(&width, &height, path, true);
    if (width < 4 || height < 2 || height > width)
        die(EXIT_BAD_INPUT, "%s: %d x %d pixels; give an equirectangular map, twice as wide as high", path, width,
            height);
    for (size_t i = 0; i < 3 * (size_t)width * (size_t)height; i++) {
        if (!isfinite(rgb[i]))
            die(EXIT_BAD_INPUT, "%s: the value at %zu, %zu is not finite; repair the map", path, i / 3 % (size_t)width,
                i / 3 / (size_t)width);
        rgb[i] = fmaxf(rgb[i], 0);
    }
    if (width > ENVIRONMENT_MAX_WIDTH) {
        float *small = average_down(&width, &height, rgb, (width + ENVIRONMENT_MAX_WIDTH - 1) / ENVIRONMENT_MAX_WIDTH);
        free(rgb);
        rgb = small;
    }
    environment_make(out, width, height, rgb);
    free(rgb);
}

/* --- integration --- */

/* A point of the surface: its frame (x towards the viewer) and the viewer in it. */
struct point {
    const struct environment *e;
    const struct brdf_source *f;
    double coarseness, frame[3][3], v[3], sum[3];
};

static void to_local(double out[3], const struct point *p, const double d[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = dot(p->frame[i], d);
}

/* Light of `power` from l; `cosine` is that of its mean angle. */
static void add_light(struct point *p, const double l[3], double cosine, const double power[3], double part)
{
    double f[3];
    if (l[2] <= 1e-9 || cosine <= 0)
        return;
    p->f->value(f, p->f->ctx, l, p->v);
    for (int c = 0; c < 3; c++)
        p->sum[c] += f[c] * power[c] * cosine * part;
}

/* The radius within which f can hardly differ around l. */
static double tolerance(const struct point *p, const double l[3])
{
    double h[3] = {l[0] + p->v[0], l[1] + p->v[1], l[2] + p->v[2]}, length = sqrt(dot(h, h));
    if (length < 1e-6)
        return p->coarseness * farthest;
    double off = sqrt(h[0] * h[0] + h[1] * h[1]) / length,
           difference = fmax(length / 2, 0.1); /* cosine of the difference angle */
    return fmin(2 * difference * (p->coarseness * share * off + nearest), p->coarseness * farthest);
}

static void add_pixel(struct point *p, const struct environment_node *n, int parts)
{
    double all = environment_solid_angle(p->e, n->y), across[SPLIT][2];
    for (int i = 0; i < parts; i++) {
        double longitude = pi * (1 - 2 * (n->x + (i + 0.5) / parts) / p->e->width);
        across[i][0] = sin(longitude);
        across[i][1] = cos(longitude);
    }
    for (int j = 0; j < parts; j++) {
        double y0 = n->y + (double)j / parts, y1 = n->y + (j + 1.0) / parts, part = band(p->e, y0, y1) / all / parts;
        double latitude = pi * (0.5 - (y0 + y1) / 2 / p->e->height), high = sin(latitude), flat = cos(latitude);
        for (int i = 0; i < parts; i++) {
            const double d[3] = {flat * across[i][0], high, flat * across[i][1]};
            double l[3];
            to_local(l, p, d);
            add_light(p, l, l[2], n->power, part);
        }
    }
}

static void add_node(struct point *p, uint32_t index)
{
    const struct environment_node *n = &p->e->nodes[index];
    double l[3], mean[3];
    to_local(l, p, n->direction);
    if (n->radius < pi / 2 && l[2] < -sin(n->radius))
        return;
    double radius = n->radius * n->fineness, allowed = tolerance(p, l);
    if (fabs(l[2]) < sin(fmin(n->radius, pi / 2)))
        allowed = fmin(allowed, p->coarseness * at_horizon);
    if (radius <= allowed) {
        to_local(mean, p, n->moment);
        add_light(p, l, mean[2], n->power, 1);
    } else if (n->second) {
        add_node(p, index + 1);
        add_node(p, n->second);
    } else {
        add_pixel(p, n, (int)fmin(ceil(radius / allowed), SPLIT));
    }
}

void environment_reflect(double rgb[3], const struct environment *e, const struct brdf_source *f, const double n[3],
                         const double v[3], double coarseness)
{
    struct point p = {.e = e, .f = f, .coarseness = coarseness};
    double nv = dot(n, v), t[3], length;
    memset(rgb, 0, 3 * sizeof *rgb);
    if (nv <= 1e-9)
        return;
    for (int c = 0; c < 3; c++)
        t[c] = v[c] - nv * n[c];
    length = sqrt(dot(t, t));
    if (length < 1e-9) { /* seen along the normal: any tangent will do */
        int least = fabs(n[0]) < 0.6 ? 0 : fabs(n[1]) < 0.6 ? 1 : 2;
        for (int c = 0; c < 3; c++)
            t[c] = (c == least) - n[least] * n[c];
        length = sqrt(dot(t, t));
        p.v[2] = 1;
    } else {
        p.v[0] = length;
        p.v[2] = nv;
    }
    for (int c = 0; c < 3; c++) {
        p.frame[0][c] = t[c] / length;
        p.frame[2][c] = n[c];
    }
    for (int c = 0; c < 3; c++) { /* y = z x x */
        int a = (c + 1) % 3, b = (c + 2) % 3;
        p.frame[1][c] = p.frame[2][a] * p.frame[0][b] - p.frame[2][b] * p.frame[0][a];
    }
    add_node(&p, 0);
    memcpy(rgb, p.sum, 3 * sizeof *rgb);
}
