/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 364729,
    .clear = 84672,
    .meshlet = 6283,
    .vertex = 1591,
    .triangle = 492,
    .general = 1918,
    .facing = 4887,
    .row = 1067,
    .tested = 368,
    .general_facing = 4358,
    .general_row = 112,
    .general_tested = 325,
    .survey = 351,
    .light = 3200,
    .region = 99103,
    .flat = 117042,
    .part = 5799,
    .finished = 229,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30040, 6040, 1964, 120, 16749, 81486},
            [RASTER_SHADE_SPECULAR_FRAME] = {28033, 6060, 16331, 391, 28600, 118052},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {29887, 6387, 897, 0, 15240, 76200},
            [RASTER_SHADE_BLINN_PHONG] = {29288, 7068, 2233, 1084, 17120, 84370},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31718, 7084, 3712, 63, 20307, 96047},
            [RASTER_SHADE_DIFFUSE_ROW] = {8207, 2837, 1379, 1379, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {12331, 5427, 1074, 1074, 0, 0},
        },
};

#endif
