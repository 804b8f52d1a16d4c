/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 575755,
    .meshlet = 5373,
    .vertex = 1577,
    .triangle = 477,
    .general = 1844,
    .clipped = 0,
    .facing = 4909,
    .row = 1082,
    .tested = 370,
    .survey = 373,
    .light = 3200,
    .region = 118657,
    .flat = 277753,
    .cell = 311,
    .part = 8737,
    .mixed = 3037,
    .run = 1979,
    .copied = 236,
    .finished = 239,
    .plan = 96000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31683, 6933, 2188, 0, 16441, 69927},
            [RASTER_SHADE_SPECULAR_FRAME] = {28502, 6976, 17560, 131, 27985, 104662},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30925, 7311, 990, 0, 14858, 64542},
            [RASTER_SHADE_BLINN_PHONG] = {30343, 8352, 2483, 1084, 16821, 73334},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32144, 8350, 4119, 0, 19806, 83994},
            [RASTER_SHADE_DIFFUSE_ROW] = {0, 4603, 1675, 1675, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {0, 7943, 973, 973, 0, 0},
        },
};

#endif
