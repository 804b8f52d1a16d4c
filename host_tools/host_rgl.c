#include "host_rgl.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

static const double pi = 3.14159265358979323846;

/* --- the container --- */

enum { TYPE_U8 = 1, TYPE_F32 = 10, HEADER_BYTES = 18, MAX_DIMENSIONS = 5, MAX_EXTENT = 4096 };
static const char magic[12] = "tensor_file"; /* with its NUL */

/* A rank-n array of doubles; shape is padded with 1 in front to MAX_DIMENSIONS. */
struct tensor {
    size_t shape[MAX_DIMENSIONS], count;
    double *data;
};

struct file {
    const char *path;
    const uint8_t *data;
    size_t bytes;
};

static uint64_t get_uint(const struct file *f, size_t at, int width)
{
    if (at > f->bytes || f->bytes - at < (size_t)width)
        die(EXIT_BAD_INPUT, "%s: field table ends beyond byte %zu; the file is truncated", f->path, f->bytes);
    uint64_t x = 0;
    for (int i = width - 1; i >= 0; i--)
        x = x << 8 | f->data[at + (size_t)i];
    return x;
}

/* Finds a field's record: *at is after its name. */
static bool field_find(size_t *at, const struct file *f, const char *name)
{
    size_t count = get_uint(f, 14, 4), p = HEADER_BYTES;
    for (size_t i = 0; i < count; i++) {
        size_t name_bytes = get_uint(f, p, 2), after = p + 2 + name_bytes;
        size_t dimensions = get_uint(f, after, 2);
        if (name_bytes == strlen(name) && !memcmp(f->data + p + 2, name, name_bytes)) {
            *at = after;
            return true;
        }
        p = after + 11 + 8 * dimensions;
    }
    return false;
}

static struct tensor field_read(const struct file *f, const char *name, unsigned type, size_t dimensions)
{
    size_t at;
    if (!field_find(&at, f, name))
        die(EXIT_BAD_INPUT, "%s: no field '%s'; an RGB material file of the RGL database is wanted (not spectral)",
            f->path, name);
    size_t has = get_uint(f, at, 2);
    unsigned is = (unsigned)get_uint(f, at + 2, 1);
    if (has != dimensions || is != type)
        die(EXIT_BAD_INPUT, "%s: field '%s' has %zu dimensions of type %u, want %zu of type %u", f->path, name, has, is,
            dimensions, type);
    uint64_t offset = get_uint(f, at + 3, 8);
    struct tensor t = {.shape = {1, 1, 1, 1, 1}, .count = 1};
    for (size_t i = 0; i < dimensions; i++) {
        uint64_t extent = get_uint(f, at + 11 + 8 * i, 8);
        if (!extent || extent > MAX_EXTENT)
            die(EXIT_BAD_INPUT, "%s: field '%s' has extent %llu, the limit is 1..%d", f->path, name,
                (unsigned long long)extent, MAX_EXTENT);
        t.shape[MAX_DIMENSIONS - dimensions + i] = extent;
        t.count *= extent; /* <= 2^60 */
    }
    size_t width = type == TYPE_U8 ? 1 : 4;
    if (offset > f->bytes || t.count > (f->bytes - offset) / width)
        die(EXIT_BAD_INPUT,
            "%s: field '%s' of %zu values at byte %llu reaches beyond the file's %zu bytes; it is truncated", f->path,
            name, t.count, (unsigned long long)offset, f->bytes);
    t.data = xmalloc(t.count * sizeof(double));
    for (size_t i = 0; i < t.count; i++) {
        uint32_t u = (uint32_t)get_uint(f, offset + i * width, (int)width);
        float x;
        memcpy(&x, &u, 4);
        t.data[i] = type == TYPE_U8 ? (double)u : (double)x;
        if (!(fabs(t.data[i]) <= (double)FLT_MAX))
            die(EXIT_BAD_INPUT, "%s: field '%s': value %zu is not finite; the file is damaged", f->path, name, i);
    }
    return t;
}

/* --- the material --- */

struct rgl {
    struct tensor theta_i; /* [n], ascending */
    struct tensor ndf;     /* microfacet distribution over (phi, theta) */
    struct tensor sigma;   /* projected area over (phi, theta) */
    struct tensor vndf;    /* [n][y][x], visible normals, scaled to integrate to 1 */
    struct tensor row_cdf; /* [n][y][x]: integral of vndf over x */
    struct tensor cdf;     /* [n][y]: integral of whole rows over y */
    struct tensor rgb;     /* [n][3][y][x], over the warped unit square */
    bool jacobian;         /* rgb is divided by ndf / (4 sigma) */
};

bool rgl_recognise(const uint8_t *data, size_t bytes)
{
    return bytes >= sizeof magic && !memcmp(data, magic, sizeof magic);
}

static void want_shape(const char *path, bool ok, const char *name)
{
    if (!ok)
        die(EXIT_BAD_INPUT,
            "%s: field '%s' has a shape that does not fit the others; the file is damaged or of another kind", path,
            name);
}

