/* gtusb: talks to a Goniotile device over USB. */
#include "gtusb.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "goniotile_version.h"

static const struct {
    const char *name, *purpose;
    void (*run)(int argc, char **argv);
} commands[] = {
    {"list", "the devices there are", command_list},
    {"info", "what a device is and holds", command_info},
    {"push", "send a scene or a table", command_push},
    {"verify", "compare a slot with a file", command_verify},
    {"select", "give a material another table", command_select},
    {"set", "camera, light, output or model", command_set},
    {"frame", "render a frame and fetch it as PNG", command_frame},
    {"stats", "what the last frame cost", command_stats},
    {"reset", "forget select and set", command_reset},
};

static void help(FILE *to)
{
    fputs("Usage: gtusb COMMAND [OPTION...]\nTalks to a Goniotile device over USB.\n\nCommands:\n", to);
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
        fprintf(to, "  %-8s %s\n", commands[i].name, commands[i].purpose);
    fputs("\n'gtusb COMMAND --help' explains one. Exit codes: 0 ok, 2 usage, 3 file, 4 bad input file, 5 no device,\n"
          "6 several devices, 7 permission, 8 USB transfer, 9 refused by the device, 10 contents differ, 130 "
          "interrupted.\n"
          "\nExamples:\n"
          "  $ gtusb push six_models.blob\n"
          "  $ gtusb push gold.ktx2 --slot 2\n"
          "  $ gtusb frame -o frame.png\n",
          to);
}

void options_parse(const struct argp *argp, int argc, char **argv, void *input)
{
    argp_err_exit_status = EXIT_USAGE;
    argp_program_version = "gtusb " GONIOTILE_VERSION;
    argp_parse(argp, argc, argv, 0, NULL, input);
}

void parse_triple(double out[3], const char *option, const char *text, double lo, double hi)
{
    char *copy = xstrdup(text), *part = copy;
    for (int i = 0; i < 3; i++) {
        char *comma = strchr(part, ',');
        if (!comma != (i == 2))
            die(EXIT_USAGE, "%s: '%s' is not three numbers; write x,y,z", option, text);
        if (comma)
            *comma = 0;
        out[i] = parse_double(option, part, lo, hi);
        part = comma ? comma + 1 : part;
    }
    free(copy);
}

int main(int argc, char **argv)
{
    common_set_name("gtusb", NULL);
    if (argc < 2) {
        help(stderr);
        return EXIT_USAGE;
    }
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "help")) {
        help(stdout);
        return EXIT_OK;
    }
    if (!strcmp(argv[1], "--version")) {
        puts("gtusb " GONIOTILE_VERSION);
        return EXIT_OK;
    }
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
        if (!strcmp(argv[1], commands[i].name)) {
            common_set_name("gtusb", commands[i].name);
            argv[1] = xasprintf("gtusb %s", commands[i].name);
            commands[i].run(argc - 1, argv + 1);
            return EXIT_OK;
        }
    die(EXIT_USAGE, "no command '%s'; see 'gtusb --help'", argv[1]);
}
