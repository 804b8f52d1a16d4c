/*
 * Sets the loops of half_vector_arm.h to work. Pixels that they do not take, brighter than a scale can say, are portable C's, and so are
 * some after them, likely to be bright, too.
 */
#include "half_vector_arm.h"

#ifdef RASTER_ARM

#define BRIGHT_PIXELS 8

/* By the loop, and by portable C of as many taps. Inline: so a program is linked with no loop that it does not ask for. */
__attribute__((always_inline)) static inline uint32_t
shade_by_loop(struct raster_batch *b, uint32_t first, uint32_t end, const struct lut_table *table,
              const struct raster_block_light *light, raster_half_vector_pixels *loop, raster_half_vector *portable)
{
    if (table->height > HALF_VECTOR_LOOP_H)
        return portable(b, first, end, table, light);
    const struct half_vector_constants c = half_vector_constants_find(table, light->colour);
    const struct half_vector_loop k = {.warp = (uintptr_t)table->warp_h + 2 * (8 * 19 - 8),
                                       .half = (1u << 21) - 64,
                                       .width = (table->width - 1) << 6 | 12 << 16,
                                       .height = (table->height - 1) | 12 * table->width << 16,
                                       .slabs = table->slabs,
                                       .top = c.top,
                                       .colour = {c.colour[0], c.colour[1], c.colour[2]},
                                       .end = &b->pixel[end]};
    uint32_t lit = end - first;
    for (uint32_t i = first; i < end; i++) {
        const uint64_t out = loop(&b->pixel[i], b->radiance[i], light, &k);
        const struct raster_batch_pixel *bright = (const struct raster_batch_pixel *)(uintptr_t)(uint32_t)out;
        lit -= (uint32_t)(out >> 32);
        i = (uint32_t)(bright - b->pixel);
        if (i < end) {
            const uint32_t last = fx_min_u(i + BRIGHT_PIXELS, end);
            lit -= last - i - portable(b, i, last, table, light);
            i = last - 1;
        }
    }
    return lit;
}

uint32_t raster_half_vector_arm(struct raster_batch *b, uint32_t first, uint32_t end, const struct lut_table *table,
                                const struct raster_block_light *light)
{
    return shade_by_loop(b, first, end, table, light, raster_half_vector_loop, raster_half_vector_plain);
}

uint32_t raster_half_vector_fewer_arm(struct raster_batch *b, uint32_t first, uint32_t end,
                                      const struct lut_table *table, const struct raster_block_light *light)
{
    return shade_by_loop(b, first, end, table, light,
                         b->taps == RASTER_TAPS_1 ? raster_half_vector_loop_one : raster_half_vector_loop_four,
                         raster_half_vector_fewer_plain);
}

#endif
