/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 364526,
    .clear = 84688,
    .meshlet = 6411,
    .vertex = 1574,
    .triangle = 479,
    .general = 1959,
    .facing = 4945,
    .row = 1085,
    .tested = 363,
    .general_facing = 4585,
    .general_row = 94,
    .general_tested = 315,
    .survey = 348,
    .light = 3200,
    .region = 97244,
    .flat = 114822,
    .part = 5899,
    .finished = 229,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30181, 6040, 1969, 124, 16713, 81215},
            [RASTER_SHADE_SPECULAR_FRAME] = {28122, 6063, 16321, 405, 28546, 117735},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30086, 6388, 900, 0, 15235, 76036},
            [RASTER_SHADE_BLINN_PHONG] = {29515, 7073, 2242, 1078, 17162, 84385},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31788, 7089, 3738, 67, 20222, 95576},
            [RASTER_SHADE_DIFFUSE_ROW] = {8124, 2799, 1418, 1418, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {12277, 5428, 1056, 1056, 0, 0},
        },
};

#endif
