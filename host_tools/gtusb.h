/*
 * gtusb's parts: finding the device, one function per subcommand, the option tables they share.
 * A subcommand takes argv with its own name in argv[0], prints its data on stdout and returns; failures end the program.
 */
#ifndef HOST_TOOLS_GTUSB_H
#define HOST_TOOLS_GTUSB_H

#include <argp.h>

#include "common.h"
#include "gtusb_link.h"

/* --serial, --port and --timeout, as an argp child of every subcommand's parser. */
extern const struct argp_child device_options[];

/* Opens the device that the options name, brings it to a known state and reads its information. Ends the program when there is
 * none (EXIT_NO_DEVICE), several match (EXIT_SEVERAL), it may not be opened (EXIT_PERMISSION) or it speaks another protocol
 * version (EXIT_REFUSED). */
struct link *device_open(struct usb_info *info);
void device_close(struct link *l);

/* argp_parse with the messages' name and exit code of this project. */
void options_parse(const struct argp *argp, int argc, char **argv, void *input);

/* Three numbers "x,y,z" within [lo, hi]; ends the program with EXIT_USAGE naming the option. */
void parse_triple(double out[3], const char *option, const char *text, double lo, double hi);

void command_list(int argc, char **argv);
void command_info(int argc, char **argv);
void command_stats(int argc, char **argv);
void command_push(int argc, char **argv);
void command_verify(int argc, char **argv);
void command_select(int argc, char **argv);
void command_set(int argc, char **argv);
void command_frame(int argc, char **argv);
void command_reset(int argc, char **argv);

#endif
