/*
 * One tile: transform and draw its meshlets, then shade what is visible.
 */
#include "internal.h"
#include "quality.h"

static void clear_surface(struct raster_tile *t)
{
    const struct raster_surface empty = {0, 0};
    for (struct raster_surface *p = t->surface, *end = p + RASTER_TILE_PIXELS; p != end; p += 8)
        p[0] = p[1] = p[2] = p[3] = p[4] = p[5] = p[6] = p[7] = empty;
}

/* What shading needs of a meshlet: its frame's axes in eye space, Q14. |sums| <= sqrt(3) * 2^28. */
static void slot_setup(struct raster_slot *s, const struct raster_object *o, const struct scene_meshlet *m,
                       unsigned normal_shift)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int32_t sum = o->rotation[3 * i] * m->frame[3 * j] + o->rotation[3 * i + 1] * m->frame[3 * j + 1] +
                          o->rotation[3 * i + 2] * m->frame[3 * j + 2];
            s->frame[3 * i + j] = (int16_t)((sum + (1 << 13)) >> 14);
        }
    s->material = o->material;
    s->normal_shift = (uint8_t)normal_shift;
    s->class_id = 0;
}

static void project(struct raster_vertex *p, const struct raster_object *o, const struct raster_clip_vertex *c,
                    unsigned normal_shift, int32_t centre_x2, int32_t centre_y2)
{
    raster_project(p, o, c, centre_x2, centre_y2);
    p->u = (int16_t)raster_homogeneous(c->u, p->inv_w, normal_shift);
    p->v = (int16_t)raster_homogeneous(c->v, p->inv_w, normal_shift);
}

/* A triangle that reaches behind the near plane or out of the guard band: its clipped polygon as a fan. */
FX_COLD static void draw_clipped(struct raster_tile *t, const struct raster_object *o, const struct scene_triangle *tri,
                                 unsigned codes, int32_t centre_x2, int32_t centre_y2, uint32_t slot,
                                 struct raster_stats *stats)
{
    struct raster_clip_vertex p[CLIP_MAX_VERTICES];
    struct raster_vertex v[CLIP_MAX_VERTICES];
    for (unsigned i = 0; i < 3; i++)
        p[i] = t->m.general.clip[tri->v[i]];
    unsigned count = raster_clip_polygon(p, 3, codes, o);
    for (unsigned i = 0; i < count; i++)
        project(&v[i], o, &p[i], t->slots[slot].normal_shift, centre_x2, centre_y2);
    for (unsigned i = 2; i < count; i++)
        raster_draw_general(t, &v[0], &v[i - 1], &v[i], slot, stats);
}

FX_COLD static void draw_general(struct raster_tile *t, const struct raster_object *o, const struct scene_meshlet *m,
                                 const struct scene_vertex *vertex, const struct scene_triangle *triangle,
                                 uint32_t slot, int32_t centre_x2, int32_t centre_y2, struct raster_stats *stats)
{
    struct raster_vertex *p = t->m.general.vertices;
    uint8_t code[SCENE_MESHLET_MAX_VERTICES];
    for (unsigned i = 0; i < m->vertex_count; i++) {
        raster_transform(&t->m.general.clip[i], o, &vertex[i]);
        code[i] = (uint8_t)raster_clip_code(o, &t->m.general.clip[i]);
        if (!code[i])
            project(&p[i], o, &t->m.general.clip[i], t->slots[slot].normal_shift, centre_x2, centre_y2);
    }
    for (unsigned i = 0; i < m->triangle_count; i++) {
        const uint8_t *v = triangle[i].v;
        unsigned all = code[v[0]] & code[v[1]] & code[v[2]], any = code[v[0]] | code[v[1]] | code[v[2]];
        if (!any)
            raster_draw_general(t, &p[v[0]], &p[v[1]], &p[v[2]], slot, stats);
        else if (!all)
            draw_clipped(t, o, &triangle[i], any, centre_x2, centre_y2, slot, stats);
    }
}

/* By the counts that there are: clipping is not, rows are taken to be of 16 pixels and the triangle's last. */
FX_COLD static void charge_meshlet(const struct raster *r, const struct scene_meshlet *m, uint32_t visible,
                                   const struct raster_stats *before, struct raster_stats *stats)
{
    const uint32_t drawn = stats->triangles - before->triangles, tested = stats->tested - before->tested,
                   general = stats->general - before->general;
    const struct raster_costs *c = r->frame.costs;
    if (!c)
        return;
    const uint32_t triangle = c->triangle + (visible & VISIBLE_SMALL ? 0 : c->general);
    stats->cost += c->meshlet + m->vertex_count * c->vertex + m->triangle_count * triangle; /* 2^26 */
    stats->cost +=
        (uint64_t)tested * c->tested + (uint64_t)(drawn + tested / 16) * c->row + (uint64_t)drawn * c->facing;
    stats->cost += (uint64_t)general * c->general_tested + (uint64_t)(general / 16) * c->general_row;
}

