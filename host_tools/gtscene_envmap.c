#include "gtscene_envmap.h"

#include <math.h>

#include "common.h"

#define MAX_IRRADIANCE 256 /* as in a scene file */

static void light_quantise(struct scene_light *out, const struct envmap_light *l, const struct envmap_options *o)
{
    const double angle = o->degrees * 3.14159265358979323846 / 180, c = cos(angle), s = sin(angle);
    const double *d = l->direction, turned[3] = {c * d[0] + s * d[2], d[1], c * d[2] - s * d[0]};
    *out = (struct scene_light){.kind = SCENE_LIGHT_DIRECTIONAL};
    for (int k = 0; k < 3; k++) {
        double irradiance = l->irradiance[k] * o->scale;
        if (irradiance > MAX_IRRADIANCE)
            die(EXIT_BAD_INPUT, "%s: a light gets an irradiance of %g, the limit is %d; give --envmap-scale %.3g",
                o->path, irradiance, MAX_IRRADIANCE, o->scale * 0.99 * MAX_IRRADIANCE / irradiance);
        out->direction[k] = (q2_30_t)lrint(turned[k] * (1 << 30));
        out->irradiance[k] = (uq16_16_t)lrint(irradiance * 65536);
    }
}

void envmap_add(struct scene_desc *desc, const struct envmap_options *o)
{
    struct environment e;
    struct envmap_light lights[ENVMAP_MAX_LIGHTS];
    environment_read(&e, o->path);
    unsigned count = envmap_lights(lights, o->lights, &e);
    if (!count)
        die(EXIT_BAD_INPUT, "%s: black all over; give a map that holds light", o->path);
    if (desc->light_count + count > SCENE_MAX_LIGHTS)
        die(EXIT_BAD_INPUT, "%s: %u lights beside the scene's %u, at most %u fit; lower --envmap-lights", o->path,
            count, desc->light_count, SCENE_MAX_LIGHTS);
    for (unsigned i = 0; i < count; i++)
        light_quantise(&desc->lights[desc->light_count++], &lights[i], o);
    environment_free(&e);
}
