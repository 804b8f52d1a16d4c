/* From a mesh to the scene blob's quantised meshlets. */
#ifndef GTSCENE_MESHLETS_H
#define GTSCENE_MESHLETS_H

#include "gtscene_mesh.h"
#include "gtscene_simplify.h"
#include "scene.h"

/* The meshlets of all meshes, in the blob's arrays; zero-initialised by the owner, who frees the arrays. */
struct meshlet_pool {
    struct scene_meshlet *meshlets;
    struct scene_vertex *vertices;
    struct scene_triangle *triangles;
    uint32_t meshlet_count, vertex_count, triangle_count;
};

/* One mesh's part of the pool. Position of vertex q in the mesh's own units: q * scale + center. */
struct packed_mesh {
    double center[3], scale;
    int16_t lo[3], hi[3];
    struct scene_lod levels[1 + SIMPLIFY_MAX_LEVELS]; /* the finest first */
    unsigned level_count;
};

struct pack_options {
    bool with_levels; /* coarser levels of detail, too */
    double
        normal_error; /* radians: meshlets are split until interpolated normals stray less; doubled for each coarser level,
                            which is drawn smaller */
};

/* Quantises, welds, drops triangles without area and appends meshlets to the pool.
 * Consumes *m. `name` is for messages; dies with EXIT_BAD_INPUT when nothing remains. Positions move by at most scale/2
 * per axis; the largest |coordinate| is 32767. */
void mesh_pack(struct packed_mesh *out, struct meshlet_pool *pool, struct mesh *m, const struct pack_options *options,
               const char *name);

#endif
