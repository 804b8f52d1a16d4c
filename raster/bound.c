#include "bound.h"

#include "quality.h"

/* A triangle cut by every plane is a polygon of 8 vertices, a fan of 6. */
#define FAN (CLIP_MAX_VERTICES - 2)
/* Of the frame's budget, what a meshlet may take before it is bounded more closely. */
#define WORTH_BOXES 32
static uint32_t cost_ticks(uint64_t cost)
{
    cost = (cost + (1u << RASTER_COST_BITS) - 1) >> RASTER_COST_BITS;
    return cost < UINT32_MAX ? (uint32_t)cost : UINT32_MAX;
}

/* 1/cos(phi) at the picture's corner, at most: 1 + tan^2(phi)/2. */
static struct magnitude find_corner_secant(const struct raster_frame *f)
{
    const uint32_t w = f->width, h = f->height;
    const struct magnitude inverse = magnitude_inverse(magnitude_of((uint64_t)h * f->camera->focal));
    struct magnitude tan2 = magnitude_mul(magnitude_of(w * w + h * h), magnitude_mul(inverse, inverse));
    tan2.e += 32 + 15; /* focal's fraction bits, twice; half of it, 16 fraction bits */
    struct magnitude secant = magnitude_of((1u << 16) + (uint64_t)magnitude_above(tan2));
    secant.e -= 16;
    return secant;
}

static void clear_bounds(struct raster *r, struct raster_extent *e)
{
    for (uint32_t t = 0; t < raster_tile_count(r); t++)
        r->bounds[t] = (struct raster_tile_bound){0};
    e->corner_secant = find_corner_secant(&r->frame);
}

/* Of one sample at full quality; lights reach about five in eight of what they are tried on, point lights one in four. */
static uint32_t full_cost(const struct raster *r, uint32_t material)
{
    const struct raster_shading_cost c =
        raster_shading_cost_of(r, raster_shading_of(r, material, RASTER_RATE_1X1), RASTER_TAPS_8);
    const uint64_t points = r->frame.light_count - r->directional;
    const uint64_t sum =
        c.sample + (r->directional * (5 * (uint64_t)c.lit + 3 * (uint64_t)c.dark) >> 3) + (points * c.point >> 2);
    return sum < UINT32_MAX ? (uint32_t)sum : UINT32_MAX;
}

static void bound_object(struct raster_extent *e, const struct raster *r, const struct raster_object *o)
{
    uint64_t square = 0; /* of the length of X's row: of rotation times scale; entries below 2^31 */
    for (int j = 0; j < 3; j++)
        square += (uint64_t)((int64_t)o->row[0][j] * o->row[0][j]);
    e->length = magnitude_mul(magnitude_root(magnitude_of(square)), e->corner_secant);
    /* half sub-pixels times W, with ROW_BITS fraction bits: raster_project */
    e->length.e += 29 - o->shift_xy - ROW_BITS - 9;
    e->pixel_cost = full_cost(r, o->material);
}

/* Of a meshlet, whatever faces the eye. */
static uint64_t setup_cost(const struct raster_costs *c, const struct scene_meshlet *m, bool small)
{
    return c->meshlet + (uint64_t)c->vertex * m->vertex_count +
           ((uint64_t)c->triangle + (small ? 0 : c->general)) * m->triangle_count;
}

/* Of triangles that face the eye, of rows and pixels; `general`: in general.c. */
static uint64_t fill_cost(const struct raster_costs *c, uint32_t facing, uint32_t rows, uint32_t tested, bool general)
{
    const uint64_t cost = (uint64_t)c->facing * facing + (uint64_t)c->row * rows + (uint64_t)c->tested * tested;
    return !general ? cost
                    : cost + (uint64_t)c->general_facing * facing + (uint64_t)c->general_row * rows +
                          (uint64_t)c->general_tested * tested;
}

/* A meshlet in any one tile. */
struct load {
    uint32_t ticks;           /* at most */
    uint32_t setup;           /* of the ticks: for every triangle */
    uint32_t triangles, rows; /* in all tiles; the latter of triangles about as wide as high */
    uint32_t shown;           /* pixels^2 in all tiles, at most */
};

