#include "budget.h"

static const struct raster_parts parts = {
    .half_vector = &raster_half_vector_model,
};

const struct raster_parts *const product_parts = &parts;
const struct budget_scheduler *const product_budgets;
