/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 587406,
    .clear = 84688,
    .meshlet = 6391,
    .vertex = 1574,
    .triangle = 479,
    .general = 1959,
    .clipped = 0,
    .facing = 4945,
    .row = 1085,
    .tested = 363,
    .general_facing = 4600,
    .general_row = 94,
    .general_tested = 315,
    .survey = 351,
    .light = 3200,
    .region = 83678,
    .flat = 115364,
    .part = 5887,
    .mixed = 0,
    .run = 0,
    .copied = 0,
    .finished = 117,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30649, 6229, 2005, 169, 16729, 81211},
            [RASTER_SHADE_SPECULAR_FRAME] = {28499, 6260, 16565, 489, 28561, 117736},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30625, 6597, 911, 0, 15247, 76030},
            [RASTER_SHADE_BLINN_PHONG] = {30025, 7283, 2286, 1155, 17174, 84381},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32252, 7298, 3802, 115, 20233, 95572},
            [RASTER_SHADE_DIFFUSE_ROW] = {8368, 2594, 1301, 1301, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {11209, 4836, 773, 773, 0, 0},
        },
};

#endif
