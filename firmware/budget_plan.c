/*
 * What shading a tile takes at each rate, in expectation and at most, and the plan for it.
 */
#include "budget.h"

#define COST_BITS  4                    /* fraction bits of struct raster_costs */
#define BLOCK_COST (2000u << COST_BITS) /* of a block beyond planes, at most */

/* --- what shading takes --- */

static bool in_rows(unsigned shading)
{
    return shading == RASTER_SHADE_DIFFUSE_ROW || shading == RASTER_SHADE_BLINN_PHONG_ROW;
}

/* Lights that are evaluated when at most `lights` are, the strongest: of either kind in proportion; or the most of each, but flat. */
static void count_lights(struct raster_work *w, const struct budget_plan *p, uint32_t lights, bool most)
{
    const uint32_t directional = p->r->directional, points = p->survey->point_lights, all = directional + points;
    const uint32_t n = lights < all ? lights : all;
    w->directional = all ? directional * n / all : 0;
    w->points = n - w->directional;
    if (most && w->rate != RASTER_RATE_FLAT) {
        w->directional = directional < n ? directional : n;
        w->points = points < n ? points : n;
    }
}

/* Blocks of a region where planes do not hold: as small as a cell. */
static const uint16_t blocks[RASTER_RATE_COUNT] = {256, 64, 64, 16, 16, 1};

static enum raster_shading shading_of(const struct budget_plan *p, uint32_t class_id, unsigned rate)
{
    return raster_shading_of(p->r, p->survey->material[class_id], (enum raster_rate)rate);
}

/* Of a class in a region, at most, but for its passes. */
static uint32_t most_ticks(const struct budget_plan *p, uint32_t class_id, enum raster_rate rate, uint32_t lights,
                           uint32_t region)
{
    const struct raster_area *area = &p->survey->area[class_id][region];
    struct raster_work w = {
        .shading = shading_of(p, class_id, rate),
        .rate = rate,
        .samples = p->last || rate != RASTER_RATE_1X1 ? raster_samples_most(p->r, p->survey, class_id, area, rate)
                                                      : area->pixels,
        .lit = 256,
    };
    raster_work_area(&w, p->r, area);
    count_lights(&w, p, lights, true);
    w.exact = !(p->regular >> region & 1) && !in_rows(w.shading) && w.directional;
    return raster_shading_ticks(p->r->frame.costs, &w);
}

static uint32_t count_bits(uint64_t x)
{
    uint32_t n = 0;
    for (; x; x &= x - 1)
        n++;
    return n;
}

/* A region is gone through once for every material and rate in it: a pass at a rate. Where planes do not hold, for each of its blocks. */
static uint32_t pass_ticks(const struct budget_plan *p, unsigned rate, bool regular)
{
    static const uint8_t cells[RASTER_RATE_COUNT] = {0, 128, 64, 32, 16, 0};
    const struct raster_costs *c = p->r->frame.costs;
    const uint64_t n = regular ? 1 : blocks[rate], visited = rate && !regular ? blocks[rate] : cells[rate];
    if (rate == RASTER_RATE_FLAT)
        return (c->flat >> COST_BITS) + 1;
    return (uint32_t)((c->region + n * (p->planes + BLOCK_COST) + visited * c->cell) >> COST_BITS) + 1;
}

/* All passes of a region, at most. */
static uint32_t passes_ticks(const struct budget_plan *p, const struct raster_quality *q, uint32_t region)
{
    const bool regular = p->regular >> region & 1;
    uint64_t materials[RASTER_RATE_COUNT] = {0};
    uint32_t sum = 0;
    for (uint32_t c = 0; c < p->survey->classes; c++)
        if (p->survey->area[c][region].pixels && !in_rows(shading_of(p, c, q->rate[c])))
            materials[q->rate[c]] |= p->materials[c];
    for (unsigned rate = 0; rate < RASTER_RATE_COUNT; rate++)
        if (materials[rate])
            sum += count_bits(materials[rate]) * pass_ticks(p, rate, regular);
    return sum;
}

