#include "bound.h"

#include "quality.h"

/* A triangle cut by every plane is a polygon of 8 vertices, a fan of 6. */
#define FAN (CLIP_MAX_VERTICES - 2)

static uint32_t cost_ticks(uint64_t cost)
{
    cost = (cost + (1u << RASTER_COST_BITS) - 1) >> RASTER_COST_BITS;
    return cost < UINT32_MAX ? (uint32_t)cost : UINT32_MAX;
}

void raster_bounds_clear(struct raster *r)
{
    for (uint32_t t = 0; t < raster_tile_count(r); t++)
        r->bounds[t] = (struct raster_tile_bound){0};
}

struct magnitude raster_corner_secant(const struct raster_frame *f)
{
    const uint32_t w = f->width, h = f->height;
    const struct magnitude inverse = magnitude_inverse(magnitude_of((uint64_t)h * f->camera->focal));
    struct magnitude tan2 = magnitude_mul(magnitude_of(w * w + h * h), magnitude_mul(inverse, inverse));
    tan2.e += 32 + 15; /* focal's fraction bits, twice; half of it, 16 fraction bits */
    struct magnitude secant = magnitude_of((1u << 16) + (uint64_t)magnitude_above(tan2));
    secant.e -= 16;
    return secant;
}

/* Of one sample at full quality; lights reach about five in eight of what they are tried on, point lights one in four. */
static uint32_t full_cost(const struct raster *r, uint32_t material)
{
    const struct raster_costs *c = r->frame.costs;
    const unsigned k = raster_shading_of(r, material, RASTER_RATE_1X1);
    const uint64_t points = r->frame.light_count - r->directional;
    const uint64_t sum = c->shading[k].sample +
                         (r->directional * (5 * (uint64_t)c->shading[k].lit + 3 * (uint64_t)c->shading[k].dark) >> 3) +
                         (points * c->shading[k].point >> 2);
    return sum < UINT32_MAX ? (uint32_t)sum : UINT32_MAX;
}

void raster_extent_setup(struct raster_extent *e, const struct raster *r, const struct raster_object *o,
                         struct magnitude corner_secant)
{
    uint64_t square = 0; /* of the length of X's row: of rotation times scale; entries below 2^31 */
    for (int j = 0; j < 3; j++)
        square += (uint64_t)((int64_t)o->row[0][j] * o->row[0][j]);
    e->length = magnitude_mul(magnitude_root(magnitude_of(square)), corner_secant);
    /* half sub-pixels times W, with ROW_BITS fraction bits: raster_project */
    e->length.e += 29 - o->shift_xy - ROW_BITS - 9;
    e->pixel_cost = full_cost(r, o->material);
}

/* Of rows and pixels: in general coordinates they take more; half as much again, as boxes are not filled. */
static uint64_t fill_cost(const struct raster_costs *c, uint32_t rows, uint32_t tested, bool small)
{
    const uint64_t cost = (uint64_t)c->row * rows + (uint64_t)c->tested * tested;
    return small ? cost : cost + cost / 2;
}

void raster_load_find(struct raster_load *load, const struct raster *r, const struct raster_extent *e,
                      const struct raster_object *o, const struct scene_meshlet *m, int32_t nearest, bool small,
                      bool cut)
{
    const struct raster_costs *c = r->frame.costs;
    const struct magnitude unit =
        magnitude_mul(e->length, magnitude_inverse(magnitude_of((uint32_t)fx_max(nearest, o->near_w))));
    const uint32_t triangles = m->triangle_count;
    struct magnitude area = magnitude_mul(magnitude_mul(unit, unit), magnitude_of(scene_size(m->area)));
    area.e += 6;
    load->shown = magnitude_above(area);
    const uint32_t half = (magnitude_above(magnitude_mul(unit, magnitude_of(scene_size(m->perimeter)))) >> 1) + 1;
    const uint32_t sum = fx_add_sat_u(half, triangles), all = triangles * (RASTER_TILE_HEIGHT * (cut ? FAN : 1));
    const uint32_t rows = cut || sum > all ? all : sum; /* what clipping adds has edges of its own */
    const uint32_t tested = fx_add_sat_u(load->shown, sum), whole = triangles * RASTER_TILE_PIXELS;
    load->tested = tested < whole ? tested : whole;
    const uint64_t triangle =
        (uint64_t)c->triangle + (small ? 0 : c->general) + (cut ? c->clipped + (uint64_t)FAN * c->facing : c->facing);
    const uint64_t setup = c->meshlet + (uint64_t)c->vertex * m->vertex_count + triangle * triangles;
    load->setup = cost_ticks(setup);
    load->ticks = cost_ticks(setup + fill_cost(c, rows, load->tested, small));
}

