#include "sphere.h"

enum { RADIUS = 100, LEAST_NV = 1 << 23, DEPTH_SHIFT = 4, DEPTH = 16000 };

void __wrap_raster_finish_pixels(uint32_t *out, uq12_20_t radiance[][3], uint32_t count, uint8_t tone_curve,
                                 uint8_t format);

void __wrap_raster_finish_pixels(uint32_t *out, uq12_20_t radiance[][3], uint32_t count, uint8_t tone_curve,
                                 uint8_t format)
{
    (void)tone_curve;
    (void)format;
    sphere_radiance(out, radiance, count);
}

const char *sphere_open(struct sphere *s, const void *input)
{
    const uint32_t *header = input, table_bytes = header[0];
    s->taps = header[1];
    const uint8_t *blob = (const uint8_t *)input + 16;
    const uint32_t blob_bytes = ((const struct scene_header *)(const void *)blob)->total_bytes;
    enum scene_status status = scene_open(&s->scene, blob, blob_bytes);
    if (status != SCENE_OK)
        return scene_status_text(status);
    if (table_bytes) {
        enum lut_status opened = lut_open(&s->table, blob + (((size_t)blob_bytes + 15) & ~(size_t)15), table_bytes);
        if (opened != LUT_OK)
            return lut_status_text(opened);
        s->tables[0] = &s->table;
    }
    return sphere_begin(s, true);
}

const char *sphere_begin(struct sphere *s, bool lights)
{
    const struct scene_header *h = s->scene.header;
    const struct raster_frame frame = {.parts = &raster_all_parts,
                                       .scene = &s->scene,
                                       .camera = &h->camera,
                                       .output = &h->output,
                                       .lights = s->scene.lights,
                                       .materials = s->scene.materials,
                                       .tables = s->tables,
                                       .width = SPHERE_WIDTH,
                                       .height = SPHERE_HEIGHT,
                                       .light_count = (uint8_t)(lights ? h->lights.count : 0),
                                       .format = RASTER_RGB888};
    enum raster_status status = raster_begin(&s->raster, &frame, s->arena, sizeof s->arena);
    s->tile.slot_count = 1;
    s->tile.slots[1] =
        (struct raster_slot){.frame = {16384, 0, 0, 0, 16384, 0, 0, 0, 16384}, .normal_shift = DEPTH_SHIFT};
    return status == RASTER_OK ? NULL : raster_status_text(status);
}

static uint32_t square_root(uint32_t x)
{
    uint32_t root = 0;
    for (uint32_t bit = 1u << 15; bit; bit >>= 1)
        if ((root | bit) * (root | bit) <= x)
            root |= bit;
    return root;
}

/* In half pixels from the sphere's centre, y up. The radius is 2 RADIUS of them. */
static struct raster_surface surface_at(int32_t x, int32_t y)
{
    const int32_t z2 = 4 * RADIUS * RADIUS - x * x - y * y;
    if (z2 < 0)
        return (struct raster_surface){0, 0};
    /* 1 + n.z, likewise in half pixels, 8 fraction bits with the latter; |x| DEPTH 256 < 2^30 */
    const int32_t den = 2 * RADIUS * 256 + (int32_t)square_root((uint32_t)z2 << 16);
    const uint32_t u = (uint32_t)(x * DEPTH * 256 / den), v = (uint32_t)(y * DEPTH * 256 / den);
    return (struct raster_surface){(((uint32_t)DEPTH << DEPTH_SHIFT) + DEPTH_BIAS) << 8 | 1, (u & 0xffff) | v << 16};
}

struct vec3 sphere_normal(const struct raster_tile *t, uint32_t index)
{
    const struct vec3 n = raster_eye_normal(t->slots[1].frame, t->slots[1].normal_shift, &t->surface[index]);
    return (struct vec3){fx_clamp(n.x, -32767, 32767), fx_clamp(n.y, -32767, 32767), fx_clamp(n.z, -32767, 32767)};
}

void sphere_fill(struct sphere *s, uint32_t index)
{
    const uint32_t x0 = index % SPHERE_TILES_X * RASTER_TILE_WIDTH, y0 = index / SPHERE_TILES_X * RASTER_TILE_HEIGHT;
    s->rect = (struct raster_rect){(uint16_t)x0, (uint16_t)y0, (uint16_t)fx_min(RASTER_TILE_WIDTH, SPHERE_WIDTH - x0),
                                   (uint16_t)fx_min(RASTER_TILE_HEIGHT, SPHERE_HEIGHT - y0)};
    for (uint32_t y = 0; y < RASTER_TILE_HEIGHT; y++)
        for (uint32_t x = 0; x < RASTER_TILE_WIDTH; x++) {
            const uint32_t at = y * RASTER_TILE_WIDTH + x;
            struct raster_surface *out = &s->tile.surface[at];
            *out = surface_at(2 * (int32_t)(x0 + x) + 1 - SPHERE_WIDTH, SPHERE_HEIGHT - 1 - 2 * (int32_t)(y0 + y));
            if (out->depth_slot &&
                fx_dot(sphere_normal(&s->tile, at), raster_view_vector(&s->raster, x0 + x, y0 + y)) < LEAST_NV)
                *out = (struct raster_surface){0, 0};
        }
}

void sphere_shade(struct sphere *s, struct raster_stats *stats)
{
    if (s->taps == RASTER_TAPS_8) {
        raster_shade_tile(&s->raster, &s->tile, &s->rect, stats);
        return;
    }
    const struct raster_quality quality = {.lights = RASTER_ALL_LIGHTS, .taps = (uint8_t)s->taps};
    raster_find_lights(&s->raster, &s->tile, &s->rect);
    for (uint32_t i = 0; i < RASTER_REGIONS(s->rect.width) * RASTER_REGIONS(s->rect.height); i++)
        raster_tile_shade(&s->raster, &s->tile, &s->rect, i, &quality, stats);
    raster_tile_finish(&s->raster, &s->tile, &s->rect, stats);
}

void sphere_count(const struct sphere *s, uint32_t *covered, uint32_t *lit)
{
    for (uint32_t i = 0; i < RASTER_TILE_PIXELS; i++) {
        if (!s->tile.surface[i].depth_slot)
            continue;
        *covered += 1;
        for (uint32_t l = 0; l < s->raster.frame.light_count; l++)
            *lit += fx_dot(sphere_normal(&s->tile, i), s->raster.lights[l].v) > 0;
    }
}
