/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 364729,
    .clear = 84672,
    .meshlet = 6281,
    .vertex = 1591,
    .triangle = 492,
    .general = 1918,
    .facing = 4887,
    .row = 1067,
    .tested = 368,
    .general_facing = 4361,
    .general_row = 112,
    .general_tested = 325,
    .survey = 320,
    .light = 3200,
    .region = 83983,
    .flat = 117172,
    .part = 5787,
    .finished = 229,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {29971, 4682, 1831, 206, 16702, 80102},
            [RASTER_SHADE_SPECULAR_FRAME] = {27514, 4703, 16296, 490, 28552, 116660},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30145, 4863, 789, 23, 15232, 74679},
            [RASTER_SHADE_BLINN_PHONG] = {28909, 5509, 2130, 1260, 17121, 82829},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31283, 5505, 3623, 245, 20313, 94482},
            [RASTER_SHADE_DIFFUSE_ROW] = {8620, 1333, 1319, 1319, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {13035, 3924, 1015, 1015, 0, 0},
        },
};

#endif
