/* What cortex-m7 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M7_H
#define HAL_COSTS_CORTEX_M7_H

#include "quality.h"

static const struct raster_costs costs_cortex_m7 = {
    .tile = 364526,
    .clear = 84688,
    .meshlet = 6406,
    .vertex = 1574,
    .triangle = 479,
    .general = 1959,
    .facing = 4945,
    .row = 1085,
    .tested = 363,
    .general_facing = 4568,
    .general_row = 94,
    .general_tested = 315,
    .survey = 351,
    .light = 3200,
    .region = 97410,
    .flat = 114829,
    .part = 5902,
    .finished = 229,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30181, 6040, 1969, 124, 16713, 81215},
            [RASTER_SHADE_SPECULAR_FRAME] = {28122, 6063, 16322, 405, 28546, 117736},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30086, 6388, 900, 0, 15235, 76036},
            [RASTER_SHADE_BLINN_PHONG] = {29514, 7073, 2242, 1078, 17162, 84384},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {31788, 7089, 3738, 67, 20222, 95575},
            [RASTER_SHADE_DIFFUSE_ROW] = {8124, 2800, 1418, 1418, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {12277, 5428, 1056, 1056, 0, 0},
        },
};

#endif