static void check_shapes(const char *path, const struct rgl *r)
{
    size_t n = r->theta_i.count;
    for (size_t i = 1; i < n; i++)
        if (!(r->theta_i.data[i] > r->theta_i.data[i - 1]))
            die(EXIT_BAD_INPUT, "%s: theta_i does not ascend at entry %zu; the file is damaged", path, i);
    want_shape(path, r->ndf.shape[3] >= 2 && r->ndf.shape[4] >= 2, "ndf");
    want_shape(path, r->sigma.shape[3] >= 2 && r->sigma.shape[4] >= 2, "sigma");
    want_shape(path, r->vndf.shape[1] == 1 && r->vndf.shape[2] == n && r->vndf.shape[3] >= 2 && r->vndf.shape[4] >= 2,
               "vndf");
    want_shape(path, r->rgb.shape[0] == 1 && r->rgb.shape[1] == n && r->rgb.shape[2] == 3, "rgb");
    want_shape(path, r->rgb.shape[3] >= 2 && r->rgb.shape[4] >= 2, "rgb");
}

/* Running integrals (trapezoids, node spacing 1) of each slice, along rows and then over them; all scaled so that the slice
 * integrates to 1. */
static void make_distributions(const char *path, struct rgl *r)
{
    size_t n = r->vndf.shape[2], height = r->vndf.shape[3], width = r->vndf.shape[4];
    r->row_cdf = r->vndf;
    r->row_cdf.data = xcalloc(r->vndf.count, sizeof(double));
    r->cdf = (struct tensor){{1, 1, 1, n, height}, n * height, xcalloc(n * height, sizeof(double))};
    for (size_t z = 0; z < n; z++) {
        double *density = r->vndf.data + z * height * width, *rows = r->row_cdf.data + z * height * width;
        double *total = r->cdf.data + z * height;
        for (size_t y = 0; y < height; y++) {
            for (size_t x = 1; x < width; x++)
                rows[y * width + x] =
                    rows[y * width + x - 1] + (density[y * width + x - 1] + density[y * width + x]) / 2;
            if (y)
                total[y] = total[y - 1] + (rows[y * width - 1] + rows[(y + 1) * width - 1]) / 2;
        }
        double all = total[height - 1];
        if (!(all > 0))
            die(EXIT_BAD_INPUT, "%s: field 'vndf': slice %zu integrates to %g, not above 0; the file is damaged", path,
                z, all);
        for (size_t i = 0; i < height * width; i++) {
            density[i] /= all;
            rows[i] /= all;
        }
        for (size_t y = 0; y < height; y++)
            total[y] /= all;
    }
}

struct rgl *rgl_open(const char *path, const uint8_t *data, size_t bytes)
{
    struct file f = {path, data, bytes};
    struct rgl *r = xcalloc(1, sizeof *r);
    unsigned major = (unsigned)get_uint(&f, 12, 1);
    if (major != 1)
        die(EXIT_BAD_INPUT, "%s: tensor_file version %u, this program reads 1", path, major);
    struct tensor phi_i = field_read(&f, "phi_i", TYPE_F32, 1);
    if (phi_i.count != 1)
        die(EXIT_BAD_INPUT, "%s: anisotropic, %zu azimuths of incidence; only isotropic materials (1) fit a table",
            path, phi_i.count);
    free(phi_i.data);
    r->theta_i = field_read(&f, "theta_i", TYPE_F32, 1);
    r->ndf = field_read(&f, "ndf", TYPE_F32, 2);
    r->sigma = field_read(&f, "sigma", TYPE_F32, 2);
    r->vndf = field_read(&f, "vndf", TYPE_F32, 4);
    r->rgb = field_read(&f, "rgb", TYPE_F32, 5);
    struct tensor jacobian = field_read(&f, "jacobian", TYPE_U8, 1);
    r->jacobian = jacobian.data[0] != 0;
    free(jacobian.data);
    check_shapes(path, r);
    make_distributions(path, r);
    return r;
}

void rgl_close(struct rgl *r)
{
    struct tensor *all[] = {&r->theta_i, &r->ndf, &r->sigma, &r->vndf, &r->row_cdf, &r->cdf, &r->rgb};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        free(all[i]->data);
    free(r);
}

/* --- evaluation --- */

/* A cell of a grid over the unit square and the position in it. */
struct cell {
    size_t x, y;
    double u, v;
};

static struct cell cell_at(double x, double y, size_t width, size_t height)
{
    double fx = fmin(fmax(x, 0), 1) * (double)(width - 1), fy = fmin(fmax(y, 0), 1) * (double)(height - 1);
    struct cell c = {(size_t)fmin(floor(fx), (double)(width - 2)), (size_t)fmin(floor(fy), (double)(height - 2)), 0, 0};
    c.u = fx - (double)c.x;
    c.v = fy - (double)c.y;
    return c;
}

