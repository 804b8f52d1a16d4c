/* Where the window's eye is, and how it moves around the scene: scene.h's camera in floating point. */
#ifndef HOST_TOOLS_GTSIM_WINDOW_EYE_H
#define HOST_TOOLS_GTSIM_WINDOW_EYE_H

#include "scene.h"

struct eye {
    double at[3], row[3][3]; /* rows: right, up, back; orthonormal */
};

void eye_read(struct eye *e, const struct scene_camera *c);

/* Places the camera there. False, and *c as it was, when that is farther away than its format goes. */
bool eye_write(struct scene_camera *c, const struct eye *e);

/* The middle of the box around all objects. */
void eye_scene_middle(double middle[3], const struct scene *s);

/* What the eye turns around: the point that it looks at, as far away as the scene's middle, so that the picture's middle stays where it is. In: a
 * distance below which the scene counts as beside or behind the eye. */
void eye_pivot(double pivot[3], const struct eye *e, const struct scene *s, double least);

/* Turns it about the vertical through the pivot, and up, degrees; it ends short of the poles. False, and *e as it was, where it cannot go on. */
bool eye_orbit(struct eye *e, const double pivot[3], double around, double up);

/* Multiplies its distance from the pivot. False, and *e as it was, when it is to come nearer than `least`. */
bool eye_approach(struct eye *e, const double pivot[3], double factor, double least);

/* A vector turned about the vertical, degrees. */
void eye_turn_vertical(double v[3], double degrees);

#endif