/* Fills what every rate of a class is expected to take under at most `lights` lights. */
static void expected_ticks(uint32_t ticks[RASTER_RATE_COUNT], const struct budget_plan *p, uint32_t class_id,
                           uint32_t lit, uint32_t lights)
{
    const struct raster_survey *s = p->survey;
    uint32_t samples[RASTER_RATE_COUNT], regions = 0, irregular = 0;
    raster_samples_likely(samples, p->r, s, class_id, &s->total[class_id]);
    if (!p->last)
        samples[RASTER_RATE_1X1] = s->total[class_id].pixels;
    for (uint32_t i = 0; i < s->regions; i++)
        if (s->area[class_id][i].pixels) {
            regions++;
            irregular += !(p->regular >> i & 1);
        }
    for (unsigned rate = 0; rate < RASTER_RATE_COUNT; rate++) {
        struct raster_work w = {.shading = shading_of(p, class_id, rate),
                                .rate = (enum raster_rate)rate,
                                .samples = samples[rate],
                                .exact = irregular > regions / 2,
                                .lit = lit};
        raster_work_area(&w, p->r, &s->total[class_id]);
        count_lights(&w, p, rate == RASTER_RATE_FLAT ? RASTER_LEAST_LIGHTS : lights, false);
        ticks[rate] = raster_shading_ticks(p->r->frame.costs, &w);
        /* Classes of one material and rate share a pass; where planes do not hold, some blocks are smaller. */
        if (!in_rows(w.shading))
            ticks[rate] +=
                ((regions - irregular) * pass_ticks(p, rate, true) + irregular * pass_ticks(p, rate, false) / 2) *
                (rate ? 1 : p->first >> class_id & 1);
    }
}

/* Of a class in a region, at most, with passes of its own. */
static uint32_t alone_ticks(const struct budget_plan *p, uint32_t class_id, unsigned rate, uint32_t lights,
                            uint32_t region)
{
    const uint32_t ticks = most_ticks(p, class_id, (enum raster_rate)rate, lights, region);
    if (in_rows(shading_of(p, class_id, rate)))
        return ticks;
    return ticks + count_bits(p->materials[class_id]) * pass_ticks(p, rate, p->regular >> region & 1);
}

/* The last rung of a class in a region: the fewest lights, and the cheaper of cells of 4 x 4 and flat. */
static uint32_t last_rung(const struct budget_plan *p, uint32_t class_id, uint32_t region)
{
    const uint32_t flat = alone_ticks(p, class_id, RASTER_RATE_FLAT, RASTER_LEAST_LIGHTS, region);
    const uint32_t cells = alone_ticks(p, class_id, RASTER_RATE_4X4, RASTER_LEAST_LIGHTS, region);
    return flat < cells ? flat : cells;
}

/* Everything from a region on flat, each meshlet evaluated once. */
static uint32_t flat_ticks(const struct budget_plan *p, uint32_t region)
{
    const uint32_t cells = p->flat_cells[region], slots = p->survey->slots;
    return p->flat_ticks[region] + (cells < slots ? cells : slots) * p->flat_each;
}

uint32_t budget_least_ticks(const struct budget_plan *p, uint32_t region)
{
    const uint32_t flat = flat_ticks(p, region);
    return flat < p->last_rung[region] ? flat : p->last_rung[region];
}

uint32_t budget_cells_ticks(const struct budget_plan *p, uint32_t region, const struct raster_quality *q)
{
    uint32_t sum = 0;
    for (uint32_t c = 0; c < p->survey->classes; c++) {
        struct raster_work w = {.rate = (enum raster_rate)q->rate[c]};
        if (!p->survey->area[c][region].pixels || in_rows(shading_of(p, c, q->rate[c])))
            continue;
        raster_work_area(&w, p->r, &p->survey->area[c][region]);
        sum += raster_shading_ticks(p->r->frame.costs, &w);
    }
    return sum;
}

uint32_t budget_rows_ticks(const struct budget_plan *p, uint32_t region, const struct raster_quality *q)
{
    uint32_t sum = 0;
    for (uint32_t c = 0; c < p->survey->classes; c++)
        if (p->survey->area[c][region].pixels && in_rows(shading_of(p, c, q->rate[c])))
            sum += most_ticks(p, c, (enum raster_rate)q->rate[c], q->lights, region);
    return sum;
}

