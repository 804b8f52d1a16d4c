/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 328288,
    .clear = 84688,
    .meshlet = 6409,
    .vertex = 1574,
    .triangle = 479,
    .general = 1959,
    .facing = 4945,
    .row = 1085,
    .tested = 363,
    .general_facing = 4598,
    .general_row = 94,
    .general_tested = 315,
    .survey = 328,
    .light = 3200,
    .region = 78584,
    .flat = 115011,
    .part = 3658,
    .cell = 1274,
    .finished = 197,
    .run = 1315,
    .plan = 432000,
    .taps = {0, 125, 299},
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31235, 4329, 1861, 130, 16651, 80433},
            [RASTER_SHADE_SPECULAR_FRAME] = {29811, 4321, 16526, 283, 28395, 116503},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30604, 4505, 808, 0, 15124, 74658},
            [RASTER_SHADE_BLINN_PHONG] = {30624, 5155, 2162, 1172, 17053, 82987},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {33152, 5147, 3694, 130, 20116, 94153},
            [RASTER_SHADE_DIFFUSE_ROW] = {5332, 1591, 1327, 1327, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8283, 4283, 980, 980, 0, 0},
        },
};

#endif
