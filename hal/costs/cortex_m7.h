/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 328287,
    .clear = 84688,
    .meshlet = 6407,
    .vertex = 1574,
    .triangle = 479,
    .general = 1959,
    .facing = 4945,
    .row = 1085,
    .tested = 363,
    .general_facing = 4580,
    .general_row = 94,
    .general_tested = 315,
    .survey = 328,
    .light = 3200,
    .region = 77872,
    .flat = 114836,
    .part = 3662,
    .cell = 1274,
    .finished = 197,
    .run = 1315,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31107, 4322, 1861, 129, 16555, 79954},
            [RASTER_SHADE_SPECULAR_FRAME] = {29819, 4319, 16529, 283, 28396, 116464},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30631, 4505, 808, 0, 15125, 74639},
            [RASTER_SHADE_BLINN_PHONG] = {30653, 5154, 2162, 1172, 17053, 82967},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {33181, 5146, 3694, 130, 20116, 94133},
            [RASTER_SHADE_DIFFUSE_ROW] = {5332, 1591, 1327, 1327, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8283, 4283, 980, 980, 0, 0},
        },
};

#endif
