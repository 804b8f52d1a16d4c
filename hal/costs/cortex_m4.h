/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 577511,
    .meshlet = 5864,
    .vertex = 1592,
    .triangle = 491,
    .general = 2039,
    .clipped = 0,
    .facing = 4879,
    .row = 1063,
    .tested = 372,
    .survey = 375,
    .light = 3200,
    .region = 116517,
    .flat = 283488,
    .cell = 363,
    .part = 8599,
    .mixed = 2706,
    .run = 2175,
    .copied = 222,
    .finished = 218,
    .plan = 96000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {32279, 6903, 2206, 0, 16735, 71296},
            [RASTER_SHADE_SPECULAR_FRAME] = {29158, 6942, 17759, 139, 28448, 106553},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {31602, 7307, 1006, 0, 15117, 65725},
            [RASTER_SHADE_BLINN_PHONG] = {30971, 8289, 2490, 1081, 17034, 74258},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32951, 8174, 4105, 0, 20151, 85374},
            [RASTER_SHADE_DIFFUSE_ROW] = {0, 4834, 1642, 1642, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {0, 8098, 999, 999, 0, 0},
        },
};

#endif
