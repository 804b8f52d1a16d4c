/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 319286,
    .clear = 84640,
    .meshlet = 6220,
    .vertex = 1625,
    .triangle = 477,
    .general = 1976,
    .facing = 4827,
    .row = 1047,
    .tested = 368,
    .general_facing = 4104,
    .general_row = 139,
    .general_tested = 326,
    .survey = 330,
    .light = 3200,
    .region = 80146,
    .flat = 117217,
    .part = 3775,
    .cell = 1132,
    .finished = 200,
    .run = 1249,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30734, 4638, 2990, 182, 17631, 83728},
            [RASTER_SHADE_SPECULAR_FRAME] = {29580, 4635, 16575, 236, 28559, 117163},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30393, 4831, 1044, 4, 15433, 75943},
            [RASTER_SHADE_BLINN_PHONG] = {30240, 5473, 2239, 1242, 17168, 83625},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32907, 5466, 3674, 121, 20183, 94585},
            [RASTER_SHADE_DIFFUSE_ROW] = {5324, 1647, 1328, 1328, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8306, 4323, 992, 992, 0, 0},
        },
};

#endif
