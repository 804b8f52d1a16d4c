/*
 * The frame's first half: set up objects, cull meshlets, bin what survives to tiles.
 *
 * The arena holds, in this order: objects, list heads, visible meshlets (growing up); list nodes grow down from its end. A
 * meshlet is bound by its box's eight projected corners, not by a sphere: half as many entries.
 */
#include "internal.h"

/* Where binning puts its results, or only counts them. */
struct binner {
    struct raster *r;
    bool store;
    size_t fixed_bytes; /* objects and heads */
    size_t arena_bytes;
    uint32_t visible_count; /* counted on even when storing stops */
    uint32_t node_count;    /* node 0 is the list end and not used */
    struct raster_node *node_end;
};

/* Tiles a meshlet touches, inclusive, and its class. */
struct coverage {
    int32_t x0, y0, x1, y1;
    uint16_t flags;
};

const char *raster_status_text(enum raster_status s)
{
    static const char *const text[RASTER_STATUS_COUNT] = {
        "no error",
        "the picture's width or height is zero or above 4096",
        "the arena is too small for this frame",
        "a measured material's slot holds no table",
        "more than 65535 visible meshlets or bin entries",
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

/* Projects the box; false when it is outside the view. */
static bool box_coverage(struct coverage *out, const struct raster *r, const struct raster_object *o,
                         const struct scene_meshlet *m)
{
    const int32_t width = r->frame.width, height = r->frame.height;
    int32_t x0 = INT32_MAX, y0 = INT32_MAX, x1 = INT32_MIN, y1 = INT32_MIN;
    int32_t w0 = INT32_MAX, w1 = 0;
    uint32_t inv_w0 = UINT32_MAX, inv_w1 = 0;
    unsigned common = CLIP_NEAR | CLIP_LEFT | CLIP_RIGHT | CLIP_TOP | CLIP_BOTTOM, any = 0;
    for (unsigned i = 0; i < 8; i++) {
        struct scene_vertex corner = {i & 1 ? m->hi[0] : m->lo[0], i & 2 ? m->hi[1] : m->lo[1],
                                      i & 4 ? m->hi[2] : m->lo[2], 0, 0};
        struct raster_clip_vertex c;
        struct raster_vertex p;
        raster_transform(&c, o, &corner);
        unsigned code = raster_clip_code(o, &c);
        common &= code;
        any |= code;
        if (any)
            continue;
        raster_project(&p, o, &c, width * 256 + 1, height * 256 + 1);
        x0 = fx_min(x0, p.x);
        x1 = fx_max(x1, p.x);
        y0 = fx_min(y0, p.y);
        y1 = fx_max(y1, p.y);
        w0 = fx_min(w0, c.w);
        w1 = fx_max(w1, c.w);
        inv_w0 = p.inv_w < inv_w0 ? p.inv_w : inv_w0;
        inv_w1 = p.inv_w > inv_w1 ? p.inv_w : inv_w1;
    }
    if (common)
        return false;
    if (any) { /* reaches behind the near plane or out of the guard band: the whole picture may be touched */
        *out = (struct coverage){0, 0, r->tiles_x - 1, r->tiles_y - 1, VISIBLE_SHIFT(INV_W_BITS - NORMAL_BITS)};
        return true;
    }
    uint32_t bits = 32 - fx_clz(inv_w1 | 1);
    out->flags = VISIBLE_SHIFT(bits > NORMAL_BITS ? bits - NORMAL_BITS : 0);
    /* A vertex inside the box may round 1/256 px beyond the corners'. First pixel centre >= x0-1, last < x1+1. */
    int32_t px0 = (x0 - 1 + 127) >> 8, px1 = (x1 + 1 - 128) >> 8, py0 = (y0 - 1 + 127) >> 8, py1 = (y1 + 1 - 128) >> 8;
    if (px0 > px1 || py0 > py1 || px1 < 0 || py1 < 0 || px0 >= width || py0 >= height)
        return false;
    /* The small path's shifts are in range for every w between the corners'. */
    int32_t near_lead = (int32_t)fx_clz((uint32_t)w0), far_lead = (int32_t)fx_clz((uint32_t)w1);
    if (x1 - x0 <= SMALL_EXTENT - 2 && y1 - y0 <= SMALL_EXTENT - 2 && inv_w1 - inv_w0 <= SMALL_DEPTH &&
        o->shift_xy - near_lead >= 0 && o->shift_xy - far_lead <= 31 && o->shift_depth - near_lead >= 6 &&
        o->shift_depth - far_lead <= 31)
        out->flags |= VISIBLE_SMALL;
    out->x0 = fx_max(px0, 0) / RASTER_TILE_WIDTH;
    out->y0 = fx_max(py0, 0) / RASTER_TILE_HEIGHT;
    out->x1 = fx_min(px1, width - 1) / RASTER_TILE_WIDTH;
    out->y1 = fx_min(py1, height - 1) / RASTER_TILE_HEIGHT;
    return true;
}

static void bin_meshlet(struct binner *b, uint32_t object, uint32_t meshlet, const struct coverage *c)
{
    struct raster *r = b->r;
    uint32_t nodes = (uint32_t)(c->x1 - c->x0 + 1) * (uint32_t)(c->y1 - c->y0 + 1);
    uint32_t id = b->visible_count++;
    b->node_count += nodes;
    size_t needed = b->fixed_bytes + (size_t)b->visible_count * sizeof(struct raster_visible) +
                    (size_t)b->node_count * sizeof(struct raster_node);
    if (b->visible_count > UINT16_MAX || b->node_count > UINT16_MAX || needed > b->arena_bytes)
        b->store = false;
    if (!b->store)
        return;
    r->visible[id] = (struct raster_visible){(uint16_t)object, c->flags, meshlet};
    uint32_t node = b->node_count - nodes;
    for (int32_t ty = c->y0; ty <= c->y1; ty++)
        for (int32_t tx = c->x0; tx <= c->x1; tx++) {
            uint16_t *head = &r->heads[(uint32_t)ty * r->tiles_x + (uint32_t)tx];
            node++; /* entry n lies n before the end, so that 0 can mean none */
            b->node_end[-(ptrdiff_t)node] = (struct raster_node){(uint16_t)id, *head};
            *head = (uint16_t)node;
        }
}

static void bin_objects(struct binner *b)
{
    struct raster *r = b->r;
    const struct scene *s = r->frame.scene;
    for (uint32_t i = 0; i < s->header->objects.count; i++) {
        struct raster_object local, *o = b->store ? &r->objects[i] : &local;
        raster_object_setup(o, &r->frame, &s->objects[i]);
        const struct scene_lod *lod = &s->lods[s->meshes[s->objects[i].mesh].lod_first];
        for (uint32_t k = 0; k < lod->meshlet_count; k++) {
            uint32_t id = lod->meshlet_first + k;
            const struct scene_meshlet *m = &s->meshlets[id];
            struct coverage c;
            if (!cone_culled(o, m) && box_coverage(&c, r, o, m))
                bin_meshlet(b, i, id, &c);
        }
    }
}

/* Lights into eye space, times exposure. */
static void light_setup(struct raster *r)
{
    const q2_30_t *m = r->frame.camera->rotation;
    for (unsigned i = 0; i < r->frame.light_count; i++) {
        const struct scene_light *l = &r->frame.lights[i];
        int32_t d[3];
        for (int j = 0; j < 3; j++) { /* Q60 to Q15 */
            int64_t q60 = (int64_t)m[3 * j] * l->direction[0] + (int64_t)m[3 * j + 1] * l->direction[1] +
                          (int64_t)m[3 * j + 2] * l->direction[2];
            d[j] = (int32_t)((q60 + ((int64_t)1 << 44)) >> 45);
        }
        r->lights[i].direction = (struct vec3){d[0], d[1], d[2]};
        for (int j = 0; j < 3; j++) {
            uint64_t e = (uint64_t)l->irradiance[j] * r->frame.output->exposure >> 16;
            r->lights[i].irradiance[j] = e > UINT32_MAX ? UINT32_MAX : (uint32_t)e;
        }
    }
}

static enum raster_status check_frame(struct raster *r, const struct raster_frame *f)
{
    if (!f->width || !f->height || f->width > RASTER_MAX_WIDTH || f->height > RASTER_MAX_HEIGHT)
        return RASTER_ERR_SIZE;
    for (uint32_t i = 0; i < f->scene->header->objects.count; i++) {
        const struct scene_material *m = &f->materials[f->scene->objects[i].material];
        if (m->kind == SCENE_MATERIAL_MEASURED && (m->slot >= RASTER_MAX_SLOTS || !f->tables[m->slot])) {
            r->bad_material = f->scene->objects[i].material;
            return RASTER_ERR_TABLE;
        }
    }
    return RASTER_OK;
}

enum raster_status raster_begin(struct raster *r, const struct raster_frame *f, void *arena, size_t bytes)
{
    r->arena_needed = 0;
    enum raster_status status = check_frame(r, f);
    if (status != RASTER_OK)
        return status;
    r->frame = *f;
    r->tiles_x = (uint16_t)((f->width + RASTER_TILE_WIDTH - 1) / RASTER_TILE_WIDTH);
    r->tiles_y = (uint16_t)((f->height + RASTER_TILE_HEIGHT - 1) / RASTER_TILE_HEIGHT);
    uint32_t tiles = raster_tile_count(r);
    size_t object_bytes = f->scene->header->objects.count * sizeof(struct raster_object);
    size_t head_bytes = (tiles * sizeof(uint16_t) + 3) & ~(size_t)3;
    bytes &= ~(size_t)3;
    struct binner b = {.r = r, .fixed_bytes = object_bytes + head_bytes, .arena_bytes = bytes};
    b.store = arena && bytes >= b.fixed_bytes;
    if (b.store) {
        uint8_t *p = arena;
        r->objects = (struct raster_object *)p;
        r->heads = (uint16_t *)(p + object_bytes);
        r->visible = (struct raster_visible *)(p + b.fixed_bytes);
        b.node_end = (struct raster_node *)(p + bytes);
        r->nodes = b.node_end;
        for (uint32_t t = 0; t < tiles; t++)
            r->heads[t] = 0;
    }
    bin_objects(&b);
    r->visible_count = b.visible_count;
    r->node_count = b.node_count;
    if (b.visible_count > UINT16_MAX || b.node_count > UINT16_MAX)
        return RASTER_ERR_LIMIT;
    r->arena_needed = b.fixed_bytes + (size_t)b.visible_count * sizeof(struct raster_visible) +
                      (size_t)b.node_count * sizeof(struct raster_node);
    if (!b.store)
        return RASTER_ERR_ARENA;
    light_setup(r);
    raster_view_setup(&r->view, f->camera, f->width, f->height);
    return RASTER_OK;
}

size_t raster_arena_bytes(const struct raster_frame *f)
{
    struct raster r;
    return raster_begin(&r, f, NULL, 0) == RASTER_ERR_ARENA ? r.arena_needed : 0;
}
