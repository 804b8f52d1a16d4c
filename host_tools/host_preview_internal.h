/*
 * What the pictures share: marks, colours, and a page's legend.
 */
#ifndef HOST_TOOLS_HOST_PREVIEW_INTERNAL_H
#define HOST_TOOLS_HOST_PREVIEW_INTERNAL_H

#include "host_preview.h"

/* Of the value for light from l and view v. A pair counts as measured when the samples have it either way round. */
enum measurement_mark preview_mark(const struct preview *p, const double l[3], const double v[3]);

/* Hatches pixel (x, y) of a picture when it is marked. */
void preview_hatch(uint8_t rgb[3], enum measurement_mark mark, int x, int y);

/* At the foot of the page, for the marks (bits 1 << mark) that it shows. */
void preview_legend(struct gnuplot *g, unsigned marks);

double preview_luminance(const double rgb[3]);

/* IEC 61966-2-1; clips to 0..1. */
uint8_t preview_srgb(double linear);

/* Unit vector at these angles in degrees; azimuth 0 is where light comes from in a plane of incidence. */
void preview_direction(double d[3], double theta, double phi);

/* Triangles seen along -z, x to the right, y up; z towards the viewer. `points` are in pixels from the lower left corner of a grid of
 * width x height samples, each at the middle of its cell. The triangle in front at every sample, top row first; malloc'd. */
struct preview_hit {
    uint32_t triangle; /* number of its first index + 1; 0: none */
    float share[2];    /* of its second and third point */
    float z;
};
struct preview_hit *preview_rasterize(int width, int height, const double (*points)[3], const unsigned *indices,
                                      size_t index_count);

/* A material sampled at 65536 quality^3 pairs of directions (quality 1 or 2), which lie closest around the mirror direction, and
 * interpolated: several times faster to evaluate. The preview must outlive it. */
struct preview_fast;
struct preview_fast *preview_fast_make(const struct preview *p, int quality, int threads);
void preview_fast_free(struct preview_fast *t);
void preview_fast_source(struct brdf_source *out, const struct preview_fast *t);
/* Only the part of it that is extrapolated. */
void preview_fast_extrapolated(struct brdf_source *out, const struct preview_fast *t);

/* The material's surface, pixel by pixel, top row first. exact: evaluated as it is, and `extrapolated` left 0; else through
 * preview_fast. */
struct preview_image {
    int width, height;
    double (*radiance)[3];
    float *coverage;       /* share of the pixel; 0 where radiance is 0, too */
    uint8_t *extrapolated; /* 1 where most of the light was reflected by extrapolated values */
};
void preview_render(struct preview_image *out, const struct preview *p, const struct preview_view *view, bool exact);
void preview_image_free(struct preview_image *i);

/* Puts the image, tone-mapped, at (x, y) of an RGB picture `stride` pixels wide; returns the marks it shows. */
unsigned preview_place(uint8_t *rgb, int stride, int x, int y, const struct preview_image *i,
                       const struct preview_view *view);

#endif
