/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 364526,
    .clear = 84688,
    .meshlet = 6410,
    .vertex = 1574,
    .triangle = 478,
    .general = 1960,
    .facing = 4945,
    .row = 1085,
    .tested = 363,
    .general_facing = 4585,
    .general_row = 94,
    .general_tested = 315,
    .survey = 348,
    .light = 3200,
    .region = 87749,
    .flat = 114887,
    .part = 5920,
    .finished = 229,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30079, 4665, 1838, 207, 16665, 79933},
            [RASTER_SHADE_SPECULAR_FRAME] = {27581, 4689, 16294, 496, 28499, 116444},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30324, 4847, 793, 22, 15227, 74617},
            [RASTER_SHADE_BLINN_PHONG] = {29086, 5497, 2141, 1253, 17163, 82945},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31300, 5493, 3653, 247, 20227, 94113},
            [RASTER_SHADE_DIFFUSE_ROW] = {8999, 1280, 1361, 1361, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {13448, 3914, 997, 997, 0, 0},
        },
};

#endif
