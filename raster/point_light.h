/*
 * Point lights: where a surface is in eye space, what of a light arrives there, and which tiles a light reaches. Eye space is
 * right-handed, looks down -z and is measured in world units, q16_16; what lies beyond +-32768 is brought to that limit.
 * For the rasterizer's own files.
 */
#ifndef RASTER_POINT_LIGHT_H
#define RASTER_POINT_LIGHT_H

#include "raster.h"

/* What the rest calls. */
struct raster_points {
    void (*position)(struct vec3 *eye, const struct scene_camera *camera, const q16_16_t position[3]);
    /* raster_point_light for the surface seen at pixel (x, y), see raster_surface_point. */
    bool (*at)(struct vec3 *l, uint32_t *attenuation, const struct raster *r, const struct raster_light *light,
               uint32_t x, uint32_t y, uint32_t depth);
    /* The tile's box; then of a light whether it reaches it, and the largest attenuation in it. */
    void (*find_box)(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect);
    bool (*reaches)(const struct raster_light_box *box, const struct vec3 *position, uq16_16_t radius);
    uint32_t (*attenuation)(const struct raster_light_box *box, const struct vec3 *position, uq16_16_t radius);
};

/* A light's position in eye space, q16_16, within one unit (2^-16) but for the saturation. Once a light and frame. */
void raster_light_position(struct vec3 *eye, const struct scene_camera *camera, const q16_16_t position[3]);

/* Eye-space position, q16_16, of the surface seen at the centre of pixel (x, y) of the picture. In: depth as in the tile's
 * surface (without the slot's byte), DEPTH_BIAS included; x < width, y < height. Every coordinate is within one unit, 2^-24 of itself
 * and 2^-17 of a pixel of what that depth says exactly. */
struct vec3 raster_surface_point(const struct raster *r, uint32_t x, uint32_t y, uint32_t depth);

/*
 * What a point light does at a point: false, and nothing written, when it lies at `radius` or beyond. Otherwise *l is the unit
 * vector towards the light, Q15 (components within 0.51 of a unit, length within one; (0, 0, 1) at the light itself), and *attenuation,
 * 1.0 = 2^30, what its intensity is multiplied by:
 *   min(1/max(d, 0.01)^2 * (1 - (d/radius)^4)^2, 1)
 * within one unit and 2^-20 of min(1/d^2, 1); nearer than 0.1 within 2^-15. In: position and point q16_16,
 * 0 < radius <= SCENE_MAX_RADIUS.
 * The window that ends the light at its radius is Karis 2013's, "Real Shading in Unreal Engine 4".
 */
bool raster_point_light(struct vec3 *l, uint32_t *attenuation, const struct vec3 *position, uq16_16_t radius,
                        struct vec3 point);

/* Once a tile: a box that holds every raster_surface_point of a rectangle of pixels. In: the rectangle, not empty, and the largest and smallest depth among its surfaces, as for raster_surface_point;
 * background excluded. */
void raster_light_box_setup(struct raster_light_box *box, const struct raster *r, const struct raster_rect *rect,
                            uint32_t nearest, uint32_t farthest);

/* Whether a point light may reach a surface in the box: true wherever raster_point_light says so for a point of it. */
bool raster_light_box_reached(const struct raster_light_box *box, const struct vec3 *position, uq16_16_t radius);

/* No point of the box gets a larger *attenuation from raster_point_light; 0 where the light does not reach it. */
uint32_t raster_light_box_attenuation(const struct raster_light_box *box, const struct vec3 *position,
                                      uq16_16_t radius);

#endif
