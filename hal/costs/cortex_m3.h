/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 586990,
    .clear = 84640,
    .meshlet = 6202,
    .vertex = 1625,
    .triangle = 477,
    .general = 1976,
    .clipped = 0,
    .facing = 4827,
    .row = 1047,
    .tested = 368,
    .general_facing = 4115,
    .general_row = 139,
    .general_tested = 325,
    .survey = 349,
    .light = 3200,
    .region = 76204,
    .flat = 120294,
    .part = 5530,
    .mixed = 0,
    .run = 0,
    .copied = 2,
    .finished = 117,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {29959, 6651, 3071, 233, 17880, 85484},
            [RASTER_SHADE_SPECULAR_FRAME] = {28527, 6668, 16358, 399, 28735, 118613},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30182, 6995, 1118, 0, 15635, 77883},
            [RASTER_SHADE_BLINN_PHONG] = {29625, 7657, 2317, 1219, 17376, 85590},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32063, 7669, 3724, 111, 20388, 96547},
            [RASTER_SHADE_DIFFUSE_ROW] = {8506, 2788, 1293, 1293, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {11344, 5013, 759, 759, 0, 0},
        },
};

#endif
