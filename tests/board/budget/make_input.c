/*
 * Writes the input of tests/board/budget/main.c.
 *
 *   make_input TARGET OUT tiles KIND SEED SCENES FRAMES TABLE.ktx2...    scenes of tests/budget/scenes.h, from SEED on
 *   make_input TARGET OUT picture BUDGET SCENE.blob TABLE.ktx2...        that one scene; BUDGET: 0, see input.h
 *   make_input TARGET OUT rates 0 SCENE.blob TABLE.ktx2...               likewise
 *
 * KIND: a name as scenes_name gives it.
 */
#include "common.h"
#include "costs/cortex_m3.h"
#include "costs/cortex_m4.h"
#include "costs/cortex_m7.h"
#include "input.h"
#include "scenes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct budget_input input;
static uint32_t at = sizeof input;

static const struct raster_costs *costs_of(const char *target)
{
    if (!strcmp(target, "cortex-m3"))
        return &costs_cortex_m3;
    if (!strcmp(target, "cortex-m4"))
        return &costs_cortex_m4;
    if (!strcmp(target, "cortex-m7"))
        return &costs_cortex_m7;
    die(EXIT_USAGE, "%s: no costs of this target", target);
}

static struct budget_input_file write_part(FILE *f, const void *data, size_t bytes)
{
    static const char zero[16];
    struct budget_input_file part = {(at + 15) & ~15u, (uint32_t)bytes};
    fwrite(zero, 1, part.at - at, f);
    fwrite(data, 1, bytes, f);
    at = part.at + part.bytes;
    return part;
}

static struct budget_input_file write_copy(FILE *f, const char *path)
{
    size_t bytes;
    void *data = read_file(path, 16 << 20, &bytes);
    const struct budget_input_file part = write_part(f, data, bytes);
    free(data);
    return part;
}

static enum scenes_kind kind_of(const char *name)
{
    int kind = 0;
    while (kind < SCENES_KIND_COUNT && strcmp(name, scenes_name((enum scenes_kind)kind)))
        kind++;
    if (kind == SCENES_KIND_COUNT)
        die(EXIT_USAGE, "%s: no kind of scenes", name);
    return (enum scenes_kind)kind;
}

int main(int argc, char **argv)
{
    common_set_name("make_input", NULL);
    const bool tiles = argc > 7 && !strcmp(argv[3], "tiles"), picture = argc > 5 && !strcmp(argv[3], "picture"),
               rates = argc > 5 && !strcmp(argv[3], "rates");
    const int first_table = tiles ? 8 : 6;
    if ((!tiles && !picture && !rates) || argc - first_table > (int)BUDGET_INPUT_TABLES)
        die(EXIT_USAGE, "usage: make_input TARGET OUT tiles KIND SEED SCENES FRAMES TABLE... | picture|rates BUDGET "
                        "SCENE TABLE...");
    FILE *f = fopen(argv[2], "wb");
    if (!f)
        die(EXIT_FILE, "%s: cannot be written", argv[2]);
    fwrite(&input, sizeof input, 1, f);
    input.mode = tiles ? BUDGET_INPUT_TILES : picture ? BUDGET_INPUT_PICTURE : BUDGET_INPUT_RATES;
    input.costs = *costs_of(argv[1]);
    if (tiles) {
        const enum scenes_kind kind = kind_of(argv[4]);
        input.seed = (uint32_t)atoi(argv[5]);
        input.scene_count = (uint32_t)atoi(argv[6]);
        input.frames = (uint32_t)atoi(argv[7]);
        if (input.scene_count > BUDGET_INPUT_SCENES)
            die(EXIT_USAGE, "too many scenes");
        for (uint32_t i = 0; i < input.scene_count; i++) {
            size_t bytes;
            void *blob = scenes_make(kind, input.seed + i, &bytes);
            input.scenes[i] = write_part(f, blob, bytes);
            free(blob);
        }
    } else {
        input.frames = (uint32_t)atoi(argv[4]);
        input.scene_count = 1;
        input.scenes[0] = write_copy(f, argv[5]);
    }
    for (int i = first_table; i < argc; i++)
        input.tables[i - first_table] = write_copy(f, argv[i]);
    rewind(f);
    fwrite(&input, sizeof input, 1, f);
    if (fclose(f))
        die(EXIT_FILE, "%s: cannot be written", argv[2]);
    return EXIT_OK;
}
