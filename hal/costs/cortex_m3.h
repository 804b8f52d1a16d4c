/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 586857,
    .clear = 84640,
    .meshlet = 6202,
    .vertex = 1625,
    .triangle = 477,
    .general = 1976,
    .clipped = 0,
    .facing = 4827,
    .row = 1047,
    .tested = 368,
    .general_facing = 4116,
    .general_row = 139,
    .general_tested = 325,
    .survey = 349,
    .light = 3200,
    .region = 77074,
    .flat = 117488,
    .part = 5560,
    .mixed = 0,
    .run = 0,
    .copied = 0,
    .finished = 117,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {29860, 6611, 3094, 224, 17823, 85201},
            [RASTER_SHADE_SPECULAR_FRAME] = {28390, 6629, 16476, 393, 28746, 118649},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30054, 6974, 1134, 0, 15574, 77550},
            [RASTER_SHADE_BLINN_PHONG] = {29544, 7643, 2335, 1201, 17313, 85250},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31984, 7657, 3744, 90, 20325, 96235},
            [RASTER_SHADE_DIFFUSE_ROW] = {8459, 2767, 1302, 1302, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {11299, 4994, 768, 768, 0, 0},
        },
};

#endif
