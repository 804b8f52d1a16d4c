/*
 * The re-packed half-vector table over a block, for Cortex-M cores of ARMv7-M and later: half_vector.h's arithmetic, instruction by
 * instruction, since a compiler runs out of registers. half_vector_dsp.c has the loop for cores with the DSP instructions,
 * half_vector_thumb.c for those without.
 */
#ifndef RASTER_HALF_VECTOR_ARM_H
#define RASTER_HALF_VECTOR_ARM_H

#include "half_vector.h"

/* One light and table: what the loops copy to their own stack. */
struct half_vector_loop {
    uintptr_t warp;  /* where a node of index 0 would be: clz gives 19 for the first */
    uint32_t half;   /* 1/2 of the ratio, 22 fraction bits */
    uint32_t width;  /* (T-1) << 6 | bytes of a node << 16 */
    uint32_t height; /* H-1 | bytes of a row << 16 */
    const uint32_t *slabs;
    int32_t top;
    uint32_t colour[3];
    const struct raster_batch_pixel *end;
};
_Static_assert(sizeof(void *) != 4 ||
                   (sizeof(struct half_vector_loop) == 40 && offsetof(struct raster_block_light, l_z) == 52 &&
                    PLANE_B_XY == 1 && PLANE_AB_Z == 2 && PLANE_TERM == 3),
               "the loops' offsets");

/* Out: in the low word the end, or the first pixel whose cell is brighter than the scale's top; in the high word how many before it
 * the light does not reach. With DSP instructions H <= 64, so that the warp's coordinates are positive as 16-bit numbers. A step of
 * the warp is loaded as one unaligned word. */
typedef uint64_t raster_half_vector_pixels(const struct raster_batch_pixel *pixel, uq12_20_t *radiance,
                                           const struct raster_block_light *light, const struct half_vector_loop *k);
extern raster_half_vector_pixels raster_half_vector_loop;      /* by 8 taps */
extern raster_half_vector_pixels raster_half_vector_loop_four; /* by 4 */
extern raster_half_vector_pixels raster_half_vector_loop_one;

#endif
