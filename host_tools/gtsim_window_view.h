/*
 * What the window's keys do to the simulated device, as requests of the protocol. The device's own state is the only one: each function starts from
 * what the device shows now, so that it does not matter who set it.
 */
#ifndef HOST_TOOLS_GTSIM_WINDOW_VIEW_H
#define HOST_TOOLS_GTSIM_WINDOW_VIEW_H

#include "sim_device.h"

struct view {
    struct sim_device *device;
    uint32_t material;          /* the selected one */
    struct scene_camera camera; /* as set last: while it is the device's, the pivot stays */
    double pivot[3];
    uint32_t lit[APP_MAX_SET_LIGHTS][3]; /* irradiance of lights that were switched off */
};

/* All of these do nothing when the device has no scene; what the device refuses is warned of. `by` is +1 or -1. */

/* Turns the eye around the scene, degrees; `up` ends short of the poles. */
void view_orbit(struct view *v, double around, double up);
/* Multiplies the distance. */
void view_distance(struct view *v, double factor);
/* The next material becomes the selected one; it takes the next table slot that is not empty. */
void view_material(struct view *v, int by);
void view_slot(struct view *v, int by);
/* All materials take the next model: as the scene says, then enum scene_material_kind; those that change nothing are left out. */
void view_model(struct view *v, int by);
/* Thirds of a stop. */
void view_exposure(struct view *v, int by);
/* Switches light `index` off or on again, if there is one; turns all lights about the vertical through the scene, degrees. */
void view_light(struct view *v, uint32_t index);
void view_turn_lights(struct view *v, double degrees);
/* A fifth less of the ticks that a tile gets on average, or a fourth more. In: those that tiles take now. From no limit, less is less than they take; so much that
 * it limits nothing becomes no limit, and less than the scene needs becomes what it needs. */
void view_budget(struct view *v, int by, const struct usb_stats *stats);
/* The next coarser rate of shading for all surfaces, or the next finer one; full quality is one without a budget. */
void view_rate(struct view *v, int by);
void view_reset(struct view *v);

/* The state in a line, malloc'd: "2 gold: measured, slot 2 | exposure 1.00 | lights 1 2 3". */
char *view_text(const struct view *v);

#endif
