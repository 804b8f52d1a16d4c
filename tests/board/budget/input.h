/*
 * What tests/board/budget/make_input.c hands to tests/board/budget/main.c: this, then the files that it points to, all little-endian.
 */
#ifndef TESTS_BOARD_BUDGET_INPUT_H
#define TESTS_BOARD_BUDGET_INPUT_H

#include "quality.h"

#define BUDGET_INPUT_SCENES 64u
#define BUDGET_INPUT_TABLES 6u

enum budget_input_mode {
    BUDGET_INPUT_TILES,   /* frames at random budgets of every scene */
    BUDGET_INPUT_PICTURE, /* the only scene at parts of what its shading takes */
    BUDGET_INPUT_RATES    /* the only scene at each rate */
};

struct budget_input_file {
    uint32_t at, bytes; /* at: a multiple of 16 */
};

struct budget_input {
    uint32_t mode, scene_count;
    uint32_t
        frames; /* of each scene, besides the unlimited one; or the picture's budget, 0: half and a quarter of its shading */
    uint32_t seed;
    struct raster_costs costs;
    struct budget_input_file scenes[BUDGET_INPUT_SCENES], tables[BUDGET_INPUT_TABLES];
};

#endif
