/*
 * What the shading benchmarks measure: a sphere of 100 pixels' radius amid 320 x 240, its normals those of an orthographic view, its view
 * vectors those of the scene's camera; pixels with n.v below 1/128 are left out. Its surfaces are put into a tile as the
 * rasterizer would leave them, and raster_shade_tile does the rest.
 *
 * Input: 16 bytes, of which four are the length of the table file (0: the material is none) and four how many taps a half-vector table is
 * evaluated by (enum raster_taps), little-endian; a scene blob with one material, padded to a multiple of 16 bytes; the table file.
 * The program is linked with --wrap=raster_finish_pixels: tone curve and packing are not measured, and sphere_radiance, which the
 * program gives, sees what they would get.
 */
#ifndef TESTS_BOARD_SHADE_SPHERE_H
#define TESTS_BOARD_SHADE_SPHERE_H

#include "internal.h"
#include "lut.h"
#include "quality.h"

enum {
    SPHERE_WIDTH = 320,
    SPHERE_HEIGHT = 240,
    SPHERE_TILES_X = (SPHERE_WIDTH + RASTER_TILE_WIDTH - 1) / RASTER_TILE_WIDTH,
    SPHERE_TILES_Y = (SPHERE_HEIGHT + RASTER_TILE_HEIGHT - 1) / RASTER_TILE_HEIGHT,
    SPHERE_TILES = SPHERE_TILES_X * SPHERE_TILES_Y
};

struct sphere {
    struct scene scene;
    struct lut_table table;
    const struct lut_table *tables[RASTER_MAX_SLOTS];
    struct raster raster;
    uint64_t arena[2048];
    struct raster_tile tile; /* the one being shaded */
    struct raster_rect rect; /* its place */
    uint32_t taps;           /* enum raster_taps */
};

/* Returns NULL, or what is wrong with the input. *s stays where it is: it points into itself. */
const char *sphere_open(struct sphere *s, const void *input);

/* Gets ready to shade, by all the scene's lights or none. */
const char *sphere_begin(struct sphere *s, bool lights);

/* Puts the sphere's surfaces into tile `index`; shading overwrites them. */
void sphere_fill(struct sphere *s, uint32_t index);

/* Shades the filled tile by as many taps as the input says: raster_shade_tile with all. */
void sphere_shade(struct sphere *s, struct raster_stats *stats);

/* Adds up the filled tile's pixels, and their pixel-lights with n.l > 0. */
void sphere_count(const struct sphere *s, uint32_t *covered, uint32_t *lit);

/* The normal of the surface at `index`, eye space, Q15, as raster/shade.c gathers it. */
struct vec3 sphere_normal(const struct raster_tile *t, uint32_t index);

/* The program's: gets the radiance of `count` finished pixels, leaves the pixels in `out`, which overlaps it. */
void sphere_radiance(uint32_t *out, uq12_20_t radiance[][3], uint32_t count);

#endif
