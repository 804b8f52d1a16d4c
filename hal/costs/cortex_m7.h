/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 587552,
    .clear = 84688,
    .meshlet = 6389,
    .vertex = 1574,
    .triangle = 479,
    .general = 1959,
    .clipped = 0,
    .facing = 4945,
    .row = 1085,
    .tested = 363,
    .general_facing = 4583,
    .general_row = 94,
    .general_tested = 315,
    .survey = 351,
    .light = 3200,
    .region = 83739,
    .flat = 116875,
    .part = 5841,
    .mixed = 0,
    .run = 0,
    .copied = 5,
    .finished = 117,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30480, 6278, 2001, 171, 16665, 81078},
            [RASTER_SHADE_SPECULAR_FRAME] = {28396, 6308, 16262, 487, 28243, 116698},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30458, 6646, 909, 0, 15183, 75964},
            [RASTER_SHADE_BLINN_PHONG] = {29863, 7331, 2282, 1156, 17110, 84321},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32094, 7346, 3796, 118, 20169, 95480},
            [RASTER_SHADE_DIFFUSE_ROW] = {8380, 2642, 1301, 1301, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {11215, 4884, 773, 773, 0, 0},
        },
};

#endif
