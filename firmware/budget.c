#include "budget.h"

#define ONE 256u /* of ratios */

/* Ticks of deciding, modelled where there is no clock: a tile's share, a class's rates, a region's. */
enum { OWN_TILE = 300, OWN_CLASS = 3000, OWN_REGION = 150 };
#define KEPT_REGION 600u /* what a region's and class's deciding takes at most, on a clock */

/* Ticks beyond the least from which on a plan is made, and rates are chosen in it: more than either takes. */
#define PLAN_WORTH   60000u
#define CHOICE_WORTH 40000u

/* A tile being rendered. */
struct tile {
    struct budget *b;
    const struct raster *r;
    struct raster_tile *work;
    const struct raster_rect *rect;
    struct raster_stats *stats;
    struct budget_report *report;
    uint32_t index;
    uint32_t start;         /* on the clock */
    uint32_t limit;         /* what later tiles need for certain is behind it */
    uint32_t survey;        /* a survey's ticks and its plan's, at most */
    bool any;               /* something was drawn since slots were free */
    uint32_t shading, full; /* ticks that it took, and would at full quality */
    uint32_t spare;         /* at the coarsest levels: ticks that are not needed for certain */
};

static uint32_t elapsed(const struct tile *k)
{
    const struct hal *hal = k->b->hal;
    return hal->clock ? hal->clock(hal->ctx) - k->start
                      : (uint32_t)(k->stats->cost >> RASTER_COST_BITS) + k->report->own;
}

static uint32_t ticks_until(const struct tile *k, uint32_t end)
{
    const uint32_t now = elapsed(k);
    return end > now ? end - now : 0;
}

/* Adds what deciding took since `before`; modelled as `model`. */
static void decided(struct tile *k, uint32_t before, uint32_t model)
{
    k->report->own += k->b->hal->clock ? elapsed(k) - before : model;
}

/* Of sums, 8 fraction bits, 0: nothing was learnt. */
static uint32_t ratio_of(const struct budget_ratio *k)
{
    const uint32_t most = (uint32_t)((k->over | k->under) >> 24); /* < 2^56 */
    const unsigned shift = most ? 32 - fx_clz(most) : 0;
    const uint32_t over = (uint32_t)(k->over >> shift), under = (uint32_t)(k->under >> shift);
    return under ? fx_clamp((int32_t)((over << 8) / under), 1, UINT16_MAX) : 0;
}

/* Half as much as what the next frame will tell. */
static void forget(struct budget_ratio *k)
{
    k->over /= 2;
    k->under /= 2;
}

/* What tiles must find, but will not take, with all shading times a ratio, 8 fraction bits. */
static uint64_t surplus(const struct budget_reserve *k, uint32_t ratio)
{
    const uint64_t takes = k->besides + (k->demand * ratio >> 8);
    return k->ticks > takes ? k->ticks - takes : 0;
}

/* Of tiles to come, the ones whose reserves are larger by the most than what they and all after them are expected to take. */
static void find_reserve(struct budget *b, const struct raster *r)
{
    const uint32_t ratio = ratio_of(&b->chosen_ratio);
    struct budget_reserve at = {.from = raster_tile_count(r)};
    uint64_t least = 0, most = 0;
    b->reserve = at;
    while (at.from > b->done + 1) {
        const uint32_t tile = raster_tile_at(r, --at.from);
        const struct raster_expected e = raster_tile_expected(r, tile);
        least += r->bounds[tile].least;
        at.demand += e.shading;
        at.besides += e.besides;
        at.ticks = least + r->bounds[raster_tile_at(r, at.from - 1)].keep;
        if (surplus(&at, ratio ? ratio : ONE) > most) {
            most = surplus(&at, ratio ? ratio : ONE);
            b->reserve = at;
        }
    }
}

