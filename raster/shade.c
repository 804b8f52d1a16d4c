/*
 * Deferred shading of a tile, region by region and material by material. Surfaces of one material are gathered block by block
 * (block.h) into a batch, which is lit by every light, tone mapped and packed, and whose colours take the surfaces' place. What is gathered
 * is every sample, or what cells.c makes of them.
 */
#include "shade.h"

#include "func.h"

/* Keeps it below 2^31. */
FX_NOINLINE static void limit_radiance(struct raster_batch *b)
{
    for (uint32_t *c = b->radiance[0], *end = b->radiance[b->count]; c != end; c++)
        *c = *c < INT32_MAX ? *c : INT32_MAX;
}

void raster_flush(const struct shading *o, struct raster_block *k, struct raster_stats *stats)
{
    const struct raster *r = o->r;
    struct raster_batch *b = &o->t->batch;
    const struct scene_material *m = &r->frame.materials[o->material];
    static const uint8_t texels[RASTER_TAPS_COUNT] = {8, 4, 1};
    struct raster_shading_cost c = {0};
    const bool table = o->model->shading == RASTER_SHADE_HALF_VECTOR;
    uint32_t lit = 0;
    if (!b->count)
        return;
    if (r->frame.costs)
        c = raster_shading_cost_of(r, o->model->shading, (enum raster_taps)b->taps);
    uint64_t cost = (uint64_t)b->count * c.sample;
    __builtin_memset(b->radiance, 0, b->count * sizeof b->radiance[0]);
    unsigned added = 0;
    for (unsigned l = 0; l < r->frame.light_count; l++) {
        if (!(o->t->light_chosen[l / 32] >> l % 32 & 1))
            continue;
        const bool planes = !r->lights[l].radius && !k->exact;
        if (planes && (l >= RASTER_BLOCK_LIGHTS || !(k->ready >> l & 1)))
            cost += c.material;
        const uint32_t lit_by = raster_shade_light(o->t, k, r, o->x0, o->y0, l, o->model);
        lit += lit_by;
        stats->tried += b->count;
        cost += planes ? lit_by * c.lit + (b->count - lit_by) * c.dark : b->count * c.point; /* 2^6 2^20 */
        if (++added % 16 == 0) /* sums of 2^31 and RASTER_LIGHT_LIMIT */
            limit_radiance(b);
    }
    if (added > 16)
        limit_radiance(b);
    stats->samples += b->count;
    stats->shaded += lit;
    stats->cost += cost;
    if (m->kind == SCENE_MATERIAL_MEASURED)
        stats->fetches += (table ? texels[b->taps] : 8u) * lit;
    if (o->model->ambient)
        o->model->ambient(b, m, r->frame.output->exposure);
    uint32_t *value = b->radiance[0]; /* a pixel's value takes less room than its radiance */
    raster_finish_pixels(value, b->radiance, b->count, r->frame.output->tone_curve, o->format);
    if (o->pass != PASS_PIXELS || r->sample_shift || o->t->memory)
        r->frame.parts->cells->put(o, value);
    else
        for (uint32_t i = 0; i < b->count; i++)
            raster_put_colour(&o->t->surface[b->surface[i]], value[i]);
    b->count = 0;
}

struct vec3 raster_face_viewer(struct vec3 n, struct vec3 v, int32_t nv)
{
    const int32_t lift = 32768 / 128 - (nv >> 15);
    n = (struct vec3){n.x + (v.x * lift >> 15), n.y + (v.y * lift >> 15), n.z + (v.z * lift >> 15)};
    unsigned shift;
    uint32_t m = lut_rsqrt((uint32_t)fx_max(fx_dot(n, n), 1), &shift);
    int32_t k = (int32_t)(m >> shift); /* 2^30 / |n|: its product with a component of n is at most 2^30 */
    return (struct vec3){n.x * k >> 15, n.y * k >> 15, n.z * k >> 15};
}

