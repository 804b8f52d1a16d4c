/* What cortex-m3 takes, in instructions with 4 fraction bits (raster/quality.h). Written by make calibrate. */
#ifndef HAL_COSTS_CORTEX_M3_H
#define HAL_COSTS_CORTEX_M3_H

#include "quality.h"

static const struct raster_costs costs_cortex_m3 = {
    .tile = 328740,
    .clear = 84640,
    .meshlet = 6220,
    .vertex = 1625,
    .triangle = 477,
    .general = 1976,
    .facing = 4828,
    .row = 1047,
    .tested = 368,
    .general_facing = 4115,
    .general_row = 139,
    .general_tested = 326,
    .survey = 330,
    .light = 3200,
    .region = 80063,
    .flat = 117061,
    .part = 3773,
    .cell = 1132,
    .finished = 198,
    .run = 1327,
    .plan = 432000,
    .shading =
        {
            [RASTER_SHADE_HALF_VECTOR] = {30728, 4637, 2989, 182, 17631, 83722},
            [RASTER_SHADE_SPECULAR_FRAME] = {29575, 4634, 16573, 236, 28559, 117158},
            [RASTER_SHADE_LAFORTUNE_PHONG] = {30388, 4830, 1044, 4, 15433, 75939},
            [RASTER_SHADE_BLINN_PHONG] = {30234, 5472, 2239, 1241, 17168, 83619},
            [RASTER_SHADE_METALLIC_ROUGHNESS] = {32901, 5465, 3673, 121, 20183, 94580},
            [RASTER_SHADE_DIFFUSE_ROW] = {5408, 1631, 1331, 1331, 0, 0},
            [RASTER_SHADE_BLINN_PHONG_ROW] = {8432, 4309, 1001, 1001, 0, 0},
        },
};

#endif
