/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 323831,
    .clear = 84672,
    .meshlet = 6283,
    .vertex = 1590,
    .triangle = 493,
    .general = 1918,
    .facing = 4887,
    .row = 1067,
    .tested = 368,
    .general_facing = 4343,
    .general_row = 112,
    .general_tested = 325,
    .survey = 333,
    .light = 3200,
    .region = 79401,
    .flat = 117143,
    .part = 3687,
    .cell = 1222,
    .finished = 199,
    .run = 1297,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31089, 4365, 1864, 131, 16587, 80125},
            [RASTER_SHADE_SPECULAR_FRAME] = {29757, 4361, 16611, 285, 28444, 116680},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30586, 4548, 809, 0, 15134, 74702},
            [RASTER_SHADE_BLINN_PHONG] = {30525, 5196, 2163, 1189, 17005, 82850},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {33205, 5189, 3683, 133, 20196, 94504},
            [RASTER_SHADE_DIFFUSE_ROW] = {5242, 1644, 1284, 1284, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8157, 4293, 989, 989, 0, 0},
        },
};

#endif
