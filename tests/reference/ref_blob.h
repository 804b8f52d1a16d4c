/*
 * Hand-made scene blobs for tests, written byte by byte as SPEC.md says: every triangle is a meshlet of its own, with
 * the true frame, cone and flat normals.
 *
 * Usage: ref_blob_init, then any of the other calls in any order, ref_blob_finish, ref_blob_free. Objects name
 * meshes, materials in the order they were added.
 */
#ifndef REF_BLOB_H
#define REF_BLOB_H

#include <stddef.h>
#include <stdint.h>

enum { REF_BLOB_ARRAYS = 8 };

struct ref_blob_bytes {
    uint8_t *data;
    size_t bytes, room;
    uint32_t count; /* elements */
};

struct ref_blob {
    double eye[3], rotation[9], focal, near; /* as in the blob's camera, in world units */
    double exposure;
    uint8_t tone_curve, background[3];
    struct ref_blob_bytes array[REF_BLOB_ARRAYS];
};

/* Camera at the origin looking down -z, focal 1, near 1/16; exposure 1, no tone curve, black background. */
void ref_blob_init(struct ref_blob *b);

void ref_blob_light(struct ref_blob *b, const double direction[3], double irradiance);

/* kind 0: the measured table in `slot`; 1: Lafortune-Phong, a grey kd and nothing else. Returns its index. */
unsigned ref_blob_material(struct ref_blob *b, unsigned kind, unsigned slot, double kd, const char *name);

/* Counter-clockwise triangles of int16 vertices. Returns the mesh's index. */
unsigned ref_blob_mesh(struct ref_blob *b, const int16_t (*vertices)[3], const uint16_t (*triangles)[3],
                       unsigned triangle_count);

/* World position = vertex * scale + position. In: scale 2^-40 < scale < 2. */
void ref_blob_object(struct ref_blob *b, unsigned mesh, unsigned material, const double position[3], double scale);

/* The blob, malloc'd. */
void *ref_blob_finish(const struct ref_blob *b, size_t *bytes);
void ref_blob_free(struct ref_blob *b);

#endif
