/*
 * Sixteen samples at a time, by the slots that they show: pixels of 4 samples, and rates of shading (quality.h), which evaluate one for each
 * meshlet in a cell of samples, or one for each meshlet.
 */
#include "shade.h"

#define FLAT_KNOWN 0x80000000u
#define FLAT_SOON  1u

#define PLACE(y, x) ((y)*RASTER_TILE_WIDTH + (x))
#define PLACES(y)   PLACE(y, 0), PLACE(y, 1), PLACE(y, 2), PLACE(y, 3)

/* Of sixteen samples, four by four; in masks the first is the highest bit. */
static const uint16_t place[16] = {PLACES(0), PLACES(1), PLACES(2), PLACES(3)};
#define ALL 0xffff0000u

/* The first slot in words of four; 0: there is none. */
static inline uint32_t first_slot(const uint32_t word[4])
{
    const uint32_t w = word[0] ? word[0] : word[1] ? word[1] : word[2] ? word[2] : word[3];
    return w ? raster_first_slot(w) : 0;
}

/* Removes a slot from a word of four; returns where it was, the highest bits of a mask. */
static inline uint32_t mask_four(uint32_t *word, uint32_t slot)
{
    const uint32_t differs = raster_slots_differ(*word, slot);
    *word = raster_keep_slots(*word, differs);
    return (differs ^ 128 * EACH_SLOT) * ((1u << 21) + (1u << 14) + (1u << 7) + 1) & 0xf0000000u;
}

static inline uint32_t mask_slot(uint32_t word[4], uint32_t slot)
{
    const uint32_t low = mask_four(&word[2], slot) | mask_four(&word[3], slot) >> 4,
                   high = mask_four(&word[0], slot) | mask_four(&word[1], slot) >> 4;
    return high | low >> 8;
}

/* Samples in columns left .. right-1 and rows above .. below-1. */
static uint32_t mask_inside(uint32_t left, uint32_t right, uint32_t above, uint32_t below)
{
    const uint32_t row = (UINT32_MAX >> left) & ~(UINT32_MAX >> fx_min_u(right, 4));
    uint32_t mask = 0;
    for (uint32_t y = above; y < fx_min_u(below, 4); y++)
        mask |= row >> 4 * y;
    return mask;
}

/* The mean of a whole cell's corners, which for one triangle is that of all its samples. */
static inline struct raster_surface cell_mean(const struct shading_cell *cell, const struct raster_surface *a)
{
    const struct raster_surface *b = a + (1 << cell->x) - 1, *c = a + PLACE((1 << cell->y) - 1, 0), *d = c + (b - a);
    return (struct raster_surface){
        ((a->depth_slot >> 8) + (b->depth_slot >> 8) + (c->depth_slot >> 8) + (d->depth_slot >> 8) + 2) >> 2 << 8,
        lanes((lane_low(a->normal) + lane_low(b->normal) + lane_low(c->normal) + lane_low(d->normal) + 2) >> 2,
              (lane_high(a->normal) + lane_high(b->normal) + lane_high(c->normal) + lane_high(d->normal) + 2) >> 2)};
}

