/* What tiles took, as a picture. */
#ifndef HOST_TOOLS_GTSIM_HEATMAP_H
#define HOST_TOOLS_GTSIM_HEATMAP_H

#include "host_canvas.h"
#include "sim_device.h"

enum { HEATMAP_TICKS, HEATMAP_RATE, HEATMAP_ERROR, HEATMAP_PANELS };

/* A panel's subject, as text; a tile's value in it, and what the brightest colour stands for, above 0. */
const char *heatmap_name(int panel);
double heatmap_value(const struct usb_tile_stats *tile, int panel);
double heatmap_most(const struct usb_tile_stats *tiles, uint32_t count, int panel);

/* Dark blue over magenta and orange to light yellow for x from 0 to 1: rising in brightness, told apart without colour vision, too. */
void heatmap_colour(uint8_t rgb[3], double x);

/*
 * Writes three panels side by side, the frame in grey under each: ticks of every tile, its mean rate of shading, its predicted error. A scale
 * is under each panel, from dark (0) to bright; what bright stands for is printed. In: the frame, whose statistics *d holds. Dies as
 * image_write_u8 does.
 */
void heatmap_write(const char *path, const struct sim_device *d, const struct canvas *frame);

#endif
