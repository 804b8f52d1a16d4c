/*
 * Sixteen samples at a time, by the slots that they show: pixels of 4 samples, and rates of shading (quality.h), which evaluate one for each
 * meshlet in a cell of samples, or one for each meshlet.
 */
#include "shade.h"

#define FLAT_KNOWN 0x80000000u
#define FLAT_SOON  1u

#define PLACE(y, x)  ((y)*RASTER_TILE_WIDTH + (x))
#define PLACES(y, x) PLACE(y, x), PLACE(y, (x) + 1), PLACE(y, (x) + 2), PLACE(y, (x) + 3)
static const uint16_t places[3][16] = {{PLACES(0, 0), PLACES(0, 4), PLACES(0, 8), PLACES(0, 12)},
                                       {PLACES(0, 0), PLACES(0, 4), PLACES(1, 0), PLACES(1, 4)},
                                       {PLACES(0, 0), PLACES(1, 0), PLACES(2, 0), PLACES(3, 0)}};

/* The first slot in words of four; 0: there is none. */
static inline uint32_t first_slot(const uint32_t word[4])
{
    const uint32_t w = word[0] ? word[0] : word[1] ? word[1] : word[2] ? word[2] : word[3];
    return w ? w >> (24 - (fx_clz(w) & 24u)) : 0;
}

/* Removes a slot from a word of four; returns where it was, the highest bits of a mask. */
static inline uint32_t mask_four(uint32_t *word, uint32_t slot)
{
    const uint32_t differs = raster_slots_differ(*word, slot);
    *word &= differs - (differs >> 7);
    return (differs ^ 128 * EACH_SLOT) * ((1u << 21) + (1u << 14) + (1u << 7) + 1) & 0xf0000000u;
}

static inline uint32_t mask_slot(uint32_t word[4], uint32_t slot)
{
    const uint32_t low = mask_four(&word[2], slot) | mask_four(&word[3], slot) >> 4,
                   high = mask_four(&word[0], slot) | mask_four(&word[1], slot) >> 4;
    return high | low >> 8;
}

/* Samples in columns left .. right-1 and rows 0 .. below-1. */
static uint32_t mask_inside(const struct shading *o, uint32_t left, uint32_t right, uint32_t below)
{
    const uint32_t row = (UINT32_MAX >> left) & ~(UINT32_MAX >> fx_min_u(right, 1u << o->wide));
    uint32_t mask = 0;
    for (uint32_t y = 0; y < fx_min_u(below, 16u >> o->wide); y++)
        mask |= row >> (y << o->wide);
    return mask;
}

/* The mean of a whole cell's corners, which for one triangle is that of all its samples. */
static inline struct raster_surface cell_mean(const struct shading *o, const struct raster_surface *a)
{
    const struct raster_surface *b = a + (1 << o->cell_x) - 1, *c = a + PLACE((1 << o->cell_y) - 1, 0),
                                *d = c + (b - a);
    return (struct raster_surface){
        ((a->depth_slot >> 8) + (b->depth_slot >> 8) + (c->depth_slot >> 8) + (d->depth_slot >> 8) + 2) >> 2 << 8,
        lanes((lane_low(a->normal) + lane_low(b->normal) + lane_low(c->normal) + lane_low(d->normal) + 2) >> 2,
              (lane_high(a->normal) + lane_high(b->normal) + lane_high(c->normal) + lane_high(d->normal) + 2) >> 2)};
}

/* The mean of a mask's. */
static inline struct raster_surface mask_mean(const struct shading *o, const struct raster_surface *first,
                                              uint32_t mask)
{
    uint32_t u = 0, v = 0, depth = 0, count = 0; /* u and v 2^15 more each at last, so that division rounds one way */
    do {
        const uint32_t i = fx_clz(mask);
        const struct raster_surface *s = &first[o->place[i]];
        mask &= ~(0x80000000u >> i);
        u += (uint32_t)lane_low(s->normal);
        v += (uint32_t)lane_high(s->normal);
        depth += s->depth_slot >> 8;
        count++;
    } while (mask);
    const uint32_t half = count / 2, offset = (count << 15) + half;
    return (struct raster_surface){(depth + half) / count << 8, lanes((int32_t)((u + offset) / count - 32768),
                                                                      (int32_t)((v + offset) / count - 32768))};
}

