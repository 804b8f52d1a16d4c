/*
 * Deferred shading of a tile, region by region and material by material. Surfaces of one material are gathered block by block
 * (block.h) into a batch, which is lit by every light, tone mapped and packed, and whose colours take the surfaces' place. What is gathered
 * is every sample, or one for each meshlet in a cell of them, or one for each meshlet (quality.h).
 */
#include "block.h"
#include "func.h"
#include "quality.h"

#define FLAT_KNOWN 0x80000000u

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
    uint32_t other;         /* slot of another material or rate that was met, too; 0: none */
    uint8_t format;         /* of a finished value */
    uint8_t cell_x, cell_y; /* log2 of a cell's edges, in samples */
    bool mean;              /* a cell's meshlets are shaded by their mean normal, not by their first sample's */
    bool flat;              /* a meshlet has one colour */
};

/* Keeps it below 2^31. */
static void limit_radiance(struct raster_batch *b)
{
    for (uint32_t *c = b->radiance[0], *end = b->radiance[b->count]; c != end; c++)
        *c = *c < INT32_MAX ? *c : INT32_MAX;
}

/* The same for all samples of its cell that show the same slot. */
static void put_cell(const struct shading *o, uint32_t index, uint32_t value)
{
    const uint32_t columns = (1u << o->cell_x) - 1, rows = (1u << o->cell_y) - 1;
    const uint32_t slot = raster_slot_of(&o->t->surface[index]);
    struct raster_surface *s = &o->t->surface[index & ~(columns + rows * RASTER_TILE_WIDTH)];
    for (uint32_t y = 0; y <= rows; y++, s += RASTER_TILE_WIDTH)
        for (uint32_t x = 0; x <= columns; x++)
            if (raster_slot_of(&s[x]) == slot)
                raster_put_colour(&s[x], value);
}

