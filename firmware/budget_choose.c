/*
 * The choice of rates: a multiple-choice knapsack. Up to four classes are searched in full: every pair of rates of the first two, and for each
 * pair the other two at once, as one gets finer while the other gets coarser. For more classes a price of a tick is found first, at which
 * each class on its own would choose what fits in all (Lagrange; Everett 1963); then the four with most at stake are searched in full.
 */
#include "budget.h"

#define SEARCHED 4

/* A class's rates worth choosing, from the dearest to the cheapest: the error rises. */
struct options {
    struct budget_class *of;
    uint32_t count;
    uint32_t ticks[RASTER_RATE_COUNT], error[RASTER_RATE_COUNT];
    uint8_t rate[RASTER_RATE_COUNT];
};

/* Leaves out what is no cheaper than a finer rate, and what errs no less than a coarser one that is cheaper. */
static void options_find(struct options *o, struct budget_class *c)
{
    o->of = c;
    o->count = 0;
    for (unsigned rate = 0; rate < RASTER_RATE_COUNT; rate++) {
        uint32_t ticks = c->ticks[rate], error = c->error[rate], n = o->count;
        if (n && ticks >= o->ticks[n - 1])
            continue;
        while (n && error <= o->error[n - 1])
            n--;
        o->ticks[n] = ticks;
        o->error[n] = error;
        o->rate[n] = (uint8_t)rate;
        o->count = n + 1;
    }
}

/* Per class an index into its options. */
struct choice {
    uint32_t error;
    uint8_t at[SEARCHED];
};

/* The best of the last two classes within `ticks`, for given options of the first two, whose error is in *c. */
static void search_last(struct choice *best, struct choice *c, const struct options *const o[SEARCHED], uint32_t ticks)
{
    const struct options *p = o[2], *q = o[3];
    uint32_t j = q->count; /* q's finest that fits beside p's is before it */
    for (uint32_t i = 0; i < p->count; i++) {
        if (p->ticks[i] > ticks)
            continue;
        while (j && q->ticks[j - 1] <= ticks - p->ticks[i])
            j--;
        if (j == q->count) /* not even its cheapest */
            continue;
        uint32_t error = c->error + p->error[i] + q->error[j];
        if (error < best->error) {
            *best = *c;
            best->error = error;
            best->at[2] = (uint8_t)i;
            best->at[3] = (uint8_t)j;
        }
    }
}

/* Up to four classes, whose cheapest options fit. */
static void search(const struct options *const classes[], uint32_t count, uint32_t ticks)
{
    static const struct options nothing = {.count = 1};
    const struct options *o[SEARCHED];
    struct choice best = {UINT32_MAX, {0}}, c = {0, {0}};
    for (uint32_t i = 0; i < SEARCHED; i++)
        o[i] = i < count ? classes[i] : &nothing;
    for (uint32_t i = 0; i < o[0]->count; i++)
        for (uint32_t j = 0; j < o[1]->count; j++) {
            uint32_t first = o[0]->ticks[i] + o[1]->ticks[j];
            c.error = o[0]->error[i] + o[1]->error[j];
            if (c.error >= best.error)
                break;
            c.at[0] = (uint8_t)i;
            c.at[1] = (uint8_t)j;
            if (first <= ticks)
                search_last(&best, &c, o, ticks - first);
        }
    for (uint32_t i = 0; i < count; i++)
        classes[i]->of->rate = o[i]->rate[best.at[i]];
}

/* From 1 to 2^30 errors per 2^16 ticks, four to an octave. */
#define PRICES 120u
static uint32_t price_of(uint32_t step)
{
    return (4 + step % 4) << step / 4 >> 2;
}

/* What a class would choose on its own. */
static uint32_t choose_at_price(const struct options *o, uint32_t price)
{
    uint32_t best = 0;
    uint64_t least = UINT64_MAX;
    for (uint32_t i = 0; i < o->count; i++) {
        uint64_t cost = ((uint64_t)o->error[i] << 16) + (uint64_t)o->ticks[i] * price; /* < 2^48 + 2^62 */
        if (cost < least) {
            least = cost;
            best = i;
        }
    }
    return best;
}

static uint32_t ticks_at_price(const struct options *o, uint32_t count, uint32_t price)
{
    uint32_t sum = 0;
    for (uint32_t i = 0; i < count; i++)
        sum += o[i].ticks[choose_at_price(&o[i], price)];
    return sum;
}

