/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 358938,
    .clear = 84640,
    .meshlet = 6218,
    .vertex = 1626,
    .triangle = 477,
    .general = 1976,
    .facing = 4827,
    .row = 1047,
    .tested = 368,
    .general_facing = 4104,
    .general_row = 139,
    .general_tested = 326,
    .survey = 347,
    .light = 3200,
    .region = 93162,
    .flat = 117147,
    .part = 5522,
    .finished = 229,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {29441, 6446, 3046, 179, 17804, 85207},
            [RASTER_SHADE_SPECULAR_FRAME] = {27983, 6458, 16239, 319, 28728, 118654},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {29567, 6790, 1119, 0, 15559, 77557},
            [RASTER_SHADE_BLINN_PHONG] = {29066, 7458, 2293, 1129, 17298, 85257},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31520, 7474, 3682, 47, 20310, 96242},
            [RASTER_SHADE_DIFFUSE_ROW] = {8199, 2989, 1416, 1416, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {12417, 5594, 1071, 1071, 0, 0},
        },
};

#endif
