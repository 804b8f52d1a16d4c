/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 364729,
    .clear = 84672,
    .meshlet = 6283,
    .vertex = 1591,
    .triangle = 492,
    .general = 1918,
    .facing = 4887,
    .row = 1067,
    .tested = 368,
    .general_facing = 4358,
    .general_row = 112,
    .general_tested = 325,
    .survey = 351,
    .light = 3200,
    .region = 86058,
    .flat = 117172,
    .part = 5820,
    .finished = 229,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {29966, 4675, 1833, 205, 16702, 80102},
            [RASTER_SHADE_SPECULAR_FRAME] = {27509, 4696, 16305, 487, 28552, 116660},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30147, 4856, 790, 22, 15232, 74680},
            [RASTER_SHADE_BLINN_PHONG] = {28897, 5502, 2132, 1260, 17121, 82828},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31270, 5498, 3626, 244, 20313, 94481},
            [RASTER_SHADE_DIFFUSE_ROW] = {9042, 1322, 1323, 1323, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {13465, 3921, 1017, 1017, 0, 0},
        },
};

#endif
