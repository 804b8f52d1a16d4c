/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 574691,
    .meshlet = 5405,
    .vertex = 1626,
    .triangle = 477,
    .general = 2019,
    .clipped = 0,
    .facing = 4809,
    .row = 1043,
    .tested = 373,
    .survey = 372,
    .light = 3200,
    .region = 118852,
    .flat = 292371,
    .cell = 374,
    .part = 8674,
    .mixed = 2503,
    .run = 1879,
    .copied = 217,
    .finished = 218,
    .plan = 96000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30857, 7042, 3367, 79, 17774, 74693},
            [RASTER_SHADE_SPECULAR_FRAME] = {28280, 7077, 17777, 104, 28592, 107022},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30956, 7406, 1221, 0, 15430, 66873},
            [RASTER_SHADE_BLINN_PHONG] = {30169, 8369, 2537, 1185, 17209, 74956},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32198, 8254, 4070, 0, 20150, 85332},
            [RASTER_SHADE_DIFFUSE_ROW] = {0, 4838, 1668, 1668, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {0, 8159, 979, 979, 0, 0},
        },
};

#endif
