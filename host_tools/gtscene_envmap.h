/* `gtscene build --envmap`: the lights of an environment map, added to a scene's own. */
#ifndef GTSCENE_ENVMAP_H
#define GTSCENE_ENVMAP_H

#include "gtscene_desc.h"
#include "host_envmap.h"

struct envmap_options {
    const char *path;
    unsigned lights; /* ENVMAP_MIN_LIGHTS..ENVMAP_MAX_LIGHTS */
    double scale;    /* of the map's radiance */
    double degrees;  /* the map is turned by, about the world's +y: its centre goes from +z towards +x */
};

/* Dies with EXIT_FILE or EXIT_BAD_INPUT, also when a light gets brighter than the blob can say or there are too many. */
void envmap_add(struct scene_desc *desc, const struct envmap_options *o);

#endif
