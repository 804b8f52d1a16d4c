/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 358939,
    .clear = 84640,
    .meshlet = 6225,
    .vertex = 1624,
    .triangle = 478,
    .general = 1976,
    .facing = 4827,
    .row = 1048,
    .tested = 368,
    .general_facing = 4105,
    .general_row = 139,
    .general_tested = 326,
    .survey = 349,
    .light = 3200,
    .region = 93314,
    .flat = 117141,
    .part = 5525,
    .finished = 229,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {29442, 6445, 3046, 179, 17804, 85209},
            [RASTER_SHADE_SPECULAR_FRAME] = {27983, 6458, 16240, 319, 28728, 118655},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {29567, 6790, 1119, 0, 15559, 77558},
            [RASTER_SHADE_BLINN_PHONG] = {29064, 7458, 2293, 1129, 17298, 85258},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31519, 7473, 3682, 47, 20310, 96243},
            [RASTER_SHADE_DIFFUSE_ROW] = {8199, 2989, 1416, 1416, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {12417, 5594, 1071, 1071, 0, 0},
        },
};

#endif
