/*
 * The scene blob in double precision, for the reference renderer and for tests: read byte by byte at the offsets that
 * SPEC.md documents, with nothing of the product's code. Normals are decoded and unit, positions are in the mesh's
 * vertex units, object matrices include the scale.
 */
#ifndef REF_SCENE_H
#define REF_SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "ref_models.h"

struct ref_camera {
    double eye[3], rotation[3][3]; /* rows: right, up, back */
    double focal, near;
};

struct ref_light {
    int point;           /* 1: from `position`, intensity `irradiance`, up to `radius`; 0: directional */
    double direction[3]; /* world space, unit (normalised here) */
    double position[3];  /* world space */
    double radius;
    double irradiance[3];
};

struct ref_object {
    unsigned mesh, material;
    double matrix[3][4];   /* world from vertex units: rotation * scale | position */
    double rotation[3][3]; /* world from object, for normals */
};

struct ref_vertex {
    double position[3]; /* vertex units: whole numbers */
    double normal[3];   /* object space, unit: n = frame^T * (2u, 2v, 1-s)/(1+s), normalised */
    double uv[2];       /* as stored, 1.0 = 1 */
};

struct ref_meshlet {
    double frame[3][3];     /* rows x, y, z */
    double cone_cutoff;     /* 1 or more: never culled */
    double area, perimeter; /* of all triangles, at least; vertex units */
    double lo[3], hi[3];
    unsigned vertex_first, vertex_count;
    unsigned triangle_first, triangle_count; /* triangles' indices count from vertex_first */
};

struct ref_mesh {
    double lo[3], hi[3];
    unsigned meshlet_first, meshlet_count; /* of the finest level */
};

struct ref_scene {
    struct ref_camera camera;
    double exposure;
    int aces; /* 1: ACES tone curve */
    uint8_t background[3];
    unsigned light_count, material_count, object_count, mesh_count, meshlet_count, vertex_count, triangle_count;
    struct ref_light *lights;
    struct ref_material *materials;
    struct ref_object *objects;
    struct ref_mesh *meshes;
    struct ref_meshlet *meshlets;
    struct ref_vertex *vertices; /* every meshlet's own */
    unsigned (*triangles)[3];    /* vertex indices, local to the meshlet */
};

/* NULL when the blob is not one that this reader understands or out of memory; the caller frees with ref_scene_close. */
struct ref_scene *ref_scene_open(const void *blob, size_t bytes);
void ref_scene_close(struct ref_scene *s);

#endif