/* A slot's samples of sixteen from surface `first` on, a cell at a time; the first cell's middle is at pixel (x0, y) of the block, `row_view`
 * at (0, y). */
static inline void gather_masked(const struct shading *o, struct raster_block *k, uint32_t first, uint32_t mask,
                                 uint32_t slot, uint32_t x0, uint32_t y, struct vec3 row_view,
                                 struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    const struct raster_slot *info = &o->t->slots[slot];
    const struct raster_surface *s = &o->t->surface[first];
    do {
        const uint32_t i = fx_clz(mask), before = (i & ((1u << o->wide) - 1)) >> o->cell_x << o->cell_x,
                       cell = o->cell >> before, part = mask & cell, x = x0 + (before >> o->r->sample_shift);
        struct raster_surface mean = s[o->place[i]];
        mask -= part;
        if (o->mean && part == cell)
            mean = cell_mean(o, &s[before]);
        else if (o->mean && part & (part - 1))
            mean = mask_mean(o, s, part);
        if (b->count == RASTER_BATCH)
            raster_flush(o, k, stats);
        b->surface[b->count] = part | (first + o->place[i]);
        set_pixel(&b->pixel[b->count++], info->frame, info->normal_shift, o->model->facing, mean,
                  k->exact ? block_view(o, k, x, y) : view_after(row_view, k, x), x | y << 8);
    } while (mask);
}

/* A block's samples, sixteen at a time, by the slots that they show. */
static void gather_cells(struct shading *o, struct raster_block *k, uint32_t width, uint32_t height,
                         struct raster_stats *stats)
{
    const unsigned shift = o->r->sample_shift;
    const uint32_t left = k->x << shift, right = (k->x + width) << shift, below = (k->y + height) << shift,
                   columns = 1u << o->wide, rows = 16u >> o->wide, middle_x = ((1u << o->cell_x) - 1) >> 1,
                   middle_y = ((1u << o->cell_y) - 1) >> 1;
    for (uint32_t y = k->y << shift; y < below; y += rows) {
        const uint32_t pixel_y = ((y + middle_y) >> shift) - k->y;
        const struct vec3 view = block_view(o, k, 0, pixel_y);
        for (uint32_t x = left & ~(columns - 1); x < right; x += columns) {
            const uint32_t first = y * RASTER_TILE_WIDTH + x;
            const struct raster_surface *s = &o->t->surface[first];
            uint32_t inside = 0xffff0000u, slot,
                     word[4] = {raster_four_slots(s), raster_four_slots(s + o->place[4]),
                                raster_four_slots(s + o->place[8]), raster_four_slots(s + o->place[12])};
            if (x < left || x + columns > right || y + rows > below)
                inside = mask_inside(o, x < left ? left - x : 0, right - x, below - y);
            while ((slot = first_slot(word)) != 0) {
                const uint32_t mask = mask_slot(word, slot) & inside;
                if (mask && is_wanted(o, slot))
                    gather_masked(o, k, first, mask, slot, ((x + middle_x) >> shift) - k->x, pixel_y, view, stats);
            }
        }
    }
}