void budget_begin(struct budget *b, const struct hal *hal, const struct raster *r, uint32_t mean)
{
    const uint32_t tiles = raster_tile_count(r);
    b->hal = hal;
    b->mean = mean;
    b->learnt.lod_bias = (uint8_t)r->lod_bias;
    forget(&b->shading_ratio);
    for (uint32_t i = 0; i < BUDGET_PRICES; i++)
        forget(&b->price_ratio[i]);
    b->left = (uint64_t)mean * tiles; /* < 2^50 */
    b->least = b->demand = b->besides = 0;
    for (uint32_t t = 0; t < tiles; t++) {
        const struct raster_expected e = raster_tile_expected(r, t);
        b->least += r->bounds[t].least;
        b->demand += e.shading;
        b->besides += e.besides;
    }
    forget(&b->chosen_ratio);
    b->done = 0;
    find_reserve(b, r);
    b->lit = b->lit ? b->lit : 192;
    b->point = b->point ? b->point : 256;
}

/* The tile is no longer one to come. */
static void take_out(struct tile *k)
{
    struct budget *b = k->b;
    const struct raster_expected e = raster_tile_expected(k->r, k->index);
    b->least -= k->r->bounds[k->index].least;
    /* Tiles that share what was learnt may have changed it. */
    b->demand -= e.shading < b->demand ? e.shading : b->demand;
    b->besides -= e.besides < b->besides ? e.besides : b->besides;
    k->limit = b->left > b->least ? fx_sat31(b->left - b->least) : 0;
    if (b->done >= b->reserve.from)
        find_reserve(b, k->r);
    b->done++;
}

static void learn(struct budget_ratio *k, uint32_t over, uint32_t under)
{
    k->over += over;
    k->under += under < over / 16 ? over / 16 : under; /* a tile by itself is not to be trusted */
}

/* What a tile has and takes as long as there is nothing to be shaded. */
static void none_planned(struct tile *k)
{
    k->report->share = k->r->bounds[k->index].least;
    k->report->predicted = elapsed(k) + ((k->r->frame.costs->tile - k->r->frame.costs->clear) >> RASTER_COST_BITS);
}

/* --- drawing --- */

/* Back to an empty tile, which the coarsest levels fill for certain. */
static void fall_back(struct tile *k)
{
    const uint32_t left = ticks_until(k, k->limit), least = k->r->bounds[k->index].least;
    *k->report = (struct budget_report){.lights = RASTER_ALL_LIGHTS, .own = k->report->own, .coarse = true};
    k->spare = left > least ? left - least : 0;
    k->any = false;
    none_planned(k);
    raster_tile_restart(k->r, k->index, k->work);
    k->stats->cost += k->r->frame.costs->clear;
}

/* Draws until no slot is left (false), or no meshlet is: falls back before what is left would no longer do for that. */
static bool draw(struct tile *k)
{
    const struct raster_tile_bound *t = &k->r->bounds[k->index];
    const uint32_t reserve = fx_add_sat(t->least, k->survey);
    for (;;) {
        uint32_t most = UINT32_MAX;
        if (!k->report->coarse && t->largest) {
            const uint32_t left = ticks_until(k, k->limit);
            most = left > reserve ? (left - reserve) / t->largest : 0;
            if (!most) {
                fall_back(k);
                continue;
            }
        }
        const uint32_t before = k->stats->meshlets;
        const enum raster_drawing drawn = raster_tile_draw(k->r, k->work, most, k->stats);
        k->any |= k->stats->meshlets != before;
        if (drawn != RASTER_MORE)
            return drawn == RASTER_DRAWN;
    }
}

/* --- shading --- */

/* Pixels and their errors, at the rates that they got. */
static void report_region(const struct tile *k, uint32_t region, const struct raster_quality *q)
{
    const struct budget_plan *p = &k->b->plan;
    struct budget_report *out = k->report;
    for (uint32_t i = 0; i < p->count; i++) {
        const uint32_t id = p->id[i], pixels = p->survey->area[id][region].pixels;
        const uint8_t rate = q->rate[id];
        out->pixels += pixels;
        if ((!rate && !q->taps) || !pixels)
            continue;
        out->rates += pixels * rate;
        out->error =
            fx_add_sat(out->error, (p->classes[i].error[rate] / p->survey->total[id].pixels + 1) * pixels); /* 2^29 */
        out->coarsest = rate > out->coarsest ? rate : out->coarsest;
    }
}

