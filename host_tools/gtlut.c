/* gtlut: from a reflectance measurement to the table a device shades with. */
#include "gtlut.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "goniotile_version.h"

static const char help[] =
    "Usage: gtlut SUBCOMMAND [options]\n"
    "\n"
    "From a reflectance measurement to the table a device shades with.\n"
    "\n"
    "Commands:\n"
    "  measure MATERIAL -o out.csv   sample an analytic material with a virtual goniophotometer\n"
    "  formats                       list the measurement formats that are read\n"
    "  import FILE -o out.gtm        a measurement of any of them to a measurement file\n"
    "  check FILE                    look for what is wrong or missing in a measurement, and repair it\n"
    "  build SOURCE -o out.ktx2      measurement file, CSV, .bsdf, fit or table to a table\n"
    "  info FILE                     describe a measurement or a table\n"
    "  export TABLE -o out.exr|.png  all texels of a table as one image\n"
    "  atlas TABLE... -o out.ktx2    several materials' tables in one texture, and out of it again\n"
    "  fit FILE --model NAME         the analytic material that comes nearest to a measurement\n"
    "  preview INPUT -o FOLDER|FILE  pictures: lobe, plots, slices, a sphere under an environment, contact sheet\n"
    "\n"
    "'gtlut SUBCOMMAND --help' explains one. Exit codes: 0 ok, 1 internal, 2 usage, 3 file cannot be read or written,\n"
    "4 bad input file, 11 found wanting (check, --max-de not reached).\n"
    "\n"
    "Examples:\n"
    "  $ gtlut measure gold -o gold.csv\n"
    "  $ gtlut check gold.csv\n"
    "  $ gtlut build gold.csv -o gold.ktx2 --kind half_vector\n";

int gtlut_option(int argc, char **argv, const struct option *options, const char *subcommand_help)
{
    opterr = 0;
    int c = getopt_long(argc, argv, ":o:h", options, NULL);
    if (c == 'h') {
        fputs(subcommand_help, stdout);
        exit(EXIT_OK);
    }
    if (c == ':')
        die(EXIT_USAGE, "%s: no value given; see gtlut %s --help", argv[optind - 1], argv[0]);
    if (c == '?')
        die(EXIT_USAGE, "%s: unknown option; see gtlut %s --help", argv[optind - 1], argv[0]);
    return c;
}

const char *gtlut_argument(int argc, char **argv, const char *what)
{
    if (argc - optind != 1)
        die(EXIT_USAGE, "%d arguments where one %s is wanted; see gtlut %s --help", argc - optind, what, argv[0]);
    return argv[optind];
}

void gtlut_need_output(const char *output)
{
    if (!output)
        die(EXIT_USAGE, "no output file; give -o FILE");
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        int (*run)(int argc, char **argv);
    } subcommands[] = {{"measure", gtlut_measure}, {"import", gtlut_import}, {"build", gtlut_build},
                       {"info", gtlut_info},       {"export", gtlut_export}, {"formats", gtlut_formats},
                       {"check", gtlut_check},     {"fit", gtlut_fit},       {"preview", gtlut_preview},
                       {"atlas", gtlut_atlas}};
    common_set_name("gtlut", NULL);
    if (argc < 2)
        die(EXIT_USAGE, "no subcommand; see gtlut --help");
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h")) {
        fputs(help, stdout);
        return EXIT_OK;
    }
    if (!strcmp(argv[1], "--version")) {
        puts("gtlut " GONIOTILE_VERSION);
        return EXIT_OK;
    }
    for (size_t i = 0; i < sizeof subcommands / sizeof *subcommands; i++)
        if (!strcmp(argv[1], subcommands[i].name)) {
            common_set_name("gtlut", argv[1]);
            return subcommands[i].run(argc - 1, argv + 1);
        }
    die(EXIT_USAGE, "'%s': no such subcommand; see gtlut --help", argv[1]);
}
