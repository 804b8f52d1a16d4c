/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 574675,
    .meshlet = 5406,
    .vertex = 1626,
    .triangle = 477,
    .general = 2019,
    .clipped = 0,
    .facing = 4808,
    .row = 1043,
    .tested = 373,
    .survey = 372,
    .light = 3200,
    .region = 378646,
    .cell = 541,
    .part = 2582,
    .mixed = 8340,
    .run = 1465,
    .copied = 366,
    .finished = 218,
    .plan = 96000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31416, 6890, 3372, 179, 17260, 98599},
            [RASTER_SHADE_SPECULAR_FRAME] = {29194, 6933, 17920, 215, 28076, 123263},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {31779, 7278, 1212, 0, 14910, 91471},
            [RASTER_SHADE_BLINN_PHONG] = {30696, 8232, 2530, 1309, 16687, 99551},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32961, 8129, 4078, 69, 19622, 108375},
            [RASTER_SHADE_DIFFUSE_ROW] = {0, 4838, 1668, 1668, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {0, 8159, 979, 979, 0, 0},
        },
};

#endif