/* Shades all regions: what they take, and `finish` ticks, end before `end`. */
static void shade_regions(struct tile *k, uint32_t end, uint32_t finish)
{
    struct budget_plan *p = &k->b->plan;
    uint32_t rows = 0;
    for (uint32_t i = 0; i < p->survey->regions; i++) {
        if (p->flat_cells[i] == p->flat_cells[i + 1])
            continue; /* nothing waits there */
        const uint32_t before = elapsed(k), own = OWN_REGION * (p->count + 1);
        const uint32_t deciding = KEPT_REGION * (p->count + 1) * (p->survey->regions - i);
        const uint32_t after = budget_least_ticks(p, i + 1) + rows + finish + deciding;
        const uint32_t left = end > before ? end - before : 0;
        struct raster_quality q = p->quality;
        budget_region_fit(&q, p, i, left > after ? left - after : 0);
        rows += budget_rows_ticks(p, i, &q);
        report_region(k, i, &q);
        decided(k, before, own);
        raster_tile_shade(k->r, k->work, k->rect, i, &q, k->stats);
        if (!k->b->hal->clock)
            k->stats->cost += (uint64_t)budget_cells_ticks(p, i, &q) << RASTER_COST_BITS;
    }
    k->report->lights = p->quality.lights < k->report->lights ? p->quality.lights : k->report->lights;
    k->report->taps = p->quality.taps > k->report->taps ? p->quality.taps : k->report->taps;
}

/* At most, of what follows the last region, but for rows. */
static uint32_t finish_ticks(const struct tile *k)
{
    const struct raster_costs *c = k->r->frame.costs;
    const struct budget_plan *p = &k->b->plan;
    uint32_t pixels = p->pixels, runs = 8 * p->survey->edges; /* two in a row of a cell */
    if (k->stats->meshlets >= RASTER_SLOTS)                   /* some may have their colour */
        pixels = RASTER_TILE_PIXELS, runs = RASTER_TILE_PIXELS / 2;
    runs = fx_min_u(runs, pixels);
    return ((c->finished * pixels + c->run * runs + c->tile - c->clear) >> RASTER_COST_BITS) + 1; /* 2^20 2^11, twice */
}

/* Ticks for shading what is drawn: at the lowest price at which this and the tiles to come take what is left, or between that and the
 * next; in full, if they may. Out: the taps. */
static uint32_t grant(enum raster_taps *taps, struct tile *k, uint32_t now, uint32_t full, uint32_t finish)
{
    struct budget *b = k->b;
    const uint64_t besides = b->besides + finish + now;
    const uint64_t kept = b->least + k->r->bounds[k->index].keep + finish + now;
    const uint64_t others = b->demand;
    const uint32_t takes = ratio_of(&b->shading_ratio);
    uint64_t left = b->left > besides ? b->left - besides : 0, need_above = others + full + surplus(&b->reserve, ONE);
    uint32_t own[BUDGET_PRICES], own_above = full, ticks = full;
    left += takes && takes < ONE ? (left * (ONE - takes)) >> 8 : 0; /* as is expected */
    bool found = need_above <= left;
    *taps = RASTER_TAPS_8;
    budget_ticks_at_prices(own, b->plan.classes, b->plan.count);
    for (uint32_t i = 0; i < BUDGET_PRICES; i++) { /* all, for they are learnt */
        learn(&b->price_ratio[i], own[i], full);
        if (found)
            continue;
        uint32_t ratio = ratio_of(&b->price_ratio[i]);
        ratio = ratio ? ratio : ONE - i * ONE / (BUDGET_PRICES + 4); /* before anything was learnt */
        const uint64_t need = (others * ratio >> 8) + own[i] + surplus(&b->reserve, ratio);
        found = need <= left;
        *taps = budget_taps_at(i);
        ticks = own[i];
        if (found && own_above > own[i] && need_above > need) {
            uint64_t more = left - need, range = need_above - need;
            while (range >> 16)
                range >>= 1, more >>= 1;
            ticks += (uint32_t)((uint64_t)(own_above - own[i]) * ((uint32_t)(more << 8) / (uint32_t)range) >> 8);
        }
        need_above = need;
        own_above = own[i];
    }
    const uint32_t most = b->left > kept ? fx_sat31(b->left - kept) : 0;
    *taps = most < ticks ? RASTER_TAPS_1 : *taps;
    return fx_min_u(ticks, most);
}

