/*
 * Deferred shading of a tile, row by row in runs of one meshlet. Pixels of one material are gathered into batches, each
 * batch is lit by every light, tone mapped and packed; a material that does not depend on the view is shaded run by run.
 * Finished pixels overwrite the surface from its start: a pixel takes 2 or 3 of the 8 bytes it had, so writing never
 * overtakes reading.
 */
#include "internal.h"
#include "func.h"

enum target {
    TARGET_PIXELS,  /* finished pixels from the surface's start on */
    TARGET_SAMPLES, /* colours into the samples' own surface, slot 0 */
    TARGET_RESOLVE  /* weighted colours, summed in the surface of a pixel's first sample */
};

struct output {
    const struct raster *r;
    struct raster_tile *t;
    uint32_t width, height; /* pixels, or samples for TARGET_SAMPLES */
    uint32_t x0, y0;        /* the tile's first pixel, for views */
    enum target target;
    uint8_t format; /* of a finished value: the frame's, but RGB888 where samples will be averaged */
};

static struct output make_output(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                                 enum target target)
{
    unsigned shift = target == TARGET_SAMPLES ? r->sample_shift : 0;
    uint8_t format = r->sample_shift ? RASTER_RGB888 : r->frame.format;
    return (struct output){.r = r,
                           .t = t,
                           .width = (uint32_t)rect->width << shift,
                           .height = (uint32_t)rect->height << shift,
                           .x0 = rect->x,
                           .y0 = rect->y,
                           .target = target,
                           .format = format};
}

/* Four sums of bytes fit ten bits each. */
static inline uint32_t spread(uint32_t bgr)
{
    return (bgr & 0xff) | (bgr & 0xff00) << 2 | (bgr & 0xff0000) << 4;
}

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

/* `value`: a finished pixel or sample. */
static inline void put_pixel(const struct output *o, uint32_t x, uint32_t y, uint32_t value, uint32_t weight)
{
    struct raster_surface *s = &o->t->surface[y * RASTER_TILE_WIDTH + x];
    if (o->target == TARGET_PIXELS) {
        store_pixel(o, y * o->width + x, value);
    } else if (o->target == TARGET_SAMPLES) {
        s->normal = value;
        s->depth_slot &= ~(uint32_t)255;
    } else {
        s->normal += weight * spread(value);
    }
}

/* A run of finished pixels. */
static void put_run(const struct output *o, uint32_t x, uint32_t y, const uint32_t *values, uint32_t count)
{
    if (o->target == TARGET_PIXELS && o->r->frame.format == RASTER_RGB565) {
        uint16_t *out = (uint16_t *)o->t->surface + y * o->width + x;
        for (const uint32_t *end = values + count; values != end; values++)
            *out++ = (uint16_t)*values;
        return;
    }
    for (uint32_t i = 0; i < count; i++)
        put_pixel(o, x + i, y, values[i], 1);
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
            b->radiance[i][k] = add_radiance(
                b->radiance[i][k],
                (uint32_t)((uint64_t)f.c[k] * (uint32_t)fx_min(fx_dot(b->normal[i], light->direction), 1 << 30) >> 30),
                f.e, light->irradiance[k]);
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
        else if (m->kind == SCENE_MATERIAL_BLINN_PHONG)
            stats->shaded += raster_shade_blinn_phong(b, m, &r->lights[l]);
        else
            stats->shaded += raster_shade_lafortune_phong(b, m, &r->lights[l]);
    }
    if (m->kind == SCENE_MATERIAL_BLINN_PHONG)
        raster_finish_blinn_phong(b, m, r->frame.output->exposure);
    uint32_t *value = b->radiance[0]; /* a pixel's value takes less room than its radiance */
    raster_finish_pixels(value, b->radiance, b->count, r->frame.output->tone_curve, o->format);
    for (uint32_t i = 0; i < b->count; i++)
        put_pixel(o, b->pixel[i] % RASTER_TILE_WIDTH, b->pixel[i] / RASTER_TILE_WIDTH, value[i], b->weight[i]);
    b->count = 0;
}

