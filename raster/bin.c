/*
 * The frame's first half: set up and cull objects, choose their levels of detail, cull meshlets, bin what survives to tiles.
 *
 * The arena holds, in this order: list heads, lights, objects in view, runs (internal.h), which are a tile's list. Ids of 16 bits name
 * what is in the arena, not what is in the world. A meshlet is bound by its box's projection, not by a sphere: half as many entries.
 */
#include "block.h"
#include "bound.h"

#define FIRST_THRESHOLD (1u << 12) /* 1/16 px: what doubling starts from where the scene asks for the finest levels */
#define MAX_BIAS        30         /* the coarsest levels */

/* The newest run of a tile, as far as counting runs takes. */
struct newest {
    uint32_t object; /* as raster_run has it; UINT32_MAX: none */
    uint32_t meshlet;
};

#define WINDOW_TILES 48 /* whose runs are counted together, on the stack */

/* Where binning puts its results, or only counts them. */
struct binner {
    struct raster *r;
    struct magnitude pixels; /* threshold / (focal * H/2) */
    bool objects_stored;     /* in the arena; else they are set up again whenever they are needed */
    bool full;               /* more than run_limit runs: binning ended */
    bool coarsest;           /* every object in view was drawn at its last level */
    uint32_t bias;
    size_t fixed_bytes; /* heads, lights and objects */
    size_t arena_bytes;
    uint32_t run_count, run_limit;
    struct newest *window; /* NULL: runs are stored; else counted, in the tiles from window_first on */
    uint32_t window_first;
    uint16_t *heads;             /* where they are stored */
    bool at_coarsest;            /* every object is taken at its last level, for coarse_heads */
    struct raster_extent extent; /* of the object in hand, with bounds */
};

/* Tiles a meshlet touches, and its class. */
struct coverage {
    struct raster_tiles tiles;
    int32_t nearest; /* smallest W of its corners */
    bool cut;        /* may have to be clipped */
    uint32_t flags;  /* VISIBLE_* */
};

const char *raster_status_text(enum raster_status s)
{
    static const char *const text[RASTER_STATUS_COUNT] = {
        "no error",
        "the picture is empty or larger than 4096 x 4096, 2048 x 2048 with 4 samples, or its samples are not 1 or 4",
        "the arena is too small for this frame, even at the coarsest levels of detail",
        "a measured material's slot holds no table",
        "more than 65535 runs of meshlets in tiles, even at the coarsest levels of detail",
        "the tiles' budget is too small for this frame, even at the coarsest levels of detail",
        "a material asks for a model that this program is without",
        "a light is a point light, which this program is without",
    };
    return (unsigned)s < RASTER_STATUS_COUNT ? text[s] : "unknown raster status";
}

/*
 * Back-face cone: f(p) = (p-eye).axis - cutoff |p-eye| >= 0 over the meshlet's box. f changes by at most |dp| where it is
 * positive, so f(centre) >= radius is enough. Units are vertex units >> eye_shift; the roundings are taken off f.
 */
static bool cone_culled(const struct raster_object *o, const struct scene_meshlet *m)
{
    if (m->cone_cutoff >= 16384)
        return false;
    unsigned shift = o->eye_shift;
    int64_t along = 0, length2 = 0;
    int32_t half[3];
    for (int i = 0; i < 3; i++) {
        int32_t centre = (m->lo[i] + m->hi[i]) >> 1, to = shift > 16 ? -o->eye[i] : (centre >> shift) - o->eye[i];
        half[i] = m->hi[i] - m->lo[i];
        along += (int64_t)to * m->frame[6 + i]; /* 2^17 * 2^14 */
        length2 += (int64_t)to * to;            /* < 3 * 2^34 */
    }
    int32_t a = fx_max(half[0], fx_max(half[1], half[2])), sum = half[0] + half[1] + half[2];
    int32_t radius = (a + ((sum - a) >> 1) + 1) >> 1; /* sqrt(a^2+b^2+c^2) <= a + b/2 + c/2, halved: < 2^17 */
    int32_t d = (int32_t)(along >> 14) - (shift > 16 ? 1 : radius >> shift) - 8;
    if (d <= 0)
        return false;
    /* d^2 * 2^28 >= cutoff^2 * length2: 2^34 * 2^28, 2^28 * 2^35.6 < 2^64 */
    return (uint64_t)((int64_t)d * d) << 28 >= (uint64_t)length2 * (uint32_t)(m->cone_cutoff * m->cone_cutoff);
}

