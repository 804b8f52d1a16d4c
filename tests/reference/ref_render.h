/*
 * Reference renderer: a scene in double precision, from the same snapped vertices that the product draws.
 *
 * Coverage is exact (ref_coverage.h). The surface seen at a pixel is the one with the smallest eye-space depth there, depth
 * and normal interpolated perspective-correctly from the vertices' own; normals are interpolated as vectors and brought
 * to unit length. Each light adds irradiance * exposure * f(l,v) * n.l, nothing where n.l <= 0 or n.v <= 0, v pointing from
 * the surface back along the pixel's view ray; a point light's irradiance and direction are those at the pixel's point.
 * Blinn-Phong is summed and clamped as James 2022 does it, metallic-roughness gets ambient light.
 * Then tone curve, clamp, sRGB, 8 bits.
 * No clipping: every vertex of a triangle that shows must lie in front of the near plane.
 */
#ifndef REF_RENDER_H
#define REF_RENDER_H

#include <stdint.h>

#include "ref_scene.h"
#include "ref_table.h"

/* How the normal between a triangle's vertices is found. */
enum ref_normals {
    REF_NORMALS_LINEAR,       /* as vectors, brought to unit length: the reference proper */
    REF_NORMALS_STEREOGRAPHIC /* as the stored coordinates in the meshlet's frame: tells the choice of interpolant from
                                 the arithmetic */
};

enum ref_model {
    REF_MODEL_AS_SCENE,
    REF_MODEL_MEASURED,
    REF_MODEL_LAFORTUNE_PHONG,
    REF_MODEL_BLINN_PHONG,
    REF_MODEL_METALLIC_ROUGHNESS
};

struct ref_view {
    const struct ref_scene *scene;
    const struct ref_table *const *tables; /* by slot */
    int width, height;
    enum ref_model model; /* of all materials */
    enum ref_normals normals;
    /* Where vertex `vertex` (into the scene's vertices) of an object was snapped to: 24.8, from the picture's top left
     * corner, y down. */
    void (*snapped)(int32_t xy[2], void *context, unsigned object, unsigned vertex);
    void *context;
};

/* width * height pixels each, row by row; free with ref_picture_free. */
struct ref_picture {
    uint8_t *rgb;
    int *object;           /* -1: no surface covers the pixel */
    double *inv_w;         /* of the surface seen, 1 / world units; 0 for none */
    double (*normal)[3];   /* of the surface seen, eye space, unit */
    double (*radiance)[3]; /* exposed, linear; 0 where there is no surface */
    double (*display)[3];  /* 0..255 before rounding */
};

void ref_render(struct ref_picture *out, const struct ref_view *view);
void ref_picture_free(struct ref_picture *p);

/* Exposed linear sRGB to display bytes before rounding, 0..255. */
void ref_tone(double display[3], const double radiance[3], int aces);

#endif
