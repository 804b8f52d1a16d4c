/*
 * The specular-frame table over a block: its variant for processors with AVX2.
 */
#ifndef RASTER_SPECULAR_FRAME_H
#define RASTER_SPECULAR_FRAME_H

#include "block.h"

/* specular_frame_wide.c, where RASTER_WIDE: as raster_shade_specular_frame, from the batch's first pixel on. The same bits. */
uint32_t raster_specular_frame_wide(struct raster_batch *b, uint32_t end, const struct lut_table *t,
                                    const struct raster_block_light *light);

#endif