/* Without a plan, for which there are no ticks: every region at the last rung. */
static void shade_flat(struct tile *k, const struct raster_survey *survey)
{
    static const struct raster_quality q = {.rate = {[0 ... RASTER_CLASSES - 1] = RASTER_RATE_FLAT},
                                            .lights = RASTER_LEAST_LIGHTS};
    for (uint32_t c = 0; c < survey->classes; c++) {
        const uint32_t pixels = survey->total[c].pixels;
        k->report->pixels += pixels;
        k->report->rates += pixels * RASTER_RATE_FLAT;
        if (pixels)
            k->report->error = fx_add_sat(k->report->error, raster_class_error(survey, c, RASTER_RATE_FLAT));
    }
    k->report->coarsest = RASTER_RATE_FLAT;
    k->report->lights = RASTER_LEAST_LIGHTS;
    k->report->share = k->limit;
    k->report->predicted = k->r->bounds[k->index].least;
    for (uint32_t i = 0; i < survey->regions; i++)
        raster_tile_shade(k->r, k->work, k->rect, i, &q, k->stats);
}

/* Shading under point lights took `ticks`, where `expected` were; rises at once, falls slowly, too. */
static void learn_point(struct budget *b, uint32_t ticks, uint32_t expected)
{
    while (expected >> 20)
        expected >>= 1, ticks >>= 1;
    if (!expected)
        return;
    const uint32_t now = fx_min_u(b->point * fx_min_u((ticks << 8) / expected, 1024) >> 8, 256); /* 2^9 2^10 */
    b->point = now > b->point ? now : b->point - (b->point - now) / 8;
    b->point = b->point > 64 ? b->point : 64;
}

/* Plans and shades what is drawn; `last`: every meshlet is. False: it took too much, the tile is to be drawn again. */
static bool shade_pass(struct tile *k, bool last)
{
    struct budget *b = k->b;
    struct budget_plan *p = &b->plan;
    const struct raster_survey *survey = raster_tile_survey(k->r, k->work, k->rect);
    k->stats->cost += (uint64_t)k->r->frame.costs->survey * RASTER_TILE_PIXELS +
                      (uint64_t)k->r->frame.costs->light * k->r->frame.light_count;
    const uint32_t before = elapsed(k);
    if (k->report->coarse && k->spare < PLAN_WORTH) {
        shade_flat(k, survey);
        return true;
    }
    budget_plan_begin(p, b, k->r, k->work, k->rect, last);
    decided(k, before, OWN_CLASS);
    const uint32_t begun = elapsed(k), left = ticks_until(k, k->limit);
    const uint32_t finish = last ? finish_ticks(k) : 0, least = budget_least_ticks(p, 0);
    const uint32_t own = KEPT_REGION * (p->count + 1) * survey->regions,
                   own_likely = OWN_REGION * (p->count + 1) * survey->regions;
    /* What an earlier pass must leave: for the levels wanted as much as it takes to fall back still, then half of what is spare. */
    const uint32_t reserve = last ? 0 : k->r->bounds[k->index].least, need = least + finish + own;
    if (!k->report->coarse && left < need + reserve)
        return false;
    const uint32_t spare = last ? left : k->report->coarse ? need + k->spare / 2 : need + (left - need - reserve) / 2;
    uint32_t full = 0, ticks = least, expected, end = begun + spare;
    for (uint32_t i = 0; i < p->count; i++)
        full = fx_add_sat(full, p->classes[i].ticks[RASTER_RATE_1X1]);
    if (spare > need + CHOICE_WORTH) {
        enum raster_taps taps;
        const uint32_t granted = grant(&taps, k, begun + own_likely + OWN_CLASS * p->count, full, finish);
        ticks = granted > least ? granted : least;
        expected = budget_plan_choose(p, b, ticks, taps);
        decided(k, begun, OWN_CLASS * p->count);
    } else {
        expected = budget_plan_flat(p);
    }
    k->report->predicted = elapsed(k) + own_likely + finish + expected;
    if (ticks < full && spare > need) { /* as much, and some for surprises, but what is kept for later tiles */
        const uint32_t now = elapsed(k), keep = k->r->bounds[k->index].keep,
                       soft = k->limit > keep ? k->limit - keep : 0;
        const uint32_t wanted = now + own + finish + ticks / 4 * 5, most = now + need > soft ? now + need : soft;
        end = fx_min_u(end, fx_min_u(wanted, most));
    }
    if (last) { /* what is kept for the tile is its own, whatever it needs */
        const uint32_t kept = fx_min_u(k->r->bounds[k->index].least, k->limit);
        end = end > kept ? end : kept;
    }
    k->report->share = end;
    const uint32_t shading = elapsed(k);
    shade_regions(k, end, finish);
    const uint32_t took = elapsed(k) - shading;
    learn(&b->shading_ratio, took, expected);
    learn(&b->chosen_ratio, expected, full);
    if (survey->point_lights)
        learn_point(b, took, expected);
    k->shading = fx_add_sat(k->shading, took);
    k->full = fx_add_sat(k->full, full);
    const uint32_t used = elapsed(k) - begun, more = used > need ? used - need : 0;
    k->spare -= more < k->spare ? more : k->spare;
    return true;
}