/* The next coarser rate that takes less than `ticks`, or none: RASTER_RATE_COUNT. */
static unsigned coarser(const struct budget_plan *p, uint32_t class_id, const struct raster_quality *q, uint32_t region,
                        uint32_t ticks)
{
    unsigned rate = q->rate[class_id];
    do
        rate++;
    while (rate < RASTER_RATE_COUNT && alone_ticks(p, class_id, rate, q->lights, region) >= ticks);
    return rate;
}

/* Coarsens the dearest class that can be, until the region fits (true) or none can be. */
static bool coarsen(struct raster_quality *q, const struct budget_plan *p, uint32_t region, uint32_t ticks)
{
    for (;;) {
        uint32_t dearest = 0, most = 0, sum = passes_ticks(p, q, region);
        unsigned next = RASTER_RATE_COUNT;
        for (uint32_t c = 0; c < p->survey->classes; c++) {
            if (!p->survey->area[c][region].pixels)
                continue;
            const uint32_t takes = alone_ticks(p, c, q->rate[c], q->lights, region);
            sum = fx_add_sat(sum, most_ticks(p, c, (enum raster_rate)q->rate[c], q->lights, region));
            const unsigned rate = takes > most ? coarser(p, c, q, region, takes) : RASTER_RATE_COUNT;
            if (rate == RASTER_RATE_COUNT)
                continue;
            most = takes;
            dearest = c;
            next = rate;
        }
        if (sum <= ticks)
            return true;
        if (next == RASTER_RATE_COUNT)
            return false;
        q->rate[dearest] = (uint8_t)next;
    }
}

void budget_region_fit(struct raster_quality *q, const struct budget_plan *p, uint32_t region, uint32_t ticks)
{
    const struct raster_quality planned = *q;
    if (coarsen(q, p, region, ticks))
        return;
    if (q->lights > RASTER_LEAST_LIGHTS && p->r->directional + p->survey->point_lights > RASTER_LEAST_LIGHTS) {
        *q = planned;
        q->lights = RASTER_LEAST_LIGHTS;
        if (coarsen(q, p, region, ticks))
            return;
    }
    if (flat_ticks(p, region) < p->last_rung[region]) /* a meshlet that shows in many regions is evaluated once */
        for (uint32_t c = 0; c < RASTER_CLASSES; c++)
            q->rate[c] = RASTER_RATE_FLAT;
}

/* --- the plan --- */

/* Of leaving out the weakest lights, whose part of all light is taken to be the square of their part of the number; of all pixels. */
static uint32_t light_error(const struct budget_plan *p, uint32_t lights)
{
    const uint32_t all = p->r->directional + p->survey->point_lights;
    if (lights >= all)
        return 0;
    const uint32_t part = (all - lights) * 64 / all, steps = part * part >> 6; /* of 64 */
    return p->pixels * 3 * steps * steps;                                      /* 2^13.6 2^12 */
}

/* The last rung, from each region on. */
static void sum_last_rungs(struct budget_plan *p)
{
    const struct raster_costs *costs = p->r->frame.costs;
    const struct raster_survey *s = p->survey;
    p->flat_each = 0;
    for (uint32_t c = 0; c < s->classes; c++) {
        if (!s->total[c].pixels)
            continue; /* and no material */
        const uint32_t flat = (costs->shading[shading_of(p, c, RASTER_RATE_FLAT)].flat >> COST_BITS) + 1;
        p->flat_each = flat > p->flat_each ? flat : p->flat_each;
    }
    p->flat_ticks[s->regions] = p->flat_cells[s->regions] = p->last_rung[s->regions] = 0;
    for (uint32_t region = s->regions; region-- > 0;) {
        uint32_t pixels = 0, cells = 0, last = 0;
        uint64_t materials = 0;
        for (uint32_t c = 0; c < s->classes; c++) {
            const struct raster_area *area = &s->area[c][region];
            if (!area->pixels)
                continue;
            last = fx_add_sat(last, last_rung(p, c, region));
            pixels += area->pixels;
            cells += area->cells;
            materials |= p->materials[c];
        }
        p->last_rung[region] = fx_add_sat(p->last_rung[region + 1], last);
        p->flat_ticks[region] =
            p->flat_ticks[region + 1] +
            (uint32_t)(((uint64_t)costs->copied * pixels + (uint64_t)costs->flat * count_bits(materials)) >>
                       COST_BITS) +
            1;
        p->flat_cells[region] = p->flat_cells[region + 1] + cells;
    }
}

