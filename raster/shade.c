/*
 * Deferred shading of a tile. Surfaces that need the view are shaded block by block (block.h): pixels of one material are
 * gathered into a batch, which is lit by every light, tone mapped and packed, and whose colours take the surface's place. Then
 * follows a pass by rows: diffuse surfaces are shaded there, run by run of one meshlet, and finished pixels are
 * stored from the surface's start on; a pixel takes 2 or 3 of the 8 bytes it had, so writing never overtakes reading.
 */
#include "block.h"
#include "func.h"

struct output {
    const struct raster *r;
    struct raster_tile *t;
    uint32_t width, height; /* pixels */
    uint32_t x0, y0;        /* the tile's first pixel */
    uint8_t format;         /* of a finished value: the frame's, but RGB888 where samples will be averaged */
    bool whole_pixels;      /* samples of one pixel and slot are shaded once */
};

static inline void store_pixel(const struct output *o, uint32_t index, uint32_t value)
{
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
    if (o->r->frame.format == RASTER_RGB565) {
        uint16_t *out = (uint16_t *)o->t->surface + y * o->width + x;
        for (const uint32_t *end = values + count; values != end; values++)
            *out++ = (uint16_t)*values;
        return;
    }
    for (uint32_t i = 0; i < count; i++)
        store_pixel(o, y * o->width + x + i, values[i]);
}

static inline uint32_t slot_of(const struct raster_surface *s)
{
    return s->depth_slot & 255;
}

static raster_model *find_model(const struct raster *r, const struct scene_material *m)
{
    switch (m->kind) {
    case SCENE_MATERIAL_MEASURED:
        return r->frame.tables[m->slot]->kind == LUT_HALF_VECTOR ? raster_shade_half_vector
                                                                 : raster_shade_specular_frame;
    case SCENE_MATERIAL_BLINN_PHONG:
        return raster_shade_blinn_phong;
    case SCENE_MATERIAL_METALLIC_ROUGHNESS:
        return raster_shade_metallic_roughness;
    default:
        return raster_shade_lafortune_phong;
    }
}

/* A finished pixel or sample in its surface's place. */
static inline void put_colour(struct raster_surface *s, uint32_t value)
{
    s->normal = value;
    s->depth_slot &= ~(uint32_t)255;
}

/* The same for all of its pixel's samples that show the same slot. */
static void put_pixel(const struct output *o, uint32_t index, uint32_t value)
{
    struct raster_surface *corner = &o->t->surface[index & ~(uint32_t)(RASTER_TILE_WIDTH + 1)];
    const uint32_t slot = slot_of(&o->t->surface[index]);
    for (int i = 0; i < 4; i++) {
        struct raster_surface *s = corner + (i & 1) + (i >> 1) * RASTER_TILE_WIDTH;
        if (slot_of(s) == slot)
            put_colour(s, value);
    }
}

/* Keeps it below 2^31. */
static void limit_radiance(struct raster_batch *b)
{
    for (uint32_t *c = b->radiance[0], *end = b->radiance[b->count]; c != end; c++)
        *c = *c < INT32_MAX ? *c : INT32_MAX;
}