/* The mean of a mask's. */
static inline struct raster_surface mask_mean(const struct raster_surface *first, uint32_t mask)
{
    uint32_t u = 0, v = 0, depth = 0, count = 0; /* u and v 2^15 more each at last, so that division rounds one way */
    do {
        const uint32_t i = fx_clz(mask);
        const struct raster_surface *s = &first[place[i]];
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

/* A slot's samples of sixteen from (x0, y0) of the tile on, a cell at a time, all in pixel row y of the block, as rows never fall in a batch;
 * `row_view` at (0, y). */
static inline void gather_masked(const struct shading *o, struct raster_block *k, uint32_t x0, uint32_t y0,
                                 uint32_t mask, uint32_t slot, uint32_t y, struct vec3 row_view,
                                 struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    const struct raster_slot *info = &o->t->slots[slot];
    const struct shading_cell *cell = &o->cells[o->quality->rate[info->class_id]];
    const uint32_t first = PLACE(y0, x0), middle = ((1u << cell->x) - 1) >> 1;
    const struct raster_surface *s = &o->t->surface[first];
    do {
        const uint32_t i = fx_clz(mask), column = (i & 3) >> cell->x << cell->x, row = i >> 2 >> cell->y << cell->y,
                       whole = cell->mask >> (column + 4 * row), part = mask & whole;
        const uint32_t x = ((x0 + column + middle) >> o->r->sample_shift) - k->x;
        struct raster_surface mean = s[place[i]];
        mask -= part;
        if (cell->mean && part == whole)
            mean = cell_mean(cell, &s[PLACE(row, column)]);
        else if (cell->mean && part & (part - 1))
            mean = mask_mean(s, part);
        if (b->count == RASTER_BATCH)
            raster_flush(o, k, stats);
        b->surface[b->count] = part | (first + place[i]);
        set_pixel(&b->pixel[b->count++], info->frame, info->normal_shift, o->model->facing, mean,
                  k->exact ? block_view(o, k, x, y) : view_after(row_view, k, x), x | y << 8);
    } while (mask);
}

/* A block's samples, sixteen at a time, by the slots that they show. */
static void gather_cells(struct shading *o, struct raster_block *k, uint32_t width, uint32_t height,
                         struct raster_stats *stats)
{
    const unsigned shift = o->r->sample_shift;
    const uint32_t left = k->x << shift, right = (k->x + width) << shift, above = k->y << shift,
                   below = (k->y + height) << shift;
    /* A pixel's samples are in two rows. */
    const uint32_t rows = o->pass == PASS_PIXELS ? 2 : 4;
    for (uint32_t y = above & ~(rows - 1); y < below; y += rows) {
        const uint32_t middle = y + 1 > above ? ((y + 1) >> shift) - k->y : 0;
        const struct vec3 view = block_view(o, k, 0, middle);
        for (uint32_t x = left & ~3u; x < right; x += 4) {
            const struct raster_surface *s = &o->t->surface[PLACE(y, x)];
            uint32_t inside = ALL, slot,
                     word[4] = {raster_four_slots(s), raster_four_slots(s + PLACE(1, 0)),
                                rows == 4 ? raster_four_slots(s + PLACE(2, 0)) : 0,
                                rows == 4 ? raster_four_slots(s + PLACE(3, 0)) : 0};
            if (x < left || x + 4 > right || y < above || y + rows > below)
                inside = mask_inside(x < left ? left - x : 0, right - x, y < above ? above - y : 0, below - y);
            while ((slot = first_slot(word)) != 0) {
                const uint32_t mask = mask_slot(word, slot) & inside;
                if (mask && is_wanted(o, slot))
                    gather_masked(o, k, x, y, mask, slot, middle, view, stats);
            }
        }
    }
}

/* Each rate's cells, and the largest of those that classes have. */
static void choose_cells(struct shading *o)
{
    o->least = 0;
    for (unsigned rate = 0; rate < RASTER_RATE_FLAT; rate++) {
        struct shading_cell *c = &o->cells[rate];
        /* Before the last meshlet is drawn, every sample is shaded by itself: which of a pixel's is seen may change. */
        const bool one = rate == RASTER_RATE_1X1 && o->t->run;
        c->mean = rate != RASTER_RATE_1X1;
        c->x = one ? 0 : raster_cell_shift(o->r, rate, 0);
        c->y = one ? 0 : raster_cell_shift(o->r, rate, 1);
        c->mask = 0;
        for (uint32_t y = 0; y < 1u << c->y; y++)
            c->mask |= ~(UINT32_MAX >> (1u << c->x)) >> 4 * y;
    }
    for (unsigned i = 0; i < RASTER_CLASSES; i++)
        if (o->quality->rate[i] < RASTER_RATE_FLAT)
            o->least = o->cells[o->quality->rate[i]].x > o->least ? o->cells[o->quality->rate[i]].x : o->least;
    o->least -= fx_min_u(o->least, o->r->sample_shift);
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
    if (mask == ALL) {
        for (const struct raster_surface *end = s + PLACE(4, 0); s != end; s += PLACE(1, 0)) {
            raster_put_colour(&s[0], value);
            raster_put_colour(&s[1], value);
            raster_put_colour(&s[2], value);
            raster_put_colour(&s[3], value);
        }
        return;
    }
    s -= place[fx_clz(mask)];
    do {
        const uint32_t i = fx_clz(mask);
        mask &= ~(0x80000000u >> i);
        raster_put_colour(&s[place[i]], value);
    } while (mask);
}

/* Keeps the range of a meshlet's green, where it shows in some cells: fewer would tell too little. */
static void note_values(const struct shading *o, const uint32_t *value)
{
    const struct raster_batch *b = &o->t->batch;
    for (uint32_t i = 0; i < b->count; i++) {
        const uint32_t slot = raster_slot_of(&o->t->surface[b->surface[i] & 0xffff]);
        const uint8_t green = (uint8_t)(o->format == RASTER_RGB565 ? value[i] >> 5 << 2 : value[i] >> 8);
        if (o->pass == PASS_CELLS) {
            const struct shading_cell *c = &o->cells[o->quality->rate[o->t->slots[slot].class_id]];
            if (o->t->m.shading.pixels[slot] < 4u << (c->x + c->y))
                continue;
        }
        uint8_t *low = &o->t->m.shading.low[slot], *high = &o->t->m.shading.high[slot];
        *low = green < *low ? green : *low;
        *high = green > *high ? green : *high;
    }
}

static void put_values(const struct shading *o, const uint32_t *value)
{
    const struct raster_batch *b = &o->t->batch;
    if (o->t->memory && o->pass != PASS_FLAT)
        note_values(o, value);
    if (o->pass == PASS_FLAT)
        for (uint32_t i = 0; i < b->count; i++)
            o->t->m.shading.flat[raster_slot_of(&o->t->surface[b->surface[i] & 0xffff])] = value[i] | FLAT_KNOWN;
    else if (o->pass == PASS_CELLS || o->r->sample_shift)
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
            const uint32_t value = raster_pack(bgr, r->frame.format);
            raster_put_pixels(r, t, y * rect->width + x, &value, 1, 1);
        }
}

const struct raster_cells raster_cells = {
    choose_cells, gather_cells, shade_flat, put_values, finish_samples, raster_strongest_lights, raster_remember};
