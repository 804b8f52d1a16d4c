/* The built-in shapes of scenes, as meshes before they become meshlets. */
#ifndef GTSCENE_MESH_H
#define GTSCENE_MESH_H

#include <stdbool.h>

#include "host_mesh.h"

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