/* In: nearest, the box's least depth in W; whether it is drawn by small.c, and whether it may have to be clipped. */
static void find_load(struct load *load, const struct raster *r, const struct raster_extent *e,
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
    const uint32_t tested = fx_min_u(fx_add_sat_u(load->shown, sum), triangles * RASTER_TILE_PIXELS);
    const uint64_t setup = setup_cost(c, m, small);
    load->setup = cost_ticks(setup);
    /* Thin triangles of any meshlet may be filled in general coordinates. */
    load->ticks = cost_ticks(setup + fill_cost(c, cut ? FAN * triangles : triangles, rows, tested, true));
    load->rows = fx_min_u(half, all);
    load->triangles = triangles;
}

/* A triangle on the screen: pixel centres are in its box, and it has at most so much area. */
struct box {
    int16_t x0, y0, x1, y1; /* inclusive */
    uint32_t area;          /* pixels^2, rounded down */
    bool general;           /* it may be filled by general.c */
    bool cut;               /* it may have to be clipped */
};

static uint32_t differ(int32_t a, int32_t b)
{
    return (uint32_t)(a > b ? a - b : b - a);
}

/* Whether general.c may fill a triangle of so much area, doubled, in 1/65536 pixel^2: what small.c does not, and a little more. */
static bool is_general(const struct raster_vertex p[3], uint64_t area)
{
    for (int i = 0; i < 3; i++) {
        const struct raster_vertex *a = &p[i], *b = &p[i < 2 ? i + 1 : 0];
        const uint32_t dx = differ(a->x, b->x), dy = differ(a->y, b->y), longest = dx > dy ? dx : dy;
        if (longest > SMALL_EXTENT || differ((int32_t)a->inv_w, (int32_t)b->inv_w) > SMALL_DEPTH ||
            (uint64_t)longest * 257 > area || differ(a->u, b->u) >= 1 << 13 || differ(a->v, b->v) >= 1 << 13)
            return true;
    }
    return false;
}

/* False: it does not show. */
static bool triangle_box(struct box *box, const struct raster *r, const struct raster_object *o,
                         const struct scene_meshlet *m, const struct scene_triangle *t, unsigned normal_shift)
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
        if (!code) {
            raster_project(&p[i], o, &c, r->width * 256 + 1, r->height * 256 + 1);
            p[i].u = (int16_t)raster_homogeneous(c.u, p[i].inv_w, normal_shift);
            p[i].v = (int16_t)raster_homogeneous(c.v, p[i].inv_w, normal_shift);
        }
    }
    if (any) { /* beyond the picture, too: a tile is drawn whole */
        *box = (struct box){0, 0, INT16_MAX, INT16_MAX, UINT32_MAX, true, true};
        return !all;
    }
    const int64_t area =
        (int64_t)(p[1].x - p[0].x) * (p[2].y - p[0].y) - (int64_t)(p[1].y - p[0].y) * (p[2].x - p[0].x);
    if (area >= 0) /* counter-clockwise, y down: its normal's away */
        return false;
    box->x0 =
        (int16_t)((fx_min(p[0].x, fx_min(p[1].x, p[2].x)) + 127) >> 8); /* < 2^14: the guard band and half a picture */
    box->y0 = (int16_t)((fx_min(p[0].y, fx_min(p[1].y, p[2].y)) + 127) >> 8);
    box->x1 = (int16_t)((fx_max(p[0].x, fx_max(p[1].x, p[2].x)) - 128) >> 8);
    box->y1 = (int16_t)((fx_max(p[0].y, fx_max(p[1].y, p[2].y)) - 128) >> 8);
    box->area = (uint32_t)(-area >> 17); /* < 2^47 */
    box->general = is_general(p, (uint64_t)-area);
    box->cut = false;
    return true;
}

/* How much of lo .. hi is in the `size` from `first` on. */
static uint32_t overlap(int32_t lo, int32_t hi, int32_t first, int32_t size)
{
    return (uint32_t)fx_max(fx_min(hi, first + size - 1) - fx_max(lo, first) + 1, 0);
}

/* What a triangle takes of a tile at most. */
struct part {
    uint32_t columns, rows, tested;
    uint64_t cost;
};

