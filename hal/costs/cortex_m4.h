/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 328772,
    .clear = 84672,
    .meshlet = 6278,
    .vertex = 1592,
    .triangle = 491,
    .general = 1918,
    .facing = 4887,
    .row = 1067,
    .tested = 368,
    .general_facing = 4358,
    .general_row = 112,
    .general_tested = 325,
    .survey = 333,
    .light = 3200,
    .region = 79318,
    .flat = 116996,
    .part = 3685,
    .cell = 1222,
    .finished = 198,
    .run = 1327,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31085, 4364, 1863, 131, 16588, 80120},
            [RASTER_SHADE_SPECULAR_FRAME] = {29754, 4360, 16608, 285, 28444, 116674},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30581, 4547, 809, 0, 15134, 74697},
            [RASTER_SHADE_BLINN_PHONG] = {30520, 5196, 2162, 1188, 17005, 82846},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {33200, 5189, 3683, 133, 20196, 94498},
            [RASTER_SHADE_DIFFUSE_ROW] = {5335, 1629, 1287, 1287, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8291, 4281, 998, 998, 0, 0},
        },
};

#endif
