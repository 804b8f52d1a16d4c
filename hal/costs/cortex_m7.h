/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 577839,
    .meshlet = 5875,
    .vertex = 1576,
    .triangle = 477,
    .general = 2013,
    .clipped = 0,
    .facing = 4926,
    .row = 1080,
    .tested = 368,
    .survey = 373,
    .light = 3200,
    .region = 121750,
    .flat = 289730,
    .part = 8481,
    .mixed = 3033,
    .run = 1993,
    .copied = 226,
    .finished = 218,
    .plan = 96000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {32268, 6933, 2196, 0, 16595, 70869},
            [RASTER_SHADE_SPECULAR_FRAME] = {29012, 6975, 17576, 138, 28138, 105690},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {31497, 7309, 997, 0, 15012, 65449},
            [RASTER_SHADE_BLINN_PHONG] = {30861, 8349, 2491, 1092, 16975, 74191},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32690, 8349, 4128, 0, 19960, 84882},
            [RASTER_SHADE_DIFFUSE_ROW] = {0, 4746, 1678, 1678, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {0, 8072, 975, 975, 0, 0},
        },
};

#endif
