/*
 * Built-in shapes: a superellipsoid on a cube's grid (sphere, rounded cube) and surfaces on a grid of rows and columns
 * (knot, vase, gear, spring). Normals come from the surface's formula, not from its triangles.
 */
#include "gtscene_mesh.h"

#include "common.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

struct point {
    double p[3], n[3]; /* n of any positive length */
};

typedef void surface(struct point *out, const double *parameters, unsigned row, unsigned column);

static void mesh_alloc(struct mesh *m, size_t vertices, size_t indices)
{
    m->vertices = xmalloc(vertices * sizeof *m->vertices);
    m->indices = xmalloc(indices * sizeof *m->indices);
    m->vertex_count = m->index_count = 0;
}

static void add_vertex(struct mesh *m, const struct point *s)
{
    struct mesh_vertex *v = &m->vertices[m->vertex_count++];
    double length = sqrt(s->n[0] * s->n[0] + s->n[1] * s->n[1] + s->n[2] * s->n[2]);
    for (int k = 0; k < 3; k++) {
        v->position[k] = (float)s->p[k];
        v->normal[k] = (float)(s->n[k] / length);
    }
}

/* Two triangles with corners a, b (one row) and c, d (the next row). */
static void add_quad(struct mesh *m, size_t a, size_t b, size_t c, size_t d)
{
    const size_t q[6] = {a, b, c, c, b, d};
    for (int k = 0; k < 6; k++)
        m->indices[m->index_count++] = (unsigned)q[k];
}

/* Turns all triangles if their geometric normals are, by area, against the vertices' normals. */
static void orient(struct mesh *m)
{
    double sum = 0;
    for (size_t i = 0; i < m->index_count; i += 3) {
        const struct mesh_vertex *v[3];
        double e[2][3];
        for (int k = 0; k < 3; k++)
            v[k] = &m->vertices[m->indices[i + k]];
        for (int k = 0; k < 3; k++) {
            e[0][k] = v[1]->position[k] - v[0]->position[k];
            e[1][k] = v[2]->position[k] - v[0]->position[k];
        }
        for (int k = 0; k < 3; k++)
            sum += v[0]->normal[k] * (e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3]);
    }
    for (size_t i = 0; sum < 0 && i < m->index_count; i += 3) {
        unsigned t = m->indices[i];
        m->indices[i] = m->indices[i + 1];
        m->indices[i + 1] = t;
    }
}

/* Columns wrap; rows wrap too, or the first and the last row are one point each (its triangles without area and its
 * equal vertices are removed with those of every mesh). */
static void build_grid(struct mesh *m, surface *s, const double *parameters, unsigned rows, unsigned columns, bool wrap)
{
    mesh_alloc(m, (size_t)rows * columns, 6 * (size_t)rows * columns);
    for (unsigned i = 0; i < rows; i++)
        for (unsigned j = 0; j < columns; j++) {
            struct point point;
            s(&point, parameters, i, j);
            add_vertex(m, &point);
        }
    for (unsigned i = 0; i < (wrap ? rows : rows - 1); i++)
        for (unsigned j = 0; j < columns; j++) {
            size_t a = (size_t)i * columns, c = (size_t)((i + 1) % rows) * columns, next = (j + 1) % columns;
            add_quad(m, a + j, a + next, c + j, c + next);
        }
    orient(m);
}

/* |x|^e + |y|^e + |z|^e = 1 on the six faces of a cube, each a grid of equal angles. */
static void build_superellipsoid(struct mesh *m, unsigned segments, double e)
{
    size_t side = segments + 1;
    mesh_alloc(m, 6 * side * side, 36 * (size_t)segments * segments);
    for (int face = 0; face < 6; face++) {
        size_t first = m->vertex_count;
        for (unsigned i = 0; i <= segments; i++)
            for (unsigned j = 0; j <= segments; j++) {
                const double c[2] = {2.0 * i / segments - 1, 2.0 * j / segments - 1};
                struct point s;
                double d[3], sum = 0;
                d[face % 3] = face < 3 ? 1 : -1;
                for (int k = 0; k < 2; k++) /* exactly 1 at the edges: neighbouring faces share their points */
                    d[(face + 1 + k) % 3] = fabs(c[k]) == 1 ? c[k] : tan(c[k] * pi / 4);
                for (int k = 0; k < 3; k++)
                    sum += pow(fabs(d[k]), e);
                for (int k = 0; k < 3; k++) {
                    s.p[k] = d[k] * pow(sum, -1 / e);
                    s.n[k] = copysign(pow(fabs(s.p[k]), e - 1), s.p[k]);
                }
                add_vertex(m, &s);
            }
        for (unsigned i = 0; i < segments; i++)
            for (unsigned j = 0; j < segments; j++) {
                size_t a = first + i * side + j, t[4] = {a, a + 1, a + side, a + side + 1};
                if (face < 3)
                    add_quad(m, t[0], t[2], t[1], t[3]);
                else
                    add_quad(m, t[0], t[1], t[2], t[3]);
            }
    }
    orient(m);
}

