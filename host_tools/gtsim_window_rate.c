#include "gtsim_window_rate.h"

#include <string.h>

static enum raster_rate shown = RASTER_RATE_1X1;

static void shade(const struct raster *r, struct raster_tile *work, const struct raster_rect *rect,
                  struct budget_report *report, struct raster_stats *stats)
{
    struct raster_quality q = {.lights = RASTER_ALL_LIGHTS};
    const struct raster_survey *s = raster_tile_survey(r, work, rect);
    memset(q.rate, (int)shown, sizeof q.rate);
    for (uint32_t c = 0; c < s->classes; c++) {
        report->pixels += s->total[c].pixels;
        report->rates += s->total[c].pixels * shown;
        if (s->total[c].pixels)
            report->error += raster_class_error(s, c, shown);
    }
    for (uint32_t region = 0; region < s->regions; region++)
        raster_tile_shade(r, work, rect, region, &q, stats);
}

static void render_tile(struct budget *b, struct budget_report *report, const struct raster *r, uint32_t index,
                        struct raster_tile *work, struct raster_rect *rect, struct raster_stats *stats)
{
    if (b->mean != RATE_BUDGET) {
        budget_render_tile(b, report, r, index, work, rect, stats);
        return;
    }
    *report = (struct budget_report){.lights = RASTER_ALL_LIGHTS, .coarsest = (uint8_t)shown};
    raster_tile_begin(r, index, work, rect, stats);
    while (raster_tile_draw(r, work, UINT32_MAX, stats) == RASTER_NO_SLOT) {
        shade(r, work, rect, report, stats);
        raster_tile_free_slots(r, work, rect, stats);
    }
    shade(r, work, rect, report, stats);
    raster_tile_finish(r, work, rect, stats);
    report->spent = (uint32_t)(stats->cost >> RASTER_COST_BITS); /* modelled */
    report->share = report->predicted = report->spent;
}

void rate_install(struct sim_device *d)
{
    static struct budget_scheduler scheduler;
    scheduler = budget_scheduler;
    scheduler.render_tile = render_tile;
    d->config.budgets = d->app.config.budgets = &scheduler;
}

void rate_set(enum raster_rate rate)
{
    shown = rate;
}

enum raster_rate rate_now(void)
{
    return shown;
}

const char *rate_name(enum raster_rate rate)
{
    static const char *const names[RASTER_RATE_COUNT] = {"1x1", "2x1", "2x2", "4x2", "4x4", "flat"};
    return names[rate];
}
