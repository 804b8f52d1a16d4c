/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 577511,
    .meshlet = 5870,
    .vertex = 1590,
    .triangle = 492,
    .general = 2039,
    .clipped = 0,
    .facing = 4880,
    .row = 1062,
    .tested = 372,
    .survey = 375,
    .light = 3200,
    .region = 117201,
    .flat = 285993,
    .part = 8442,
    .mixed = 2707,
    .run = 2193,
    .copied = 215,
    .finished = 218,
    .plan = 96000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {32268, 6894, 2205, 0, 16736, 71218},
            [RASTER_SHADE_SPECULAR_FRAME] = {29136, 6933, 17753, 140, 28449, 106472},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {31609, 7300, 1005, 0, 15118, 65684},
            [RASTER_SHADE_BLINN_PHONG] = {30972, 8281, 2488, 1082, 17036, 74218},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32954, 8166, 4104, 0, 20153, 85336},
            [RASTER_SHADE_DIFFUSE_ROW] = {0, 4834, 1642, 1642, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {0, 8098, 999, 999, 0, 0},
        },
};

#endif
