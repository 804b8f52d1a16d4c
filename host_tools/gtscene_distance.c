#include "gtscene_distance.h"

#include "common.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_CELLS 128 /* per axis */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Squared distance of p from the segment a + t d, 0 <= t <= 1. */
static double segment_distance2(const double p[3], const double a[3], const double d[3])
{
    double ap[3] = {p[0] - a[0], p[1] - a[1], p[2] - a[2]}, length2 = dot(d, d);
    double t = length2 > 0 ? fmin(1, fmax(0, dot(ap, d) / length2)) : 0;
    for (int k = 0; k < 3; k++)
        ap[k] -= t * d[k];
    return dot(ap, ap);
}

/* Above the triangle's inside it is the distance from its plane, elsewhere from its nearest edge. */
static double triangle_distance2(const struct distance_grid *g, unsigned triangle, const double p[3])
{
    double corner[3][3], edge[3][3], normal[3], best = INFINITY;
    bool inside = true;
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++)
            corner[c][k] = g->vertices[g->indices[3 * triangle + c]].position[k];
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++)
            edge[c][k] = corner[(c + 1) % 3][k] - corner[c][k];
    for (int k = 0; k < 3; k++)
        normal[k] = edge[0][(k + 1) % 3] * edge[1][(k + 2) % 3] - edge[0][(k + 2) % 3] * edge[1][(k + 1) % 3];
    for (int c = 0; c < 3; c++) {
        double to[3], side = 0; /* (edge x to) . normal */
        for (int k = 0; k < 3; k++)
            to[k] = p[k] - corner[c][k];
        for (int k = 0; k < 3; k++)
            side += normal[k] * (edge[c][(k + 1) % 3] * to[(k + 2) % 3] - edge[c][(k + 2) % 3] * to[(k + 1) % 3]);
        inside = inside && side >= 0;
        best = fmin(best, segment_distance2(p, corner[c], edge[c]));
    }
    double area2 = dot(normal, normal);
    if (!inside || !(area2 > 0))
        return best;
    double to[3] = {p[0] - corner[0][0], p[1] - corner[0][1], p[2] - corner[0][2]}, height = dot(to, normal);
    return height * height / area2;
}

static void make_sphere(struct distance_sphere *s, const struct mesh_vertex *vertices, const unsigned *t)
{
    double radius2 = 0;
    for (int k = 0; k < 3; k++)
        s->center[k] =
            ((double)vertices[t[0]].position[k] + vertices[t[1]].position[k] + vertices[t[2]].position[k]) / 3;
    for (int c = 0; c < 3; c++) {
        double d[3];
        for (int k = 0; k < 3; k++)
            d[k] = vertices[t[c]].position[k] - s->center[k];
        radius2 = fmax(radius2, dot(d, d));
    }
    s->radius = sqrt(radius2) * (1 + 1e-9);
}

static int cell_of(const struct distance_grid *g, int axis, double x)
{
    double c = floor((x - g->lo[axis]) / g->cell);
    return (int)fmin(g->size[axis] - 1, fmax(0, c));
}

/* Counts a triangle into every cell that its box touches, or stores it there. */
static void enter(struct distance_grid *g, unsigned triangle, size_t *at, bool store)
{
    int lo[3], hi[3];
    for (int k = 0; k < 3; k++) {
        double least = INFINITY, most = -INFINITY;
        for (int c = 0; c < 3; c++) {
            double x = g->vertices[g->indices[3 * triangle + c]].position[k];
            least = fmin(least, x);
            most = fmax(most, x);
        }
        lo[k] = cell_of(g, k, least);
        hi[k] = cell_of(g, k, most);
    }
    for (int z = lo[2]; z <= hi[2]; z++)
        for (int y = lo[1]; y <= hi[1]; y++)
            for (int x = lo[0]; x <= hi[0]; x++) {
                size_t cell = ((size_t)z * g->size[1] + y) * g->size[0] + x;
                if (store)
                    g->triangles[at[cell]] = triangle;
                at[cell]++;
            }
}

