/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 328288,
    .clear = 84688,
    .meshlet = 6411,
    .vertex = 1573,
    .triangle = 479,
    .general = 1960,
    .facing = 4946,
    .row = 1084,
    .tested = 363,
    .general_facing = 4600,
    .general_row = 94,
    .general_tested = 315,
    .survey = 328,
    .light = 3200,
    .region = 78573,
    .flat = 114974,
    .part = 3658,
    .cell = 1274,
    .finished = 197,
    .run = 1315,
    .plan = 432000,
    .taps = {0, 125, 298},
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31234, 4329, 1861, 130, 16651, 80432},
            [RASTER_SHADE_SPECULAR_FRAME] = {29809, 4321, 16526, 283, 28395, 116502},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30603, 4505, 808, 0, 15124, 74657},
            [RASTER_SHADE_BLINN_PHONG] = {30623, 5155, 2162, 1172, 17053, 82985},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {33150, 5147, 3694, 130, 20116, 94153},
            [RASTER_SHADE_DIFFUSE_ROW] = {5332, 1591, 1327, 1327, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8283, 4283, 980, 980, 0, 0},
        },
};

#endif
