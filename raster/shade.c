/*
 * Deferred shading of a tile, region by region and material by material. Surfaces of one material are gathered block by block
 * (block.h) into a batch, which is lit by every light, tone mapped and packed, and whose colours take the surfaces' place. What is gathered
 * is every sample, or one for each meshlet in a cell of them, or one for each meshlet (quality.h).
 */
#include "block.h"
#include "func.h"
#include "quality.h"

#define FLAT_KNOWN 0x80000000u
#define FLAT_SOON  1u

/* Surfaces of one material being shaded, and the region they are in. */
struct shading {
    const struct raster *r;
    struct raster_tile *t;
    uint32_t x0, y0;        /* the tile's first pixel */
    uint32_t width, height; /* of the tile, pixels */
    const struct raster_quality *quality;
    uint32_t material;
    const struct raster_model *model; /* its */
    enum raster_rate rate;
    struct raster_block *block; /* the last one, which may be the next material's or rate's, too */
    uint32_t other;             /* slot of another material or rate that was met, too; 0: none */
    uint8_t format;             /* of a finished value */
    bool mean;                  /* a cell's meshlets are shaded by their mean normal, not by their first sample's */
    bool flat;                  /* a meshlet has one colour */
    uint8_t cell_x, cell_y;     /* log2 of a cell's edges, in samples; at most 2 */
    /* Sixteen samples side by side, cells in a row: `wide` is log2 of their columns. In masks the first is the highest bit. */
    uint8_t wide;
    const uint16_t *place; /* of each, from the first on */
    uint32_t cell;         /* the first one's mask; 0: there are none */
};

#define PLACE(y, x)  ((y)*RASTER_TILE_WIDTH + (x))
#define PLACES(y, x) PLACE(y, x), PLACE(y, (x) + 1), PLACE(y, (x) + 2), PLACE(y, (x) + 3)
static const uint16_t places[3][16] = {{PLACES(0, 0), PLACES(0, 4), PLACES(0, 8), PLACES(0, 12)},
                                       {PLACES(0, 0), PLACES(0, 4), PLACES(1, 0), PLACES(1, 4)},
                                       {PLACES(0, 0), PLACES(1, 0), PLACES(2, 0), PLACES(3, 0)}};