/* The least and the largest X, Y and W of a box. */
static void box_extremes(int32_t least[3], int32_t most[3], const struct raster_object *o, const int16_t lo[3],
                         const int16_t hi[3])
{
    for (unsigned i = 0; i < 3; i++) {
        int64_t a = o->offset[i], b;
        for (unsigned k = 0; k < 3; k++)
            a += (int64_t)o->row[i][k] * lo[k];
        b = a;
        for (unsigned k = 0; k < 3; k++) {
            int64_t side = (int64_t)o->row[i][k] * (hi[k] - lo[k]);
            a += side < 0 ? side : 0;
            b += side < 0 ? 0 : side;
        }
        least[i] = (int32_t)(a >> ROW_BITS);
        most[i] = (int32_t)(b >> ROW_BITS);
    }
}

/*
 * Points, in front of the near plane, whose projections bound the box's; returns how many. X/W and Y/W lie between those of the
 * extremes, which exceed the corners' by the share by which W varies: four points do where that is little, or where the near plane cuts
 * the box.
 */
static unsigned box_points(struct raster_clip_vertex c[8], const struct raster_object *o, const int16_t lo[3],
                           const int16_t hi[3], const int32_t least[3], const int32_t most[3])
{
    bool cut = least[2] < o->near_w;
    if (!cut && most[2] - least[2] > least[2] >> 4) {
        for (unsigned i = 0; i < 8; i++) {
            const struct scene_vertex corner = {i & 1 ? hi[0] : lo[0], i & 2 ? hi[1] : lo[1], i & 4 ? hi[2] : lo[2], 0,
                                                0};
            raster_transform(&c[i], o, &corner);
        }
        return 8;
    }
    for (unsigned i = 0; i < 4; i++) {
        const int32_t *xy = i & 1 ? most : least;
        c[i] = (struct raster_clip_vertex){xy[0], xy[1], i & 2 ? most[2] : cut ? o->near_w : least[2], 0, 0};
    }
    return 4;
}

