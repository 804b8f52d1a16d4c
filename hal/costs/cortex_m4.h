/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 328740,
    .clear = 84640,
    .meshlet = 6282,
    .vertex = 1591,
    .triangle = 492,
    .general = 1918,
    .facing = 4887,
    .row = 1067,
    .tested = 368,
    .general_facing = 4402,
    .general_row = 112,
    .general_tested = 325,
    .survey = 333,
    .light = 3200,
    .region = 82610,
    .flat = 117192,
    .part = 3677,
    .cell = 1224,
    .finished = 198,
    .run = 1327,
    .plan = 432000,
    .broad = 2743,
    .texels = {3771, 2582, 1419},
    .taps = {0, 122, 296},
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31196, 4371, 1864, 132, 16697, 80683},
            [RASTER_SHADE_SPECULAR_FRAME] = {29747, 4364, 16601, 284, 28441, 116757},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30543, 4549, 809, 0, 15126, 74753},
            [RASTER_SHADE_BLINN_PHONG] = {30481, 5198, 2162, 1188, 17003, 82901},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {33161, 5191, 3682, 133, 20194, 94555},
            [RASTER_SHADE_DIFFUSE_ROW] = {5335, 1629, 1287, 1287, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8291, 4281, 998, 998, 0, 0},
        },
};

#endif
