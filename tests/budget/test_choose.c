/*
 * The choice of rates within a tile's ticks, against the best of all assignments: on cases as tiles have them (materials of every kind and
 * size, costs that fall and errors that rise with the rate), and on cases that are but numbers.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"

static uint64_t state;

static uint32_t draw(uint32_t below)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)((state >> 32) * below >> 32);
}

struct sums {
    uint64_t ticks, error;
};

static struct sums sums_of(const struct budget_class *c, uint32_t count)
{
    struct sums s = {0, 0};
    for (uint32_t i = 0; i < count; i++) {
        s.ticks += c[i].ticks[c[i].rate];
        s.error += c[i].error[c[i].rate];
    }
    return s;
}

/* The least error of all assignments within `ticks`; UINT64_MAX when there is none. */
static uint64_t best_of_all(const struct budget_class *c, uint32_t count, uint64_t ticks)
{
    uint64_t best = UINT64_MAX;
    if (!count)
        return 0;
    for (unsigned rate = 0; rate < RASTER_RATE_COUNT; rate++) {
        if (c->ticks[rate] > ticks)
            continue;
        uint64_t rest = best_of_all(c + 1, count - 1, ticks - c->ticks[rate]);
        if (rest != UINT64_MAX && rest + c->error[rate] < best)
            best = rest + c->error[rate];
    }
    return best;
}

/* Materials as a tile has them. */
static void draw_tile(struct budget_class *c, uint32_t count)
{
    static const uint32_t cell[RASTER_RATE_COUNT] = {1, 2, 4, 8, 16, 64}, loss[] = {0, 8, 20, 40, 90, 300};
    for (uint32_t i = 0; i < count; i++) {
        uint32_t pixels = 1 + draw(4096 / count) * draw(4096) / 4096, sample = 50 + draw(600), sharp = 1 + draw(40);
        for (unsigned rate = 0; rate < RASTER_RATE_COUNT; rate++) {
            uint32_t edges = rate ? draw(pixels) / 4 : 0, samples = pixels / cell[rate] + edges;
            samples = samples < pixels ? samples : pixels;
            c[i].ticks[rate] = samples * sample + (rate ? 12 * (pixels - samples) : 0);
            c[i].error[rate] = pixels * loss[rate] * sharp / 16;
        }
    }
}

static void draw_numbers(struct budget_class *c, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        for (unsigned rate = 0; rate < RASTER_RATE_COUNT; rate++) {
            c[i].ticks[rate] = draw(1 + draw(1000));
            c[i].error[rate] = (rate ? c[i].error[rate - 1] : 0) + draw(1 + draw(300));
        }
}

/* Ticks between what the cheapest and the dearest rates take. */
static uint32_t draw_ticks(const struct budget_class *c, uint32_t count)
{
    uint32_t least = 0, most = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t lo = UINT32_MAX, hi = 0;
        for (unsigned rate = 0; rate < RASTER_RATE_COUNT; rate++) {
            lo = c[i].ticks[rate] < lo ? c[i].ticks[rate] : lo;
            hi = c[i].ticks[rate] > hi ? c[i].ticks[rate] : hi;
        }
        least += lo;
        most += hi;
    }
    return least + draw(most - least + 1);
}

static bool is_full(const struct budget_class *c, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (c[i].rate != RASTER_RATE_1X1)
            return false;
    return true;
}

static void up_to_four_materials_get_the_optimum(void **unused)
{
    (void)unused;
    state = 1;
    for (unsigned n = 0; n < 20000; n++) {
        struct budget_class c[4];
        uint32_t count = 1 + n % 4;
        if (n % 3)
            draw_tile(c, count);
        else
            draw_numbers(c, count);
        uint32_t ticks = draw_ticks(c, count), error = budget_choose(c, count, ticks);
        struct sums s = sums_of(c, count);
        assert_int_equal(error, s.error);
        assert_true(s.ticks <= ticks);
        uint64_t best = best_of_all(c, count, ticks);
        assert_true(s.error == best || is_full(c, count));
    }
}