/* Projects the box; false when it is outside the view. What is out of the guard band is taken to its border: off the picture. */
static bool box_coverage(struct coverage *out, const struct raster *r, const struct raster_object *o,
                         const int16_t lo[3], const int16_t hi[3])
{
    const int32_t width = r->width, height = r->height;
    int32_t x0 = INT32_MAX, y0 = INT32_MAX, x1 = INT32_MIN, y1 = INT32_MIN, least[3], most[3];
    uint32_t inv_w0 = UINT32_MAX, inv_w1 = 0;
    struct raster_clip_vertex c[8];
    box_extremes(least, most, o, lo, hi);
    if (most[2] < o->near_w)
        return false;
    unsigned points = box_points(c, o, lo, hi, least, most);
    for (unsigned i = 0; i < points; i++) {
        struct raster_vertex p;
        raster_project(&p, o, &c[i], width * 256 + 1, height * 256 + 1);
        x0 = fx_min(x0, p.x);
        x1 = fx_max(x1, p.x);
        y0 = fx_min(y0, p.y);
        y1 = fx_max(y1, p.y);
        inv_w0 = p.inv_w < inv_w0 ? p.inv_w : inv_w0;
        inv_w1 = p.inv_w > inv_w1 ? p.inv_w : inv_w1;
    }
    const int32_t w0 = fx_max(least[2], o->near_w), w1 = most[2];
    uint32_t bits = 32 - fx_clz(inv_w1 | 1);
    out->nearest = least[2];
    const int32_t guard = (1 << (GUARD_BITS + 8)) - 512; /* from the centre, 1/256 px */
    out->cut = least[2] < o->near_w || fx_min(x0 - width * 128, y0 - height * 128) < -guard ||
               fx_max(x1 - width * 128, y1 - height * 128) > guard;
    out->flags = VISIBLE_SHIFT(bits > NORMAL_BITS ? bits - NORMAL_BITS : 0);
    /* A vertex inside the box may round 1/256 px beyond the corners'. First pixel centre >= x0-1, last < x1+1. */
    int32_t px0 = (x0 - 1 + 127) >> 8, px1 = (x1 + 1 - 128) >> 8, py0 = (y0 - 1 + 127) >> 8, py1 = (y1 + 1 - 128) >> 8;
    if (px0 > px1 || py0 > py1 || px1 < 0 || py1 < 0 || px0 >= width || py0 >= height)
        return false;
    /* The small path's shifts are in range for every w between the corners'. */
    int32_t near_lead = (int32_t)fx_clz((uint32_t)w0), far_lead = (int32_t)fx_clz((uint32_t)w1);
    if (least[2] >= o->near_w && x1 - x0 <= SMALL_EXTENT - 2 && y1 - y0 <= SMALL_EXTENT - 2 &&
        inv_w1 - inv_w0 <= SMALL_DEPTH && o->shift_xy - near_lead >= 0 && o->shift_xy - far_lead <= 31 &&
        o->shift_depth - near_lead >= 6 && o->shift_depth - far_lead <= 31)
        out->flags |= VISIBLE_SMALL;
    out->tiles.x0 = fx_max(px0, 0) / RASTER_TILE_WIDTH;
    out->tiles.y0 = fx_max(py0, 0) / RASTER_TILE_HEIGHT;
    out->tiles.x1 = fx_min(px1, width - 1) / RASTER_TILE_WIDTH;
    out->tiles.y1 = fx_min(py1, height - 1) / RASTER_TILE_HEIGHT;
    return true;
}

/* Whether a run whose newest meshlet is `newest` takes another, newer one. */
static inline bool run_takes(uint32_t run_object, uint32_t newest, uint32_t object, uint32_t meshlet)
{
    return run_object - (object << RUN_BITS) < RUN_BACK && meshlet - newest - 1 < UINT8_MAX;
}

/* False when there are too many runs. */
static inline bool take_run(struct binner *b)
{
    b->full = b->run_count == b->run_limit;
    b->run_count += !b->full;
    return !b->full;
}

FX_NOINLINE static void bin_store(struct binner *b, uint32_t tile, uint32_t object, uint32_t meshlet)
{
    uint16_t *head = &b->heads[tile];
    if (*head) {
        struct raster_run *run = &b->r->runs[*head - 1];
        if (run_takes(run->object, run->meshlet, object, meshlet)) {
            run->back[RUN_USED(run->object++)] = (uint8_t)(meshlet - run->meshlet);
            run->meshlet = meshlet;
            return;
        }
    }
    if (!take_run(b))
        return;
    struct raster_run *run = &b->r->runs[b->run_count - 1];
    run->next = *head;
    run->object = (uint16_t)(object << RUN_BITS);
    run->meshlet = meshlet;
    *head = (uint16_t)b->run_count;
}

static void bin_count(struct binner *b, uint32_t tile, uint32_t object, uint32_t meshlet)
{
    if (tile - b->window_first >= WINDOW_TILES)
        return;
    struct newest *run = &b->window[tile - b->window_first];
    const bool takes = run_takes(run->object, run->meshlet, object, meshlet);
    if (takes || take_run(b))
        *run = (struct newest){takes ? run->object + 1 : object << RUN_BITS, meshlet};
}