/* Keeps it below 2^31. */
static void limit_radiance(struct raster_batch *b)
{
    for (uint32_t *c = b->radiance[0], *end = b->radiance[b->count]; c != end; c++)
        *c = *c < INT32_MAX ? *c : INT32_MAX;
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

static const struct raster_costs no_costs;

static const struct raster_costs *costs_of(const struct raster *r)
{
    return r->frame.costs ? r->frame.costs : &no_costs;
}

static void flush(const struct shading *o, struct raster_block *k, struct raster_stats *stats)
{
    const struct raster *r = o->r;
    struct raster_batch *b = &o->t->batch;
    const struct scene_material *m = &r->frame.materials[o->material];
    const struct raster_shading_cost *c = &costs_of(r)->shading[o->model->shading];
    uint32_t lit = 0;
    uint64_t cost = (uint64_t)b->count * c->sample;
    if (!b->count)
        return;
    __builtin_memset(b->radiance, 0, b->count * sizeof b->radiance[0]);
    unsigned added = 0;
    for (unsigned l = 0; l < r->frame.light_count; l++) {
        if (!(o->t->light_chosen[l / 32] >> l % 32 & 1))
            continue;
        const bool planes = !r->lights[l].radius && !k->exact;
        if (planes && (l >= RASTER_BLOCK_LIGHTS || !(k->ready >> l & 1)))
            cost += c->material;
        const uint32_t lit_by = raster_shade_light(o->t, k, r, o->x0, o->y0, l, o->model);
        lit += lit_by;
        stats->tried += b->count;
        cost += planes ? lit_by * c->lit + (b->count - lit_by) * c->dark : b->count * c->point; /* 2^6 2^20 */
        if (++added % 16 == 0) /* sums of 2^31 and RASTER_LIGHT_LIMIT */
            limit_radiance(b);
    }
    if (added > 16)
        limit_radiance(b);
    stats->samples += b->count;
    stats->shaded += lit;
    stats->cost += o->flat ? (uint64_t)b->count * c->flat : cost;
    if (m->kind == SCENE_MATERIAL_MEASURED)
        stats->fetches += 8 * lit;
    if (o->model->ambient)
        o->model->ambient(b, m, r->frame.output->exposure);
    uint32_t *value = b->radiance[0]; /* a pixel's value takes less room than its radiance */
    raster_finish_pixels(value, b->radiance, b->count, r->frame.output->tone_curve, o->format);
    put_values(o, value);
    b->count = 0;
}

/*
 * Interpolation turns normals of visible pixels away from the eye, near silhouettes. Tables and microfacets have no value there, and a
 * black pixel beside a bright one would flicker with the least movement: the normal is turned back to where n.v is 1/128.
 */
static struct vec3 face_viewer(struct vec3 n, struct vec3 v, int32_t nv)
{
    const int32_t lift = 32768 / 128 - (nv >> 15);
    n = (struct vec3){n.x + (v.x * lift >> 15), n.y + (v.y * lift >> 15), n.z + (v.z * lift >> 15)};
    unsigned shift;
    uint32_t m = lut_rsqrt((uint32_t)fx_max(fx_dot(n, n), 1), &shift);
    int32_t k = (int32_t)(m >> shift); /* 2^30 / |n|: its product with a component of n is at most 2^30 */
    return (struct vec3){n.x * k >> 15, n.y * k >> 15, n.z * k >> 15};
}

#ifdef RASTER_WIDE
/* The batch's next pixels, up to eight and to the first that is to be turned to the viewer, from surfaces of one slot side by side; `view`
 * as wide as its planes are. Returns how many: none where there is no room for eight. */
static uint32_t gather_eight(struct raster_tile *t, const struct raster_block *k, const struct raster_surface *s,
                             uint32_t count, const int32_t view[3], uint32_t at, bool facing)
{
    struct raster_batch *b = &t->batch;
    if (count < 3)
        return 0;
    const uint32_t index = (uint32_t)(s - t->surface);
    if (index + 8 > RASTER_TILE_PIXELS || b->count + 8 > RASTER_BATCH)
        return 0;
    const uint32_t away = raster_gather_wide(&b->pixel[b->count], s, &t->slots[raster_slot_of(s)], view, k->plane, at);
    count = count < 8 ? count : 8;
    for (uint32_t i = 0; i < count; i++) {
        if (facing && away >> 4 * i & 1)
            return i;
        b->surface[b->count++] = index + i;
    }
    return count;
}
#endif

/* Towards the eye at pixel (x, y) of a block, as wide as its planes are. */
static inline void block_view(int32_t view[3], const struct shading *o, const struct raster_block *k, uint32_t x,
                              uint32_t y)
{
    if (k->exact) {
        const struct vec3 v = raster_view_vector(o->r, o->x0 + k->x + x, o->y0 + k->y + y);
        view[0] = v.x * (1 << VIEW_PLANE_BITS);
        view[1] = v.y * (1 << VIEW_PLANE_BITS);
        view[2] = v.z * (1 << VIEW_PLANE_BITS);
        return;
    }
    for (int i = 0; i < 3; i++)
        view[i] = (int32_t)(k->plane[i].base + x * k->plane[i].dx + y * k->plane[i].dy) + (1 << (VIEW_PLANE_BITS - 1));
}

/* The batch's next sample: a surface's normal, seen from `view`. */
__attribute__((always_inline)) static inline void add_sample(struct raster_batch *b, const struct raster_slot *slot,
                                                             bool facing, const struct raster_surface *s,
                                                             const int32_t view[3], uint32_t at, uint32_t surface)
{
    struct vec3 n = raster_eye_normal(slot, s);
    const struct vec3 v = {view[0] >> VIEW_PLANE_BITS, view[1] >> VIEW_PLANE_BITS, view[2] >> VIEW_PLANE_BITS};
    int32_t nv = fx_dot(n, v);
    if (nv < 1 << 23 && facing) {
        n = face_viewer(n, v, nv);
        nv = fx_max(fx_dot(n, v), 1 << 22);
    }
    struct raster_batch_pixel *p = &b->pixel[b->count];
    if (((uint32_t)(n.x + 32768) | (uint32_t)(n.y + 32768) | (uint32_t)(n.z + 32768)) >> 16)
        n = (struct vec3){fx_clamp(n.x, -32768, 32767), fx_clamp(n.y, -32768, 32767), fx_clamp(n.z, -32768, 32767)};
    p->normal_xy = lanes(n.x, n.y);
    p->normal_z = n.z;
    p->nv = nv;
    p->at = at;
    b->surface[b->count++] = surface;
}

/* Adds surfaces of one slot side by side to the block's batch, from pixel (x, y) of the block on; more than one only where the block is not
 * exact. */
static void gather_run(const struct shading *o, struct raster_block *k, uint32_t x, uint32_t y,
                       const struct raster_surface *s, const struct raster_surface *end, struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    const struct raster_slot *slot = &o->t->slots[raster_slot_of(s)];
    const bool facing = o->model->facing;
    uint32_t at = x | y << 8;
    int32_t view[3]; /* Q15 with VIEW_PLANE_BITS more */
    block_view(view, o, k, x, y);
    for (uint32_t index = (uint32_t)(s - o->t->surface); s != end; s++, at++, index++) {
        if (b->count == RASTER_BATCH)
            flush(o, k, stats);
#ifdef RASTER_WIDE
        const uint32_t eight = gather_eight(o->t, k, s, (uint32_t)(end - s), view, at, facing);
        if (eight) {
            for (int i = 0; i < 3; i++)
                view[i] += (int32_t)(eight * k->plane[i].dx);
            s += eight - 1;
            at += eight - 1;
            index += eight - 1;
            continue;
        }
#endif
        add_sample(b, slot, facing, s, view, at, index);
        view[0] += (int32_t)k->plane[0].dx;
        view[1] += (int32_t)k->plane[1].dx;
        view[2] += (int32_t)k->plane[2].dx;
    }
}

static inline bool waits_for_rows(const struct shading *o, const struct raster_slot *slot)
{
    return o->r->in_rows[slot->material] && o->quality->rate[slot->class_id] == RASTER_RATE_1X1;
}

/* Whether a surface is of the material and rate being shaded. Takes note of others. */
static inline bool is_wanted(struct shading *o, uint32_t slot)
{
    if (!slot)
        return false;
    const struct raster_slot *info = &o->t->slots[slot];
    if (info->material == o->material && o->quality->rate[info->class_id] == o->rate)
        return true;
    if (!waits_for_rows(o, info))
        o->other = slot;
    return false;
}

/* Where the slot's run from s on ends. */
static inline const struct raster_surface *run_end(const struct raster_surface *s, const struct raster_surface *end)
{
    const uint32_t slot = raster_slot_of(s);
    do
        s++;
    while (s != end && raster_slot_of(s) == slot);
    return s;
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
                                 uint32_t slot, uint32_t x0, uint32_t y, const int32_t row_view[3],
                                 struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    const struct raster_surface *s = &o->t->surface[first];
    do {
        const uint32_t i = fx_clz(mask), before = (i & ((1u << o->wide) - 1)) >> o->cell_x << o->cell_x,
                       cell = o->cell >> before, part = mask & cell, x = x0 + (before >> o->r->sample_shift);
        struct raster_surface mean = s[o->place[i]];
        int32_t view[3];
        mask -= part;
        if (o->mean && part == cell)
            mean = cell_mean(o, &s[before]);
        else if (o->mean && part & (part - 1))
            mean = mask_mean(o, s, part);
        if (b->count == RASTER_BATCH)
            flush(o, k, stats);
        if (k->exact) {
            block_view(view, o, k, x, y);
        } else {
            view[0] = row_view[0] + (int32_t)(x * k->plane[0].dx);
            view[1] = row_view[1] + (int32_t)(x * k->plane[1].dx);
            view[2] = row_view[2] + (int32_t)(x * k->plane[2].dx);
        }
        add_sample(b, &o->t->slots[slot], o->model->facing, &mean, view, x | y << 8, part | (first + o->place[i]));
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
        int32_t view[3];
        block_view(view, o, k, 0, pixel_y);
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

static void shade_block(struct shading *o, uint32_t x, uint32_t y, unsigned shift, bool exact,
                        struct raster_stats *stats)
{
    const uint32_t edge = 1u << shift, right = o->width - x, below = o->height - y;
    const uint32_t width = right < edge ? right : edge, height = below < edge ? below : edge;
    struct raster_block *k = o->block;
    raster_block_setup(k, o->r, o->x0, o->y0, x, y, shift, exact);
    if (o->cell)
        gather_cells(o, k, width, height, stats);
    else
        for (uint32_t i = 0; i < height; i++)
            gather_row(o, k, i, width, stats);
    flush(o, k, stats);
}

/* A region, in smaller blocks where planes do not hold: in Z order, each as large as its place allows and no smaller than a cell. */
static void shade_region(struct shading *o, uint32_t x0, uint32_t y0, struct raster_stats *stats)
{
    const unsigned cell = (o->cell_x > o->cell_y ? o->cell_x : o->cell_y),
                   least = cell > o->r->sample_shift ? cell - o->r->sample_shift : 0,
                   most = o->r->block_shift > least ? o->r->block_shift : least;
    unsigned shift;
    stats->cost += costs_of(o->r)->region;
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

/* Every meshlet of the region by its frame's z axis, which is about its mean normal, seen from the region's middle; once in the tile. */
static void shade_flat(struct shading *o, uint32_t x0, uint32_t y0, struct raster_stats *stats)
{
    const struct raster_surface axis = {0, 0};
    const unsigned shift = o->r->sample_shift;
    const uint32_t edge = 1u << RASTER_REGION_SHIFT, right = o->width - x0 < edge ? o->width : x0 + edge,
                   below = o->height - y0 < edge ? o->height : y0 + edge;
    uint32_t *flat = o->t->m.shading.flat;
    int32_t view[3];
    struct raster_block *k = o->block;
    raster_block_setup(k, o->r, o->x0, o->y0, x0, y0, 0, false);
    block_view(view, o, k, 0, 0);
    stats->cost += costs_of(o->r)->flat;
    for (bool waits = true; waits;) {
        waits = false;
        for (uint32_t y = y0 << shift; y < below << shift; y++) {
            struct raster_surface *s = &o->t->surface[y * RASTER_TILE_WIDTH + (x0 << shift)];
            for (const struct raster_surface *end = s + ((right - x0) << shift), *first = s; s != end;) {
                const uint32_t slot = raster_slot_of(s), colour = is_wanted(o, slot) ? flat[slot] : FLAT_SOON;
                if (colour & FLAT_KNOWN) {
                    do
                        raster_put_colour(s++, colour & ~FLAT_KNOWN);
                    while (s != end && raster_slot_of(s) == slot);
                    continue;
                }
                if (!colour) {
                    const uint32_t at = (uint32_t)(s - first) >> shift | ((y >> shift) - y0) << 8;
                    flat[slot] = FLAT_SOON;
                    waits = true;
                    if (o->t->batch.count == RASTER_BATCH)
                        flush(o, k, stats);
                    add_sample(&o->t->batch, &o->t->slots[slot], o->model->facing, &axis, view, at,
                               (uint32_t)(s - o->t->surface));
                }
                s += run_end(s, end) - s;
            }
        }
        flush(o, k, stats);
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

/* That of the region's first surface that waits for blocks; 0: there is none. */
static uint32_t find_slot(const struct shading *o, uint32_t x0, uint32_t y0)
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
    struct shading o = {.r = r,
                        .t = t,
                        .block = &block,
                        .x0 = rect->x,
                        .y0 = rect->y,
                        .width = rect->width,
                        .height = rect->height,
                        .quality = q,
                        .format = raster_value_format(r)};
    block.shift = RASTER_BLOCK_SHIFT + 1; /* none */
    block.material = UINT32_MAX;
    block.scaled = false;
    t->batch.count = 0;
    raster_choose_lights(r, t, q->lights);
    for (o.other = find_slot(&o, x, y); o.other;) {
        o.material = t->batch.material = t->slots[o.other].material;
        o.model = raster_model_of(&r->frame, &r->frame.materials[o.material]);
        o.rate = (enum raster_rate)q->rate[t->slots[o.other].class_id];
        o.other = 0;
        choose_cells(&o);
        if (o.flat)
            shade_flat(&o, x, y, stats);
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
