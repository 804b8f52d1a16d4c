/*
 * What shading a tile takes at each rate, in expectation and at most, and the plan for it. Costs have 4 fraction bits, as in struct raster_costs;
 * ticks have none.
 */
#include "budget.h"

#define BLOCK_COST (2000u << RASTER_COST_BITS) /* of a block beyond planes, at most */

/* --- what shading takes --- */

static enum raster_shading shading_of(const struct budget_plan *p, uint32_t i, unsigned rate)
{
    return raster_shading_of(p->r, p->survey->material[p->id[i]], (enum raster_rate)rate);
}

static const struct raster_area *area_of(const struct budget_plan *p, uint32_t i, uint32_t region)
{
    return &p->survey->area[p->id[i]][region];
}

static uint32_t ticks_of(uint64_t cost)
{
    return (uint32_t)(cost >> RASTER_COST_BITS) + 1;
}

/* Of an area's pixels in rows, at rate 1x1, with `runs` in each cell of it. */
static uint64_t row_cost(const struct budget_units *u, uint32_t i, const struct raster_area *area, uint32_t runs,
                         uint32_t each)
{
    return (uint64_t)area->pixels * u->row[i] + fx_min_u(runs * area->cells, area->pixels) * (uint64_t)each;
}

/* At most: a meshlet has two runs in each row of a cell, with a run between them of what was shaded before. */
static uint64_t most_row_cost(const struct budget_plan *p, const struct budget_units *u, uint32_t i,
                              const struct raster_area *area)
{
    return row_cost(u, i, area, 8, u->row_run[i] + p->r->frame.costs->run);
}

/* As is to be expected: hardly more than one. */
static uint64_t likely_row_cost(const struct budget_units *u, uint32_t i, const struct raster_area *area)
{
    return row_cost(u, i, area, 4, u->row_run[i]);
}

/* What a class's samples take at most under at most `lights` lights, of each kind as many as there may be among the strongest. */
static void units_find(struct budget_units *u, const struct budget_plan *p, uint32_t lights, enum raster_taps taps)
{
    const struct raster_costs *costs = p->r->frame.costs;
    const uint32_t all = fx_min_u(p->r->directional + p->survey->point_lights, lights),
                   points = fx_min_u(p->survey->point_lights, all);
    u->lights = (uint8_t)all;
    for (uint32_t i = 0; i < p->count; i++) {
        const struct raster_shading_cost c = raster_shading_cost_of(p->r, shading_of(p, i, RASTER_RATE_4X4), taps);
        const struct raster_shading_cost *row = &costs->shading[shading_of(p, i, RASTER_RATE_1X1)];
        const uint32_t lit = c.lit > c.dark ? c.lit : c.dark, point = c.point > lit ? c.point : lit;
        u->planes[i] = c.sample + (all - points) * lit + points * point;
        u->exact[i] = c.sample + all * point;
        u->row[i] = row->sample + fx_min_u(p->r->directional, all) * row->lit;
        u->row_run[i] = row->material;
    }
}

/* Of an area's cells and samples, all but its passes, at a rate. */
static uint64_t area_cost(const struct budget_plan *p, const struct raster_area *area, unsigned rate, uint32_t samples,
                          uint32_t unit)
{
    const struct raster_costs *c = p->r->frame.costs;
    const bool cells = rate != RASTER_RATE_1X1 && rate != RASTER_RATE_FLAT;
    return (uint64_t)samples * unit + (cells ? area->cells * c->part + samples * c->cell : 0); /* 2^11 2^16, twice */
}

/* Of a class in a region, at most, but for its passes. */
static uint64_t most_cost(const struct budget_plan *p, const struct budget_units *u, uint32_t i, unsigned rate,
                          uint32_t region)
{
    const struct raster_area *area = area_of(p, i, region);
    if (rate == RASTER_RATE_1X1 && p->rows >> i & 1)
        return most_row_cost(p, u, i, area);
    if (rate == RASTER_RATE_FLAT && u->lights <= RASTER_LEAST_LIGHTS)
        return area_cost(p, area, rate, fx_min_u(area->cells, p->survey->meshlets[p->id[i]]),
                         p->flat_each << RASTER_COST_BITS);
    const uint32_t samples = rate == RASTER_RATE_1X1 && !p->last
                                 ? area->pixels
                                 : raster_samples_most(p->r, p->survey, p->id[i], area, (enum raster_rate)rate);
    return area_cost(p, area, rate, samples,
                     p->region_planes[region] && rate != RASTER_RATE_FLAT ? u->planes[i] : u->exact[i]);
}

