/*
 * Levels of detail of a mesh: fewer triangles between some of its vertices, and how far they are from the original.
 *
 * Triangles between vertices of a curved surface all lie on one side of it. A level's vertices are therefore moved along their
 * normals to where the original is, on average, as far on one side as on the other, which nearly halves the distance.
 */
#ifndef GTSCENE_SIMPLIFY_H
#define GTSCENE_SIMPLIFY_H

#include "gtscene_mesh.h"

#define SIMPLIFY_MAX_LEVELS 24

struct simplified {
    struct mesh mesh; /* owned */
    double error; /* distance between the two surfaces, in the mesh's units, either way; not below the level's before */
};

/* Makes coarser levels of m, each with about half the triangles of the one before, until fewer than 64 are left or
 * simplification gets stuck; returns their number (0 for a mesh that cannot be made coarser). In: no triangle of m is
 * without area. The error is measured at about 16,000 points of each surface, and at least the simplifier's own. */
unsigned mesh_simplify(struct simplified out[SIMPLIFY_MAX_LEVELS], const struct mesh *m);

#endif
