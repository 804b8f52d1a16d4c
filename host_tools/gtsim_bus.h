/*
 * A mocked USB bus with simulated devices on it (umockdev): the child process, and whatever it starts, sees /sys and
 * /dev/bus/usb with these devices only, and its unmodified libusb talks to the firmware that runs in this process.
 */
#ifndef HOST_TOOLS_GTSIM_BUS_H
#define HOST_TOOLS_GTSIM_BUS_H

#include <stdbool.h>

#include "gtsim_usbfs.h"

#define BUS_MAX_DEVICES 2

struct bus_options {
    int devices;                /* 0..BUS_MAX_DEVICES */
    struct sim_config board;    /* of each device; a second one's serial number ends in "-2" */
    struct usbfs_faults faults; /* of the first device, which comes back a moment after it was unplugged */
    unsigned protocol_version;  /* other than the firmware's own: the devices claim to speak this one */
};

struct bus;

/* A bus with its devices, enumerated. In: *o must outlive it. Dies with EXIT_INTERNAL when it cannot be set up, with EXIT_FILE when
 * a flash file cannot be read or is another gtsim's, with EXIT_BAD_INPUT when it is not this device's. */
struct bus *bus_create(const struct bus_options *o);

/* Device 0..o->devices - 1, which the bus keeps. */
struct sim_device *bus_device(struct bus *b, int index);

/* Another host of the first device, in this process. */
struct bus_host {
    /* Called every few milliseconds, whenever no program on the bus has a request under way with the device. In: `used`, whether one
     * had since the last call. False ends bus_run. */
    bool (*step)(void *ctx, bool used);
    void *ctx;
};

/*
 * Runs the command, if there is one, on the bus and frees the bus. `host` may be NULL. Returns the command's exit code (128 + signal
 * number when it was killed), or 0 when the host ended it: the command then gets SIGHUP and is waited for. Without a command, 0 or 128 +
 * the number of the signal that ended it.
 */
int bus_run(struct bus *b, char **command, const struct bus_host *host);

#endif
