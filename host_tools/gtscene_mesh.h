/* A triangle mesh as gtscene handles it before it becomes meshlets: from a built-in shape or from a file. */
#ifndef GTSCENE_MESH_H
#define GTSCENE_MESH_H

#include <stdbool.h>
#include <stddef.h>

struct mesh_vertex {
    float position[3];
    float normal[3]; /* unit length, or zero where unknown */
};

struct mesh {
    struct mesh_vertex *vertices;
    unsigned *indices; /* three per triangle, counter-clockwise from outside */
    size_t vertex_count, index_count;
};

#define MESH_MAX_TRIANGLES 4000000u

void mesh_free(struct mesh *m);

/* Loads an OBJ, PLY or glTF file; smooth normals are generated where the file has none. Dies with EXIT_FILE or
 * EXIT_BAD_INPUT. */
void mesh_load(struct mesh *out, const char *path);

/* A built-in shape: closed, about 5,000 triangles by default, inside the sphere of radius 1.5. */
#define SHAPE_MAX_PARAMETERS 6

struct shape {
    const char *name, *what;
    struct shape_parameter {
        const char *name;
        double value, lo, hi; /* default and range */
        bool whole;           /* a whole number */
    } parameters[SHAPE_MAX_PARAMETERS];
    void (*build)(struct mesh *out, const double *parameters);
};

extern const struct shape shapes[]; /* ends with a NULL name */

/* NULL when there is none of that name. */
const struct shape *shape_find(const char *name);

#endif
