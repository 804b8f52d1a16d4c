/*
 * Which pixels a triangle covers, exactly: the Direct3D 11 rules evaluated in integers.
 *
 * Coordinates are 24.8 fixed point, y down; the centre of pixel (x, y) is at (256 x + 128, 256 y + 128). A pixel is
 * covered when its centre is inside the triangle, or on a top edge (horizontal, interior below) or a left edge (not
 * horizontal, interior to the right) and on no other kind of edge. Front faces look counter-clockwise on the screen;
 * others, and triangles without area, cover nothing.
 */
#ifndef REF_COVERAGE_H
#define REF_COVERAGE_H

#include <stdbool.h>
#include <stdint.h>

/* Edge i at point p: a[i] p.x + b[i] p.y + c[i], positive inside. */
struct ref_triangle {
    int64_t a[3], b[3], c[3];
    bool owns[3]; /* points on this edge belong to the triangle */
    int64_t area; /* twice, in (1/256 px)^2; <= 0: nothing is covered */
};

/* In: |coordinate| <= 2^28, so that every term stays below 2^60. */
void ref_triangle_setup(struct ref_triangle *t, const int32_t vertex[3][2]);

bool ref_triangle_covers(const struct ref_triangle *t, int32_t x, int32_t y);

/* Barycentric weights of the pixel's centre, exact but for one rounding each; they sum to 1. */
void ref_triangle_weights(double weight[3], const struct ref_triangle *t, int32_t x, int32_t y);

#endif