/* In: `visible` as raster_run has it. */
static void draw_meshlet(const struct raster *r, struct raster_tile *t, const struct raster_object *o, uint32_t visible,
                         uint32_t slot, int32_t centre_x2, int32_t centre_y2, struct raster_stats *stats)
{
    const struct scene *s = r->frame.scene;
    const struct scene_meshlet *m = &s->meshlets[VISIBLE_MESHLET(visible)];
    const struct scene_vertex *vertex = s->vertices + m->vertex_first;
    const struct scene_triangle *triangle = s->triangles + m->triangle_first;
    unsigned normal_shift = VISIBLE_GET_SHIFT(visible);
    slot_setup(&t->slots[slot], o, m, normal_shift);
    t->slots[slot].memory =
        (uint16_t)((VISIBLE_MESHLET(visible) * 2654435761u + (uint32_t)(o - r->objects) * 1367130551u) >>
                   (32 - RASTER_MEMORY_SHIFT)); /* multiples of the golden section: even */
    const struct raster_stats before = *stats;
    if (visible & VISIBLE_SMALL) {
        raster_transform_small(t->m.small, o, vertex, m->vertex_count, normal_shift, centre_x2 - 256, centre_y2 - 256);
        raster_draw_small(t, t->m.small, triangle, m->triangle_count, slot, stats);
    } else {
        draw_general(t, o, m, vertex, triangle, slot, centre_x2, centre_y2, stats);
    }
    charge_meshlet(r, m, visible, &before, stats);
}

FX_COLD static void start_run(struct raster_tile *t, const struct raster *r, uint32_t id)
{
    t->run = id;
    if (!id)
        return;
    t->meshlet = r->runs[id - 1].meshlet;
    t->run_left = RUN_USED(r->runs[id - 1].object);
}

void raster_tile_begin(const struct raster *r, uint32_t index, struct raster_tile *t, struct raster_rect *rect,
                       struct raster_stats *stats)
{
    /* In samples; even with 4 of them per pixel, as the tile's size is. */
    uint32_t x = index % r->tiles_x * RASTER_TILE_WIDTH, y = index / r->tiles_x * RASTER_TILE_HEIGHT;
    uint32_t right = r->width - x, below = r->height - y, shift = r->sample_shift;
    *rect = (struct raster_rect){(uint16_t)(x >> shift), (uint16_t)(y >> shift),
                                 (uint16_t)((right < RASTER_TILE_WIDTH ? right : RASTER_TILE_WIDTH) >> shift),
                                 (uint16_t)((below < RASTER_TILE_HEIGHT ? below : RASTER_TILE_HEIGHT) >> shift)};
    *stats = (struct raster_stats){.cost = r->frame.costs ? r->frame.costs->tile : 0};
    clear_surface(t);
    t->memory = NULL;
    t->centre_x2 = r->width * 256 - (int32_t)x * 512 + 1;
    t->centre_y2 = r->height * 256 - (int32_t)y * 512 + 1;
    start_run(t, r, r->heads[index]);
    t->slot_count = 0;
}

enum raster_drawing raster_tile_draw(const struct raster *r, struct raster_tile *t, uint32_t most,
                                     struct raster_stats *stats)
{
    for (; t->run; stats->meshlets++) {
        const struct raster_run *run = &r->runs[t->run - 1];
        if (t->slot_count == RASTER_SLOTS - 1)
            return RASTER_NO_SLOT;
        if (!most--)
            return RASTER_MORE;
        draw_meshlet(r, t, &r->objects[run->object >> RUN_BITS], t->meshlet, ++t->slot_count, t->centre_x2,
                     t->centre_y2, stats);
        if (t->run_left)
            t->meshlet -= run->back[--t->run_left];
        else
            start_run(t, r, run->next);
    }
    return RASTER_DRAWN;
}

void raster_tile_restart(const struct raster *r, uint32_t index, struct raster_tile *t)
{
    clear_surface(t);
    start_run(t, r, r->coarse_heads[index]);
    t->slot_count = 0;
}

void raster_render_tile(const struct raster *r, uint32_t index, struct raster_tile *work, struct raster_rect *rect,
                        struct raster_stats *stats)
{
    raster_tile_begin(r, index, work, rect, stats);
    while (raster_tile_draw(r, work, UINT32_MAX, stats) == RASTER_NO_SLOT) {
        raster_shade_regions(r, work, rect, stats);
        raster_tile_free_slots(r, work, rect, stats);
    }
    raster_shade_tile(r, work, rect, stats);
}