/* Of the tile from (x, y) on. What a triangle covers of it is convex, as is the hull of the pixel centres in that: of these there are at most
 * area + perimeter/2 + 1, and the perimeter is at most that of the box of centres. A fan's triangles do not overlap. */
static struct part part_of(const struct raster_costs *c, const struct box *box, int32_t x, int32_t y)
{
    const uint32_t columns = overlap(box->x0, box->x1, x, RASTER_TILE_WIDTH);
    const uint32_t rows = columns ? overlap(box->y0, box->y1, y, RASTER_TILE_HEIGHT) : 0;
    const uint32_t tested = !rows ? 0 : fx_min_u(columns * rows, fx_add_sat_u(box->area, columns + rows - 1));
    return (struct part){columns, rows, tested,
                         box->cut ? fill_cost(c, FAN, FAN * rows, tested, true)
                                  : fill_cost(c, 1, rows, tested, box->general)};
}

/* Regions of 2^shift by 2^shift samples that `columns` by `rows` samples from (x, y) of a tile on are in, as bits. */
static uint32_t regions_of(uint32_t x, uint32_t y, uint32_t columns, uint32_t rows, unsigned shift)
{
    const uint32_t across = RASTER_TILE_WIDTH >> shift, last = (x + columns - 1) >> shift;
    const uint32_t row = (2u << last) - (1u << (x >> shift));
    uint32_t bits = 0;
    for (uint32_t i = y >> shift; i <= (y + rows - 1) >> shift; i++)
        bits |= row << i * across;
    return bits;
}

/* A material's regions, each counted once for all objects that follow each other with it. */
static void bound_passes(struct raster_tile_bound *b, uint32_t material, uint32_t regions)
{
    if (b->material != material || !b->passes) {
        b->material = (uint8_t)material;
        b->regions = 0;
    }
    for (uint32_t more = regions & ~(uint32_t)b->regions; more; more &= more - 1)
        b->passes++;
    b->regions |= (uint16_t)regions;
}

/* A row of a triangle is a run at most when it is packed. */
static void bound_triangle(struct raster_tile_bound *b, const struct raster *r, const struct box *box, int32_t x,
                           int32_t y, uint32_t material)
{
    const struct raster_costs *c = r->frame.costs;
    const struct part part = part_of(c, box, x, y);
    b->least = fx_add_sat_u(b->least, cost_ticks(part.cost + (uint64_t)c->run * part.rows));
    b->pixels = fx_add_sat_u(b->pixels, part.tested);
    if (part.tested)
        bound_passes(b, material,
                     regions_of((uint32_t)fx_max(box->x0 - x, 0), (uint32_t)fx_max(box->y0 - y, 0), part.columns,
                                part.rows, RASTER_REGION_SHIFT + r->sample_shift));
}

/* Adds a meshlet of the coarsest levels to the tiles that it touches. */
static void bound_coarse(struct raster *r, const struct raster_object *o, const struct scene_meshlet *m,
                         const struct raster_tiles *tiles, uint32_t flags)
{
    const uint32_t ticks = cost_ticks(setup_cost(r->frame.costs, m, flags & VISIBLE_SMALL));
    for (int32_t y = tiles->y0; y <= tiles->y1; y++)
        for (int32_t x = tiles->x0; x <= tiles->x1; x++) {
            struct raster_tile_bound *b = &r->bounds[(uint32_t)y * r->tiles_x + (uint32_t)x];
            b->least = fx_add_sat_u(b->least, ticks);
            b->meshlets++; /* <= 2^16 RUN_BACK in all */
        }
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        struct box box;
        if (!triangle_box(&box, r, o, m, &r->frame.scene->triangles[m->triangle_first + i], VISIBLE_GET_SHIFT(flags)))
            continue;
        for (int32_t y = tiles->y0; y <= tiles->y1; y++)
            for (int32_t x = tiles->x0; x <= tiles->x1; x++)
                bound_triangle(&r->bounds[(uint32_t)y * r->tiles_x + (uint32_t)x], r, &box, x * RASTER_TILE_WIDTH,
                               y * RASTER_TILE_HEIGHT, o->material);
    }
}

