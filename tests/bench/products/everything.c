#include "budget.h"

const struct raster_parts *const product_parts = &raster_all_parts;
const struct budget_scheduler *const product_budgets;
