/*
 * A triangle mesh, and reading one from a file.
 */
#ifndef HOST_TOOLS_HOST_MESH_H
#define HOST_TOOLS_HOST_MESH_H

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

#endif
