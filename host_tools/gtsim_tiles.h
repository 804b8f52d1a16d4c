/* The tiles of a frame on a pool of threads. */
#ifndef HOST_TOOLS_GTSIM_TILES_H
#define HOST_TOOLS_GTSIM_TILES_H

#include "raster.h"

/* 0..count-1, in a random order when `shuffled`; the same seed gives the same order. */
void tiles_order(uint32_t *order, uint32_t count, bool shuffled, uint32_t seed);

/*
 * Renders the tiles of a begun frame in `order` (raster_tile_count entries, each tile once), each thread with a struct raster_tile of its
 * own. Out: the picture in the frame's format, row by row, and the sum of all tiles' statistics. Dies with EXIT_INTERNAL when a
 * thread cannot be started.
 */
void tiles_render(uint8_t *pixels, struct raster_stats *sum, const struct raster *r, const uint32_t *order,
                  unsigned threads);

#endif