/* Drawing one of the levels wanted, at most. It is kept in reserve for falling back: where it is a part of the frame's budget that matters, it is
 * bounded by triangles' boxes, as the sums of areas and perimeters alone can be ten times too high. */
static void bound_largest(struct raster *r, const struct load *load, const struct raster_object *o,
                          const struct scene_meshlet *m, const struct raster_tiles *tiles, uint32_t flags)
{
    const uint64_t budget = (uint64_t)r->frame.tile_budget * raster_tile_count(r);
    const bool matters = budget && load->ticks > budget / WORTH_BOXES;
    struct box boxes[SCENE_MESHLET_MAX_TRIANGLES];
    uint32_t count = 0;
    for (uint32_t i = 0; matters && i < m->triangle_count; i++)
        count += triangle_box(&boxes[count], r, o, m, &r->frame.scene->triangles[m->triangle_first + i],
                              VISIBLE_GET_SHIFT(flags));
    for (int32_t y = tiles->y0; y <= tiles->y1; y++)
        for (int32_t x = tiles->x0; x <= tiles->x1; x++) {
            struct raster_tile_bound *b = &r->bounds[(uint32_t)y * r->tiles_x + (uint32_t)x];
            uint32_t ticks = load->ticks;
            if (matters) {
                uint64_t cost = 0;
                for (uint32_t i = 0; i < count; i++)
                    cost += part_of(r->frame.costs, &boxes[i], x * RASTER_TILE_WIDTH, y * RASTER_TILE_HEIGHT).cost;
                ticks = fx_min_u(ticks, fx_add_sat_u(load->setup, cost_ticks(cost)));
            }
            b->largest = ticks > b->largest ? ticks : b->largest;
        }
}

/* Adds one of the levels wanted. Of what may be filled about half is: triangles that face away, rows and edges that no pixel centre is in. */
static void bound_wanted(struct raster *r, const struct load *load, const struct raster_extent *e,
                         const struct raster_tiles *tiles)
{
    const uint32_t count = (uint32_t)(tiles->x1 - tiles->x0 + 1) * (uint32_t)(tiles->y1 - tiles->y0 + 1);
    const uint32_t whole = count * RASTER_TILE_PIXELS; /* < 2^24 and a tile */
    const uint32_t shown = (load->shown < whole ? load->shown : whole) * 3 / (8 * count);
    const uint32_t demand = cost_ticks((uint64_t)shown * e->pixel_cost);
    /* Per tile; of a surface that is not culled three quarters of the triangles face the eye, the others' pixels and rows are fewer still */
    const uint32_t rows = fx_min_u(load->rows / 3, load->triangles * (RASTER_TILE_HEIGHT / 4) * count);
    const uint32_t drawing = load->setup + cost_ticks(fill_cost(r->frame.costs, load->triangles * 3 / 4, rows,
                                                                fx_min_u(load->shown / 2, whole), false)) /
                                               count;
    for (int32_t y = tiles->y0; y <= tiles->y1; y++)
        for (int32_t x = tiles->x0; x <= tiles->x1; x++) {
            struct raster_tile_bound *b = &r->bounds[(uint32_t)y * r->tiles_x + (uint32_t)x];
            b->besides = fx_add_sat_u(b->besides, drawing);
            b->shown = fx_add_sat_u(b->shown, shown);
            b->demand = fx_add_sat_u(b->demand, demand);
        }
}

static struct raster_shading_cost flat_shading(const struct raster *r, uint32_t material)
{
    return raster_shading_cost_of(r, raster_shading_of(r, material, RASTER_RATE_FLAT), RASTER_TAPS_8);
}

uint32_t raster_flat_cost(const struct raster *r, uint32_t material, uint32_t points)
{
    const struct raster_shading_cost c = flat_shading(r, material);
    const uint32_t lit = c.lit > c.dark ? c.lit : c.dark, point = c.point > lit ? c.point : lit;
    const uint32_t most = fx_min_u(r->directional + points, RASTER_LEAST_LIGHTS), exact = fx_min_u(points, most);
    return fx_min_u(c.flat, c.sample + (most - exact) * lit + exact * point);
}

