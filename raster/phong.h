/*
 * Lafortune-Phong over a block: what its portable and its ARM loop share. They give the same bits:
 *
 *   s2 = ((n.a)^2 + (n.b)^2) / 2^32                    Q28: the high word of the 64-bit sum
 *   lobe = raster_lobe_at(2 s2)                        Q31
 *   power = lobe n.l, Q61                              its high word Q29; the low one goes into the first channel's sum below
 *   radiance += diffuse n.l + specular power           64 bits, the radiance above 32; a channel's low word goes into the next one's
 *                                                      sum, so that only the last is lost
 */
#ifndef RASTER_PHONG_H
#define RASTER_PHONG_H

#include "block.h"

/* Reflected radiance for n.l = 1: diffuse, and the lobe's peak; 22 and 23 fraction bits. */
struct phong_colour {
    uint32_t diffuse, specular;
};

/* One light and material. */
struct phong_loop {
    uint32_t unlit; /* bytes of the batch's pixels that the light does not reach */
    const struct raster_batch_pixel *end;
    struct phong_colour colour[3];
    uint32_t offset; /* the lobe's */
    uintptr_t nodes; /* its node of index 0, were clz 0 */
};

#ifdef RASTER_ARM
/* phong_arm.c: adds the light to the pixels from `pixel` to k->end. In: k->unlit = 0. */
extern void raster_shade_lafortune_phong_loop(const struct raster_batch_pixel *pixel, uq12_20_t *radiance,
                                              const struct raster_block_light *light, struct phong_loop *k);
#endif

#endif