static void find_classes(struct budget_plan *p, const struct budget *b, uint32_t lights)
{
    p->pixels = p->shown = 0;
    for (uint32_t c = 0; c < p->survey->classes; c++) {
        p->pixels += p->survey->total[c].pixels;
        p->shown += p->survey->total[c].pixels != 0;
        if (p->survey->total[c].pixels)
            expected_ticks(p->classes[c].ticks, p, c, b->lit, lights);
        else
            p->classes[c] = (struct budget_class){.rate = RASTER_RATE_1X1};
        for (unsigned rate = 0; rate < RASTER_RATE_COUNT; rate++)
            p->classes[c].error[rate] = raster_class_error(p->survey, c, (enum raster_rate)rate);
    }
}

/* Materials of each class, and what a pass takes. */
static void find_materials(struct budget_plan *p, const struct raster_tile *work)
{
    const struct raster_costs *c = p->r->frame.costs;
    uint32_t planes = 0;
    uint64_t seen = 0;
    for (uint32_t i = 0; i < RASTER_CLASSES; i++)
        p->materials[i] = 0;
    for (uint32_t i = 1; i <= p->survey->slots; i++)
        if (work->m.shading.pixels[i])
            p->materials[work->slots[i].class_id] |= (uint64_t)1 << work->slots[i].material;
    p->first = 0;
    for (uint32_t i = 0; i < p->survey->classes; i++) {
        if (!p->survey->total[i].pixels)
            continue;
        const uint32_t material = c->shading[shading_of(p, i, RASTER_RATE_4X4)].material;
        planes = material > planes ? material : planes;
        if (p->materials[i] & ~seen)
            p->first |= 1u << i;
        seen |= p->materials[i];
    }
    p->planes = planes * p->r->directional;
}

void budget_plan_begin(struct budget_plan *p, const struct budget *b, const struct raster *r,
                       const struct raster_tile *work, const struct raster_rect *rect, bool last)
{
    const struct raster_survey *survey = &work->m.shading.survey;
    p->r = r;
    p->survey = survey;
    p->last = last;
    p->regular = 0;
    for (uint32_t i = 0; i < survey->regions; i++)
        p->regular |= (uint32_t)(raster_region_blocks(r, rect, i, RASTER_RATE_1X1) == 1) << i;
    find_materials(p, work);
    sum_last_rungs(p);
    find_classes(p, b, RASTER_ALL_LIGHTS);
}

uint32_t budget_plan_choose(struct budget_plan *p, const struct budget *b, uint32_t ticks)
{
    static const uint8_t ladder[] = {RASTER_ALL_LIGHTS, 16, RASTER_LEAST_LIGHTS};
    const uint32_t all = p->r->directional + p->survey->point_lights, count = p->survey->classes;
    uint32_t least = UINT32_MAX, expected = 0;
    for (uint32_t step = 0; step < sizeof ladder && least; step++) {
        if (step) {
            if (ladder[step] >= all)
                continue;
            find_classes(p, b, ladder[step]);
        }
        uint32_t error = budget_choose(p->classes, count, ticks), sum = 0;
        for (uint32_t c = 0; c < count; c++)
            sum = fx_add_sat(sum, p->classes[c].ticks[p->classes[c].rate]);
        error = fx_add_sat(error, light_error(p, ladder[step]));
        if (error >= least || (sum > ticks && ladder[step] > RASTER_LEAST_LIGHTS && all > RASTER_LEAST_LIGHTS))
            continue; /* fewer lights may fit */
        least = error;
        expected = sum;
        p->quality.lights = ladder[step];
        for (uint32_t c = 0; c < count; c++)
            p->quality.rate[c] = p->classes[c].rate;
    }
    return expected;
}
