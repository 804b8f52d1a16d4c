/*
 * The end of a tile: what waits for it is shaded in runs of a row, pixels are packed and stored from the surface's start on. A pixel takes
 * 2 or 3 of the 8 bytes it had, so writing never overtakes reading.
 */
#include "shade.h"

/* Pixels of one value from the tile's `at`-th on, three words at a time. */
FX_NOINLINE static void fill_run(const struct shading *o, uint32_t at, uint32_t value, uint32_t count)
{
    const bool narrow = o->r->frame.format == RASTER_RGB565;
    const uint32_t group = narrow ? 6 : 4, first = fx_min_u(count, (narrow ? at : 0 - at) % (narrow ? 2 : 4));
    const uint32_t w[3] = {narrow ? value | value << 16 : value | value << 24,
                           narrow ? value | value << 16 : value >> 8 | value << 16,
                           narrow ? value | value << 16 : value >> 16 | value << 8};
    raster_put_pixels(o->r, o->t, at, &value, 0, first);
    at += first;
    count -= first;
    uint32_t *out = &o->t->surface->depth_slot + (narrow ? at / 2 : at / 4 * 3);
    for (; count >= group; count -= group, at += group, out += 3) {
        out[0] = w[0];
        out[1] = w[1];
        out[2] = w[2];
    }
    raster_put_pixels(o->r, o->t, at, &value, 0, count);
}

/* Shades a run of pixels of one slot into the batch's radiance, finished. A run is at most a row, thus a batch, long. */
static const uint32_t *shade_run(const struct shading *o, uint32_t slot, uint32_t x, uint32_t y, uint32_t count,
                                 struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    const struct raster_slot *info = &o->t->slots[slot];
    const struct raster_surface *s = o->t->surface + y * RASTER_TILE_WIDTH + x;
    raster_rows_of(&o->r->frame, &o->r->frame.materials[info->material])
        ->shade(b, o->r, info, s, o->x0 + x, o->y0 + y, count);
    raster_finish_pixels(b->radiance[0], b->radiance, count, o->r->frame.output->tone_curve, o->format);
    stats->samples += count;
    stats->tried += count * o->r->frame.light_count;
    stats->shaded += count * o->r->frame.light_count;
    if (o->r->frame.costs) {
        const struct raster_shading_cost *c =
            &o->r->frame.costs->shading[raster_shading_of(o->r, info->material, RASTER_RATE_1X1)];
        stats->cost += (uint64_t)count * (c->sample + o->r->frame.light_count * c->lit);
    }
    return b->radiance[0];
}

/* Pixels without a slot from x on: shaded before, or background. Returns where they end. */
static uint32_t plain_run(const struct shading *o, uint32_t background, uint32_t x, uint32_t y,
                          struct raster_stats *stats)
{
    const struct raster_surface *row = o->t->surface + y * RASTER_TILE_WIDTH, *s = row + x, *end = row + o->width;
    const uint32_t at = y * o->width;
    while (s != end && s->depth_slot && !raster_slot_of(s))
        s++;
    const uint32_t shaded = (uint32_t)(s - row);
    stats->covered += shaded - x;
    raster_put_pixels(o->r, o->t, at + x, &row[x].normal, 2, shaded - x);
    while (end - s >= 4 && !(s[0].depth_slot | s[1].depth_slot | s[2].depth_slot | s[3].depth_slot))
        s += 4;
    while (s != end && !s->depth_slot)
        s++;
    fill_run(o, at + shaded, background, (uint32_t)(s - row) - shaded);
    return (uint32_t)(s - row);
}

static void finish_rows(const struct shading *o, struct raster_stats *stats)
{
    const uint32_t background = raster_background(&o->r->frame, o->format);
    o->t->batch.diffuse_material = 0;
    for (uint32_t y = 0; y < o->height; y++) {
        const struct raster_surface *row = o->t->surface + y * RASTER_TILE_WIDTH;
        for (uint32_t x = 0; x < o->width;) {
            if (!raster_slot_of(&row[x])) {
                x = plain_run(o, background, x, y, stats);
                continue;
            }
            const uint32_t count = (uint32_t)(run_end(&row[x], row + o->width) - &row[x]);
            stats->covered += count;
            raster_put_pixels(o->r, o->t, y * o->width + x, shade_run(o, raster_slot_of(&row[x]), x, y, count, stats),
                              1, count);
            x += count;
        }
    }
}

void raster_tile_finish(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                        struct raster_stats *stats)
{
    const struct shading o = tile_shading(r, t, rect);
    if (t->memory)
        r->frame.parts->cells->remember(t);
    if (r->sample_shift)
        r->frame.parts->cells->finish(r, t, rect, stats);
    else
        finish_rows(&o, stats);
    if (r->frame.costs)
        stats->cost += (uint64_t)stats->covered * r->frame.costs->finished;
}

FX_COLD void raster_tile_free_slots(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                                    struct raster_stats *stats)
{
    const struct shading o = tile_shading(r, t, rect);
    if (t->memory)
        r->frame.parts->cells->remember(t);
    t->batch.diffuse_material = 0;
    for (uint32_t y = 0; y < o.height && !r->sample_shift; y++)
        for (uint32_t x = 0; x < o.width;) {
            struct raster_surface *s = &t->surface[y * RASTER_TILE_WIDTH + x];
            const uint32_t slot = raster_slot_of(s);
            const uint32_t count = slot ? (uint32_t)(run_end(s, s + o.width - x) - s) : 1;
            if (slot) {
                const uint32_t *value = shade_run(&o, slot, x, y, count, stats);
                for (uint32_t i = 0; i < count; i++)
                    raster_put_colour(&s[i], value[i]);
            }
            x += count;
        }
    t->slot_count = 0;
}
