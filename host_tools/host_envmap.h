/*
 * An environment map as a few directional lights, for renderers that know no others.
 *
 * The map's pixels are parted into as many clusters as lights are wanted, so that the sum over the clusters of the variance of their
 * directions, weighted by luminance, is small: first by cutting rectangles of the map in two, always the one of the largest variance
 * where most of it goes (Viriyothai and Debevec 2009, "Variance minimization light probe sampling"; Debevec 2005's median cut parts
 * energy evenly instead, which spends most lights on the brightest spot), then by Lloyd's iteration, which frees the
 * clusters from rectangles and from the map's seam. A light has all its cluster's energy and stands at its mean direction.
 */
#ifndef HOST_TOOLS_HOST_ENVMAP_H
#define HOST_TOOLS_HOST_ENVMAP_H

#include "host_environment.h"

enum { ENVMAP_MIN_LIGHTS = 4, ENVMAP_MAX_LIGHTS = 64 };

struct envmap_light {
    double direction[3]; /* unit, towards the light, in the map's frame */
    double
        irradiance[3]; /* on a surface that faces it; the sum over all lights is the integral of the map's radiance */
};

/* Fills out[0..count-1], the brightest first; returns how many there are: fewer than `count` where fewer pixels are not black. */
unsigned envmap_lights(struct envmap_light *out, unsigned count, const struct environment *e);

#endif
