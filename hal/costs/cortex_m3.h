/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 586857,
    .clear = 84640,
    .meshlet = 6204,
    .vertex = 1625,
    .triangle = 478,
    .general = 1976,
    .clipped = 0,
    .facing = 4827,
    .row = 1047,
    .tested = 368,
    .general_facing = 4119,
    .general_row = 139,
    .general_tested = 325,
    .survey = 349,
    .light = 3200,
    .region = 93398,
    .flat = 123784,
    .part = 5469,
    .mixed = 0,
    .run = 0,
    .copied = 0,
    .finished = 117,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {29516, 6464, 3048, 187, 17801, 85061},
            [RASTER_SHADE_SPECULAR_FRAME] = {28015, 6476, 16236, 330, 28726, 118544},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {29607, 6818, 1112, 0, 15554, 77407},
            [RASTER_SHADE_BLINN_PHONG] = {29113, 7482, 2286, 1131, 17294, 85106},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31572, 7493, 3675, 54, 20307, 96097},
            [RASTER_SHADE_DIFFUSE_ROW] = {8459, 2767, 1302, 1302, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {11299, 4995, 768, 768, 0, 0},
        },
};

#endif