static void build_sphere(struct mesh *m, const double *parameters)
{
    build_superellipsoid(m, (unsigned)parameters[0], 2);
}

static void build_rounded_cube(struct mesh *m, const double *parameters)
{
    build_superellipsoid(m, (unsigned)parameters[0], parameters[1]);
}

/* A point of a round tube: centre c, unit tangent t, unit vector n across it, at azimuth a; `along` is the sine of the
 * normal's angle to the cross-section, 0 but in end caps. */
static void tube_point(struct point *out, const double c[3], const double t[3], const double n[3], double radius,
                       double azimuth, double along)
{
    double across = fabs(along) == 1 ? 0 : sqrt(1 - along * along);
    for (int k = 0; k < 3; k++) {
        int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
        double b = t[k1] * n[k2] - t[k2] * n[k1];
        out->n[k] = along * t[k] + across * (cos(azimuth) * n[k] + sin(azimuth) * b);
        out->p[k] = c[k] + radius * out->n[k];
    }
}

/* The torus knot (2,3) on a torus of elliptical section around z; the torus' normal is perpendicular to any curve on it.
 * Parameters: rings, sides, tube, major, minor, depth. */
static void knot_point(struct point *out, const double *parameters, unsigned row, unsigned column)
{
    const double major = parameters[3], minor = parameters[4], depth = parameters[5], t = 2 * pi * row / parameters[0];
    double r = major + minor * cos(3 * t), dr = -3 * minor * sin(3 * t), flat = minor / depth;
    double c[3] = {r * cos(2 * t), r * sin(2 * t), depth * sin(3 * t)};
    double n[3] = {cos(3 * t) * cos(2 * t), cos(3 * t) * sin(2 * t), flat * sin(3 * t)};
    double tangent[3] = {dr * cos(2 * t) - 2 * c[1], dr * sin(2 * t) + 2 * c[0], 3 * depth * cos(3 * t)};
    double length = sqrt(tangent[0] * tangent[0] + tangent[1] * tangent[1] + tangent[2] * tangent[2]);
    double steep = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3; k++) {
        tangent[k] /= length;
        n[k] /= steep;
    }
    tube_point(out, c, tangent, n, parameters[2], 2 * pi * column / parameters[1], 0);
}

static void build_knot(struct mesh *m, const double *parameters)
{
    build_grid(m, knot_point, parameters, (unsigned)parameters[0], (unsigned)parameters[1], true);
}

#define CAP_ROWS 5

/* A helix around y with hemispherical ends. Parameters: turns, rings, sides, tube. */
static void spring_point(struct point *out, const double *parameters, unsigned row, unsigned column)
{
    const double radius = 0.72, height = 1.7;
    unsigned rings = (unsigned)parameters[1], last = rings + 2 * CAP_ROWS - 1,
             along_cap = row < last - row ? row : last - row;
    double along = along_cap < CAP_ROWS ? cos(pi / 2 * along_cap / CAP_ROWS) : 0;
    double s = row < CAP_ROWS ? 0 : row > last - CAP_ROWS ? 1 : (double)(row - CAP_ROWS) / (rings - 1);
    double angle = 2 * pi * parameters[0], a = angle * s,
           speed = sqrt(radius * radius * angle * angle + height * height);
    double c[3] = {radius * cos(a), height * (s - 0.5), radius * sin(a)}, n[3] = {cos(a), 0, sin(a)};
    double t[3] = {-radius * angle * sin(a) / speed, height / speed, radius * angle * cos(a) / speed};
    tube_point(out, c, t, n, parameters[3], 2 * pi * column / parameters[2], row < CAP_ROWS ? -along : along);
}

static void build_spring(struct mesh *m, const double *parameters)
{
    build_grid(m, spring_point, parameters, (unsigned)parameters[1] + 2 * CAP_ROWS, (unsigned)parameters[2], false);
}

/* A surface of revolution with an inside: radius and height along a uniform cubic B-spline that starts and ends on the
 * axis, where mirrored control points make it level. Parameters: rings, sides. */