/*
 * Interpolation turns normals of visible pixels away from the eye, near silhouettes. A table has no value there, and a black pixel beside a
 * bright one would flicker with the least movement: the normal is turned back to where n.v is 1/128.
 */
static struct vec3 face_viewer(struct vec3 n, struct vec3 v)
{
    const int32_t least = 32768 / 128;
    int32_t lift = least - (fx_dot(n, v) >> 15);
    if (lift <= 0)
        return n;
    n = (struct vec3){n.x + (v.x * lift >> 15), n.y + (v.y * lift >> 15), n.z + (v.z * lift >> 15)};
    unsigned shift;
    uint32_t m = lut_rsqrt((uint32_t)fx_max(fx_dot(n, n), 1), &shift);
    int32_t k = (int32_t)(m >> shift); /* 2^30 / |n|: its product with a component of n is at most 2^30 */
    return (struct vec3){n.x * k >> 15, n.y * k >> 15, n.z * k >> 15};
}

/* Adds a pixel to the batch. (x, y): where its colour goes; `sample`: where its normal is. */
static void gather_pixel(const struct output *o, const struct raster_slot *slot, uint32_t x, uint32_t y,
                         const struct raster_surface *sample, uint32_t weight, struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    if (b->count == RASTER_BATCH || (b->count && b->material != slot->material))
        flush(o, stats);
    b->material = slot->material;
    uint32_t i = b->count++, shift = o->r->sample_shift; /* x, y are then those of a sample */
    b->pixel[i] = (uint16_t)(y * RASTER_TILE_WIDTH + x);
    b->weight[i] = (uint8_t)weight;
    b->normal[i] = raster_eye_normal(slot, sample);
    b->view[i] = raster_view_vector(o->r, o->x0 + (x >> shift), o->y0 + (y >> shift));
    if (o->r->frame.materials[slot->material].kind == SCENE_MATERIAL_MEASURED)
        b->normal[i] = face_viewer(b->normal[i], b->view[i]);
    b->radiance[i][0] = b->radiance[i][1] = b->radiance[i][2] = 0;
}

/* A run of `count` pixels of one slot, for a material that needs the view. */
static void gather_run(const struct output *o, const struct raster_slot *slot, uint32_t x, uint32_t y, uint32_t count,
                       struct raster_stats *stats)
{
    for (uint32_t end = x + count; x < end; x++)
        gather_pixel(o, slot, x, y, &o->t->surface[y * RASTER_TILE_WIDTH + x], 1, stats);
}

/* The same for a material that is shaded run by run and needs no batch of its own: runs go through the batch's radiance. A run is at
 * most a row, thus a batch, long. */
static void shade_run(const struct output *o, const struct raster_slot *slot, uint32_t x, uint32_t y, uint32_t count,
                      bool diffuse, struct raster_stats *stats)
{
    struct raster_batch *b = &o->t->batch;
    const struct raster_surface *s = o->t->surface + y * RASTER_TILE_WIDTH + x;
    if (b->count)
        flush(o, stats);
    if (diffuse)
        raster_shade_diffuse(b, o->r, slot, s, count);
    else
        raster_shade_blinn_phong_run(b, o->r, slot, s, o->x0 + x, o->y0 + y, count);
    raster_finish_pixels(b->radiance[0], b->radiance, count, o->r->frame.output->tone_curve, o->format);
    put_run(o, x, y, b->radiance[0], count);
    stats->shaded += count * o->r->frame.light_count;
}

