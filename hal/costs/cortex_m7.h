/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 587406,
    .clear = 84688,
    .meshlet = 6390,
    .vertex = 1574,
    .triangle = 479,
    .general = 1959,
    .clipped = 0,
    .facing = 4945,
    .row = 1085,
    .tested = 363,
    .general_facing = 4580,
    .general_row = 94,
    .general_tested = 315,
    .survey = 351,
    .light = 3200,
    .region = 98653,
    .flat = 121549,
    .part = 5797,
    .mixed = 0,
    .run = 0,
    .copied = 0,
    .finished = 117,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30209, 6060, 1967, 132, 16710, 81071},
            [RASTER_SHADE_SPECULAR_FRAME] = {28126, 6081, 16287, 412, 28544, 117632},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30069, 6417, 891, 0, 15230, 75891},
            [RASTER_SHADE_BLINN_PHONG] = {29527, 7096, 2231, 1077, 17159, 84238},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31802, 7108, 3724, 71, 20219, 95437},
            [RASTER_SHADE_DIFFUSE_ROW] = {8368, 2594, 1301, 1301, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {11209, 4836, 773, 773, 0, 0},
        },
};

#endif