static uint32_t count_bits(uint64_t x)
{
    uint32_t n = 0;
    for (; x; x &= x - 1)
        n++;
    return n;
}

/* A region is gone through for each material once by pixels and once by cells, whatever their rates, and once for all that is flat. */
static uint64_t pass_cost(const struct budget_plan *p, unsigned rate, unsigned planes, uint32_t materials)
{
    if (rate == RASTER_RATE_FLAT)
        return (p->r->frame.costs->flat << 2 * p->r->sample_shift) + (uint64_t)materials * p->flat_planes;
    return (uint64_t)materials * p->pass[planes][rate];
}

/* In: blocks' planes. Of region_planes that there are. */
static void passes_find(struct budget_plan *p, uint32_t planes)
{
    const uint32_t region = p->r->frame.costs->region, block = fx_min_u(planes + BLOCK_COST, 1u << 22);
    uint32_t found = 0;
    for (uint32_t i = 0; i < p->survey->regions; i++) {
        const unsigned k = p->region_planes[i];
        for (unsigned rate = 0; rate < RASTER_RATE_FLAT && !(found >> k & 1); rate++)
            p->pass[k][rate] = region + raster_region_blocks(p->r, k, (enum raster_rate)rate) * block; /* 2^8 2^22 */
        found |= 1u << k;
    }
}

/* Of a region's passes, at most: `materials` by the rates that they have in it. */
static uint64_t passes_cost(const struct budget_plan *p, const uint64_t materials[RASTER_RATE_COUNT], unsigned planes)
{
    uint64_t sum = 0, cells = 0;
    unsigned finest = 0;
    for (unsigned rate = RASTER_RATE_FLAT - 1; rate > RASTER_RATE_1X1; rate--) {
        cells |= materials[rate];
        finest = materials[rate] ? rate : finest;
    }
    if (materials[RASTER_RATE_FLAT])
        sum += pass_cost(p, RASTER_RATE_FLAT, planes, count_bits(materials[RASTER_RATE_FLAT]));
    if (cells)
        sum += pass_cost(p, finest, planes, count_bits(cells));
    if (materials[RASTER_RATE_1X1])
        sum += pass_cost(p, RASTER_RATE_1X1, planes, count_bits(materials[RASTER_RATE_1X1]));
    return sum ? sum : p->r->frame.costs->region / 2; /* looked through, and left to rows */
}

/* Of a class in a region, at most, with passes of its own. */
static uint64_t alone_cost(const struct budget_plan *p, const struct budget_units *u, uint32_t i, unsigned rate,
                           uint32_t region)
{
    const uint64_t cost = most_cost(p, u, i, rate, region);
    if (rate == RASTER_RATE_1X1 && p->rows >> i & 1)
        return cost;
    return cost + pass_cost(p, rate, p->region_planes[region], count_bits(p->materials[i]));
}

/* Of all classes in a region, at most. */
static uint64_t region_cost(const struct budget_plan *p, const struct budget_units *u, const struct raster_quality *q,
                            uint32_t region)
{
    uint64_t materials[RASTER_RATE_COUNT] = {0}, sum = 0;
    for (uint32_t i = 0; i < p->count; i++) {
        const unsigned rate = q->rate[p->id[i]];
        if (!area_of(p, i, region)->pixels)
            continue;
        sum += most_cost(p, u, i, rate, region);
        if (rate != RASTER_RATE_1X1 || !(p->rows >> i & 1))
            materials[rate] |= p->materials[i];
    }
    return sum + passes_cost(p, materials, p->region_planes[region]);
}

uint32_t budget_rows_ticks(const struct budget_plan *p, uint32_t region, const struct raster_quality *q)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < p->count; i++)
        if (p->rows >> i & 1 && q->rate[p->id[i]] == RASTER_RATE_1X1)
            sum += most_row_cost(p, &p->units, i, area_of(p, i, region));
    return sum ? ticks_of(sum) : 0;
}

uint32_t budget_cells_ticks(const struct budget_plan *p, uint32_t region, const struct raster_quality *q)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < p->count; i++) {
        const unsigned rate = q->rate[p->id[i]];
        if (rate != RASTER_RATE_1X1 || !(p->rows >> i & 1))
            sum += area_cost(p, area_of(p, i, region), rate, 0, 0);
    }
    return ticks_of(sum);
}

/* --- the last rung --- */

