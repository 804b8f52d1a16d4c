/*
 * A mocked USB bus with simulated devices on it (umockdev): the child process, and whatever it starts, sees /sys and
 * /dev/bus/usb with these devices only, and its unmodified libusb talks to the firmware that runs in this process.
 */
#ifndef HOST_TOOLS_GTSIM_BUS_H
#define HOST_TOOLS_GTSIM_BUS_H

#include <stdbool.h>

#include "sim_device.h"

#define BUS_MAX_DEVICES 2

struct bus_options {
    int devices;             /* 0..BUS_MAX_DEVICES */
    struct sim_config board; /* of each device; a second one's serial number ends in "-2" */
    long long
        unplug_after; /* bytes of bulk OUT data after which the first device is unplugged for a moment; -1: never */
    long long freeze_after;    /* the same, and it no longer answers on its bulk endpoints until reopened; -1: never */
    long long damage_after;    /* the same, and one bit of the next long packet is wrong; -1: never */
    unsigned protocol_version; /* other than the firmware's own: the devices claim to speak this one */
};

/* Runs the command on the bus and returns its exit code (128 + signal number when it was killed). Dies with EXIT_INTERNAL when the
 * bus cannot be set up. */
int bus_run(const struct bus_options *o, char **command);

#endif