/* Of pixel-lights: rises at once, falls slowly, for what is lit costs more. */
static uint32_t lit_share(uint32_t old, const struct raster_stats *s)
{
    if (!s->tried)
        return old;
    const uint32_t now = (s->shaded << 8) / s->tried; /* < 2^18 pixel-lights, 2^20 with 4 samples per pixel */
    return now > old ? now : old - (old - now) / 4;
}

static void render(struct tile *k)
{
    const struct raster_costs *c = k->r->frame.costs;
    const uint32_t begun = elapsed(k);
    take_out(k);
    k->survey = (uint32_t)(((uint64_t)c->survey * RASTER_TILE_PIXELS + (uint64_t)c->light * k->r->frame.light_count +
                            c->plan) >>
                           RASTER_COST_BITS) +
                1;
    decided(k, begun, OWN_TILE);
    none_planned(k);
    for (bool done = false; !done;) {
        const bool last = draw(k);
        if (k->any && !shade_pass(k, last)) {
            fall_back(k);
            continue;
        }
        k->any = false;
        done = last;
        if (!last)
            raster_tile_free_slots(k->r, k->work, k->rect, k->stats);
    }
}

/* See struct raster_learnt: of 6 fraction bits instead of 8. */
static uint8_t learnt_ratio(uint32_t took, uint32_t expected)
{
    const uint32_t ratio = ratio_of(&(struct budget_ratio){took, expected});
    return ratio ? (uint8_t)fx_clamp((int32_t)(ratio >> 2), 1, UINT8_MAX) : 0;
}

void budget_render_tile(struct budget *b, struct budget_report *report, const struct raster *r, uint32_t index,
                        struct raster_tile *work, struct raster_rect *rect, struct raster_stats *stats)
{
    struct tile k = {.b = b, .r = r, .work = work, .rect = rect, .stats = stats, .report = report, .index = index};
    *report = (struct budget_report){.lights = RASTER_ALL_LIGHTS};
    *stats = (struct raster_stats){0};
    k.start = b->hal->clock ? b->hal->clock(b->hal->ctx) : 0;
    raster_tile_begin(r, index, work, rect, stats);
    render(&k);
    raster_tile_finish(r, work, rect, stats);
    b->lit = lit_share(b->lit, stats);
    report->spent = elapsed(&k);
    b->left -= report->spent < b->left ? report->spent : b->left;
    if (!report->coarse) {
        b->learnt.shading[index % RASTER_LEARNT_TILES] = learnt_ratio(k.full, r->bounds[index].demand);
        b->learnt.besides[index % RASTER_LEARNT_TILES] =
            learnt_ratio(report->spent - k.shading, r->bounds[index].besides);
    }
}

const struct budget_scheduler budget_scheduler = {&raster_tile_bounds, budget_begin, budget_render_tile};
