#include "budget.h"

const struct raster_parts *const product_parts = &raster_all_parts;
const struct budget_scheduler *const product_budgets;
enum scene_status (*const product_open)(struct scene *out, const void *blob, size_t bytes) = scene_open;
