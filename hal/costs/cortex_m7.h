/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 319100,
    .clear = 84720,
    .meshlet = 6203,
    .vertex = 1576,
    .triangle = 478,
    .general = 2113,
    .facing = 4927,
    .row = 1093,
    .tested = 361,
    .general_facing = 3671,
    .general_row = 379,
    .general_tested = 376,
    .survey = 328,
    .light = 3200,
    .region = 79151,
    .flat = 112535,
    .part = 3623,
    .cell = 1274,
    .finished = 199,
    .run = 1314,
    .plan = 432000,
    .broad = 2172,
    .bright = 1312,
    .slow_point = 4150,
    .texels = {3722, 2519, 1371},
    .taps = {0, 124, 298},
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31222, 4313, 1857, 130, 16830, 81069},
            [RASTER_SHADE_SPECULAR_FRAME] = {30056, 4307, 16472, 284, 28558, 117023},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30891, 4490, 807, 0, 15298, 75266},
            [RASTER_SHADE_BLINN_PHONG] = {30666, 5137, 2156, 1168, 17201, 83461},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {33115, 5130, 3682, 129, 20248, 94559},
            [RASTER_SHADE_DIFFUSE_ROW] = {5286, 1591, 1328, 1328, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8237, 4283, 980, 980, 0, 0},
        },
};

#endif
