/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 328288,
    .clear = 84688,
    .meshlet = 6407,
    .vertex = 1574,
    .triangle = 479,
    .general = 1960,
    .facing = 4945,
    .row = 1085,
    .tested = 363,
    .general_facing = 4595,
    .general_row = 94,
    .general_tested = 315,
    .survey = 328,
    .light = 3200,
    .region = 81189,
    .flat = 115047,
    .part = 3655,
    .cell = 1275,
    .finished = 197,
    .run = 1315,
    .plan = 432000,
    .texels = {3724, 2521, 1373},
    .taps = {0, 125, 298},
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31236, 4331, 1861, 130, 16648, 80465},
            [RASTER_SHADE_SPECULAR_FRAME] = {29805, 4322, 16524, 283, 28393, 116527},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30589, 4506, 809, 0, 15117, 74675},
            [RASTER_SHADE_BLINN_PHONG] = {30609, 5155, 2162, 1172, 17051, 83003},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {33135, 5147, 3694, 130, 20114, 94171},
            [RASTER_SHADE_DIFFUSE_ROW] = {5332, 1591, 1327, 1327, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8283, 4283, 980, 980, 0, 0},
        },
};

#endif
