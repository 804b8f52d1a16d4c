#include "budget.h"

static const struct raster_parts parts = {
    .half_vector = &raster_half_vector_model,
};

const struct raster_parts *const product_parts = &parts;
const struct budget_scheduler *const product_budgets;
enum scene_status (*const product_open)(struct scene *out, const void *blob, size_t bytes) = scene_open;
