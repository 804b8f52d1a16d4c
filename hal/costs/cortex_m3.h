/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 358939,
    .clear = 84640,
    .meshlet = 6218,
    .vertex = 1626,
    .triangle = 477,
    .general = 1976,
    .facing = 4828,
    .row = 1047,
    .tested = 368,
    .general_facing = 4115,
    .general_row = 139,
    .general_tested = 325,
    .survey = 317,
    .light = 3200,
    .region = 86888,
    .flat = 117238,
    .part = 5632,
    .finished = 229,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {29224, 4915, 2929, 263, 17747, 83706},
            [RASTER_SHADE_SPECULAR_FRAME] = {27412, 4929, 16205, 415, 28671, 117145},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {29619, 5097, 1016, 58, 15540, 75922},
            [RASTER_SHADE_BLINN_PHONG] = {28643, 5737, 2196, 1297, 17287, 83602},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31052, 5732, 3600, 218, 20304, 94565},
            [RASTER_SHADE_DIFFUSE_ROW] = {8746, 1334, 1364, 1364, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {13281, 3948, 1018, 1018, 0, 0},
        },
};

#endif