#ifdef RASTER_WIDE
/* As many as eight of a batch's pixels, from p on, to the first that is to be turned to the viewer, from `count` surfaces of one slot side
 * by side. Returns how many: none where there is no room for eight. */
static uint32_t set_eight(struct raster_batch_pixel *p, const struct raster_tile *t, const struct raster_block *k,
                          const struct raster_surface *s, uint32_t count, struct vec3 view, uint32_t at, bool facing)
{
    const int32_t wide_view[3] = {view.x, view.y, view.z};
    if (count < 3 || s + 8 > t->surface + RASTER_TILE_PIXELS || p + 8 > t->batch.pixel + RASTER_BATCH)
        return 0;
    const uint32_t away = raster_gather_wide(p, s, &t->slots[raster_slot_of(s)], wide_view, k->plane, at);
    count = count < 8 ? count : 8;
    for (uint32_t i = 0; i < count; i++)
        if (facing && away >> 4 * i & 1)
            return i;
    return count;
}
#endif

/* Adds surfaces of one slot side by side to the block's batch, from pixel (x, y) of the block on; more than one only where the block is not
 * exact, and no more than a batch has room for. */
static void gather_run(const struct shading *o, struct raster_block *k, uint32_t x, uint32_t y,
                       const struct raster_surface *s, const struct raster_surface *end, struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    const struct raster_slot *slot = &o->t->slots[raster_slot_of(s)];
    const unsigned normal_shift = slot->normal_shift;
    const bool facing = o->model->facing;
    struct vec3 view = block_view(o, k, x, y);
    if (b->count + (uint32_t)(end - s) > RASTER_BATCH)
        raster_flush(o, k, stats);
    for (uint32_t i = 0, count = (uint32_t)(end - s); i < count; i++)
        b->surface[b->count + i] = (uint32_t)(s - o->t->surface) + i;
    struct raster_batch_pixel *p = &b->pixel[b->count];
    b->count += (uint32_t)(end - s);
    for (uint32_t at = x | y << 8; s != end; s++, p++, at++) {
#ifdef RASTER_WIDE
        const uint32_t eight = set_eight(p, o->t, k, s, (uint32_t)(end - s), view, at, facing);
        if (eight) {
            view = view_after(view, k, eight);
            s += eight - 1;
            p += eight - 1;
            at += eight - 1;
            continue;
        }
#endif
        set_pixel(p, slot->frame, normal_shift, facing, *s, view, at);
        view = view_after(view, k, 1);
    }
}

/* A block's row of pixels, each shaded by itself. */
static void gather_row(struct shading *o, struct raster_block *k, uint32_t y, uint32_t width,
                       struct raster_stats *stats)
{
    const struct raster_surface *row = &o->t->surface[(k->y + y) * RASTER_TILE_WIDTH + k->x], *next;
    for (const struct raster_surface *s = row, *end = row + width; s != end; s = next) {
        next = run_end(s, end);
        if (is_wanted(o, raster_slot_of(s)))
            gather_run(o, k, (uint32_t)(s - row), y, s, next, stats);
    }
}

static void shade_block(struct shading *o, uint32_t x, uint32_t y, unsigned shift, bool exact,
                        struct raster_stats *stats)
{
    const uint32_t edge = 1u << shift, right = o->width - x, below = o->height - y;
    const uint32_t width = right < edge ? right : edge, height = below < edge ? below : edge;
    struct raster_block *k = o->block;
    raster_block_setup(k, o->r, o->x0, o->y0, x, y, shift, exact);
    if (o->pass == PASS_CELLS || o->r->sample_shift)
        o->r->frame.parts->cells->gather(o, k, width, height, stats);
    else
        for (uint32_t i = 0; i < height; i++)
            gather_row(o, k, i, width, stats);
    raster_flush(o, k, stats);
}