static void flush(const struct output *o, struct raster_block *k, struct raster_stats *stats)
{
    const struct raster *r = o->r;
    struct raster_batch *b = &o->t->batch;
    const struct scene_material *m = &r->frame.materials[b->material];
    raster_model *model = find_model(r, m);
    uint32_t lit = 0;
    __builtin_memset(b->radiance, 0, b->count * sizeof b->radiance[0]);
    for (unsigned l = 0, added = 0; l < r->frame.light_count; l++) {
        if (r->lights[l].radius && !(o->t->light_reaches[l / 32] >> l % 32 & 1))
            continue;
        lit += raster_shade_light(o->t, k, r, o->x0, o->y0, l, model);
        if (++added % 16 == 0) /* sums of 2^31 and RASTER_LIGHT_LIMIT */
            limit_radiance(b);
    }
    limit_radiance(b);
    stats->shaded += lit;
    if (m->kind == SCENE_MATERIAL_MEASURED)
        stats->fetches += 8 * lit;
    raster_finish_ambient(b, m, r->frame.output->exposure);
    uint32_t *value = b->radiance[0]; /* a pixel's value takes less room than its radiance */
    raster_finish_pixels(value, b->radiance, b->count, r->frame.output->tone_curve, o->format);
    if (o->whole_pixels && r->sample_shift)
        for (uint32_t i = 0; i < b->count; i++)
            put_pixel(o, b->surface[i], value[i]);
    else
        for (uint32_t i = 0; i < b->count; i++)
            put_colour(&o->t->surface[b->surface[i]], value[i]);
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

/* Models whose lobes need the surface to face the viewer. */
static bool needs_facing(const struct scene_material *m)
{
    return m->kind == SCENE_MATERIAL_MEASURED || m->kind == SCENE_MATERIAL_METALLIC_ROUGHNESS;
}

#ifdef RASTER_WIDE
/* The batch's next pixels, up to eight and to the first that is to be turned to the viewer, from surfaces of one slot side by side; `view`
 * as wide as its planes are. Returns how many: none where there is no room for eight. */
static uint32_t gather_eight(struct raster_tile *t, const struct raster_block *k, const struct raster_surface *s,
                             uint32_t count, const int32_t frame[9], const int32_t view[3], uint32_t at, bool facing)
{
    struct raster_batch *b = &t->batch;
    const uint32_t index = (uint32_t)(s - t->surface);
    if (count < 3 || index + 8 > RASTER_TILE_PIXELS || b->count + 8 > RASTER_BATCH)
        return 0;
    const uint32_t away =
        raster_gather_wide(&b->pixel[b->count], s, frame, t->slots[slot_of(s)].normal_shift, view, k->plane, at);
    count = count < 8 ? count : 8;
    for (uint32_t i = 0; i < count; i++) {
        if (facing && away >> 4 * i & 1)
            return i;
        b->surface[b->count++] = (uint16_t)(index + i);
    }
    return count;
}
#endif

/* Adds `count` surfaces of one slot, side by side from pixel (x, y) of the block on, to its batch. `index`: of the first. */
static void gather_run(const struct output *o, struct raster_block *k, uint32_t x, uint32_t y, uint32_t index,
                       uint32_t count, struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    const struct raster_surface *s = &o->t->surface[index];
    const struct raster_slot *slot = &o->t->slots[slot_of(s)];
    const bool facing = needs_facing(&o->r->frame.materials[b->material]);
    int32_t frame[9], view[3]; /* the latter Q15 with VIEW_PLANE_BITS more, at x */
    raster_slot_frame(frame, slot);
    for (int i = 0; i < 3; i++)
        view[i] = (int32_t)(k->plane[i].base + x * k->plane[i].dx + y * k->plane[i].dy) + (1 << (VIEW_PLANE_BITS - 1));
    for (const struct raster_surface *end = s + count; s != end; s++, x++, index++) {
        if (b->count == RASTER_BATCH)
            flush(o, k, stats);
#ifdef RASTER_WIDE
        const uint32_t eight = gather_eight(o->t, k, s, (uint32_t)(end - s), frame, view, x | y << 8, facing);
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
        view[0] += (int32_t)k->plane[0].dx;
        view[1] += (int32_t)k->plane[1].dx;
        view[2] += (int32_t)k->plane[2].dx;
    }
}

/* Whether an earlier sample of the pixel than s, its i-th, shows the same slot. */
static bool seen_before(const struct raster_surface *s, uint32_t i)
{
    const struct raster_surface *first = s - (i & 1) - (i >> 1) * RASTER_TILE_WIDTH;
    for (uint32_t j = 0; j < i; j++)
        if (slot_of(first + (j & 1) + (j >> 1) * RASTER_TILE_WIDTH) == slot_of(s))
            return true;
    return false;
}

/* Whether a surface is for the batch now: of its material, which the first one chooses. Sets *left for one of another. */
static inline bool is_wanted(const struct output *o, const struct raster_surface *s, bool *left)
{
    const uint32_t slot = slot_of(s);
    if (!slot || o->r->in_rows[o->t->slots[slot].material])
        return false;
    struct raster_batch *b = &o->t->batch;
    const uint32_t material = o->t->slots[slot].material;
    if (b->material == UINT32_MAX)
        b->material = material;
    *left |= material != b->material;
    return material == b->material;
}

static void gather_row(const struct output *o, struct raster_block *k, uint32_t y, uint32_t width, bool *left,
                       struct raster_stats *stats)
{
    const uint32_t index = (k->y + y) * RASTER_TILE_WIDTH + k->x;
    const struct raster_surface *row = &o->t->surface[index];
    for (uint32_t x = 0; x < width;) {
        uint32_t end = x + 1, slot = slot_of(&row[x]);
        while (end < width && slot_of(&row[end]) == slot)
            end++;
        if (is_wanted(o, &row[x], left))
            gather_run(o, k, x, y, index + x, end - x, stats);
        x = end;
    }
}

static void gather_samples(const struct output *o, struct raster_block *k, uint32_t y, uint32_t width, bool *left,
                           struct raster_stats *stats)
{
    for (uint32_t x = 0; x < width; x++)
        for (uint32_t i = 0; i < 4; i++) {
            const uint32_t index = (2 * (k->y + y) + (i >> 1)) * RASTER_TILE_WIDTH + 2 * (k->x + x) + (i & 1);
            const struct raster_surface *s = &o->t->surface[index];
            if (is_wanted(o, s, left) && !(o->whole_pixels && seen_before(s, i)))
                gather_run(o, k, x, y, index, 1, stats);
        }
}

/* Gathers the block's surfaces of the first material met. Returns whether others are left. */
static bool gather_material(const struct output *o, struct raster_block *k, uint32_t width, uint32_t height,
                            struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    bool left = false;
    b->count = 0;
    b->material = UINT32_MAX;
    k->ready = 0;
    for (uint32_t y = 0; y < height; y++)
        if (o->r->sample_shift)
            gather_samples(o, k, y, width, &left, stats);
        else
            gather_row(o, k, y, width, &left, stats);
    if (b->count)
        flush(o, k, stats);
    return left;
}

static void shade_block(const struct output *o, uint32_t x, uint32_t y, unsigned shift, struct raster_stats *stats)
{
    const uint32_t edge = 1u << shift, right = o->width - x, below = o->height - y;
    struct raster_block k;
    raster_block_setup(&k, o->r, o->x0, o->y0, x, y, shift);
    while (gather_material(o, &k, right < edge ? right : edge, below < edge ? below : edge, stats))
        ;
}

/* Whether a surface of the largest block's pixels is for blocks. */
static bool block_occupied(const struct output *o, uint32_t x0, uint32_t y0)
{
    const unsigned shift = o->r->sample_shift;
    const uint32_t edge = 1u << RASTER_BLOCK_SHIFT, right = o->width - x0 < edge ? o->width : x0 + edge,
                   below = o->height - y0 < edge ? o->height : y0 + edge;
    for (uint32_t y = y0 << shift; y < below << shift; y++) {
        const struct raster_surface *row = o->t->surface + y * RASTER_TILE_WIDTH;
        for (uint32_t x = x0 << shift; x < right << shift; x++)
            if (slot_of(&row[x]) && !o->r->in_rows[o->t->slots[slot_of(&row[x])].material])
                return true;
    }
    return false;
}

/* A block of the largest size, in smaller ones where planes do not hold: in Z order, each as large as its place allows. */
static void shade_largest(const struct output *o, uint32_t x0, uint32_t y0, struct raster_stats *stats)
{
    unsigned shift = o->r->block_shift;
    for (uint32_t z = 0; z < 1u << 2 * RASTER_BLOCK_SHIFT; z += 1u << 2 * shift) {
        uint32_t x = x0, y = y0;
        for (unsigned i = 0; i < RASTER_BLOCK_SHIFT; i++) {
            x += (z >> 2 * i & 1) << i;
            y += (z >> (2 * i + 1) & 1) << i;
        }
        shift = o->r->block_shift;
        while (z & ((1u << 2 * shift) - 1))
            shift--;
        if (x >= o->width || y >= o->height)
            continue;
        while (shift > 0 && !raster_block_regular(o->r, o->x0 + x, o->y0 + y, shift))
            shift--;
        shade_block(o, x, y, shift, stats);
    }
}

/* Whether some slot of the tile is for blocks; and its point lights. */
static bool prepare_blocks(const struct output *o, const struct raster_rect *rect)
{
    bool any = false;
    for (uint32_t i = 1; i <= o->t->slot_count; i++)
        any |= !o->r->in_rows[o->t->slots[i].material];
    if (any && o->r->frame.light_count > o->r->directional)
        raster_cull_lights(o->r, o->t, rect);
    return any;
}

static void shade_blocks(const struct output *o, const struct raster_rect *rect, struct raster_stats *stats)
{
    if (!prepare_blocks(o, rect))
        return;
    for (uint32_t y = 0; y < o->height; y += 1u << RASTER_BLOCK_SHIFT)
        for (uint32_t x = 0; x < o->width; x += 1u << RASTER_BLOCK_SHIFT)
            if (block_occupied(o, x, y))
                shade_largest(o, x, y, stats);
}

/* Shades a run of pixels of one slot into the batch's radiance, finished. A run is at most a row, thus a batch, long. */
static const uint32_t *shade_run(const struct output *o, uint32_t slot, uint32_t x, uint32_t y, uint32_t count,
                                 struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    const struct raster_slot *info = &o->t->slots[slot];
    const struct raster_surface *s = o->t->surface + y * RASTER_TILE_WIDTH + x;
    if (raster_is_diffuse(&o->r->frame.materials[info->material]))
        raster_shade_diffuse(b, o->r, info, s, count);
    else
        raster_shade_blinn_phong_run(b, o->r, info, s, o->x0 + x, o->y0 + y, count);
    raster_finish_pixels(b->radiance[0], b->radiance, count, o->r->frame.output->tone_curve, o->format);
    stats->shaded += count * o->r->frame.light_count;
    return b->radiance[0];
}

/* How many pixels from x on have its slot. */
static uint32_t run_length(const struct output *o, uint32_t x, uint32_t y)
{
    const struct raster_surface *row = o->t->surface + y * RASTER_TILE_WIDTH;
    uint32_t slot = slot_of(&row[x]), end = x + 1;
    while (end < o->width && slot_of(&row[end]) == slot)
        end++;
    return end - x;
}

/* Pixels without a slot from x on: background, or shaded before. Returns where they end. */
static uint32_t plain_run(const struct output *o, uint32_t background, uint32_t x, uint32_t y,
                          struct raster_stats *stats)
{
    const struct raster_surface *row = o->t->surface + y * RASTER_TILE_WIDTH;
    const uint32_t width = o->width;
    for (; x < width && row[x].depth_slot && !slot_of(&row[x]); x++, stats->covered++)
        store_pixel(o, y * width + x, row[x].normal);
    if (o->r->frame.format == RASTER_RGB565) {
        uint16_t *out = (uint16_t *)o->t->surface + y * width + x;
        for (; x < width && !row[x].depth_slot; x++)
            *out++ = (uint16_t)background;
    } else {
        for (; x < width && !row[x].depth_slot; x++)
            store_pixel(o, y * width + x, background);
    }
    return x;
}

static void finish_rows(const struct output *o, struct raster_stats *stats)
{
    const uint32_t background = raster_background(&o->r->frame, o->format);
    o->t->batch.diffuse_material = 0;
    for (uint32_t y = 0; y < o->height; y++) {
        const struct raster_surface *row = o->t->surface + y * RASTER_TILE_WIDTH;
        for (uint32_t x = 0; x < o->width;) {
            if (!slot_of(&row[x])) {
                x = plain_run(o, background, x, y, stats);
                continue;
            }
            uint32_t count = run_length(o, x, y);
            stats->covered += count;
            put_run(o, x, y, shade_run(o, slot_of(&row[x]), x, y, count, stats), count);
            x += count;
        }
    }
}

/* Four sums of bytes fit ten bits each. */
static inline uint32_t spread(uint32_t bgr)
{
    return (bgr & 0xff) | (bgr & 0xff00) << 2 | (bgr & 0xff0000) << 4;
}

/* The mean of each pixel's four samples. */
static void finish_samples(const struct output *o, struct raster_stats *stats)
{
    const uint32_t background = raster_background(&o->r->frame, RASTER_RGB888);
    for (uint32_t y = 0; y < o->height; y++)
        for (uint32_t x = 0; x < o->width; x++) {
            const struct raster_surface *s = &o->t->surface[2 * y * RASTER_TILE_WIDTH + 2 * x];
            uint32_t sum = 0x00200802u, covered = 0; /* 2 in each, to round */
            for (int i = 0; i < 4; i++) {
                const struct raster_surface *sample = s + (i & 1) + (i >> 1) * RASTER_TILE_WIDTH;
                sum += spread(sample->depth_slot ? sample->normal : background);
                covered |= sample->depth_slot;
            }
            stats->covered += covered != 0;
            uint32_t bgr = (sum >> 2 & 0xff) | (sum >> 4 & 0xff00) | (sum >> 6 & 0xff0000);
            store_pixel(o, y * o->width + x, raster_pack(bgr, o->r->frame.format));
        }
}

static struct output make_output(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                                 bool whole_pixels)
{
    return (struct output){.r = r,
                           .t = t,
                           .width = rect->width,
                           .height = rect->height,
                           .x0 = rect->x,
                           .y0 = rect->y,
                           .format = r->sample_shift ? RASTER_RGB888 : r->frame.format,
                           .whole_pixels = whole_pixels};
}

void raster_shade_tile(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                       struct raster_stats *stats)
{
    const struct output o = make_output(r, t, rect, true);
    shade_blocks(&o, rect, stats);
    if (r->sample_shift)
        finish_samples(&o, stats);
    else
        finish_rows(&o, stats);
}

void raster_shade_samples(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                          struct raster_stats *stats)
{
    const struct output o = make_output(r, t, rect, false);
    shade_blocks(&o, rect, stats);
    t->batch.diffuse_material = 0;
    for (uint32_t y = 0; y < o.height && !r->sample_shift; y++)
        for (uint32_t x = 0; x < o.width;) {
            const uint32_t index = y * RASTER_TILE_WIDTH + x, slot = slot_of(&t->surface[index]);
            const uint32_t count = slot ? run_length(&o, x, y) : 1;
            if (slot) {
                const uint32_t *value = shade_run(&o, slot, x, y, count, stats);
                for (uint32_t i = 0; i < count; i++)
                    put_colour(&t->surface[index + i], value[i]);
            }
            x += count;
        }
}