/* The cells of the rate, in samples: none where every pixel is shaded, and has one. */
static void choose_cells(struct shading *o)
{
    const enum raster_rate rate = o->rate;
    o->flat = rate == RASTER_RATE_FLAT;
    o->mean = rate != RASTER_RATE_1X1;
    o->cell_x = o->cell_y = 0;
    /* Before the last meshlet is drawn, every sample is shaded by itself: which of a pixel's is seen may change. */
    if (!o->flat && (o->mean || !o->t->run)) {
        o->cell_x = raster_cell_shift(o->r, rate, 0);
        o->cell_y = raster_cell_shift(o->r, rate, 1);
    }
    o->wide = 4 - o->cell_y;
    o->place = places[o->cell_y];
    o->cell = 0;
    for (uint32_t y = 0; y < 1u << o->cell_y && !o->flat && (o->mean || o->r->sample_shift); y++)
        o->cell |= ~(UINT32_MAX >> (1u << o->cell_x)) >> (y << o->wide);
}

/* Whether a slot is of rate flat. Takes note of others. */
static inline bool is_flat(struct shading *o, uint32_t slot)
{
    if (!slot)
        return false;
    const struct raster_slot *info = &o->t->slots[slot];
    if (o->quality->rate[info->class_id] == RASTER_RATE_FLAT)
        return true;
    if (!waits_for_rows(o, info))
        o->other = slot;
    return false;
}

/* Samples meshlets that were met, each material's in turn. */
static void sample_flat(struct shading *o, uint8_t *slot, uint32_t count, struct raster_stats *stats)
{
    const struct raster_surface axis = {0, 0};
    struct raster_batch *b = &o->t->batch;
    struct raster_block *k = o->block;
    const struct vec3 view = block_view(o, k, 0, 0);
    while (count) {
        uint32_t others = 0;
        set_material(o, o->t->slots[slot[0]].material);
        for (uint32_t i = 0; i < count; i++) {
            const struct raster_slot *info = &o->t->slots[slot[i]];
            const uint32_t index = o->t->m.shading.flat[slot[i]] - FLAT_SOON, shift = o->r->sample_shift;
            const uint32_t x = (index % RASTER_TILE_WIDTH >> shift) - k->x,
                           y = (index / RASTER_TILE_WIDTH >> shift) - k->y;
            if (info->material != o->material) {
                slot[others++] = slot[i];
                continue;
            }
            if (b->count == RASTER_BATCH)
                raster_flush(o, k, stats);
            b->surface[b->count] = index;
            set_pixel(&b->pixel[b->count++], info->frame, info->normal_shift, o->model->facing, axis, view, x | y << 8);
        }
        raster_flush(o, k, stats);
        count = others;
    }
}

/* Every meshlet of the region by its frame's z axis, which is about its mean normal, seen from the region's middle; once in the tile. */
static void shade_flat(struct shading *o, uint32_t x0, uint32_t y0, struct raster_stats *stats)
{
    const unsigned shift = o->r->sample_shift;
    const uint32_t edge = 1u << RASTER_REGION_SHIFT, right = o->width - x0 < edge ? o->width : x0 + edge,
                   below = o->height - y0 < edge ? o->height : y0 + edge;
    uint32_t *flat = o->t->m.shading.flat, count;
    raster_block_setup(o->block, o->r, o->x0, o->y0, x0, y0, 0, false);
    stats->cost += o->r->frame.costs ? o->r->frame.costs->flat : 0;
    do {
        uint8_t met[RASTER_SLOTS];
        count = 0;
        for (uint32_t y = y0 << shift; y < below << shift; y++) {
            struct raster_surface *s = &o->t->surface[y * RASTER_TILE_WIDTH + (x0 << shift)];
            for (const struct raster_surface *end = s + ((right - x0) << shift); s != end;) {
                const uint32_t slot = raster_slot_of(s);
                if (is_flat(o, slot)) {
                    const uint32_t colour = flat[slot];
                    if (colour & FLAT_KNOWN) {
                        do
                            raster_put_colour(s++, colour & ~FLAT_KNOWN);
                        while (s != end && raster_slot_of(s) == slot);
                        continue;
                    }
                    if (!colour) {
                        flat[slot] = FLAT_SOON + (uint32_t)(s - o->t->surface);
                        met[count++] = (uint8_t)slot;
                    }
                }
                s += run_end(s, end) - s;
            }
        }
        sample_flat(o, met, count, stats);
    } while (count);
}

