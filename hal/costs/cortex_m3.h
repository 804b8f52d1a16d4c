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
    .general_tested = 325,
    .survey = 347,
    .light = 3200,
    .region = 88940,
    .flat = 117228,
    .part = 5664,
    .finished = 229,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {29218, 4909, 2932, 261, 17747, 83705},
            [RASTER_SHADE_SPECULAR_FRAME] = {27411, 4922, 16215, 412, 28671, 117143},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {29623, 5091, 1017, 57, 15540, 75922},
            [RASTER_SHADE_BLINN_PHONG] = {28632, 5731, 2198, 1297, 17287, 83602},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31041, 5726, 3603, 217, 20304, 94563},
            [RASTER_SHADE_DIFFUSE_ROW] = {9103, 1325, 1368, 1368, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {13645, 3944, 1020, 1020, 0, 0},
        },
};

#endif
