/*
 * Scenes that are hard on a tile's budget, and random ones: blobs as gtscene writes them, from a kind and a seed. Meant for 320 x 240.
 */
#ifndef TESTS_BUDGET_SCENES_H
#define TESTS_BUDGET_SCENES_H

#include <stddef.h>
#include <stdint.h>

enum scenes_kind {
    SCENES_RANDOM,      /* objects, materials, lights and camera by the seed */
    SCENES_ONE_TILE,    /* every triangle in the tile right below the picture's centre */
    SCENES_SLIVERS,     /* triangles across the picture, less than a pixel thin */
    SCENES_LIGHTS,      /* a hundred point lights */
    SCENES_INTERLEAVED, /* six materials, each pixel another than its neighbours */
    SCENES_INSIDE,      /* the camera within meshes, near planes cutting them */
    SCENES_BROAD,       /* as random ones, with lobes of a power up to 1, which take more than others */
    SCENES_BRIGHT,      /* as random ones, with light that tables and lobes reflect far beyond white */
    SCENES_KIND_COUNT
};

/* Table slots that materials name: half-vector tables, then one of the other kind. */
#define SCENES_HALF_VECTOR_SLOTS   2u
#define SCENES_SPECULAR_FRAME_SLOT 2u
#define SCENES_SLOTS               3u

/* The blob, malloc'd. */
void *scenes_make(enum scenes_kind kind, uint32_t seed, size_t *bytes);

const char *scenes_name(enum scenes_kind kind);

#endif