/* A region, in smaller blocks where planes do not hold: in Z order, each as large as its place allows and no smaller than a cell. */
static void shade_region(struct shading *o, uint32_t x0, uint32_t y0, struct raster_stats *stats)
{
    const unsigned least = o->pass == PASS_CELLS ? o->least : 0,
                   most = o->r->block_shift > least ? o->r->block_shift : least;
    unsigned shift;
    stats->cost += o->r->frame.costs ? o->r->frame.costs->region : 0;
    for (uint32_t z = 0; z < 1u << 2 * RASTER_BLOCK_SHIFT; z += 1u << 2 * shift) {
        uint32_t x = x0, y = y0;
        bool exact = true;
        for (unsigned i = 0; i < RASTER_BLOCK_SHIFT; i++) {
            x += (z >> 2 * i & 1) << i;
            y += (z >> (2 * i + 1) & 1) << i;
        }
        shift = most;
        while (z & ((1u << 2 * shift) - 1))
            shift--;
        if (x >= o->width || y >= o->height)
            continue;
        for (; shift > 0; shift--) {
            exact = shift > o->r->block_shift || !raster_block_regular(o->r, o->x0 + x, o->y0 + y, shift);
            if (!exact || shift == least)
                break;
        }
        shade_block(o, x, y, shift, exact, stats);
    }
}

/* That of the region's first surface that waits for blocks; 0: there is none. */
FX_NOINLINE static uint32_t find_slot(const struct shading *o, uint32_t x0, uint32_t y0)
{
    const unsigned shift = o->r->sample_shift;
    const uint32_t edge = 1u << RASTER_REGION_SHIFT, right = o->width - x0 < edge ? o->width : x0 + edge,
                   below = o->height - y0 < edge ? o->height : y0 + edge;
    for (uint32_t y = y0 << shift; y < below << shift; y++) {
        const struct raster_surface *row = o->t->surface + y * RASTER_TILE_WIDTH;
        for (uint32_t x = x0 << shift; x < right << shift; x++)
            if (raster_slot_of(&row[x]) && !waits_for_rows(o, &o->t->slots[raster_slot_of(&row[x])]))
                return raster_slot_of(&row[x]);
    }
    return 0;
}

void raster_tile_shade(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect, uint32_t region,
                       const struct raster_quality *q, struct raster_stats *stats)
{
    const uint32_t columns = RASTER_REGIONS(rect->width), x = region % columns << RASTER_REGION_SHIFT,
                   y = region / columns << RASTER_REGION_SHIFT;
    struct raster_block block;
    struct shading o = tile_shading(r, t, rect);
    o.block = &block;
    o.quality = q;
    block.shift = RASTER_BLOCK_SHIFT + 1; /* none */
    block.material = UINT32_MAX;
    block.scaled = false;
    t->batch.count = 0;
    t->batch.taps = r->frame.parts->fewer_taps ? q->taps : RASTER_TAPS_8;
    raster_choose_lights(r, t, q->lights);
    for (o.other = find_slot(&o, x, y); o.other;) {
        set_material(&o, t->slots[o.other].material);
        o.pass = pass_of(&o, &t->slots[o.other]);
        o.other = 0;
        if (o.pass == PASS_CELLS || r->sample_shift)
            r->frame.parts->cells->choose(&o);
        if (o.pass == PASS_FLAT)
            r->frame.parts->cells->flat(&o, x, y, stats);
        else
            shade_region(&o, x, y, stats);
    }
}

void raster_shade_regions(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                          struct raster_stats *stats)
{
    static const struct raster_quality full = {.lights = RASTER_ALL_LIGHTS};
    bool any = false;
    for (uint32_t i = 1; i <= t->slot_count; i++)
        any |= !r->in_rows[t->slots[i].material];
    if (!any)
        return;
    raster_find_lights(r, t, rect);
    for (uint32_t i = 0; i < RASTER_REGIONS(rect->width) * RASTER_REGIONS(rect->height); i++)
        raster_tile_shade(r, t, rect, i, &full, stats);
}

void raster_shade_tile(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                       struct raster_stats *stats)
{
    raster_shade_regions(r, t, rect, stats);
    raster_tile_finish(r, t, rect, stats);
}