static void bin_meshlet(struct binner *b, uint32_t object, uint32_t meshlet, const struct coverage *c)
{
    b->r->visible_count++;
    for (int32_t ty = c->tiles.y0; ty <= c->tiles.y1; ty++)
        for (int32_t tx = c->tiles.x0; tx <= c->tiles.x1 && !b->full; tx++) {
            const uint32_t tile = (uint32_t)ty * b->r->tiles_x + (uint32_t)tx;
            if (b->window)
                bin_count(b, tile, object, meshlet | c->flags);
            else
                bin_store(b, tile, object, meshlet | c->flags);
        }
}

/*
 * The largest error of a level of detail that shows no larger than the threshold at depth w or behind it:
 * threshold * w / (scale * focal * H/2), in vertex units with 8 fraction bits. Each of four operations is off by less than
 * 2^-26, which the last line takes off.
 */
static uint32_t error_within(const struct binner *b, const struct scene_object *so, struct magnitude w)
{
    struct magnitude scale = magnitude_of(so->scale_mantissa);
    scale.e -= 30 + so->scale_shift;
    struct magnitude e = magnitude_mul(magnitude_mul(b->pixels, w), magnitude_inverse(scale));
    e.e += 8;
    if (e.e > 0)
        return UINT32_MAX;
    return e.e <= -32 ? 0 : (e.m - (e.m >> 23)) >> -e.e;
}

/* False when nothing of the object can be seen. */
static bool object_prepare(struct raster_object *o, const struct binner *b, const struct scene_object *so)
{
    const struct scene_mesh *mesh = &b->r->frame.scene->meshes[so->mesh];
    struct coverage c;
    raster_object_setup(o, &b->r->frame, so);
    if (!box_coverage(&c, b->r, o, mesh->lo, mesh->hi))
        return false;
    /* Rounding moves W by less than 2. What is nearer than the plane is not drawn. */
    struct magnitude w = magnitude_of((uint32_t)fx_max(c.nearest - 2, o->near_w));
    w.e -= o->scale_w;
    o->max_error = error_within(b, so, w);
    o->mesh = so->mesh;
    return true;
}

/* Sets up the objects in view; stores them if the arena has room for them. */
static void list_objects(struct binner *b)
{
    struct raster *r = b->r;
    const struct scene *s = r->frame.scene;
    for (uint32_t i = 0; i < s->header->objects.count; i++) {
        struct raster_object local;
        size_t end = b->fixed_bytes + sizeof local;
        bool fits = b->objects_stored && end <= b->arena_bytes;
        if (!object_prepare(fits ? &r->objects[r->object_count] : &local, b, &s->objects[i]))
            continue;
        b->objects_stored = fits;
        b->fixed_bytes = end;
        r->object_count++;
    }
}

/* The coarsest level that the threshold allows. */
static const struct scene_lod *choose_level(struct binner *b, const struct raster_object *o)
{
    const struct scene *s = b->r->frame.scene;
    const struct scene_mesh *mesh = &s->meshes[o->mesh];
    uint32_t error = s->header->lod_error ? o->max_error : 0, level = mesh->lod_count - 1;
    if (b->at_coarsest || b->bias == MAX_BIAS)
        return &s->lods[mesh->lod_first + level];
    if (b->bias) { /* doubled as often, from 1 at least */
        error = o->max_error | (o->max_error == 0);
        error = fx_clz(error) < b->bias ? UINT32_MAX : error << b->bias;
    }
    if (s->lods[mesh->lod_first + level].error > error >> 8)
        b->coarsest = false;
    while (level && s->lods[mesh->lod_first + level].error > error >> 8)
        level--;
    return &s->lods[mesh->lod_first + level];
}

static void bin_object(struct binner *b, const struct raster_object *o, uint32_t index)
{
    const struct scene_lod *lod = choose_level(b, o);
    const struct raster_bounds *bounds = b->window ? NULL : b->r->frame.bounds;
    if (bounds && !b->at_coarsest)
        bounds->object(&b->extent, b->r, o);
    for (uint32_t k = 0; k < lod->meshlet_count && !b->full; k++) {
        uint32_t id = lod->meshlet_first + k;
        const struct scene_meshlet *m = &b->r->frame.scene->meshlets[id];
        struct coverage c;
        if (cone_culled(o, m) || !box_coverage(&c, b->r, o, m->lo, m->hi))
            continue;
        bin_meshlet(b, index, id, &c);
        if (bounds)
            bounds->meshlet(b->r, b->at_coarsest ? NULL : &b->extent, o, m, &c.tiles, c.nearest, c.flags, c.cut);
    }
}

