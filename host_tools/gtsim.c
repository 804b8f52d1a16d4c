/* gtsim: the device on a PC, the same firmware on a simulated board. */
#include "gtsim.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "goniotile_version.h"
#include "raster.h"

static error_t parse_board(int key, char *arg, struct argp_state *state)
{
    struct sim_config *board = state->input;
    char *copy, *x;
    switch (key) {
    case 's':
        copy = xstrdup(arg);
        x = strchr(copy, 'x');
        if (!x)
            die(EXIT_USAGE, "--size: '%s' is not a size; write WIDTHxHEIGHT, like 320x240", arg);
        *x = 0;
        board->width = (uint16_t)parse_long("--size WIDTH", copy, 1, RASTER_MAX_WIDTH);
        board->height = (uint16_t)parse_long("--size HEIGHT", x + 1, 1, RASTER_MAX_HEIGHT);
        free(copy);
        return 0;
    case 'f':
        if (strcmp(arg, "rgb565") && strcmp(arg, "rgb888"))
            die(EXIT_USAGE, "--format: no format '%s'; it is rgb565 or rgb888", arg);
        board->format = strcmp(arg, "rgb565") ? RASTER_RGB888 : RASTER_RGB565;
        return 0;
    case 'a':
        board->samples = (uint8_t)parse_long("--samples", arg, 1, 4);
        if (board->samples != 1 && board->samples != 4)
            die(EXIT_USAGE, "--samples: %s per pixel; it is 1 or 4", arg);
        return 0;
    case 'b':
        board->tile_budget = (uint32_t)parse_long("--budget", arg, 0, UINT32_MAX);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option board_options[] = {
    {"size", 's', "WxH", 0, "the picture's size (320x240)", 0},
    {"samples", 'a', "1|4", 0, "coverage samples per pixel (1); 4 smooths edges", 0},
    {"format", 'f', "rgb565|rgb888", 0, "the device's pixels (rgb888)", 0},
    {"budget", 'b', "TICKS", 0,
     "mean ticks per tile, as modelled for a Cortex-M7 (0: no limit); frames learn from those before: "
     "'render' makes the eighth",
     0},
    {0}};
const struct argp board_argp = {board_options, parse_board, NULL, NULL, NULL, NULL, NULL};

struct sim_config board_default(void)
{
    return (struct sim_config){.width = 320, .height = 240, .format = RASTER_RGB888, .high_speed = true};
}

void options_parse(const struct argp *argp, unsigned flags, int argc, char **argv, int *index, void *input)
{
    argp_err_exit_status = EXIT_USAGE;
    argp_program_version = "gtsim " GONIOTILE_VERSION;
    argp_parse(argp, argc, argv, flags, index, input);
}

static void help(FILE *to)
{
    fputs("Usage: gtsim COMMAND [OPTION...]\nThe device on a PC: the firmware on a simulated board.\n\nCommands:\n"
          "  run      run a program that sees the simulated device on its USB\n"
          "  window   look at the device's picture, move in it, and run a program that sees the device\n"
          "  render   render a scene into a picture, without USB\n"
          "\n'gtsim COMMAND --help' explains one. Exit codes: 0 ok, 1 internal, 2 usage, 3 file, 4 bad input file,\n"
          "5 no screen, 9 refused by the device; 'run' and 'window' end with the program's own.\n"
          "\nExamples:\n"
          "  $ gtsim render six_models.blob --model lafortune_phong -o quick.png\n"
          "  $ gtsim run -- gtusb list\n",
          to);
}

int main(int argc, char **argv)
{
    common_set_name("gtsim", NULL);
    if (argc < 2) {
        help(stderr);
        return EXIT_USAGE;
    }
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "help")) {
        help(stdout);
        return EXIT_OK;
    }
    if (!strcmp(argv[1], "--version")) {
        puts("gtsim " GONIOTILE_VERSION);
        return EXIT_OK;
    }
    static const struct {
        const char *name;
        int (*run)(int argc, char **argv);
    } commands[] = {{"run", command_run}, {"window", command_window}, {"render", command_render}};
    size_t c = 0, count = sizeof commands / sizeof *commands;
    while (c < count && strcmp(argv[1], commands[c].name))
        c++;
    if (c == count)
        die(EXIT_USAGE, "no command '%s'; see 'gtsim --help'", argv[1]);
    common_set_name("gtsim", commands[c].name);
    argv[1] = xasprintf("gtsim %s", commands[c].name);
    return commands[c].run(argc - 1, argv + 1);
}
