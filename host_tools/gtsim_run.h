/* The simulated device on a bus: what `run` and `window` share. */
#ifndef HOST_TOOLS_GTSIM_RUN_H
#define HOST_TOOLS_GTSIM_RUN_H

#include <argp.h>

#include "gtsim_bus.h"

/* The devices' options, those of the board included, as an argp child; its input is a struct bus_options. */
extern const struct argp bus_argp;

/* One device that gives no trouble. */
struct bus_options bus_default(void);

/* The mocked /sys and /dev are made by a preloaded library, which the child inherits and this process needs for hotplug events: starts this
 * program again with it, as gtsim `subcommand` and argv from [1] on. Returns when it is there. */
void bus_preload(const char *subcommand, char **argv);

#endif
