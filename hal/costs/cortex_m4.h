/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 574598,
    .meshlet = 5382,
    .vertex = 1592,
    .triangle = 491,
    .general = 2038,
    .clipped = 0,
    .facing = 4863,
    .row = 1064,
    .tested = 374,
    .survey = 375,
    .light = 3200,
    .region = 115837,
    .flat = 283366,
    .cell = 362,
    .part = 8626,
    .mixed = 2702,
    .run = 2193,
    .copied = 221,
    .finished = 218,
    .plan = 96000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31735, 6891, 2200, 0, 16727, 71057},
            [RASTER_SHADE_SPECULAR_FRAME] = {28609, 6931, 17761, 136, 28440, 106289},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {31095, 7298, 999, 0, 15109, 65561},
            [RASTER_SHADE_BLINN_PHONG] = {30490, 8282, 2484, 1077, 17026, 74135},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32445, 8166, 4100, 0, 20143, 85223},
            [RASTER_SHADE_DIFFUSE_ROW] = {0, 4717, 1642, 1642, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {0, 8000, 999, 999, 0, 0},
        },
};

#endif
