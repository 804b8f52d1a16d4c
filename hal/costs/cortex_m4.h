/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 328740,
    .clear = 84640,
    .meshlet = 6276,
    .vertex = 1592,
    .triangle = 491,
    .general = 1918,
    .facing = 4887,
    .row = 1068,
    .tested = 368,
    .general_facing = 4384,
    .general_row = 112,
    .general_tested = 325,
    .survey = 333,
    .light = 3200,
    .region = 80039,
    .flat = 117127,
    .part = 3681,
    .cell = 1223,
    .finished = 198,
    .run = 1327,
    .plan = 432000,
    .taps = {0, 122, 296},
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31223, 4371, 1864, 132, 16699, 80663},
            [RASTER_SHADE_SPECULAR_FRAME] = {29743, 4362, 16606, 284, 28444, 116713},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30554, 4548, 809, 0, 15133, 74716},
            [RASTER_SHADE_BLINN_PHONG] = {30491, 5196, 2162, 1188, 17005, 82865},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {33170, 5189, 3683, 133, 20196, 94518},
            [RASTER_SHADE_DIFFUSE_ROW] = {5335, 1629, 1287, 1287, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8291, 4281, 998, 998, 0, 0},
        },
};

#endif
