/*
 * What a product that embeds lut/ and raster/ calls: opening, a frame, its tiles. Linked with each of the other files of this folder, which
 * say what a product has, to see what it pays in flash (tests/bench/products.sh).
 */
#include "budget.h"

extern const struct raster_parts *const product_parts;
extern const struct budget_scheduler *const product_budgets; /* or NULL */
extern enum scene_status (*const product_open)(struct scene *out, const void *blob, size_t bytes);
extern const struct hal product_hal;
extern const struct raster_costs product_costs;
extern const uint32_t product_table[], product_scene[];
extern void product_show(const struct raster_rect *rect, const uint8_t *pixels);

static uint64_t arena[2048];
static struct raster raster;
static struct raster_tile tile;
static struct lut_table table;
static struct scene scene;

int main(void)
{
    static struct budget budget;
    static const struct lut_table *const tables[RASTER_MAX_SLOTS] = {&table};
    if (lut_open(&table, product_table, 1 << 16) != LUT_OK || product_open(&scene, product_scene, 1 << 20) != SCENE_OK)
        return 1;
    struct raster_frame frame = {
        .parts = product_parts,
        .scene = &scene,
        .camera = &scene.header->camera,
        .output = &scene.header->output,
        .lights = scene.lights,
        .materials = scene.materials,
        .tables = tables,
        .width = 320,
        .height = 240,
        .light_count = (uint8_t)scene.header->lights.count,
    };
    if (product_budgets) {
        frame.costs = &product_costs;
        frame.bounds = product_budgets->bounds;
        frame.tile_budget = 1 << 20;
    }
    if (raster_begin(&raster, &frame, arena, sizeof arena) != RASTER_OK)
        return 1;
    for (uint32_t i = 0; i < raster_tile_count(&raster); i++) {
        const uint32_t t = raster_tile_at(&raster, i);
        struct budget_report report;
        struct raster_rect rect;
        struct raster_stats stats;
        if (product_budgets && !i)
            product_budgets->begin(&budget, &product_hal, &raster, frame.tile_budget);
        if (product_budgets)
            product_budgets->render_tile(&budget, &report, &raster, t, &tile, &rect, &stats);
        else
            raster_render_tile(&raster, t, &tile, &rect, &stats);
        product_show(&rect, raster_tile_pixels(&tile));
    }
    return 0;
}
