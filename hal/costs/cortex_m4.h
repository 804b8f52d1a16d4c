/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 587520,
    .clear = 84672,
    .meshlet = 6282,
    .vertex = 1591,
    .triangle = 492,
    .general = 1918,
    .clipped = 0,
    .facing = 4886,
    .row = 1068,
    .tested = 368,
    .general_facing = 4359,
    .general_row = 112,
    .general_tested = 325,
    .survey = 352,
    .light = 3200,
    .region = 88756,
    .flat = 120254,
    .part = 6050,
    .mixed = 0,
    .run = 0,
    .copied = 0,
    .finished = 117,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30695, 6321, 2022, 163, 16836, 81828},
            [RASTER_SHADE_SPECULAR_FRAME] = {28543, 6352, 16517, 479, 28583, 117964},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30625, 6709, 924, 0, 15317, 76607},
            [RASTER_SHADE_BLINN_PHONG] = {29956, 7399, 2295, 1150, 17194, 84787},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32343, 7416, 3798, 100, 20381, 96450},
            [RASTER_SHADE_DIFFUSE_ROW] = {8420, 2704, 1273, 1273, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {11158, 4914, 776, 776, 0, 0},
        },
};

#endif
