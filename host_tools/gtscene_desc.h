/* A scene file (SPEC.md, "Scene file") as numbers, in the scene blob's structures where these hold them. */
#ifndef GTSCENE_DESC_H
#define GTSCENE_DESC_H

#include "gtscene_mesh.h"
#include "scene.h"

struct mesh_desc {
    const char *name;
    const struct shape *shape; /* or NULL: a file */
    double parameters[SHAPE_MAX_PARAMETERS];
    char *path;
};

struct object_desc {
    uint16_t mesh, material;
    double position[3], rotation[3][3], scale;
};

struct scene_desc {
    struct scene_camera camera;
    struct scene_output output;
    uq16_16_t lod_error;
    struct scene_light lights[SCENE_MAX_LIGHTS];
    struct scene_material materials[SCENE_MAX_MATERIALS];
    struct object_desc *objects;
    struct mesh_desc *meshes;
    unsigned light_count, material_count, object_count, mesh_count;
};

/* Reads a scene file. A mesh file is looked for relative to the scene file's folder, then in data_folder (may be NULL).
 * Dies with EXIT_FILE or EXIT_BAD_INPUT. */
void desc_load(struct scene_desc *out, const char *path, const char *data_folder);

/* Rows of a rotation to the blob's q2_30_t. */
void desc_rotation(q2_30_t out[9], double rotation[3][3]);

#endif