/* Rows and pixels of a triangle, at most, on the screen: pixel centres in its box. */
struct box {
    int32_t x0, y0, x1, y1; /* inclusive */
};

enum facing { AWAY, TOWARDS, CUT };

static enum facing triangle_box(struct box *box, const struct raster *r, const struct raster_object *o,
                                const struct scene_meshlet *m, const struct scene_triangle *t)
{
    const struct scene_vertex *vertices = r->frame.scene->vertices + m->vertex_first;
    struct raster_vertex p[3];
    unsigned all = ~0u, any = 0;
    for (int i = 0; i < 3; i++) {
        struct raster_clip_vertex c;
        raster_transform(&c, o, &vertices[t->v[i]]);
        const unsigned code = raster_clip_code(o, &c);
        all &= code;
        any |= code;
        if (!code)
            raster_project(&p[i], o, &c, r->width * 256 + 1, r->height * 256 + 1);
    }
    *box = (struct box){0, 0, INT16_MAX, INT16_MAX}; /* beyond the picture, too: a tile is drawn whole */
    if (any)
        return all ? AWAY : CUT;
    const int64_t area =
        (int64_t)(p[1].x - p[0].x) * (p[2].y - p[0].y) - (int64_t)(p[1].y - p[0].y) * (p[2].x - p[0].x);
    if (area >= 0) /* counter-clockwise, y down: its normal's away */
        return AWAY;
    box->x0 = (fx_min(p[0].x, fx_min(p[1].x, p[2].x)) + 127) >> 8;
    box->y0 = (fx_min(p[0].y, fx_min(p[1].y, p[2].y)) + 127) >> 8;
    box->x1 = (fx_max(p[0].x, fx_max(p[1].x, p[2].x)) - 128) >> 8;
    box->y1 = (fx_max(p[0].y, fx_max(p[1].y, p[2].y)) - 128) >> 8;
    return TOWARDS;
}

/* How much of lo .. hi is in the `size` from `first` on. */
static uint32_t overlap(int32_t lo, int32_t hi, int32_t first, int32_t size)
{
    return (uint32_t)fx_max(fx_min(hi, first + size - 1) - fx_max(lo, first) + 1, 0);
}

static void bound_triangle(struct raster_tile_bound *b, const struct raster_costs *c, const struct box *box, int32_t x,
                           int32_t y, bool cut, bool small)
{
    const uint32_t columns = overlap(box->x0, box->x1, x, RASTER_TILE_WIDTH);
    const uint32_t rows = columns ? overlap(box->y0, box->y1, y, RASTER_TILE_HEIGHT) : 0;
    const uint64_t cost =
        (cut ? c->clipped + (uint64_t)FAN * c->facing : c->facing) +
        fill_cost(c, cut ? FAN * rows : rows, columns * rows, small); /* a fan's triangles do not overlap */
    b->least = fx_add_sat_u(b->least, cost_ticks(cost));
    b->pixels = fx_add_sat_u(b->pixels, columns * rows);
}

void raster_bound_coarse(struct raster *r, const struct raster_object *o, const struct scene_meshlet *m,
                         const struct raster_tiles *tiles, bool small)
{
    const struct raster_costs *c = r->frame.costs;
    const uint32_t ticks = cost_ticks(c->meshlet + (uint64_t)c->vertex * m->vertex_count +
                                      ((uint64_t)c->triangle + (small ? 0 : c->general)) * m->triangle_count);
    for (int32_t y = tiles->y0; y <= tiles->y1; y++)
        for (int32_t x = tiles->x0; x <= tiles->x1; x++) {
            struct raster_tile_bound *b = &r->bounds[(uint32_t)y * r->tiles_x + (uint32_t)x];
            b->least = fx_add_sat_u(b->least, ticks);
            b->meshlets++; /* <= 2^16 RUN_BACK in all */
        }
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        struct box box;
        const enum facing facing = triangle_box(&box, r, o, m, &r->frame.scene->triangles[m->triangle_first + i]);
        if (facing == AWAY)
            continue;
        for (int32_t y = tiles->y0; y <= tiles->y1; y++)
            for (int32_t x = tiles->x0; x <= tiles->x1; x++)
                bound_triangle(&r->bounds[(uint32_t)y * r->tiles_x + (uint32_t)x], c, &box, x * RASTER_TILE_WIDTH,
                               y * RASTER_TILE_HEIGHT, facing == CUT, small);
    }
}