static void bin_objects(struct binner *b)
{
    const struct raster *r = b->r;
    const struct scene *s = r->frame.scene;
    b->coarsest = true;
    if (b->objects_stored) {
        for (uint32_t i = 0; i < r->object_count; i++)
            bin_object(b, &r->objects[i], i);
        return;
    }
    for (uint32_t i = 0, index = 0; i < s->header->objects.count; i++) {
        struct raster_object o;
        if (object_prepare(&o, b, &s->objects[i]))
            bin_object(b, &o, index++);
    }
}

static void start_bins(struct binner *b, uint32_t run_limit)
{
    b->run_limit = run_limit;
    b->run_count = b->r->visible_count = 0;
    b->full = false;
}

static void store_bins(struct binner *b)
{
    struct raster *r = b->r;
    const size_t room = (b->arena_bytes - b->fixed_bytes) / sizeof *r->runs;
    start_bins(b, room < UINT16_MAX ? (uint32_t)room : UINT16_MAX);
    b->window = NULL;
    r->runs = (struct raster_run *)(r->objects + r->object_count);
    for (uint32_t t = 0; t < raster_tile_count(r) * (r->bounds ? 2 : 1); t++)
        r->heads[t] = 0; /* coarse_heads follow */
    if (r->bounds) {
        r->frame.bounds->clear(r, &b->extent);
        b->heads = r->coarse_heads;
        b->at_coarsest = true;
        bin_objects(b);
        b->at_coarsest = false;
        r->visible_count = 0;
    }
    b->heads = r->heads;
    bin_objects(b);
}

/* How many runs there will be depends on what each tile's last one was: that of some tiles is kept at a time. */
FX_NOINLINE static void count_bins(struct binner *b)
{
    struct newest window[WINDOW_TILES];
    start_bins(b, UINT16_MAX);
    b->window = window;
    for (b->window_first = 0; b->window_first < raster_tile_count(b->r) && !b->full; b->window_first += WINDOW_TILES) {
        for (unsigned pass = b->r->frame.bounds ? 0 : 1; pass < 2; pass++) {
            for (uint32_t i = 0; i < WINDOW_TILES; i++)
                window[i].object = UINT32_MAX;
            b->at_coarsest = pass == 0;
            bin_objects(b);
        }
    }
}

static enum raster_status check_frame(struct raster *r, const struct raster_frame *f)
{
    const unsigned shift = raster_sample_shift(f);
    if (!f->width || !f->height || f->width > RASTER_MAX_WIDTH >> shift || f->height > RASTER_MAX_HEIGHT >> shift ||
        (f->samples > 1 && (f->samples != 4 || !f->parts->cells || RASTER_TILE_WIDTH < 32 || RASTER_TILE_HEIGHT < 32)))
        return RASTER_ERR_SIZE;
    if (f->light_count > SCENE_MAX_LIGHTS)
        return RASTER_ERR_LIMIT;
    for (uint32_t i = 0; i < f->scene->header->objects.count; i++) {
        const struct scene_material *m = &f->materials[f->scene->objects[i].material];
        if (m->kind == SCENE_MATERIAL_MEASURED && (m->slot >= RASTER_MAX_SLOTS || !f->tables[m->slot])) {
            r->bad_material = f->scene->objects[i].material;
            return RASTER_ERR_TABLE;
        }
        if (!raster_model_of(f, m)) {
            r->bad_material = f->scene->objects[i].material;
            return RASTER_ERR_MODEL;
        }
    }
    for (uint32_t i = 0; i < f->light_count; i++)
        if (f->lights[i].kind != SCENE_LIGHT_DIRECTIONAL && !f->parts->point_lights)
            return RASTER_ERR_POINT;
    return RASTER_OK;
}

