/* gtlut formats: what gtlut import reads. */
#include "gtlut.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "common.h"
#include "gtlut_json.h"
#include "host_import.h"

static const char help[] =
    "Usage: gtlut formats [--json]\n"
    "\n"
    "Lists the measurement formats that gtlut import, check and fit read: name, usual extensions, what it is.\n"
    "A file's format is told from its content, not from its name. Formats that hold a function of any two\n"
    "directions rather than samples are evaluated at the directions of --geometry.\n"
    "\n"
    "  --json   an array of objects with name, extensions, description, evaluated (1 or 0)\n"
    "\n"
    "Examples:\n"
    "  $ gtlut formats\n"
    "  $ gtlut formats --json\n";

static void print_json(const struct import_format *f)
{
    json_open(NULL, '{');
    json_string("name", f->name, strlen(f->name));
    json_string("extensions", f->extensions, strlen(f->extensions));
    json_string("description", f->description, strlen(f->description));
    json_integer("evaluated", f->evaluated);
    json_close('}');
}

int gtlut_formats(int argc, char **argv)
{
    static const struct option options[] = {{"json", no_argument, 0, 'j'}, {"help", no_argument, 0, 'h'}, {0}};
    bool json = false;
    for (int c; (c = gtlut_option(argc, argv, options, help)) != -1;) {
        if (c == 'o')
            die(EXIT_USAGE, "-o: formats prints to stdout; leave it out");
        json = true;
    }
    if (argc != optind)
        die(EXIT_USAGE, "%d arguments where none is wanted; see gtlut formats --help", argc - optind);
    if (json)
        json_open(NULL, '[');
    for (size_t i = 0; i < import_format_count; i++) {
        const struct import_format *f = &import_formats[i];
        if (json)
            print_json(f);
        else
            printf("%-10s %-18s %s\n", f->name, f->extensions, f->description);
    }
    if (json)
        json_close(']');
    return EXIT_OK;
}
