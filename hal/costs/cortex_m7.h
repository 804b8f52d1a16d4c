/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 575787,
    .meshlet = 5393,
    .vertex = 1576,
    .triangle = 478,
    .general = 1844,
    .clipped = 0,
    .facing = 4909,
    .row = 1082,
    .tested = 370,
    .survey = 373,
    .light = 3200,
    .region = 351109,
    .cell = 464,
    .part = 3225,
    .mixed = 8353,
    .run = 1623,
    .copied = 371,
    .finished = 239,
    .plan = 96000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {32276, 6806, 2188, 78, 15955, 87713},
            [RASTER_SHADE_SPECULAR_FRAME] = {29384, 6856, 17719, 231, 27496, 114417},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {31747, 7208, 980, 0, 14369, 82481},
            [RASTER_SHADE_BLINN_PHONG] = {30899, 8243, 2480, 1197, 16330, 91193},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32991, 8257, 4135, 39, 19308, 100281},
            [RASTER_SHADE_DIFFUSE_ROW] = {0, 4604, 1675, 1675, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {0, 7943, 973, 973, 0, 0},
        },
};

#endif
