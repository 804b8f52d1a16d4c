/* How far points are from a surface of triangles: an exact distance to each, found through a grid. */
#ifndef GTSCENE_DISTANCE_H
#define GTSCENE_DISTANCE_H

#include "gtscene_mesh.h"

struct distance_sphere { /* around a triangle */
    double center[3], radius;
};

struct distance_grid {
    const struct mesh_vertex *vertices;
    const unsigned *indices;
    double lo[3], cell;              /* lowest corner and side of a cell */
    int size[3];                     /* cells per axis */
    size_t *first;                   /* per cell, and one beyond the last: its part of `triangles` */
    struct distance_sphere *spheres; /* per triangle */
    unsigned *triangles;             /* triangles whose box touches the cell */
};

/* A grid over some triangles of a mesh, which must outlive it. In: index_count >= 3. */
void distance_grid_build(struct distance_grid *out, const struct mesh_vertex *vertices, const unsigned *indices,
                         size_t index_count);
void distance_grid_free(struct distance_grid *g);

/* Distance of p from the nearest triangle, whose number goes to *triangle unless that is NULL. */
double distance_to(const struct distance_grid *g, const double p[3], unsigned *triangle);

#endif
