/*
 * The slices of 3-D textures side by side in one image, in row-major order.
 */
#ifndef HOST_TOOLS_GTLUT_SLICES_H
#define HOST_TOOLS_GTLUT_SLICES_H

#include "lut.h"

struct slices {
    uint32_t width, height, depth; /* of the slices, number of slices */
    uint32_t columns, rows;        /* of the arrangement */
    float *pixels;                 /* RGB; owned */
};

/* Dies with EXIT_USAGE unless the name ends in .exr or .png. */
void slices_need_image(const char *path);

/* Black; as near to square as fits: an arrangement (of slices of any shape), or the image itself where `image` is set. */
void slices_make(struct slices *out, uint32_t width, uint32_t height, uint32_t depth, bool image);
void slices_free(struct slices *s);

/* A table's values, times `factor`, with its slices' corners at (x, y) of the image's slices. */
void slices_put(struct slices *s, uint32_t x, uint32_t y, const struct lut_table *t, double factor);

/* EXR: the values. PNG: clamped to 0..1 and sRGB-encoded. */
void slices_write(const char *path, const struct slices *s);

#endif
