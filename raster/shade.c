/*
 * Deferred shading of a tile: pixels in row order are gathered into batches of one material, each batch is lit by
 * every light, tone mapped and packed. Finished pixels overwrite the surface from its start: a pixel takes 2 or 3 of the
 * 8 bytes it had, so writing never overtakes reading.
 */
#include "internal.h"

struct output {
    const struct raster *r;
    struct raster_tile *t;
    const struct raster_rect *rect;
    bool final;
};

static void put_pixel(const struct output *o, uint32_t pixel, uint32_t bgr)
{
    if (!o->final) {
        o->t->surface[pixel].normal = bgr;
        o->t->surface[pixel].depth_slot &= ~(uint32_t)255;
        return;
    }
    uint32_t index = pixel / RASTER_TILE_WIDTH * o->rect->width + pixel % RASTER_TILE_WIDTH;
    uint32_t red = bgr & 255, green = bgr >> 8 & 255, blue = bgr >> 16 & 255;
    if (o->r->frame.format == RASTER_RGB565) {
        uint16_t *out = (uint16_t *)o->t->surface;
        /* nearest of 32 and 64 levels: (x * 31 + 127) / 255 without the division, exact for 0..255 */
        out[index] =
            (uint16_t)((red * 249 + 1014) >> 11 << 11 | (green * 253 + 505) >> 10 << 5 | (blue * 249 + 1014) >> 11);
    } else {
        uint8_t *out = (uint8_t *)o->t->surface + 3 * index;
        out[0] = (uint8_t)red;
        out[1] = (uint8_t)green;
        out[2] = (uint8_t)blue;
    }
}

/* Stereographic (u, v) in the meshlet's frame to a unit vector in eye space, Q15. k = 2/(1+s), n = (ku, kv, k-1):
 * of unit length by construction, whatever u and v were interpolated to. */
static struct vec3 decode_normal(const struct raster_slot *slot, uint32_t packed)
{
    int32_t u = (int16_t)(packed & 0xffff), v = (int16_t)(packed >> 16);                 /* Q14, |.| <= 2^14.1 */
    uint32_t s = (uint32_t)(u * u) + (uint32_t)(v * v);                                  /* Q28, <= 2.1 */
    int32_t k = (int32_t)((UINT32_MAX >> 1) / (((1u << 28) + s) >> 13));                 /* Q15, 0.64..2 */
    int32_t x = (u * k + (1 << 13)) >> 14, y = (v * k + (1 << 13)) >> 14, z = k - 32768; /* Q15 */
    const int16_t *f = slot->frame; /* Q14: sums <= sqrt(3) * 2^29 */
    return (struct vec3){(f[0] * x + f[1] * y + f[2] * z + (1 << 13)) >> 14,
                         (f[3] * x + f[4] * y + f[5] * z + (1 << 13)) >> 14,
                         (f[6] * x + f[7] * y + f[8] * z + (1 << 13)) >> 14};
}

/* Adds c * 2^e * irradiance to an accumulator with 20 fraction bits, saturating. c < 2^21, irradiance uq16_16. */
static inline uq12_20_t add_radiance(uq12_20_t sum, uint32_t c, int32_t e, uq16_16_t irradiance)
{
    uint64_t p = (uint64_t)c * irradiance; /* < 2^53; fraction bits: 16 - e, wanted: 20 */
    int32_t down = -e - 4;
    if (down >= 0)
        p = down > 63 ? 0 : p >> down;
    else
        p = down < -11 || p >> (64 + down) ? UINT64_MAX : p << -down;
    return fx_add_sat(sum, p > UINT32_MAX ? UINT32_MAX : (uint32_t)p);
}

static void shade_measured(const struct raster *r, struct raster_batch *b, const struct scene_material *m,
                           const struct raster_light *light, struct raster_stats *stats)
{
    const struct lut_table *table = r->frame.tables[m->slot];
    for (uint32_t i = 0; i < b->count; i++) {
        struct lut_rgb f;
        unsigned fetches = lut_eval(&f, table, b->normal[i], light->direction, b->view[i]);
        if (!fetches)
            continue;
        stats->fetches += fetches;
        stats->shaded++;
        for (int k = 0; k < 3; k++)
            b->radiance[i][k] = add_radiance(b->radiance[i][k], f.c[k], f.e, light->irradiance[k]);
    }
}

static void flush(const struct output *o, struct raster_batch *b, struct raster_stats *stats)
{
    const struct raster *r = o->r;
    const struct scene_material *m = &r->frame.materials[b->material];
    for (unsigned l = 0; l < r->frame.light_count; l++) {
        if (m->kind == SCENE_MATERIAL_MEASURED)
            shade_measured(r, b, m, &r->lights[l], stats);
        else
            stats->shaded += raster_shade_lafortune_phong(b, m, &r->lights[l]);
    }
    for (uint32_t i = 0; i < b->count; i++)
        put_pixel(o, b->pixel[i], raster_tone(b->radiance[i], r->frame.output->tone_curve));
    b->count = 0;
}

void raster_shade_tile(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect, bool final,
                       struct raster_stats *stats)
{
    const struct output o = {r, t, rect, final};
    const uint8_t *bg = r->frame.output->background;
    const uint32_t background = (uint32_t)(bg[0] | bg[1] << 8 | bg[2] << 16);
    struct raster_batch *b = &t->batch;
    b->count = 0;
    for (uint32_t y = 0; y < rect->height; y++)
        for (uint32_t x = 0; x < rect->width; x++) {
            uint32_t pixel = y * RASTER_TILE_WIDTH + x;
            const struct raster_surface s = t->surface[pixel];
            uint32_t slot = s.depth_slot & 255;
            if (!slot) { /* background, or shaded before */
                if (final) {
                    stats->covered += s.depth_slot != 0;
                    put_pixel(&o, pixel, s.depth_slot ? s.normal : background);
                }
                continue;
            }
            stats->covered += final;
            const struct raster_slot *info = &t->slots[slot];
            if (b->count == RASTER_BATCH || (b->count && b->material != info->material))
                flush(&o, b, stats);
            uint32_t i = b->count++;
            b->material = info->material;
            b->pixel[i] = (uint16_t)pixel;
            b->normal[i] = decode_normal(info, s.normal);
            b->view[i] = raster_view_vector(r, rect->x + x, rect->y + y);
            b->radiance[i][0] = b->radiance[i][1] = b->radiance[i][2] = 0;
        }
    if (b->count)
        flush(&o, b, stats);
}
