/* What cortex-m4 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M4_H
#define HAL_COSTS_CORTEX_M4_H

#include "quality.h"

static const struct raster_costs costs_cortex_m4 = {
    .tile = 322350,
    .clear = 84688,
    .meshlet = 6194,
    .vertex = 1593,
    .triangle = 491,
    .general = 2213,
    .facing = 4876,
    .row = 1075,
    .tested = 366,
    .general_facing = 3767,
    .general_row = 398,
    .general_tested = 372,
    .survey = 333,
    .light = 3200,
    .region = 80567,
    .flat = 114693,
    .part = 3647,
    .cell = 1223,
    .finished = 199,
    .run = 1371,
    .plan = 432000,
    .broad = 2181,
    .bright = 1218,
    .slow_point = 4180,
    .texels = {3771, 2582, 1419},
    .taps = {0, 122, 296},
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {31214, 4355, 1859, 131, 16830, 81106},
            [RASTER_SHADE_SPECULAR_FRAME] = {29958, 4348, 16551, 285, 28606, 117222},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30822, 4532, 807, 0, 15321, 75380},
            [RASTER_SHADE_BLINN_PHONG] = {30574, 5179, 2156, 1183, 17153, 83332},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {33174, 5172, 3671, 132, 20327, 94914},
            [RASTER_SHADE_DIFFUSE_ROW] = {5280, 1628, 1288, 1288, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8237, 4280, 998, 998, 0, 0},
        },
};

#endif
