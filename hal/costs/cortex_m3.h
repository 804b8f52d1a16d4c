/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 328724,
    .clear = 84640,
    .meshlet = 6220,
    .vertex = 1625,
    .triangle = 477,
    .general = 1976,
    .facing = 4827,
    .row = 1047,
    .tested = 368,
    .general_facing = 4156,
    .general_row = 139,
    .general_tested = 326,
    .survey = 330,
    .light = 3200,
    .region = 82339,
    .flat = 117240,
    .part = 3766,
    .cell = 1133,
    .finished = 198,
    .run = 1327,
    .plan = 432000,
    .broad = 2443,
    .texels = {2820, 1487, 373},
    .taps = {0, 427, 841},
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30783, 4645, 2988, 182, 17677, 84032},
            [RASTER_SHADE_SPECULAR_FRAME] = {29563, 4639, 16566, 235, 28558, 117244},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30340, 4833, 1044, 4, 15428, 75997},
            [RASTER_SHADE_BLINN_PHONG] = {30186, 5475, 2238, 1241, 17167, 83678},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32853, 5468, 3672, 121, 20182, 94640},
            [RASTER_SHADE_DIFFUSE_ROW] = {5408, 1631, 1331, 1331, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8432, 4309, 1001, 1001, 0, 0},
        },
};

#endif
