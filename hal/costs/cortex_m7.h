/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 328287,
    .clear = 84688,
    .meshlet = 6406,
    .vertex = 1575,
    .triangle = 478,
    .general = 1960,
    .facing = 4945,
    .row = 1085,
    .tested = 363,
    .general_facing = 4632,
    .general_row = 94,
    .general_tested = 315,
    .survey = 328,
    .light = 3200,
    .region = 81246,
    .flat = 115057,
    .part = 3654,
    .cell = 1275,
    .finished = 197,
    .run = 1315,
    .plan = 432000,
    .broad = 2662,
    .texels = {3724, 2521, 1373},
    .taps = {0, 125, 299},
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31208, 4329, 1861, 130, 16649, 80450},
            [RASTER_SHADE_SPECULAR_FRAME] = {29816, 4323, 16522, 282, 28393, 116544},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30595, 4507, 808, 0, 15117, 74691},
            [RASTER_SHADE_BLINN_PHONG] = {30615, 5156, 2162, 1172, 17051, 83019},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {33142, 5148, 3693, 130, 20114, 94187},
            [RASTER_SHADE_DIFFUSE_ROW] = {5332, 1591, 1327, 1327, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8283, 4283, 980, 980, 0, 0},
        },
};

#endif
