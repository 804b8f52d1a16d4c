/* `run`: a program with the simulated device on its USB; and what `window` shares with it. */
#include "gtsim_run.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "gtsim.h"

enum { KEY_SERIAL = 1, KEY_FLASH, KEY_FULL_SPEED, KEY_LOCK, KEY_UNPLUG, KEY_FREEZE, KEY_DAMAGE, KEY_VERSION, KEY_BANK };

static void check_serial(const char *serial, size_t added)
{
    size_t n = strlen(serial);
    for (const char *c = serial; *c; c++)
        if (*c < ' ' || *c > '~')
            n = 0;
    if (n < 1 || n + added > USB_MAX_SERIAL_CHARS)
        die(EXIT_USAGE, "--serial: '%s' is not 1 to %zu printable ASCII characters", serial,
            USB_MAX_SERIAL_CHARS - added);
}

static error_t parse_option(int key, char *arg, struct argp_state *state)
{
    struct bus_options *o = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &o->board;
        return 0;
    case 'd':
        o->devices = (int)parse_long("--devices", arg, 0, BUS_MAX_DEVICES);
        return 0;
    case KEY_SERIAL:
        o->board.serial = arg;
        return 0;
    case KEY_FLASH:
        o->board.flash_file = arg;
        return 0;
    case KEY_FULL_SPEED:
        o->board.high_speed = false;
        return 0;
    case KEY_LOCK:
        o->board.write_forbidden = true;
        return 0;
    case KEY_BANK:
        o->board.table_bank_bytes = (uint32_t)parse_long("--bank", arg, SIM_FLASH_BLOCK, 64 << 20);
        o->board.table_bank_bytes -= o->board.table_bank_bytes % SIM_FLASH_BLOCK;
        return 0;
    case KEY_UNPLUG:
        o->faults.unplug_after = parse_long("--unplug-after", arg, 0, 1 << 30);
        return 0;
    case KEY_FREEZE:
        o->faults.freeze_after = parse_long("--freeze-after", arg, 0, 1 << 30);
        return 0;
    case KEY_DAMAGE:
        o->faults.damage_after = parse_long("--damage-after", arg, 0, 1 << 30);
        return 0;
    case KEY_VERSION:
        o->protocol_version = (unsigned)parse_long("--protocol-version", arg, 1, 255);
        return 0;
    case ARGP_KEY_SUCCESS:
        if (o->board.flash_file && o->devices > 1)
            die(EXIT_USAGE, "--flash is for one device, --devices is %d", o->devices);
        check_serial(o->board.serial, o->devices > 1 ? strlen("-2") : 0);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option options[] = {
    {"devices", 'd', "N", 0, "0 to 2 devices (1), on ports 1-1 and 1-2", 0},
    {"serial", KEY_SERIAL, "TEXT", 0,
     "serial number, 1 to 31 printable ASCII characters (GT-SIM-0001); a second device adds -2", 0},
    {"flash", KEY_FLASH, "FILE", 0, "keep the flash in this file, from run to run; one gtsim at a time", 0},
    {"full-speed", KEY_FULL_SPEED, NULL, 0, "packets of 64 bytes instead of 512", 0},
    {"bank", KEY_BANK, "BYTES", 0, "bytes of flash for a table (1179648)", 0},
    {NULL, 0, NULL, 0, "Trouble, for tests:", 1},
    {"write-lock", KEY_LOCK, NULL, 0, "the board forbids writing its flash", 1},
    {"unplug-after", KEY_UNPLUG, "BYTES", 0, "pull the first device's cable when so many bytes went out; it comes back",
     1},
    {"freeze-after", KEY_FREEZE, "BYTES", 0, "the first device no longer answers after so many, until it is closed", 1},
    {"damage-after", KEY_DAMAGE, "BYTES", 0, "one bit on its way to the first device is wrong after so many", 1},
    {"protocol-version", KEY_VERSION, "N", 0, "claim to speak this version of the protocol", 1},
    {0}};

static const struct argp_child children[] = {{&board_argp, 0, NULL, 0}, {0}};
const struct argp bus_argp = {options, parse_option, NULL, NULL, children, NULL, NULL};

struct bus_options bus_default(void)
{
    struct bus_options o = {
        .devices = 1, .board = board_default(), .faults = {-1, -1, -1}, .protocol_version = USB_PROTOCOL_VERSION};
    o.board.serial = "GT-SIM-0001";
    return o;
}

void bus_preload(const char *subcommand, char **argv)
{
    const char *libraries = getenv("LD_PRELOAD");
    if (libraries && strstr(libraries, "libumockdev-preload"))
        return;
    char self[4096];
    ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
    int count = 0;
    if (n < 0)
        die(EXIT_INTERNAL, "/proc/self/exe: cannot be read; mount /proc");
    self[n] = 0;
    while (argv[count])
        count++;
    char **wrapped = xcalloc((size_t)count + 4, sizeof *wrapped);
    wrapped[0] = xstrdup("umockdev-wrapper");
    wrapped[1] = self;
    wrapped[2] = xstrdup(subcommand);
    memcpy(wrapped + 3, argv + 1, (size_t)count * sizeof *wrapped);
    execvp(wrapped[0], wrapped);
    die(EXIT_INTERNAL, "umockdev-wrapper cannot be started; install the package umockdev");
}

int command_run(int argc, char **argv)
{
    static const struct argp argp = {options,
                                     parse_option,
                                     "-- PROGRAM [ARGUMENT...]",
                                     "Runs PROGRAM and whatever it starts with a mocked USB bus on which the simulated "
                                     "device is the only one. Several commands in one life of the device: "
                                     "gtsim run -- sh -c 'gtusb push ...; gtusb frame ...'. "
                                     "Ends with PROGRAM's exit code."
                                     "\vExamples:\n"
                                     "  $ gtsim run -- gtusb list\n"
                                     "  $ gtsim run --flash flash.bin -- sh -c 'gtusb push oled.blob; gtusb info'",
                                     children,
                                     NULL,
                                     NULL};
    struct bus_options o = bus_default();
    int first;
    options_parse(&argp, ARGP_IN_ORDER, argc, argv, &first, &o);
    if (first >= argc)
        die(EXIT_USAGE, "no program to run; give one after --, like 'gtsim run -- gtusb info'");
    bus_preload("run", argv);
    return bus_run(bus_create(&o), argv + first, NULL);
}