uint32_t budget_least_ticks(const struct budget_plan *p, uint32_t region)
{
    return p->flat_ticks[region] + fx_min_u(p->flat_cells[region], p->survey->slots) * p->flat_each;
}

/* From each region on. In: of each region the materials, and in flat_cells its own meshlets in cells. */
static void sum_last_rungs(struct budget_plan *p, const uint64_t materials[RASTER_MAX_REGIONS])
{
    const uint32_t regions = p->survey->regions;
    p->flat_ticks[regions] = p->flat_cells[regions] = 0;
    for (uint32_t i = regions; i-- > 0;) {
        p->flat_ticks[i] = p->flat_ticks[i + 1] +
                           (materials[i] ? ticks_of(pass_cost(p, RASTER_RATE_FLAT, 0, count_bits(materials[i]))) : 0);
        p->flat_cells[i] += p->flat_cells[i + 1];
    }
}

/* Coarsens the dearest class that can be, until the region fits (true) or none can be. */
static bool coarsen(struct raster_quality *q, const struct budget_plan *p, const struct budget_units *u,
                    uint32_t region, uint32_t ticks)
{
    while (region_cost(p, u, q, region) >> RASTER_COST_BITS >= ticks) {
        uint32_t dearest = 0;
        uint64_t most = 0;
        unsigned next = RASTER_RATE_COUNT;
        for (uint32_t i = 0; i < p->count; i++) {
            unsigned rate = q->rate[p->id[i]];
            if (!area_of(p, i, region)->pixels || rate == RASTER_RATE_FLAT)
                continue;
            const uint64_t takes = alone_cost(p, u, i, rate, region);
            if (takes <= most)
                continue;
            do
                rate++;
            while (rate < RASTER_RATE_COUNT && alone_cost(p, u, i, rate, region) >= takes);
            if (rate == RASTER_RATE_COUNT)
                continue;
            most = takes;
            dearest = p->id[i];
            next = rate;
        }
        if (next == RASTER_RATE_COUNT)
            return false;
        q->rate[dearest] = (uint8_t)next;
    }
    return true;
}

