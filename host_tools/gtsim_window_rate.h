/*
 * Every surface at one rate of shading, which no budget would choose: to look at the rungs that budgets choose from. It takes the place of the
 * device's scheduler where the budget is RATE_BUDGET, more than any frame takes, and is the scheduler for all other budgets.
 */
#ifndef HOST_TOOLS_GTSIM_WINDOW_RATE_H
#define HOST_TOOLS_GTSIM_WINDOW_RATE_H

#include "sim_device.h"

#define RATE_BUDGET 4000000000u

/* The device's from now on, restarts included. */
void rate_install(struct sim_device *d);

/* Of the frames to come, of any device that it was installed in. */
void rate_set(enum raster_rate rate);
enum raster_rate rate_now(void);

/* "2x1", "flat". */
const char *rate_name(enum raster_rate rate);

#endif
