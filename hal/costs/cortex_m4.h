/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 587387,
    .clear = 84672,
    .meshlet = 6285,
    .vertex = 1590,
    .triangle = 492,
    .general = 1918,
    .clipped = 0,
    .facing = 4887,
    .row = 1067,
    .tested = 368,
    .general_facing = 4346,
    .general_row = 112,
    .general_tested = 325,
    .survey = 352,
    .light = 3200,
    .region = 100435,
    .flat = 123539,
    .part = 5699,
    .mixed = 0,
    .run = 0,
    .copied = 0,
    .finished = 117,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30070, 6060, 1962, 128, 16747, 81338},
            [RASTER_SHADE_SPECULAR_FRAME] = {28038, 6078, 16298, 398, 28597, 117941},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {29872, 6415, 889, 0, 15235, 76052},
            [RASTER_SHADE_BLINN_PHONG] = {29302, 7090, 2222, 1082, 17116, 84220},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31733, 7103, 3698, 67, 20305, 95903},
            [RASTER_SHADE_DIFFUSE_ROW] = {8444, 2630, 1264, 1264, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {11190, 4836, 768, 768, 0, 0},
        },
};

#endif