void distance_grid_build(struct distance_grid *out, const struct mesh_vertex *vertices, const unsigned *indices,
                         size_t index_count)
{
    *out = (struct distance_grid){.vertices = vertices, .indices = indices};
    double hi[3], longest = 0;
    for (int k = 0; k < 3; k++) {
        out->lo[k] = INFINITY;
        hi[k] = -INFINITY;
        for (size_t i = 0; i < index_count; i++) {
            out->lo[k] = fmin(out->lo[k], vertices[indices[i]].position[k]);
            hi[k] = fmax(hi[k], vertices[indices[i]].position[k]);
        }
        longest = fmax(longest, hi[k] - out->lo[k]);
    }
    /* A surface passes through about n^2 of n^3 cells: a few triangles in each. */
    unsigned triangles = (unsigned)(index_count / 3);
    out->cell = longest / fmin(MAX_CELLS, fmax(1, sqrt(triangles / 4.0)));
    size_t cells = 1;
    for (int k = 0; k < 3; k++) {
        out->size[k] = 1 + (int)((hi[k] - out->lo[k]) / out->cell);
        cells *= (size_t)out->size[k];
    }
    out->spheres = xmalloc(triangles * sizeof *out->spheres);
    for (unsigned i = 0; i < triangles; i++)
        make_sphere(&out->spheres[i], vertices, indices + 3 * i);
    out->first = xcalloc(cells + 2, sizeof *out->first);
    size_t *counts = out->first + 2; /* shifted by two: the second pass turns them into where each cell starts */
    for (unsigned i = 0; i < triangles; i++)
        enter(out, i, counts, false);
    for (size_t i = 2; i < cells + 2; i++)
        out->first[i] += out->first[i - 1];
    out->triangles = xmalloc(out->first[cells + 1] * sizeof *out->triangles);
    for (unsigned i = 0; i < triangles; i++)
        enter(out, i, out->first + 1, true);
}

void distance_grid_free(struct distance_grid *g)
{
    free(g->spheres);
    free(g->first);
    free(g->triangles);
}

/* Squared distance of p from a cell's box. */
static double cell_distance2(const struct distance_grid *g, const int cell[3], const double p[3])
{
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        double lo = g->lo[k] + cell[k] * g->cell, d = lo > p[k] ? lo - p[k] : p[k] - lo - g->cell;
        sum += d > 0 ? d * d : 0;
    }
    return sum;
}

/* Lowers *best to the squared distance from a triangle if that is nearer; its sphere tells for most that it is not. */
static bool nearest(double *best, const struct distance_grid *g, unsigned triangle, const double p[3])
{
    const struct distance_sphere *s = &g->spheres[triangle];
    double d[3] = {p[0] - s->center[0], p[1] - s->center[1], p[2] - s->center[2]};
    double reach = s->radius + sqrt(*best);
    if (dot(d, d) >= reach * reach)
        return false;
    double distance2 = triangle_distance2(g, triangle, p);
    if (distance2 >= *best)
        return false;
    *best = distance2;
    return true;
}

double distance_to(const struct distance_grid *g, const double p[3], unsigned *triangle)
{
    int at[3], reach = 0;
    double best = INFINITY;
    for (int k = 0; k < 3; k++) {
        at[k] = cell_of(g, k, p[k]);
        reach = g->size[k] > reach ? g->size[k] : reach;
    }
    /* Shells of cells around the point's own; shell r is at least r - 1 cells away. */
    for (int r = 0; r <= reach && best > (r - 1.0) * fabs(r - 1.0) * g->cell * g->cell; r++)
        for (int z = at[2] - r; z <= at[2] + r; z++)
            for (int y = at[1] - r; y <= at[1] + r; y++) {
                bool face = abs(z - at[2]) == r || abs(y - at[1]) == r;
                for (int x = at[0] - r; x <= at[0] + r; x += face || r == 0 ? 1 : 2 * r) {
                    const int cell[3] = {x, y, z};
                    if (x < 0 || y < 0 || z < 0 || x >= g->size[0] || y >= g->size[1] || z >= g->size[2] ||
                        cell_distance2(g, cell, p) >= best)
                        continue;
                    size_t index = ((size_t)z * g->size[1] + y) * g->size[0] + x;
                    for (size_t i = g->first[index]; i < g->first[index + 1]; i++)
                        if (nearest(&best, g, g->triangles[i], p) && triangle)
                            *triangle = g->triangles[i];
                }
            }
    return sqrt(best);
}
