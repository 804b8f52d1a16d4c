/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 577839,
    .meshlet = 5869,
    .vertex = 1576,
    .triangle = 477,
    .general = 2013,
    .clipped = 0,
    .facing = 4926,
    .row = 1080,
    .tested = 368,
    .survey = 373,
    .light = 3200,
    .region = 120904,
    .flat = 285591,
    .cell = 304,
    .part = 8721,
    .mixed = 3039,
    .run = 1953,
    .copied = 238,
    .finished = 218,
    .plan = 96000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {32255, 6947, 2196, 0, 16593, 71009},
            [RASTER_SHADE_SPECULAR_FRAME] = {29029, 6990, 17573, 136, 28137, 105835},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {31465, 7323, 998, 0, 15010, 65553},
            [RASTER_SHADE_BLINN_PHONG] = {30844, 8362, 2491, 1090, 16973, 74292},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32661, 8362, 4128, 0, 19958, 84967},
            [RASTER_SHADE_DIFFUSE_ROW] = {0, 4746, 1678, 1678, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {0, 8072, 975, 975, 0, 0},
        },
};

#endif
