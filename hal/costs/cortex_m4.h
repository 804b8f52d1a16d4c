/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 328740,
    .clear = 84640,
    .meshlet = 6283,
    .vertex = 1591,
    .triangle = 492,
    .general = 1918,
    .facing = 4887,
    .row = 1067,
    .tested = 368,
    .general_facing = 4417,
    .general_row = 112,
    .general_tested = 325,
    .survey = 333,
    .light = 3200,
    .region = 82544,
    .flat = 117167,
    .part = 3678,
    .cell = 1224,
    .finished = 198,
    .run = 1327,
    .plan = 432000,
    .texels = {3771, 2582, 1419},
    .taps = {0, 122, 296},
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31223, 4373, 1864, 132, 16697, 80699},
            [RASTER_SHADE_SPECULAR_FRAME] = {29738, 4363, 16603, 284, 28441, 116741},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30537, 4548, 809, 0, 15126, 74738},
            [RASTER_SHADE_BLINN_PHONG] = {30475, 5197, 2162, 1188, 17003, 82886},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {33154, 5190, 3682, 133, 20194, 94540},
            [RASTER_SHADE_DIFFUSE_ROW] = {5335, 1629, 1287, 1287, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8291, 4281, 998, 998, 0, 0},
        },
};

#endif