static double lerp(double a, double b, double t)
{
    return (1 - t) * a + t * b;
}

static double bilinear(const double *data, size_t width, struct cell c)
{
    const double *p = data + c.y * width + c.x;
    return lerp(lerp(p[0], p[1], c.u), lerp(p[width], p[width + 1], c.u), c.v);
}

/* Incidence: between slices i and i+1. */
struct slices {
    size_t i;
    double t;
};

static struct slices slices_at(const struct tensor *theta_i, double theta)
{
    const double *a = theta_i->data;
    size_t n = theta_i->count;
    if (n == 1 || theta <= a[0])
        return (struct slices){0, 0};
    if (theta >= a[n - 1])
        return (struct slices){n - 2, 1};
    size_t i = 0;
    while (theta >= a[i + 1])
        i++;
    return (struct slices){i, (theta - a[i]) / (a[i + 1] - a[i])};
}

/* Node value interpolated between the two slices, `stride` apart. */
static double node(const double *data, size_t stride, struct slices s, size_t index)
{
    const double *p = data + s.i * stride + index;
    return s.t > 0 ? lerp(p[0], p[stride], s.t) : p[0];
}

/* The inverse of sampling visible normals: (x, y) in the square of microfacet directions to its position in the square where
 * the reflectance is stored, by the cumulative distribution of y and then of x within that row (Dupuy and Jakob 2018, section
 * 4.2). The density is bilinear, so each integral is a quadratic within the cell. */
static void warp(double sample[2], const struct rgl *r, struct slices s, double x, double y)
{
    size_t height = r->vndf.shape[3], width = r->vndf.shape[4], stride = width * height;
    struct cell c = cell_at(x, y, width, height);
    size_t low = c.y * width, high = low + width;
    const double *density = r->vndf.data, *rows = r->row_cdf.data;

    double left = lerp(node(density, stride, s, low + c.x), node(density, stride, s, high + c.x), c.v);
    double right = lerp(node(density, stride, s, low + c.x + 1), node(density, stride, s, high + c.x + 1), c.v);
    double before = lerp(node(rows, stride, s, low + c.x), node(rows, stride, s, high + c.x), c.v);
    double row_low = node(rows, stride, s, low + width - 1), row_high = node(rows, stride, s, high + width - 1);
    double row = lerp(row_low, row_high, c.v);
    sample[0] = row > 0 ? (before + c.u * left + c.u * c.u / 2 * (right - left)) / row : 0;
    sample[1] = node(r->cdf.data, height, s, c.y) + c.v * row_low + c.v * c.v / 2 * (row_high - row_low);
}

/* Elevation to the unit interval: denser towards the pole. */
static double theta_unit(double theta)
{
    return sqrt(2 / pi * theta);
}

void rgl_value(double rgb[3], const struct rgl *r, double theta_in, double theta_out, double phi_out)
{
    double h[3] = {sin(theta_in) + sin(theta_out) * cos(phi_out), sin(theta_out) * sin(phi_out),
                   cos(theta_in) + cos(theta_out)};
    double theta_m = atan2(hypot(h[0], h[1]), h[2]);
    double turn = (atan2(h[1], h[0]) + pi) / (2 * pi), x = theta_unit(theta_m), y = turn - floor(turn);
    struct slices s = slices_at(&r->theta_i, theta_in);
    double sample[2];
    warp(sample, r, s, x, y);

    double scale = 1 / cos(theta_out);
    if (r->jacobian) {
        struct cell m = cell_at(x, y, r->ndf.shape[4], r->ndf.shape[3]);
        struct cell i = cell_at(theta_unit(theta_in), 0.5, r->sigma.shape[4], r->sigma.shape[3]);
        scale *= bilinear(r->ndf.data, r->ndf.shape[4], m) / (4 * bilinear(r->sigma.data, r->sigma.shape[4], i));
    }
    size_t width = r->rgb.shape[4], height = r->rgb.shape[3], plane = width * height;
    struct cell c = cell_at(sample[0], sample[1], width, height);
    for (int channel = 0; channel < 3; channel++) {
        const double *p = r->rgb.data + ((size_t)channel + 3 * s.i) * plane;
        double value = bilinear(p, width, c);
        if (s.t > 0)
            value = lerp(value, bilinear(p + 3 * plane, width, c), s.t);
        rgb[channel] = fmax(value * scale, 0);
    }
}

double rgl_theta_in(const struct rgl *r)
{
    return r->theta_i.data[r->theta_i.count - 1] * 180 / pi;
}

static enum measurement_mark sample(double rgb[3], const void *r, double theta_in, double theta_out, double phi_out)
{
    rgl_value(rgb, r, theta_in, theta_out, phi_out);
    return MEASURED;
}

void rgl_sample(struct measurement *out, const struct rgl *r, const char *source, const struct measurement_geometry *g)
{
    measurement_init(out, source);
    measurement_sample(out, g, sample, r, rgl_theta_in(r));
}