/* Pixels without a slot from x on: background, or shaded before. Returns where they end. */
static uint32_t plain_run(const struct output *o, uint32_t background, uint32_t x, uint32_t y,
                          struct raster_stats *stats)
{
    const struct raster_surface *row = o->t->surface + y * RASTER_TILE_WIDTH;
    const uint32_t width = o->width;
    if (o->target == TARGET_SAMPLES) {
        while (x < width && !(row[x].depth_slot & 255))
            x++;
        return x;
    }
    for (; x < width && row[x].depth_slot && !(row[x].depth_slot & 255); x++, stats->covered++)
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

static void shade_rows(const struct output *o, struct raster_stats *stats)
{
    const struct raster *r = o->r;
    const uint32_t background = raster_background(&r->frame, o->format);
    for (uint32_t y = 0; y < o->height; y++) {
        const struct raster_surface *row = o->t->surface + y * RASTER_TILE_WIDTH;
        for (uint32_t x = 0; x < o->width;) {
            uint32_t slot = row[x].depth_slot & 255, count = 1;
            if (!slot) {
                x = plain_run(o, background, x, y, stats);
                continue;
            }
            while (x + count < o->width && (row[x + count].depth_slot & 255) == slot)
                count++;
            stats->covered += o->target == TARGET_PIXELS ? count : 0;
            const struct raster_slot *info = &o->t->slots[slot];
            const struct scene_material *m = &r->frame.materials[info->material];
            bool diffuse = raster_is_diffuse(m);
            if (!r->sample_shift && (diffuse || raster_has_blinn_phong_run(r, m)))
                shade_run(o, info, x, y, count, diffuse, stats);
            else
                gather_run(o, info, x, y, count, stats);
            x += count;
        }
    }
}

/* One pixel's four samples, s[0] first: those that have a colour already are summed into the first one's normal, the others
 * are shaded once for each slot, with the first such sample's normal. Returns whether any shows a surface. */
static bool resolve_pixel(const struct output *o, uint32_t background, uint32_t x, uint32_t y,
                          struct raster_stats *stats)
{
    struct raster_surface *first = &o->t->surface[y * RASTER_TILE_WIDTH + x];
    const struct raster_surface s[4] = {first[0], first[1], first[RASTER_TILE_WIDTH], first[RASTER_TILE_WIDTH + 1]};
    uint32_t sum = 0;
    bool covered = false;
    for (int i = 0; i < 4; i++) {
        if (!(s[i].depth_slot & 255))
            sum += spread(s[i].depth_slot ? s[i].normal : background);
        covered |= s[i].depth_slot != 0;
    }
    first->normal = sum;
    for (int i = 0; i < 4; i++) {
        uint32_t slot = s[i].depth_slot & 255, weight = 0;
        for (int k = 0; k < 4 && slot; k++) {
            bool same = (s[k].depth_slot & 255) == slot;
            if (same && k < i)
                slot = 0; /* shaded with the earlier sample */
            weight += same;
        }
        if (slot)
            gather_pixel(o, &o->t->slots[slot], x, y, &s[i], weight, stats);
    }
    return covered;
}

static void resolve_tile(const struct output *o, struct raster_stats *stats)
{
    const uint32_t background = raster_background(&o->r->frame, RASTER_RGB888);
    for (uint32_t y = 0; y < o->height; y++)
        for (uint32_t x = 0; x < o->width; x++)
            stats->covered += resolve_pixel(o, background, 2 * x, 2 * y, stats);
    if (o->t->batch.count)
        flush(o, stats);
    for (uint32_t y = 0; y < o->height; y++)
        for (uint32_t x = 0; x < o->width; x++) {
            uint32_t sum =
                o->t->surface[2 * y * RASTER_TILE_WIDTH + 2 * x].normal + 0x00200802u; /* 2 in each, to round */
            uint32_t bgr = (sum >> 2 & 0xff) | (sum >> 4 & 0xff00) | (sum >> 6 & 0xff0000);
            store_pixel(o, y * o->width + x, raster_pack(bgr, o->r->frame.format));
        }
}

static void shade(const struct output *o, struct raster_stats *stats)
{
    o->t->batch.count = 0;
    o->t->batch.diffuse_material = 0;
    if (o->target == TARGET_RESOLVE) {
        resolve_tile(o, stats);
        return;
    }
    shade_rows(o, stats);
    if (o->t->batch.count)
        flush(o, stats);
}

void raster_shade_tile(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                       struct raster_stats *stats)
{
    const struct output o = make_output(r, t, rect, r->sample_shift ? TARGET_RESOLVE : TARGET_PIXELS);
    shade(&o, stats);
}

void raster_shade_samples(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect,
                          struct raster_stats *stats)
{
    const struct output o = make_output(r, t, rect, TARGET_SAMPLES);
    shade(&o, stats);
}
