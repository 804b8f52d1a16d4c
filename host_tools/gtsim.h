/* gtsim's subcommands and the options they share. */
#ifndef HOST_TOOLS_GTSIM_H
#define HOST_TOOLS_GTSIM_H

#include <argp.h>

#include "common.h"
#include "sim.h"

/* --size and --format of the simulated board, as an argp child; its input is a struct sim_config. */
extern const struct argp board_argp;

/* What a board is without options: 320 x 240, RGB888, high speed, memory as a small microcontroller has. */
struct sim_config board_default(void);

/* argp_parse with the exit code and version of this project; `index` as argp_parse's, or NULL. */
void options_parse(const struct argp *argp, unsigned flags, int argc, char **argv, int *index, void *input);

/* All return the program's exit code. */
int command_run(int argc, char **argv);
int command_render(int argc, char **argv);
int command_window(int argc, char **argv);

#endif
