/* What tiles took, as a picture. */
#ifndef HOST_TOOLS_GTSIM_HEATMAP_H
#define HOST_TOOLS_GTSIM_HEATMAP_H

#include "host_canvas.h"
#include "sim_device.h"

/*
 * Writes three panels side by side, the frame in grey under each: ticks of every tile, its mean rate of shading, its predicted error. A scale
 * is under each panel, from dark (0) to bright; what bright stands for is printed. In: the frame, whose statistics *d holds. Dies as
 * image_write_u8 does.
 */
void heatmap_write(const char *path, const struct sim_device *d, const struct canvas *frame);

#endif
