/*
 * Tile budgets: no tile takes longer than its share, and what is saved is saved where it is seen least.
 *
 * The host sets the mean of a tile's ticks; times the tiles that is the frame's deadline. A tile's share is what it takes at most at the
 * last rung of shading (raster_tile_bound), and of the ticks that are left beyond all these bounds a part in proportion to what it
 * would take at full quality. After visibility, pixels per material are known, and so is what each rate of shading costs: the plan
 * is the assignment of least summed error that is expected to fit. As the expectation may be wrong, every region of the tile is
 * shaded only at rates that fit at their worst, with everything after it at the last rung: the plan may err, the tile is never over.
 *
 * Errors are counted in 1/16 of an 8-bit step of the displayed pixel, summed over pixels.
 */
#ifndef FIRMWARE_BUDGET_H
#define FIRMWARE_BUDGET_H

#include "quality.h"

/* Materials with a choice of their own in a tile; the smaller ones of a tile with more share the last choice. */
#define BUDGET_CLASSES 8u

/* One material in one tile: what every rate of shading is expected to take, and to err. */
struct budget_class {
    uint32_t ticks[RASTER_RATE_COUNT];
    uint32_t error[RASTER_RATE_COUNT];
    uint8_t rate; /* the choice */
};

/*
 * Chooses a rate for each of `count` <= BUDGET_CLASSES classes: all 1x1 where `ticks` allow it, else the least summed error that takes at
 * most `ticks` in all, else the cheapest. The optimum for up to four classes. Returns the summed error. In: errors do not fall from a rate to
 * the next; sums of ticks, and of errors, are below 2^31.
 */
uint32_t budget_choose(struct budget_class *classes, uint32_t count, uint32_t ticks);

#endif
