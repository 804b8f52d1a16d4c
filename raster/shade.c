/*
 * Deferred shading of a tile, row by row in runs of one meshlet. Pixels of one material are gathered into batches, each
 * batch is lit by every light, tone mapped and packed; a material that does not depend on the view is shaded run by run.
 * Finished pixels overwrite the surface from its start: a pixel takes 2 or 3 of the 8 bytes it had, so writing never
 * overtakes reading.
 */
#include "internal.h"

struct output {
    const struct raster *r;
    struct raster_tile *t;
    const struct raster_rect *rect;
    bool final;
};

/* `value`: a finished pixel. */
static inline void put_pixel(const struct output *o, uint32_t x, uint32_t y, uint32_t value)
{
    if (!o->final) {
        struct raster_surface *s = &o->t->surface[y * RASTER_TILE_WIDTH + x];
        s->normal = value;
        s->depth_slot &= ~(uint32_t)255;
        return;
    }
    uint32_t index = y * o->rect->width + x;
    if (o->r->frame.format == RASTER_RGB565) {
        ((uint16_t *)o->t->surface)[index] = (uint16_t)value;
    } else {
        uint8_t *out = (uint8_t *)o->t->surface + 3 * index;
        out[0] = (uint8_t)value;
        out[1] = (uint8_t)(value >> 8);
        out[2] = (uint8_t)(value >> 16);
    }
}

/* A run of finished pixels. */
static void put_run(const struct output *o, uint32_t x, uint32_t y, const uint32_t *values, uint32_t count)
{
    if (o->final && o->r->frame.format == RASTER_RGB565) {
        uint16_t *out = (uint16_t *)o->t->surface + y * o->rect->width + x;
        for (const uint32_t *end = values + count; values != end; values++)
            *out++ = (uint16_t)*values;
        return;
    }
    for (uint32_t i = 0; i < count; i++)
        put_pixel(o, x + i, y, values[i]);
}

/* A surface's normal in eye space, Q15: of unit length by construction, whatever its coordinates were interpolated to. */
static struct vec3 eye_normal(const struct raster_slot *slot, const struct raster_surface *s)
{
    struct raster_normal n = raster_decode_normal(s, slot->normal_shift);
    int32_t x = (n.u * n.m + (1 << 12)) >> 13, y = (n.v * n.m + (1 << 12)) >> 13;
    int32_t z = ((n.d * n.m + (1 << 12)) >> 13) - 32768;
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
    return fx_add_sat(sum, fx_sat31(p));
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

static void flush(const struct output *o, struct raster_stats *stats)
{
    const struct raster *r = o->r;
    struct raster_batch *b = &o->t->batch;
    const struct scene_material *m = &r->frame.materials[b->material];
    for (unsigned l = 0; l < r->frame.light_count; l++) {
        if (m->kind == SCENE_MATERIAL_MEASURED)
            shade_measured(r, b, m, &r->lights[l], stats);
        else
            stats->shaded += raster_shade_lafortune_phong(b, m, &r->lights[l]);
    }
    uint32_t *value = b->radiance[0]; /* a pixel's value takes less room than its radiance */
    raster_finish_pixels(value, &r->frame, b->radiance, b->count);
    for (uint32_t i = 0; i < b->count; i++)
        put_pixel(o, b->pixel[i] % RASTER_TILE_WIDTH, b->pixel[i] / RASTER_TILE_WIDTH, value[i]);
    b->count = 0;
}

/* A run of `count` pixels of one slot, for a material that needs the view. */
static void gather_run(const struct output *o, const struct raster_slot *slot, uint32_t x, uint32_t y, uint32_t count,
                       struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    if (b->count && b->material != slot->material)
        flush(o, stats);
    b->material = slot->material;
    for (uint32_t end = x + count; x < end; x++) {
        if (b->count == RASTER_BATCH)
            flush(o, stats);
        uint32_t i = b->count++, pixel = y * RASTER_TILE_WIDTH + x;
        b->pixel[i] = (uint16_t)pixel;
        b->normal[i] = eye_normal(slot, &o->t->surface[pixel]);
        b->view[i] = raster_view_vector(o->r, o->rect->x + x, o->rect->y + y);
        b->radiance[i][0] = b->radiance[i][1] = b->radiance[i][2] = 0;
    }
}

/* The same for a diffuse material, which needs no batch of its own: runs go through the batch's radiance. A run is at most a
 * row, thus a batch, long. */
static void diffuse_run(const struct output *o, const struct raster_slot *slot, uint32_t x, uint32_t y, uint32_t count,
                        struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    if (b->count)
        flush(o, stats);
    raster_shade_diffuse(b, o->r, slot, o->t->surface + y * RASTER_TILE_WIDTH + x, count);
    raster_finish_pixels(b->radiance[0], &o->r->frame, b->radiance, count);
    put_run(o, x, y, b->radiance[0], count);
    stats->shaded += count * o->r->frame.light_count;
}

/* Pixels without a slot from x on: background, or shaded before. Returns where they end. */
static uint32_t plain_run(const struct output *o, uint32_t background, uint32_t x, uint32_t y,
                          struct raster_stats *stats)
{
    const struct raster_surface *row = o->t->surface + y * RASTER_TILE_WIDTH;
    const uint32_t width = o->rect->width;
    if (!o->final) {
        while (x < width && !(row[x].depth_slot & 255))
            x++;
        return x;
    }
    for (; x < width && row[x].depth_slot && !(row[x].depth_slot & 255); x++, stats->covered++)
        put_pixel(o, x, y, row[x].normal);
    if (o->r->frame.format == RASTER_RGB565) {
        uint16_t *out = (uint16_t *)o->t->surface + y * width + x;
        for (; x < width && !row[x].depth_slot; x++)
            *out++ = (uint16_t)background;
    } else {
        for (; x < width && !row[x].depth_slot; x++)
            put_pixel(o, x, y, background);
    }
    return x;
}

void raster_shade_tile(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect, bool final,
                       struct raster_stats *stats)
{
    const struct output o = {r, t, rect, final};
    const uint32_t background = raster_background(&r->frame);
    t->batch.count = 0;
    t->batch.diffuse_material = 0;
    for (uint32_t y = 0; y < rect->height; y++) {
        const struct raster_surface *row = t->surface + y * RASTER_TILE_WIDTH;
        for (uint32_t x = 0; x < rect->width;) {
            uint32_t slot = row[x].depth_slot & 255, count = 1;
            if (!slot) {
                x = plain_run(&o, background, x, y, stats);
                continue;
            }
            while (x + count < rect->width && (row[x + count].depth_slot & 255) == slot)
                count++;
            stats->covered += final ? count : 0;
            const struct raster_slot *info = &t->slots[slot];
            if (raster_is_diffuse(&r->frame.materials[info->material]))
                diffuse_run(&o, info, x, y, count, stats);
            else
                gather_run(&o, info, x, y, count, stats);
            x += count;
        }
    }
    if (t->batch.count)
        flush(&o, stats);
}
