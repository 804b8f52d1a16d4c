/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 574582,
    .meshlet = 5398,
    .vertex = 1592,
    .triangle = 491,
    .general = 2038,
    .clipped = 0,
    .facing = 4862,
    .row = 1064,
    .tested = 373,
    .survey = 375,
    .light = 3200,
    .region = 377933,
    .cell = 533,
    .part = 2608,
    .mixed = 8489,
    .run = 1788,
    .copied = 366,
    .finished = 218,
    .plan = 96000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {32409, 6754, 2201, 87, 16224, 91798},
            [RASTER_SHADE_SPECULAR_FRAME] = {29645, 6802, 17948, 246, 27935, 118878},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {32029, 7188, 988, 0, 14599, 86430},
            [RASTER_SHADE_BLINN_PHONG] = {31134, 8165, 2482, 1202, 16514, 94926},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {33455, 8067, 4120, 32, 19624, 104430},
            [RASTER_SHADE_DIFFUSE_ROW] = {0, 4717, 1642, 1642, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {0, 8000, 999, 999, 0, 0},
        },
};

#endif