FX_COLD enum raster_status raster_begin(struct raster *r, const struct raster_frame *f, void *arena, size_t bytes)
{
    r->arena_needed = 0;
    r->budget_needed = 0;
    enum raster_status status = check_frame(r, f);
    if (status != RASTER_OK)
        return status;
    r->frame = *f;
    r->sample_shift = (uint8_t)raster_sample_shift(f);
    r->width = (uint16_t)(f->width << r->sample_shift);
    r->height = (uint16_t)(f->height << r->sample_shift);
    r->tiles_x = (uint16_t)((r->width + RASTER_TILE_WIDTH - 1) / RASTER_TILE_WIDTH);
    r->tiles_y = (uint16_t)((r->height + RASTER_TILE_HEIGHT - 1) / RASTER_TILE_HEIGHT);
    uint32_t tiles = raster_tile_count(r);
    size_t head_bytes = ((f->bounds ? 2 : 1) * tiles * sizeof(uint16_t) + 7) & ~(size_t)7;
    size_t light_bytes = raster_light_bytes(f); /* both multiples of 8, for objects are 8-aligned */
    size_t bound_bytes = f->bounds ? (tiles * sizeof *r->bounds + 7) & ~(size_t)7 : 0;
    size_t fixed_bytes = head_bytes + light_bytes + bound_bytes;
    bytes &= ~(size_t)3;
    uint32_t threshold = f->scene->header->lod_error;
    struct binner b = {.r = r, .fixed_bytes = fixed_bytes, .arena_bytes = bytes};
    b.pixels = magnitude_mul(magnitude_of(threshold ? threshold : FIRST_THRESHOLD),
                             magnitude_inverse(magnitude_of((uint64_t)f->height * f->camera->focal)));
    b.pixels.e += 1; /* both have 16 fraction bits; H/2 */
    b.objects_stored = arena && bytes >= fixed_bytes;
    r->bounds = NULL;
    if (b.objects_stored) {
        uint8_t *p = arena;
        r->heads = (uint16_t *)p;
        r->lights = (struct raster_light *)(void *)(p + head_bytes);
        r->objects = (struct raster_object *)(p + fixed_bytes);
        if (f->bounds) {
            r->coarse_heads = r->heads + tiles;
            r->bounds = (struct raster_tile_bound *)(void *)(p + head_bytes + light_bytes);
        }
        raster_view_setup(&r->view, f->camera, f->width, f->height);
        raster_light_setup(r);
        r->block_shift = raster_block_shift(&r->view);
    }
    r->object_count = 0;
    list_objects(&b);
    bool fitted = false, back = false; /* coarser levels, which a budget asks for, may take more runs */
    for (b.bias = arena && !b.objects_stored ? MAX_BIAS : 0;; b.bias += back ? -1u : 1u) {
        if (b.objects_stored)
            store_bins(&b);
        else
            count_bins(&b);
        const bool too_much = !b.full && b.objects_stored && r->bounds && f->bounds->too_much(r, b.bias);
        if ((!b.full && !too_much) || back || (!(b.full && fitted) && (b.coarsest || b.bias == MAX_BIAS)))
            break;
        back = b.full && fitted;
        fitted = !b.full;
    }
    r->lod_bias = b.bias;
    const bool stored = b.objects_stored && !b.full;
    if (!stored && b.objects_stored)
        count_bins(&b);
    if (b.full)
        return RASTER_ERR_LIMIT;
    r->arena_needed = b.fixed_bytes + b.run_count * sizeof(struct raster_run);
    if (!stored)
        return RASTER_ERR_ARENA;
    return f->tile_budget && r->budget_needed > f->tile_budget ? RASTER_ERR_BUDGET : RASTER_OK;
}

size_t raster_arena_bytes(const struct raster_frame *f)
{
    struct raster r;
    return raster_begin(&r, f, NULL, 0) == RASTER_ERR_ARENA ? r.arena_needed : 0;
}