/* Keeps the range of a meshlet's green. */
static void note_values(const struct shading *o, const uint32_t *value)
{
    const struct raster_batch *b = &o->t->batch;
    for (uint32_t i = 0; i < b->count; i++) {
        const uint32_t slot = raster_slot_of(&o->t->surface[b->surface[i]]);
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
            o->t->m.shading.flat[raster_slot_of(&o->t->surface[b->surface[i]])] = value[i] | FLAT_KNOWN;
    else if (o->cell_x | o->cell_y)
        for (uint32_t i = 0; i < b->count; i++)
            put_cell(o, b->surface[i], value[i]);
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
    for (unsigned l = 0, added = 0; l < r->frame.light_count; l++) {
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
                             uint32_t count, const int32_t frame[9], const int32_t view[3], uint32_t at, bool facing)
{
    struct raster_batch *b = &t->batch;
    if (count < 3)
        return 0;
    const uint32_t index = (uint32_t)(s - t->surface);
    if (index + 8 > RASTER_TILE_PIXELS || b->count + 8 > RASTER_BATCH)
        return 0;
    const uint32_t away =
        raster_gather_wide(&b->pixel[b->count], s, frame, t->slots[raster_slot_of(s)].normal_shift, view, k->plane, at);
    count = count < 8 ? count : 8;
    for (uint32_t i = 0; i < count; i++) {
        if (facing && away >> 4 * i & 1)
            return i;
        b->surface[b->count++] = (uint16_t)(index + i);
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

/* Adds `count` surfaces of one slot from s on to the block's batch, as at every `step`th pixel from (x, y) of the block on; more than one
 * only where the block is not exact. Their colours are for the surfaces at every `step`th place from `index` on. */
static void gather_run(const struct shading *o, struct raster_block *k, uint32_t x, uint32_t y, uint32_t index,
                       const struct raster_surface *s, uint32_t count, uint32_t step, struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    const struct raster_slot *slot = &o->t->slots[raster_slot_of(&o->t->surface[index])];
    const bool facing = o->model->facing;
    int32_t frame[9], view[3]; /* the latter Q15 with VIEW_PLANE_BITS more, at x */
    raster_slot_frame(frame, slot);
    block_view(view, o, k, x, y);
    for (const struct raster_surface *end = s + count; s != end; s++, x += step, index += step) {
        if (b->count == RASTER_BATCH)
            flush(o, k, stats);
#ifdef RASTER_WIDE
        const uint32_t eight =
            step > 1 ? 0 : gather_eight(o->t, k, s, (uint32_t)(end - s), frame, view, x | y << 8, facing);
        if (eight) {
            for (int i = 0; i < 3; i++)
                view[i] += (int32_t)(eight * k->plane[i].dx);
            s += eight - 1;
            x += eight - 1;
            index += eight - 1;
            continue;
        }
#endif
        struct vec3 n = raster_eye_normal(frame, slot->normal_shift, s);
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
        p->at = x | y << 8;
        b->surface[b->count++] = (uint16_t)index;
        view[0] += (int32_t)(k->plane[0].dx * step);
        view[1] += (int32_t)(k->plane[1].dx * step);
        view[2] += (int32_t)(k->plane[2].dx * step);
    }
}

static inline bool waits_for_rows(const struct shading *o, const struct raster_slot *slot)
{
    return o->r->in_rows[slot->material] && o->quality->rate[slot->class_id] == RASTER_RATE_1X1;
}

/* Whether a surface is of the material and rate being shaded. Takes note of others. */
static inline bool is_wanted(struct shading *o, const struct raster_surface *s)
{
    const uint32_t slot = raster_slot_of(s);
    if (!slot)
        return false;
    const struct raster_slot *info = &o->t->slots[slot];
    if (info->material == o->material && o->quality->rate[info->class_id] == o->rate)
        return true;
    if (!waits_for_rows(o, info))
        o->other = slot;
    return false;
}

static struct raster_surface surface_mean(const struct raster_surface *a, const struct raster_surface *b)
{
    const int32_t u = lane_low(a->normal) + lane_low(b->normal) + 1,
                  v = lane_high(a->normal) + lane_high(b->normal) + 1;
    return (struct raster_surface){((a->depth_slot >> 8) + (b->depth_slot >> 8) + 1) >> 1 << 8, lanes(u >> 1, v >> 1)};
}

/* A block's row of pixels, each shaded by itself. */
static void gather_row(struct shading *o, struct raster_block *k, uint32_t y, uint32_t width,
                       struct raster_stats *stats)
{
    const uint32_t index = (k->y + y) * RASTER_TILE_WIDTH + k->x;
    const struct raster_surface *row = &o->t->surface[index];
    for (uint32_t x = 0; x < width;) {
        uint32_t end = x + 1, slot = raster_slot_of(&row[x]);
        while (end < width && raster_slot_of(&row[end]) == slot)
            end++;
        if (is_wanted(o, &row[x]))
            gather_run(o, k, x, y, index + x, &row[x], end - x, 1, stats);
        x = end;
    }
}

/* The same in cells of 2x1: of a slot's run, all but an odd first pixel are at even places. */
static void gather_pairs(struct shading *o, struct raster_block *k, uint32_t y, uint32_t width,
                         struct raster_stats *stats)
{
    const uint32_t index = (k->y + y) * RASTER_TILE_WIDTH + k->x;
    const struct raster_surface *row = &o->t->surface[index];
    for (uint32_t x = 0; x < width;) {
        struct raster_surface mean[1 << (RASTER_BLOCK_SHIFT - 1)];
        uint32_t end = x + 1, slot = raster_slot_of(&row[x]), count = 0;
        while (end < width && raster_slot_of(&row[end]) == slot)
            end++;
        const uint32_t first = x + (x & 1);
        if (is_wanted(o, &row[x])) {
            if (first != x)
                gather_run(o, k, x, y, index + x, &row[x], 1, 1, stats);
            for (uint32_t i = first; i < end; i += 2)
                mean[count++] = i + 1 < end ? surface_mean(&row[i], &row[i + 1]) : row[i];
            if (count)
                gather_run(o, k, first, y, index + first, mean, count, 2, stats);
        }
        x = end;
    }
}

/* A cell cut at the picture's edge, in samples. */
struct cell {
    uint32_t index; /* of its first surface */
    uint32_t x, y;  /* of that, in the block */
    uint32_t width, height;
};

/* Whether it shows the slot of its first sample and no other. */
static bool cell_is_whole(const struct shading *o, const struct cell *c)
{
    const struct raster_surface *s = &o->t->surface[c->index];
    const uint32_t slot = raster_slot_of(s);
    for (uint32_t y = 0; y < c->height; y++, s += RASTER_TILE_WIDTH)
        for (uint32_t x = 0; x < c->width; x++)
            if (raster_slot_of(&s[x]) != slot)
                return false;
    return true;
}

/* The mean of a whole cell's corners, which for one triangle is that of all its samples. Returns the surface amid it. */
static uint32_t cell_corners(struct raster_surface *mean, const struct shading *o, const struct cell *c)
{
    const struct raster_surface *a = &o->t->surface[c->index], *b = a + c->width - 1;
    const struct raster_surface *corner[4] = {a, b, a + (c->height - 1) * RASTER_TILE_WIDTH,
                                              b + (c->height - 1) * RASTER_TILE_WIDTH};
    int32_t u = 2, v = 2;
    uint32_t depth = 2;
    for (int i = 0; i < 4; i++) {
        u += lane_low(corner[i]->normal);
        v += lane_high(corner[i]->normal);
        depth += corner[i]->depth_slot >> 8;
    }
    *mean = (struct raster_surface){depth >> 2 << 8, lanes(u >> 2, v >> 2)};
    return c->index + ((c->height - 1) >> 1) * RASTER_TILE_WIDTH + ((c->width - 1) >> 1);
}

/* The surface at `index`, shaded with the normal of another, as if in pixel row y of the block: rows never fall in a batch. */
static void gather_sample(const struct shading *o, struct raster_block *k, uint32_t y, uint32_t index,
                          const struct raster_surface *normal, struct raster_stats *stats)
{
    gather_run(o, k, (index % RASTER_TILE_WIDTH >> o->r->sample_shift) - k->x, y, index, normal, 1, 1, stats);
}

/* Its middle row, pixels of the block: that of all cells beside it. */
static uint32_t cell_row(const struct shading *o, const struct raster_block *k, const struct cell *c)
{
    const uint32_t first = c->index / RASTER_TILE_WIDTH;
    return ((first + ((c->height - 1) >> 1)) >> o->r->sample_shift) - k->y;
}

/* What a cell shows of one slot: sums over samples, and the first one's place. */
struct part {
    uint8_t slot, count;
    uint16_t index;
    uint32_t u, v, depth; /* u and v 2^15 more a sample, so that division rounds one way; sums of 64 */
};

static struct raster_surface part_mean(const struct part *p)
{
    if (p->count == 1)
        return (struct raster_surface){p->depth << 8, lanes((int32_t)(p->u - 32768), (int32_t)(p->v - 32768))};
    const uint32_t half = p->count / 2;
    return (struct raster_surface){
        (p->depth + half) / p->count << 8,
        lanes((int32_t)((p->u + half) / p->count) - 32768, (int32_t)((p->v + half) / p->count) - 32768)};
}

/* A cell with other slots, or cut: up to 16 of them at a time. */
static void gather_mixed(struct shading *o, struct raster_block *k, const struct cell *c, struct raster_stats *stats)
{
    uint32_t done[RASTER_SLOTS / 32] = {0};
    for (bool more = true; more;) {
        struct part part[16], *p = part, *end = part;
        more = false;
        for (uint32_t y = 0; y < c->height; y++)
            for (uint32_t x = 0; x < c->width; x++) {
                const uint32_t index = c->index + y * RASTER_TILE_WIDTH + x;
                const struct raster_surface *s = &o->t->surface[index];
                const uint32_t slot = raster_slot_of(s);
                if (p == end || p->slot != slot) {
                    for (p = part; p != end && p->slot != slot;)
                        p++;
                    if (p == end) {
                        if (!is_wanted(o, s) || done[slot / 32] >> slot % 32 & 1)
                            continue;
                        if (end == part + 16) {
                            more = true;
                            continue;
                        }
                        *end++ = (struct part){.slot = (uint8_t)slot, .index = (uint16_t)index};
                    }
                }
                if (!o->mean && p->count)
                    continue;
                p->u += (uint32_t)(lane_low(s->normal) + 32768);
                p->v += (uint32_t)(lane_high(s->normal) + 32768);
                p->depth += s->depth_slot >> 8;
                p->count++;
            }
        for (p = part; p != end; p++) {
            const struct raster_surface mean = part_mean(p);
            done[p->slot / 32] |= 1u << p->slot % 32;
            gather_sample(o, k, cell_row(o, k, c), p->index, &mean, stats);
        }
    }
}

static void gather_cells(struct shading *o, struct raster_block *k, uint32_t width, uint32_t height,
                         struct raster_stats *stats)
{
    const unsigned shift = o->r->sample_shift;
    const uint32_t right = (k->x + width) << shift, below = (k->y + height) << shift;
    for (uint32_t y = k->y << shift; y < below; y += 1u << o->cell_y)
        for (uint32_t x = k->x << shift; x < right; x += 1u << o->cell_x) {
            const uint32_t columns = 1u << o->cell_x, rows = 1u << o->cell_y;
            const struct cell c = {.index = y * RASTER_TILE_WIDTH + x,
                                   .width = right - x < columns ? right - x : columns,
                                   .height = below - y < rows ? below - y : rows};
            if (!cell_is_whole(o, &c)) {
                gather_mixed(o, k, &c, stats);
            } else if (is_wanted(o, &o->t->surface[c.index])) {
                struct raster_surface mean = o->t->surface[c.index];
                gather_sample(o, k, cell_row(o, k, &c), o->mean ? cell_corners(&mean, o, &c) : c.index, &mean, stats);
            }
        }
}

static void shade_block(struct shading *o, uint32_t x, uint32_t y, unsigned shift, bool exact,
                        struct raster_stats *stats)
{
    const uint32_t edge = 1u << shift, right = o->width - x, below = o->height - y;
    const uint32_t width = right < edge ? right : edge, height = below < edge ? below : edge;
    struct raster_block k;
    raster_block_setup(&k, o->r, o->x0, o->y0, x, y, shift, exact);
    if (o->cell_y || o->r->sample_shift || (o->cell_x && exact))
        gather_cells(o, &k, width, height, stats);
    else
        for (uint32_t i = 0; i < height; i++)
            if (o->cell_x)
                gather_pairs(o, &k, i, width, stats);
            else
                gather_row(o, &k, i, width, stats);
    flush(o, &k, stats);
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

/* Every meshlet of the region by its frame's z axis, which is about its mean normal, at its first sample in the tile. */
static void shade_flat(struct shading *o, uint32_t x0, uint32_t y0, struct raster_stats *stats)
{
    const struct raster_surface axis = {0, 0};
    const unsigned shift = o->r->sample_shift;
    const uint32_t edge = 1u << RASTER_REGION_SHIFT, right = o->width - x0 < edge ? o->width : x0 + edge,
                   below = o->height - y0 < edge ? o->height : y0 + edge;
    uint32_t *flat = o->t->m.shading.flat;
    struct raster_block k;
    raster_block_setup(&k, o->r, o->x0, o->y0, x0, y0, RASTER_REGION_SHIFT, true);
    stats->cost += costs_of(o->r)->flat;
    for (int colour = 0; colour < 2; colour++) {
        for (uint32_t y = y0 << shift; y < below << shift; y++)
            for (uint32_t x = x0 << shift; x < right << shift; x++) {
                const uint32_t index = y * RASTER_TILE_WIDTH + x;
                struct raster_surface *s = &o->t->surface[index];
                if (!is_wanted(o, s))
                    continue;
                if (colour) {
                    raster_put_colour(s, flat[raster_slot_of(s)] & ~FLAT_KNOWN);
                } else if (!flat[raster_slot_of(s)]) {
                    flat[raster_slot_of(s)] = FLAT_KNOWN; /* soon */
                    gather_sample(o, &k, (y >> shift) - y0, index, &axis, stats);
                }
            }
        flush(o, &k, stats);
    }
}

/* The cells of the rate, in samples. */
static void choose_cells(struct shading *o)
{
    const enum raster_rate rate = o->rate;
    const uint8_t sample_shift = o->r->sample_shift;
    o->flat = rate == RASTER_RATE_FLAT;
    o->mean = rate != RASTER_RATE_1X1;
    o->cell_x = o->cell_y = 0;
    /* Before the last meshlet is drawn, every sample is shaded by itself: which of a pixel's is seen may change. */
    if (o->flat || (rate == RASTER_RATE_1X1 && o->t->run))
        return;
    o->cell_x = (uint8_t)(raster_cell_shift[rate][0] + sample_shift);
    o->cell_y = (uint8_t)(raster_cell_shift[rate][1] + sample_shift);
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
    struct shading o = {.r = r,
                        .t = t,
                        .x0 = rect->x,
                        .y0 = rect->y,
                        .width = rect->width,
                        .height = rect->height,
                        .quality = q,
                        .format = raster_value_format(r)};
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