/* Error and ticks at the i-th price, in units of which one is at least as large as either's last place. In: both below 2^28. */
static uint32_t weighed(uint32_t error, uint32_t ticks, uint32_t i)
{
    return i < 2 ? error + (ticks >> (8 - 4 * i)) : (error >> (4 * i - 8)) + ticks;
}

void budget_ticks_at_prices(uint32_t ticks[BUDGET_PRICES], const struct budget_class *classes, uint32_t count)
{
    for (uint32_t i = 0; i < BUDGET_PRICES; i++)
        ticks[i] = 0;
    for (const struct budget_class *c = classes, *end = c + count; c != end; c++) {
        unsigned best = RASTER_RATE_1X1;
        for (uint32_t i = 0; i < BUDGET_PRICES; i++) {
            const uint32_t saved = c->saved[budget_taps_at(i)];
            uint32_t takes = c->ticks[best] - (c->samples[best] * saved >> RASTER_COST_BITS),
                     least = weighed(c->error[best], takes, i);
            for (unsigned rate = best + 1; rate < RASTER_RATE_COUNT; rate++) { /* the dearer a tick, the coarser */
                const uint32_t other = c->ticks[rate] - (c->samples[rate] * saved >> RASTER_COST_BITS);
                const uint32_t cost = weighed(c->error[rate], other, i);
                if (cost < least) {
                    least = cost;
                    takes = other;
                    best = rate;
                }
            }
            ticks[i] = fx_add_sat(ticks[i], takes);
        }
    }
}

/* More than four classes: all by the lowest price that fits, then the four with most error at stake by search. Returns the ticks that the
 * others take, and sorts these four to the front of *chosen. */
static uint32_t choose_others(const struct options *chosen[], const struct options *o, uint32_t count, uint32_t ticks)
{
    uint32_t low = 0, high = PRICES, taken = 0; /* the highest stands for the cheapest rates */
    while (low < high) {
        uint32_t middle = (low + high) / 2;
        if (ticks_at_price(o, count, price_of(middle)) <= ticks)
            high = middle;
        else
            low = middle + 1;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t at = high < PRICES ? choose_at_price(&o[i], price_of(high)) : o[i].count - 1;
        o[i].of->rate = o[i].rate[at];
        chosen[i] = &o[i];
    }
    for (uint32_t i = 0; i < SEARCHED; i++)
        for (uint32_t k = i + 1; k < count; k++) {
            const struct options *a = chosen[i], *b = chosen[k];
            if (b->error[b->count - 1] - b->error[0] > a->error[a->count - 1] - a->error[0]) {
                chosen[i] = b;
                chosen[k] = a;
            }
        }
    for (uint32_t i = SEARCHED; i < count; i++)
        taken += chosen[i]->of->ticks[chosen[i]->of->rate];
    return taken;
}

/* Every class at full quality; false when that does not fit. */
static bool choose_full(struct budget_class *classes, uint32_t count, uint32_t ticks)
{
    uint32_t sum = 0;
    for (uint32_t i = 0; i < count; i++) {
        classes[i].rate = RASTER_RATE_1X1;
        sum += classes[i].ticks[RASTER_RATE_1X1];
    }
    return sum <= ticks;
}

static void choose_within(struct budget_class *classes, uint32_t count, uint32_t ticks)
{
    struct options o[RASTER_CLASSES];
    const struct options *chosen[RASTER_CLASSES];
    uint32_t cheapest = 0;
    for (uint32_t i = 0; i < count; i++) {
        options_find(&o[i], &classes[i]);
        chosen[i] = &o[i];
        cheapest += o[i].ticks[o[i].count - 1];
        classes[i].rate = o[i].rate[o[i].count - 1];
    }
    if (cheapest > ticks)
        return;
    if (count > SEARCHED)
        ticks -= choose_others(chosen, o, count, ticks);
    search(chosen, count < SEARCHED ? count : SEARCHED, ticks);
}

uint32_t budget_choose(struct budget_class *classes, uint32_t count, uint32_t ticks)
{
    uint32_t error = 0;
    if (!choose_full(classes, count, ticks))
        choose_within(classes, count, ticks);
    for (uint32_t i = 0; i < count; i++)
        error += classes[i].error[classes[i].rate];
    return error;
}