static void vase_point(struct point *out, const double *parameters, unsigned row, unsigned column)
{
    static const double control[][2] = {
        {-0.42, -1.00}, {0, -1.00},   {0.42, -1.00}, {0.52, -0.98}, {0.50, -0.88},  {0.72, -0.55}, {0.84, -0.10},
        {0.66, 0.30},   {0.30, 0.52}, {0.29, 0.78},  {0.50, 0.98},  {0.54, 1.04},   {0.46, 1.04},  {0.22, 0.80},
        {0.22, 0.50},   {0.45, 0.20}, {0.30, -0.10}, {0, -0.10},    {-0.30, -0.10},
    };
    const unsigned segments = sizeof control / sizeof *control - 3, last = (unsigned)parameters[0] - 1;
    double t = (double)segments * row / last, r = 0, y = 0, dr = 0, dy = 0;
    unsigned i = t >= segments ? segments - 1 : (unsigned)t;
    t -= i;
    const double u = 1 - t;
    const double w[4] = {u * u * u / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * u * u * u - 6 * u * u + 4) / 6,
                         t * t * t / 6};
    const double d[4] = {-u * u / 2, (3 * t * t - 4 * t) / 2, (4 * u - 3 * u * u) / 2, t * t / 2};
    for (unsigned k = 0; k < 4; k++) {
        r += w[k] * control[i + k][0];
        y += w[k] * control[i + k][1];
        dr += d[k] * control[i + k][0];
        dy += d[k] * control[i + k][1];
    }
    if (row == 0 || row == last)
        r = dy = 0; /* exactly */
    double a = 2 * pi * column / parameters[1];
    const double p[3] = {r * cos(a), y, r * sin(a)}, n[3] = {dy * cos(a), -dr, dy * sin(a)};
    memcpy(out->p, p, sizeof p);
    memcpy(out->n, n, sizeof n);
}

static void build_vase(struct mesh *m, const double *parameters)
{
    build_grid(m, vase_point, parameters, (unsigned)parameters[0], (unsigned)parameters[1], false);
}

static double signed_power(double x, double e)
{
    return copysign(pow(fabs(x), e), x);
}

/* A gear wheel around z with a bore: over azimuth a, a superellipse |x|^5 + |z/h|^5 = 1 across from the bore to the
 * toothed outline, x = (rho - middle) / half. Normal: the gradient. Parameters: teeth, samples per tooth, sides. */
static void gear_point(struct point *out, const double *parameters, unsigned row, unsigned column)
{
    const double bore = 0.36, outer = 0.86, tooth = 0.14, steep = 2.5, height = 0.3, e = 5;
    double teeth = parameters[0], a = 2 * pi * column / (teeth * parameters[1]), s = 2 * pi * row / parameters[2];
    double th = tanh(steep * sin(teeth * a)), rim = outer + tooth * th / tanh(steep);
    double drim = tooth / tanh(steep) * (1 - th * th) * steep * teeth * cos(teeth * a);
    double middle = (rim + bore) / 2, half = (rim - bore) / 2;
    double x = signed_power(cos(s), 2 / e), z = signed_power(sin(s), 2 / e), rho = middle + half * x;
    double by_x = signed_power(x, e - 1), by_rho = by_x / half, by_a = -by_x * drim / 2 * (1 + x) / half / rho;
    const double p[3] = {rho * cos(a), rho * sin(a), height * z};
    const double n[3] = {by_rho * cos(a) - by_a * sin(a), by_rho * sin(a) + by_a * cos(a),
                         signed_power(z, e - 1) / height};
    memcpy(out->p, p, sizeof p);
    memcpy(out->n, n, sizeof n);
}

static void build_gear(struct mesh *m, const double *parameters)
{
    build_grid(m, gear_point, parameters, (unsigned)parameters[2], (unsigned)(parameters[0] * parameters[1]), true);
}

const struct shape shapes[] = {
    {"sphere", "sphere of radius 1", {{"segments", 20, 2, 400, true}}, build_sphere},
    {"rounded_cube",
     "superellipsoid with half side 1",
     {{"segments", 20, 2, 400, true}, {"exponent", 5, 2, 12, false}},
     build_rounded_cube},
    {"knot",
     "torus knot (2,3) around z; major and minor radius and depth of the torus",
     {{"rings", 107, 24, 2000, true},
      {"sides", 24, 3, 400, true},
      {"tube", 0.19, 0.02, 0.24, false},
      {"major", 0.6, 0.5, 0.7, false},
      {"minor", 0.26, 0.2, 0.4, false},
      {"depth", 0.26, 0.2, 0.5, false}},
     build_knot},
    {"vase", "vase around y, hollow", {{"rings", 53, 17, 1000, true}, {"sides", 48, 3, 1000, true}}, build_vase},
    {"gear",
     "gear wheel around z with a bore",
     {{"teeth", 9, 3, 60, true}, {"samples", 13, 4, 100, true}, {"sides", 22, 8, 200, true}},
     build_gear},
    {"spring",
     "helical spring around y",
     {{"turns", 3.5, 0.5, 8, false},
      {"rings", 94, 8, 5000, true},
      {"sides", 24, 3, 400, true},
      {"tube", 0.17, 0.01, 0.3, false}},
     build_spring},
    {NULL, NULL, {{0}}, NULL},
};

const struct shape *shape_find(const char *name)
{
    for (const struct shape *s = shapes; s->name; s++)
        if (!strcmp(s->name, name))
            return s;
    return NULL;
}
