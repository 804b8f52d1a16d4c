/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 328723,
    .clear = 84640,
    .meshlet = 6223,
    .vertex = 1625,
    .triangle = 478,
    .general = 1976,
    .facing = 4827,
    .row = 1047,
    .tested = 368,
    .general_facing = 4150,
    .general_row = 139,
    .general_tested = 325,
    .survey = 330,
    .light = 3200,
    .region = 80741,
    .flat = 117188,
    .part = 3769,
    .cell = 1133,
    .finished = 198,
    .run = 1327,
    .plan = 432000,
    .taps = {0, 427, 841},
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30822, 4645, 2988, 182, 17679, 84010},
            [RASTER_SHADE_SPECULAR_FRAME] = {29568, 4636, 16570, 236, 28559, 117198},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30362, 4831, 1044, 4, 15432, 75960},
            [RASTER_SHADE_BLINN_PHONG] = {30207, 5473, 2239, 1241, 17168, 83641},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32874, 5466, 3673, 121, 20183, 94602},
            [RASTER_SHADE_DIFFUSE_ROW] = {5408, 1631, 1331, 1331, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8432, 4309, 1001, 1001, 0, 0},
        },
};

#endif
