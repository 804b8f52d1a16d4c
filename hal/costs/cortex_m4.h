/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 587387,
    .clear = 84672,
    .meshlet = 6284,
    .vertex = 1590,
    .triangle = 493,
    .general = 1918,
    .clipped = 0,
    .facing = 4887,
    .row = 1067,
    .tested = 368,
    .general_facing = 4361,
    .general_row = 112,
    .general_tested = 325,
    .survey = 352,
    .light = 3200,
    .region = 84681,
    .flat = 117392,
    .part = 6060,
    .mixed = 0,
    .run = 0,
    .copied = 0,
    .finished = 117,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30586, 6271, 2008, 172, 16767, 81479},
            [RASTER_SHADE_SPECULAR_FRAME] = {28370, 6303, 16641, 492, 28614, 118047},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30552, 6640, 912, 0, 15253, 76193},
            [RASTER_SHADE_BLINN_PHONG] = {29822, 7326, 2285, 1172, 17131, 84363},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32207, 7341, 3791, 121, 20319, 96039},
            [RASTER_SHADE_DIFFUSE_ROW] = {8444, 2630, 1264, 1264, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {11190, 4836, 768, 768, 0, 0},
        },
};

#endif