void budget_region_fit(struct raster_quality *q, struct budget_plan *p, uint32_t region, uint32_t ticks)
{
    const struct raster_quality planned = *q;
    if (coarsen(q, p, &p->units, region, ticks))
        return;
    if (p->units.lights != p->least.lights) { /* once fewer, so to the end: to choose them takes ticks */
        *q = planned;
        p->units = p->least;
        p->quality.lights = q->lights = RASTER_LEAST_LIGHTS;
        if (coarsen(q, p, &p->units, region, ticks))
            return;
    }
    /* a meshlet that shows in many regions is evaluated once */
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

/* What fewer taps save of a sample, of which so many lights are lit, 16 fraction bits. In: each < 2^17, lit <= 2^23. Out: times samples, below 2^31. */
static uint32_t saved_by(uint32_t each, uint32_t lit)
{
    return fx_min_u((uint32_t)((uint64_t)each * lit >> 16), (1u << 19) - 1);
}

/* Of a class, with fewer taps than it was expected. */
static void take_taps(struct budget_class *c, enum raster_taps taps, uint32_t pixels)
{
    const uint32_t more = c->saved[taps] ? raster_taps_error(taps, pixels) : 0;
    for (unsigned rate = 0; rate < RASTER_RATE_COUNT; rate++) {
        c->ticks[rate] -= c->samples[rate] * c->saved[taps] >> RASTER_COST_BITS;
        c->error[rate] += more; /* 2^28 + 2^16 */
    }
}

/* What each rate of each class is expected to take under at most `lights` lights, and to err, with all taps. Of a sample never less than four fifths of the most,
 * as what is lit differs from tile to tile. */
static void expect(struct budget_plan *p, const struct budget *b, uint32_t lights)
{
    const uint32_t lit = b->lit;
    const struct raster_survey *s = p->survey;
    const uint32_t directional = p->r->directional, all = directional + s->point_lights, n = fx_min_u(lights, all),
                   likely = all ? directional * n / all : 0;
    units_find(&p->units, p, lights, RASTER_TAPS_8);
    for (uint32_t i = 0; i < p->count; i++) {
        struct budget_class *out = &p->classes[i];
        const struct raster_area *total = &s->total[p->id[i]];
        const enum raster_shading shading = shading_of(p, i, RASTER_RATE_4X4);
        const struct raster_shading_cost c = raster_shading_cost_of(p->r, shading, RASTER_TAPS_8);
        const bool fewer = shading == RASTER_SHADE_HALF_VECTOR && p->r->frame.parts->fewer_taps;
        const uint32_t part = (p->exact[i] << 8) / total->pixels; /* 2^13 2^8 */
        const uint32_t planes = c.sample + (likely * (c.lit * lit + c.dark * (256 - lit)) >> 8) +
                                ((n - likely) * c.point * b->point >> 8); /* 2^7 2^11 2^8; 2^7 2^15 2^8 */
        const uint32_t exact = c.sample + (n * c.point * b->point >> 8);
        const uint32_t most = p->units.planes[i] * (256 - part) + p->units.exact[i] * part; /* 2^22 2^8 */
        const uint32_t expected = planes * (256 - part) + exact * part;
        const uint32_t least = most / 5 * 4, unit = (expected > least ? expected : least) >> 8;
        uint32_t *samples = out->samples;
        raster_samples_likely(samples, p->r, s, p->id[i], total);
        if (!p->last)
            samples[RASTER_RATE_1X1] = total->pixels;
        for (unsigned taps = 0; taps < RASTER_TAPS_COUNT; taps++)
            out->saved[taps] =
                fewer ? saved_by(c.lit - raster_shading_cost_of(p->r, shading, taps).lit, likely * lit * (256 - part))
                      : 0;
        uint64_t passes[RASTER_RATE_COUNT] = {0};
        for (unsigned k = 0; k <= RASTER_REGION_SHIFT; k++) /* classes of one material share them */
            for (unsigned rate = 0; rate < RASTER_RATE_COUNT && p->first[i][k]; rate++)
                passes[rate] += p->first[i][k] * pass_cost(p, rate, k, 1);
        for (unsigned rate = 0; rate < RASTER_RATE_COUNT; rate++) {
            uint64_t cost =
                passes[rate] + area_cost(p, total, rate, samples[rate],
                                         rate == RASTER_RATE_FLAT ? p->flat_each << RASTER_COST_BITS : unit);
            if (!rate && p->rows >> i & 1)
                cost = likely_row_cost(&p->units, i, total);
            out->ticks[rate] = ticks_of(cost);
            out->error[rate] = raster_class_error(s, p->id[i], (enum raster_rate)rate);
        }
        samples[RASTER_RATE_FLAT] = 0; /* its ticks are the same */
    }
}

/* Classes that show, their materials, and in how many regions. */
static void list_classes(struct budget_plan *p, const struct raster_tile *work)
{
    const struct raster_survey *s = p->survey;
    uint64_t materials[RASTER_CLASSES] = {0}, seen[RASTER_MAX_REGIONS] = {0};
    uint32_t planes = 0, flat = 0, flat_planes = 0;
    for (uint32_t i = 1; i <= s->slots; i++)
        if (work->m.shading.pixels[i])
            materials[work->slots[i].class_id] |= (uint64_t)1 << work->slots[i].material;
    p->count = p->pixels = p->rows = 0;
    __builtin_memset(p->flat_cells, 0, sizeof p->flat_cells);
    for (uint32_t id = 0; id < s->classes; id++) {
        const uint32_t i = p->count;
        if (!s->total[id].pixels)
            continue;
        p->id[p->count++] = (uint8_t)id;
        p->materials[i] = materials[id];
        p->pixels += s->total[id].pixels;
        p->exact[i] = 0;
        __builtin_memset(p->shared[i], 0, sizeof p->shared[i]);
        __builtin_memset(p->first[i], 0, sizeof p->first[i]);
        for (uint32_t region = 0; region < s->regions; region++) {
            if (!s->area[id][region].pixels)
                continue;
            const unsigned k = p->region_planes[region];
            p->flat_cells[region] += s->area[id][region].cells;
            p->exact[i] += k ? 0 : s->area[id][region].pixels;
            if (materials[id] & ~seen[region])
                p->first[i][k]++;
            else
                p->shared[i][k]++;
            seen[region] |= materials[id];
        }
        const uint32_t own = raster_shading_cost_of(p->r, shading_of(p, i, RASTER_RATE_4X4), RASTER_TAPS_8).material;
        planes = own > planes ? own : planes;
        const uint32_t each = raster_flat_cost(p->r, s->material[id], s->point_lights);
        const uint32_t more = raster_flat_planes(p->r, s->material[id]);
        flat = each > flat ? each : flat;
        flat_planes = more > flat_planes ? more : flat_planes;
        if (p->r->in_rows[s->material[id]])
            p->rows |= 1u << i;
    }
    passes_find(p, planes * p->r->directional);
    p->flat_each = ticks_of(flat);
    p->flat_planes = flat_planes;
    sum_last_rungs(p, seen);
}

void budget_plan_begin(struct budget_plan *p, const struct budget *b, const struct raster *r,
                       const struct raster_tile *work, const struct raster_rect *rect, bool last)
{
    const struct raster_survey *s = &work->m.shading.survey;
    p->r = r;
    p->survey = s;
    p->last = last;
    for (uint32_t i = 0; i < s->regions; i++)
        p->region_planes[i] = (uint8_t)raster_region_planes(r, rect, i);
    list_classes(p, work);
    expect(p, b, RASTER_ALL_LIGHTS);
    p->least = p->units;
    if (p->units.lights > RASTER_LEAST_LIGHTS)
        units_find(&p->least, p, RASTER_LEAST_LIGHTS, RASTER_TAPS_8);
}

uint32_t budget_plan_flat(struct budget_plan *p)
{
    for (uint32_t c = 0; c < RASTER_CLASSES; c++)
        p->quality.rate[c] = RASTER_RATE_FLAT;
    p->quality.lights = RASTER_LEAST_LIGHTS;
    p->quality.taps = RASTER_TAPS_8;
    p->units = p->least;
    return budget_least_ticks(p, 0);
}

/* Passes of regions beyond those that each material's first class was charged with: where its classes are shaded in different ways. */
static uint32_t more_passes(const struct budget_plan *p)
{
    uint64_t known[3] = {0}, cost = 0; /* materials, by pixels, by cells, flat */
    for (uint32_t i = 0; i < p->count; i++) {
        const unsigned rate = p->classes[i].rate, kind = rate == RASTER_RATE_FLAT ? 2 : rate != RASTER_RATE_1X1;
        for (unsigned k = 0; k <= RASTER_REGION_SHIFT && p->materials[i] & ~known[kind]; k++)
            cost += p->shared[i][k] * pass_cost(p, rate, k, 1);
        known[kind] |= p->materials[i];
    }
    return ticks_of(cost);
}

/* Flat is for where cells of 4 x 4 do not fit: it errs most, is the least certain, and its pass comes on top of the others'. */
static void leave_flat_out(struct budget_plan *p, uint32_t ticks)
{
    uint32_t cells = 0;
    for (uint32_t i = 0; i < p->count; i++)
        cells = fx_add_sat(cells, p->classes[i].ticks[RASTER_RATE_4X4]);
    for (uint32_t i = 0; i < p->count && cells <= ticks; i++)
        p->classes[i].ticks[RASTER_RATE_FLAT] = p->classes[i].ticks[RASTER_RATE_4X4];
}

uint32_t budget_plan_choose(struct budget_plan *p, const struct budget *b, uint32_t ticks, enum raster_taps taps)
{
    taps = p->r->frame.parts->fewer_taps ? taps : RASTER_TAPS_8;
    static const uint8_t ladder[] = {RASTER_ALL_LIGHTS, 16, RASTER_LEAST_LIGHTS};
    const uint32_t all = p->r->directional + p->survey->point_lights;
    uint32_t least = UINT32_MAX, expected = 0;
    for (uint32_t step = 0; step < sizeof ladder && least; step++) {
        if (step) {
            if (ladder[step] >= all)
                continue;
            expect(p, b, ladder[step]);
        }
        for (uint32_t i = 0; i < p->count; i++)
            take_taps(&p->classes[i], taps, p->survey->total[p->id[i]].pixels);
        leave_flat_out(p, ticks);
        uint32_t error = budget_choose(p->classes, p->count, ticks), sum = 0;
        for (uint32_t i = 0; i < p->count; i++)
            sum = fx_add_sat(sum, p->classes[i].ticks[p->classes[i].rate]);
        error = fx_add_sat(error, light_error(p, ladder[step]));
        if (error >= least || (sum > ticks && ladder[step] > RASTER_LEAST_LIGHTS && all > RASTER_LEAST_LIGHTS))
            continue; /* fewer lights may fit */
        least = error;
        expected = fx_add_sat(sum, more_passes(p));
        p->quality = (struct raster_quality){.lights = ladder[step], .taps = taps}; /* 1x1 of what does not show */
        for (uint32_t i = 0; i < p->count; i++)
            p->quality.rate[p->id[i]] = p->classes[i].rate;
    }
    if (p->units.lights != fx_min_u(p->quality.lights, all) || taps != RASTER_TAPS_8)
        units_find(&p->units, p, p->quality.lights, taps);
    return expected;
}
