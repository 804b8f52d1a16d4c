/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 577396,
    .meshlet = 5948,
    .vertex = 1623,
    .triangle = 478,
    .general = 2020,
    .clipped = 0,
    .facing = 4827,
    .row = 1041,
    .tested = 371,
    .survey = 372,
    .light = 3200,
    .region = 119617,
    .flat = 285136,
    .cell = 375,
    .part = 8641,
    .mixed = 2510,
    .run = 1857,
    .copied = 218,
    .finished = 218,
    .plan = 96000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31380, 7053, 3371, 83, 17782, 74819},
            [RASTER_SHADE_SPECULAR_FRAME] = {28820, 7088, 17773, 107, 28600, 107111},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {31457, 7415, 1228, 0, 15438, 66922},
            [RASTER_SHADE_BLINN_PHONG] = {30642, 8374, 2543, 1190, 17217, 74975},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32695, 8262, 4075, 0, 20158, 85375},
            [RASTER_SHADE_DIFFUSE_ROW] = {0, 4955, 1668, 1668, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {0, 8256, 978, 978, 0, 0},
        },
};

#endif
