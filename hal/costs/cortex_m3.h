/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 322414,
    .clear = 84752,
    .meshlet = 6190,
    .vertex = 1626,
    .triangle = 478,
    .general = 2211,
    .facing = 4820,
    .row = 1055,
    .tested = 365,
    .general_facing = 3794,
    .general_row = 418,
    .general_tested = 372,
    .survey = 330,
    .light = 3200,
    .region = 80298,
    .flat = 114716,
    .part = 3739,
    .cell = 1128,
    .finished = 199,
    .run = 1371,
    .plan = 432000,
    .broad = 2008,
    .bright = 1372,
    .slow_point = 4243,
    .texels = {2819, 1487, 372},
    .taps = {0, 427, 841},
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30882, 4640, 2983, 181, 17745, 84170},
            [RASTER_SHADE_SPECULAR_FRAME] = {29940, 4634, 16536, 235, 28640, 117362},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30715, 4827, 1042, 1, 15528, 76212},
            [RASTER_SHADE_BLINN_PHONG] = {30275, 5468, 2234, 1237, 17234, 83761},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32937, 5461, 3666, 119, 20233, 94652},
            [RASTER_SHADE_DIFFUSE_ROW] = {5354, 1630, 1332, 1332, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8378, 4308, 1001, 1001, 0, 0},
        },
};

#endif
