#include "budget.h"

static const struct raster_parts parts = {
    .specular_frame = &raster_specular_frame_model,
    .lafortune_phong = &raster_lafortune_phong_model,
    .blinn_phong = &raster_blinn_phong_model,
    .diffuse_rows = &raster_diffuse_rows,
    .blinn_phong_rows = &raster_blinn_phong_rows,
};

const struct raster_parts *const product_parts = &parts;
const struct budget_scheduler *const product_budgets;
enum scene_status (*const product_open)(struct scene *out, const void *blob, size_t bytes) = scene_open;
