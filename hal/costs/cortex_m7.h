/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 364527,
    .clear = 84688,
    .meshlet = 6411,
    .vertex = 1573,
    .triangle = 479,
    .general = 1960,
    .facing = 4946,
    .row = 1084,
    .tested = 363,
    .general_facing = 4601,
    .general_row = 94,
    .general_tested = 315,
    .survey = 317,
    .light = 3200,
    .region = 85667,
    .flat = 114883,
    .part = 5885,
    .finished = 229,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30082, 4673, 1836, 208, 16665, 79933},
            [RASTER_SHADE_SPECULAR_FRAME] = {27584, 4696, 16284, 500, 28499, 116444},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30320, 4854, 792, 23, 15227, 74617},
            [RASTER_SHADE_BLINN_PHONG] = {29098, 5504, 2139, 1253, 17163, 82946},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31313, 5500, 3650, 248, 20227, 94112},
            [RASTER_SHADE_DIFFUSE_ROW] = {8610, 1290, 1358, 1358, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {13051, 3917, 995, 995, 0, 0},
        },
};

#endif