/* What is drawn takes about half of what it may: triangles that face away, rows and edges that no pixel centre is in. */
void raster_bound_wanted(struct raster *r, const struct raster_load *load, const struct raster_extent *e,
                         const struct raster_tiles *tiles)
{
    const uint32_t count = (uint32_t)(tiles->x1 - tiles->x0 + 1) * (uint32_t)(tiles->y1 - tiles->y0 + 1);
    const uint32_t whole = count * RASTER_TILE_PIXELS; /* < 2^24 and a tile */
    const uint32_t shown = (load->shown < whole ? load->shown : whole) / (2 * count);
    const uint32_t demand = cost_ticks((uint64_t)shown * e->pixel_cost);
    const uint32_t drawing = load->setup + (load->ticks - load->setup) / (2 * count);
    for (int32_t y = tiles->y0; y <= tiles->y1; y++)
        for (int32_t x = tiles->x0; x <= tiles->x1; x++) {
            struct raster_tile_bound *b = &r->bounds[(uint32_t)y * r->tiles_x + (uint32_t)x];
            b->largest = load->ticks > b->largest ? load->ticks : b->largest;
            b->drawing = fx_add_sat_u(b->drawing, drawing);
            b->shown = fx_add_sat_u(b->shown, shown);
            b->demand = fx_add_sat_u(b->demand, demand);
        }
}

/* Of one flat meshlet, of any object in view. */
static uint32_t flat_cost(const struct raster *r)
{
    uint32_t most = 0;
    for (uint32_t i = 0; i < r->object_count; i++) {
        const uint32_t c = r->frame.costs->shading[raster_shading_of(r, r->objects[i].material, RASTER_RATE_FLAT)].flat;
        most = c > most ? c : most;
    }
    return most;
}

/* sum / count rounded up, with 32-bit divisions. In: count < 2^18, sum < 2^32 count. */
static uint32_t mean_above(uint64_t sum, uint32_t count)
{
    uint32_t quotient = 0, rest = 0;
    sum += count - 1;
    for (int shift = 42; shift >= 0; shift -= 14) { /* rest < 2^18 */
        rest = rest << 14 | ((uint32_t)(sum >> shift) & 0x3fff);
        quotient = quotient << 14 | rest / count;
        rest %= count;
    }
    return quotient;
}

uint32_t raster_min_tile_budget(struct raster *r)
{
    const struct raster_costs *c = r->frame.costs;
    const uint64_t flat = flat_cost(r);
    const uint64_t pass = (uint64_t)c->survey * RASTER_TILE_PIXELS + (uint64_t)c->light * r->frame.light_count +
                          (uint64_t)c->flat * RASTER_MAX_REGIONS + c->plan;
    const uint32_t tiles = raster_tile_count(r);
    uint64_t sum = 0;
    for (uint32_t t = 0; t < tiles; t++) {
        struct raster_tile_bound *b = &r->bounds[t];
        const uint32_t pixels = b->pixels < RASTER_TILE_PIXELS ? b->pixels : RASTER_TILE_PIXELS;
        const uint64_t passes = (b->meshlets + RASTER_SLOTS - 2) / (RASTER_SLOTS - 1);
        b->least =
            fx_add_sat_u(b->least, cost_ticks(2 * (uint64_t)c->tile + (uint64_t)c->finished * pixels +
                                              flat * b->meshlets + passes * (pass + (uint64_t)c->copied * pixels)));
        if (b->shown > RASTER_TILE_PIXELS)
            b->demand = (uint32_t)((uint64_t)b->demand * (((uint32_t)RASTER_TILE_PIXELS << 16) / b->shown) >> 16);
        sum += b->least;
    }
    return mean_above(sum, tiles);
}

uint64_t raster_bounds_drawing(const struct raster *r)
{
    uint64_t sum = 0;
    for (uint32_t t = 0; t < raster_tile_count(r); t++)
        sum += r->bounds[t].drawing;
    return sum;
}

static void bound_object(struct raster_extent *e, const struct raster *r, const struct raster_object *o)
{
    raster_extent_setup(e, r, o, raster_corner_secant(&r->frame));
}

static void bound_meshlet(struct raster *r, const struct raster_extent *e, const struct raster_object *o,
                          const struct scene_meshlet *m, const struct raster_tiles *tiles, int32_t nearest,
                          uint32_t flags, bool cut)
{
    const bool small = flags & VISIBLE_SMALL;
    struct raster_load load;
    if (!e) {
        raster_bound_coarse(r, o, m, tiles, small);
    } else {
        raster_load_find(&load, r, e, o, m, nearest, small, cut);
        raster_bound_wanted(r, &load, e, tiles);
    }
}

static bool draws_too_much(struct raster *r)
{
    r->budget_needed = raster_min_tile_budget(r);
    const uint64_t tiles = raster_tile_count(r), drawing = raster_bounds_drawing(r);
    return r->frame.tile_budget && drawing + (uint64_t)r->budget_needed * 3 / 4 * tiles > r->frame.tile_budget * tiles;
}

const struct raster_bounds raster_tile_bounds = {raster_bounds_clear, bound_object, bound_meshlet, draws_too_much};