uint32_t raster_flat_planes(const struct raster *r, uint32_t material)
{
    return fx_min_u(r->directional, RASTER_LEAST_LIGHTS) * flat_shading(r, material).material;
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

/* Of `shown` pixels of surfaces in a tile, how many are in front: 1 - exp(-x) of x tiles full, roughly; 16 fraction bits. */
static uint32_t seen_part(uint32_t shown)
{
    const uint32_t all = RASTER_TILE_PIXELS;
    return shown < 2 * all ? (all << 17) / (2 * all + shown) : (all << 16) / shown;
}

/* What a tile's regions take for each of their materials, whatever the rate, roughly. */
static uint32_t passes_ticks(const struct raster *r, const struct raster_tile_bound *b)
{
    const struct raster_costs *c = r->frame.costs;
    const uint32_t planes = r->directional * c->shading[RASTER_SHADE_HALF_VECTOR].material;
    return b->shown ? cost_ticks(b->passes * (uint64_t)(c->region + planes)) : 0;
}

uint32_t raster_min_tile_budget(struct raster *r)
{
    const struct raster_costs *c = r->frame.costs;
    uint32_t flat = 0, flat_planes = 0; /* of any object in view */
    for (uint32_t i = 0; i < r->object_count; i++) {
        const uint32_t material = r->objects[i].material;
        const uint32_t each = raster_flat_cost(r, material, r->frame.light_count - r->directional),
                       more = raster_flat_planes(r, material);
        flat = each > flat ? each : flat;
        flat_planes = more > flat_planes ? more : flat_planes;
    }
    const uint64_t pass = (uint64_t)c->survey * RASTER_TILE_PIXELS + (uint64_t)c->light * r->frame.light_count;
    const uint32_t tiles = raster_tile_count(r);
    uint64_t sum = 0;
    for (uint32_t t = 0; t < tiles; t++) {
        struct raster_tile_bound *b = &r->bounds[t];
        const uint32_t pixels = b->pixels < RASTER_TILE_PIXELS ? b->pixels : RASTER_TILE_PIXELS;
        const uint64_t passes = (b->meshlets + RASTER_SLOTS - 2) / (RASTER_SLOTS - 1);
        /* Where slots run out, an object may show in the same region before and after. */
        const uint64_t regions =
            ((uint64_t)b->passes << 2 * r->sample_shift) + (passes ? (passes - 1) * RASTER_MAX_REGIONS : 0);
        b->least = fx_add_sat_u(b->least, cost_ticks((uint64_t)c->tile + c->clear + (uint64_t)c->finished * pixels +
                                                     (uint64_t)flat * b->meshlets + regions * (c->flat + flat_planes) +
                                                     passes * pass));
        const uint32_t shown = fx_min_u(b->shown, RASTER_TILE_PIXELS);
        b->besides =
            fx_add_sat_u(b->besides, cost_ticks((uint64_t)c->tile + c->plan + (uint64_t)c->survey * RASTER_TILE_PIXELS +
                                                (uint64_t)c->finished * shown));
        b->demand = fx_add_sat_u((uint32_t)((uint64_t)b->demand * seen_part(b->shown) >> 16), passes_ticks(r, b));
        sum += b->least;
    }
    return mean_above(sum, tiles);
}

/* Of what bounds expect, 6 fraction bits: what tiles take. */
#define USUAL 52u

/* x times a ratio that was learnt, or the usual one. */
static uint32_t times_learnt(uint32_t x, uint8_t ratio)
{
    return fx_sat31((uint64_t)x * (ratio ? ratio : USUAL) >> 6);
}

static uint8_t shading_learnt(const struct raster *r, uint32_t tile)
{
    return r->frame.learnt ? r->frame.learnt->shading[tile % RASTER_LEARNT_TILES] : 0;
}

struct raster_expected raster_tile_expected(const struct raster *r, uint32_t tile)
{
    const struct raster_learnt *l = r->frame.learnt;
    const struct raster_tile_bound *b = &r->bounds[tile];
    return (struct raster_expected){times_learnt(b->demand, shading_learnt(r, tile)),
                                    times_learnt(b->besides, l ? l->besides[tile % RASTER_LEARNT_TILES] : 0)};
}

/* Tiles by their least, the lowest first, then by index: insertion at steps that shrink (Shell 1959). */
static void find_order(struct raster *r)
{
    struct raster_tile_bound *b = r->bounds;
    const uint32_t tiles = raster_tile_count(r);
    for (uint32_t t = 0; t < tiles; t++)
        b[t].order = (uint16_t)t;
    for (uint32_t step = tiles / 2; step; step /= 2)
        for (uint32_t i = step; i < tiles; i++) {
            const uint16_t tile = b[i].order;
            uint32_t at = i;
            for (; at >= step; at -= step) {
                const uint16_t other = b[at - step].order;
                if (b[other].least < b[tile].least || (b[other].least == b[tile].least && other < tile))
                    break;
                b[at].order = other;
            }
            b[at].order = tile;
        }
}

/* Shading in cells of 4 x 4, roughly: to coarsen levels of detail errs more than to shade for less errs, down to this. A cell's part is a seventh
 * of what it shows. Once the threshold was doubled twice, to double it again errs more than rate flat does, which takes half of that. */
static uint32_t coarse_shading(const struct raster *r, uint32_t tile, uint32_t bias)
{
    const struct raster_costs *c = r->frame.costs;
    const struct raster_tile_bound *b = &r->bounds[tile];
    const uint32_t passes = passes_ticks(r, b), samples = b->demand > passes ? b->demand - passes : 0;
    const uint32_t parts = fx_min_u(b->shown, RASTER_TILE_PIXELS) / 7;
    const uint32_t coarse = samples / 32 * 5 + cost_ticks((uint64_t)parts * (c->part + c->cell)) + passes;
    return times_learnt(bias < 2 ? coarse : coarse / 2, shading_learnt(r, tile));
}

/*
 * Ticks that the frame needs beyond the sum of `least`, for no tile to fall back: before a tile is drawn, that must suffice beside the later ones'
 * least for drawing it with its own least in reserve, and for what it takes more than its least and the tiles after it need. To each tile's `keep`:
 * what the tiles after it need so. Shading is counted at the least quality that is worth the levels of detail.
 */
static uint32_t find_keeps(struct raster *r, uint32_t bias)
{
    uint32_t need = 0;
    for (uint32_t i = raster_tile_count(r); i-- > 0;) {
        const uint32_t tile = r->bounds[i].order;
        struct raster_tile_bound *b = &r->bounds[tile];
        const struct raster_expected e = raster_tile_expected(r, tile);
        const uint32_t takes = fx_add_sat_u(fx_add_sat_u(e.besides, coarse_shading(r, tile, bias)), need);
        /* An eighth more, as to fall back for the lack of a few ticks would be the larger loss. */
        const uint32_t reserve = b->largest ? fx_add_sat_u(e.besides + e.besides / 8, b->largest) : 0;
        b->keep = need;
        need = takes > b->least ? takes - b->least : 0;
        need = need > reserve ? need : reserve;
    }
    return need;
}

static void bound_meshlet(struct raster *r, const struct raster_extent *e, const struct raster_object *o,
                          const struct scene_meshlet *m, const struct raster_tiles *tiles, int32_t nearest,
                          uint32_t flags, bool cut)
{
    struct load load;
    if (!e) {
        bound_coarse(r, o, m, tiles, flags);
    } else {
        find_load(&load, r, e, o, m, nearest, flags & VISIBLE_SMALL, cut);
        bound_largest(r, &load, o, m, tiles, flags);
        bound_wanted(r, &load, e, tiles);
    }
}

/* Levels finer than the last frame's have to do with an eighth less, so that they do not change with every frame. */
static bool takes_too_much(struct raster *r, uint32_t bias)
{
    uint64_t budget = (uint64_t)r->frame.tile_budget * raster_tile_count(r), least = 0;
    r->budget_needed = raster_min_tile_budget(r);
    if (!budget)
        return false;
    for (uint32_t t = 0; t < raster_tile_count(r); t++)
        least += r->bounds[t].least;
    find_order(r);
    const uint32_t need = find_keeps(r, bias);
    budget -= r->frame.learnt && bias < r->frame.learnt->lod_bias ? budget / 8 : 0;
    return budget < least + need;
}

const struct raster_bounds raster_tile_bounds = {clear_bounds, bound_object, bound_meshlet, takes_too_much};