static int compare_ratios(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static void more_materials_get_almost_the_optimum(void **unused)
{
    enum { CASES = 900 };
    static double ratio[CASES];
    (void)unused;
    state = 2;
    for (unsigned n = 0; n < CASES; n++) {
        struct budget_class c[6];
        uint32_t count = 5 + n % 2;
        draw_tile(c, count);
        uint32_t ticks = draw_ticks(c, count);
        budget_choose(c, count, ticks);
        struct sums s = sums_of(c, count);
        uint64_t best = best_of_all(c, count, ticks);
        assert_true(s.ticks <= ticks);
        assert_true(s.error >= best);
        ratio[n] = best ? (double)s.error / (double)best : s.error ? 1e9 : 1;
    }
    qsort(ratio, CASES, sizeof *ratio, compare_ratios);
    printf("# error over the optimum's: median %.4f, p95 %.4f, most %.3f\n", ratio[CASES / 2], ratio[CASES * 95 / 100],
           ratio[CASES - 1]);
    assert_true(ratio[CASES / 2] <= 1.02);
    assert_true(ratio[CASES * 95 / 100] <= 1.5);
}

static void enough_ticks_leave_every_rate_full(void **unused)
{
    (void)unused;
    state = 3;
    for (unsigned n = 0; n < 2000; n++) {
        struct budget_class c[RASTER_CLASSES];
        uint32_t count = 1 + n % RASTER_CLASSES, ticks = 0;
        draw_tile(c, count);
        for (uint32_t i = 0; i < count; i++)
            ticks += c[i].ticks[RASTER_RATE_1X1];
        budget_choose(c, count, ticks);
        for (uint32_t i = 0; i < count; i++)
            assert_int_equal(c[i].rate, RASTER_RATE_1X1);
    }
}

static void too_few_ticks_choose_the_cheapest_rates(void **unused)
{
    (void)unused;
    state = 4;
    for (unsigned n = 0; n < 2000; n++) {
        struct budget_class c[RASTER_CLASSES];
        uint32_t count = 1 + n % RASTER_CLASSES, least = 0;
        draw_numbers(c, count);
        for (uint32_t i = 0; i < count; i++) {
            uint32_t lo = UINT32_MAX;
            for (unsigned rate = 0; rate < RASTER_RATE_COUNT; rate++)
                lo = c[i].ticks[rate] < lo ? c[i].ticks[rate] : lo;
            least += lo;
        }
        if (!least)
            continue;
        budget_choose(c, count, draw(least));
        assert_true(sums_of(c, count).ticks == least);
    }
}

/* A tile's materials, some of which fewer taps make cheaper: each by its own least sum of error and ticks at the price. */
static void prices_say_rates_and_taps(void **unused)
{
    static const uint32_t least_taps[BUDGET_PRICES] = {0, 1, 2, 2, 2, 2};
    (void)unused;
    state = 5;
    for (unsigned n = 0; n < 2000; n++) {
        struct budget_class c[RASTER_CLASSES] = {0};
        uint32_t ticks[BUDGET_PRICES], count = 1 + n % RASTER_CLASSES;
        draw_tile(c, count);
        for (uint32_t i = 0; i < count; i++) {
            c[i].saved[RASTER_TAPS_4] = n % 2 ? draw(20 << RASTER_COST_BITS) : 0;
            c[i].saved[RASTER_TAPS_1] = 2 * c[i].saved[RASTER_TAPS_4];
            for (unsigned rate = 0; rate < RASTER_RATE_COUNT; rate++)
                c[i].samples[rate] = c[i].ticks[rate] / 50;
        }
        budget_ticks_at_prices(ticks, c, count);
        for (uint32_t price = 0; price < BUDGET_PRICES; price++) {
            double low = 0, high = 0; /* of equal sums either may be taken */
            for (uint32_t i = 0; i < count; i++) {
                double takes[RASTER_RATE_COUNT], sum[RASTER_RATE_COUNT], best = INFINITY, lo = INFINITY, hi = 0;
                for (int rate = 0; rate < RASTER_RATE_COUNT; rate++) {
                    takes[rate] = c[i].ticks[rate] - c[i].samples[rate] * c[i].saved[least_taps[price]] / 16.0;
                    sum[rate] = c[i].error[rate] + takes[rate] * pow(16, price) / 256;
                    best = fmin(best, sum[rate]);
                }
                for (int rate = 0; rate < RASTER_RATE_COUNT; rate++)
                    if (sum[rate] <= best + fmax(1, pow(16, price) / 256) * 2) { /* whole units of either */
                        lo = fmin(lo, takes[rate]);
                        hi = fmax(hi, takes[rate]);
                    }
                low += lo, high += hi;
            }
            assert_true(ticks[price] >= low - 1 && ticks[price] <= high + count);
            assert_true(!price || ticks[price] <= ticks[price - 1]);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(up_to_four_materials_get_the_optimum),
        cmocka_unit_test(more_materials_get_almost_the_optimum),
        cmocka_unit_test(enough_ticks_leave_every_rate_full),
        cmocka_unit_test(too_few_ticks_choose_the_cheapest_rates),
        cmocka_unit_test(prices_say_rates_and_taps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
