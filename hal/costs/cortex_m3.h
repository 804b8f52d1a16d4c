/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 577396,
    .meshlet = 5949,
    .vertex = 1623,
    .triangle = 479,
    .general = 2020,
    .clipped = 0,
    .facing = 4827,
    .row = 1041,
    .tested = 371,
    .survey = 372,
    .light = 3200,
    .region = 119378,
    .flat = 285149,
    .part = 8653,
    .mixed = 2512,
    .run = 1843,
    .copied = 219,
    .finished = 218,
    .plan = 96000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31364, 7058, 3371, 83, 17782, 74826},
            [RASTER_SHADE_SPECULAR_FRAME] = {28809, 7093, 17772, 106, 28601, 107121},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {31457, 7422, 1228, 0, 15438, 66969},
            [RASTER_SHADE_BLINN_PHONG] = {30644, 8381, 2542, 1189, 17217, 75020},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32698, 8269, 4075, 0, 20158, 85419},
            [RASTER_SHADE_DIFFUSE_ROW] = {0, 4955, 1668, 1668, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {0, 8256, 978, 978, 0, 0},
        },
};

#endif