/* The same for all samples of a cell's mask, of which `index` is the first. */
static inline void put_cell(const struct shading *o, uint32_t index, uint32_t mask, uint32_t value)
{
    struct raster_surface *s = &o->t->surface[index];
    if (mask == o->cell >> fx_clz(mask) && o->cell_x) {
        for (const struct raster_surface *end = s + PLACE(1 << o->cell_y, 0); s != end; s += PLACE(1, 0)) {
            raster_put_colour(&s[0], value);
            raster_put_colour(&s[1], value);
            if (o->cell_x == 1)
                continue;
            raster_put_colour(&s[2], value);
            raster_put_colour(&s[3], value);
        }
        return;
    }
    s -= o->place[fx_clz(mask)];
    do {
        const uint32_t i = fx_clz(mask);
        mask &= ~(0x80000000u >> i);
        raster_put_colour(&s[o->place[i]], value);
    } while (mask);
}

/* Keeps the range of a meshlet's green. */
static void note_values(const struct shading *o, const uint32_t *value)
{
    const struct raster_batch *b = &o->t->batch;
    for (uint32_t i = 0; i < b->count; i++) {
        const uint32_t slot = raster_slot_of(&o->t->surface[b->surface[i] & 0xffff]);
        const uint8_t green = (uint8_t)(o->format == RASTER_RGB565 ? value[i] >> 5 << 2 : value[i] >> 8);
        uint8_t *low = &o->t->m.shading.low[slot], *high = &o->t->m.shading.high[slot];
        *low = green < *low ? green : *low;
        *high = green > *high ? green : *high;
    }
}

static void put_values(const struct shading *o, const uint32_t *value)
{
    const struct raster_batch *b = &o->t->batch;
    if (o->t->memory && !o->flat)
        note_values(o, value);
    if (o->flat)
        for (uint32_t i = 0; i < b->count; i++)
            o->t->m.shading.flat[raster_slot_of(&o->t->surface[b->surface[i] & 0xffff])] = value[i] | FLAT_KNOWN;
    else if (o->cell)
        for (uint32_t i = 0; i < b->count; i++)
            put_cell(o, b->surface[i] & 0xffff, b->surface[i] & 0xffff0000u, value[i]);
    else
        for (uint32_t i = 0; i < b->count; i++)
            raster_put_colour(&o->t->surface[b->surface[i]], value[i]);
}

/* Four sums of bytes fit ten bits each. */
static inline uint32_t spread(uint32_t bgr)
{
    return (bgr & 0xff) | (bgr & 0xff00) << 2 | (bgr & 0xff0000) << 4;
}

/* The mean of each pixel's four samples. */
static void finish_samples(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                           struct raster_stats *stats)
{
    const uint32_t background = raster_background(&r->frame, RASTER_RGB888);
    for (uint32_t y = 0; y < rect->height; y++)
        for (uint32_t x = 0; x < rect->width; x++) {
            const struct raster_surface *s = &t->surface[2 * y * RASTER_TILE_WIDTH + 2 * x];
            uint32_t sum = 0x00200802u, covered = 0; /* 2 in each, to round */
            for (int i = 0; i < 4; i++) {
                const struct raster_surface *sample = s + (i & 1) + (i >> 1) * RASTER_TILE_WIDTH;
                sum += spread(sample->depth_slot ? sample->normal : background);
                covered |= sample->depth_slot;
            }
            stats->covered += covered != 0;
            uint32_t bgr = (sum >> 2 & 0xff) | (sum >> 4 & 0xff00) | (sum >> 6 & 0xff0000);
            raster_store_pixel(r, t, y * rect->width + x, raster_pack(bgr, r->frame.format));
        }
}

const struct raster_cells raster_cells = {
    choose_cells, gather_cells, shade_flat, put_values, finish_samples, raster_strongest_lights, raster_remember};
