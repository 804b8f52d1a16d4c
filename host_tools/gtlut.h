/*
 * The subcommands of gtlut: each parses its own options (argv[0] is its name) and returns an exit code or dies.
 */
#ifndef HOST_TOOLS_GTLUT_H
#define HOST_TOOLS_GTLUT_H

#include <getopt.h>
#include <stdbool.h>
#include <stddef.h>

int gtlut_measure(int argc, char **argv);
int gtlut_import(int argc, char **argv);
int gtlut_build(int argc, char **argv);
int gtlut_info(int argc, char **argv);
int gtlut_export(int argc, char **argv);
int gtlut_formats(int argc, char **argv);
int gtlut_check(int argc, char **argv);
int gtlut_fit(int argc, char **argv);
int gtlut_preview(int argc, char **argv);
int gtlut_atlas(int argc, char **argv);

/* What `info` prints of an atlas, which host_atlas.h recognises; takes `data` over. */
void gtlut_atlas_describe(const char *path, void *data, size_t bytes, bool json);

/* getopt_long for "-o FILE" and long options. Prints `help` and exits on --help; dies with EXIT_USAGE on an unknown option or
 * a missing value. Returns -1 at the end. */
int gtlut_option(int argc, char **argv, const struct option *options, const char *help);

/* The only positional argument; dies with EXIT_USAGE when there is none or more than one. */
const char *gtlut_argument(int argc, char **argv, const char *what);

/* Dies with EXIT_USAGE when no -o was given. */
void gtlut_need_output(const char *output);

#endif
