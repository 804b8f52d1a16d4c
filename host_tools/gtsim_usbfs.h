/*
 * A simulated device as usbfs shows it to programs: transfers submitted, reaped and discarded, control requests, and the faults that
 * tests ask for.
 */
#ifndef HOST_TOOLS_GTSIM_USBFS_H
#define HOST_TOOLS_GTSIM_USBFS_H

#include <stdbool.h>
#include <umockdev.h>

#include "sim_device.h"

/* Bytes of bulk OUT data after which something happens once; -1: never. */
struct usbfs_faults {
    long long unplug_after; /* the device is gone */
    long long freeze_after; /* it no longer answers on its bulk endpoints until reopened */
    long long damage_after; /* one bit of the next long packet is wrong */
};

struct usbfs {
    struct sim_device *device;
    unsigned protocol_version; /* other than the firmware's own: the device claims to speak this one */
    struct usbfs_faults faults;
    bool gone; /* unplugged; the caller plugs it in again */
    /* internal */
    GQueue out, in, complete; /* of struct urb */
    bool frozen;
    bool waiting; /* the last REAPURB found nothing */
    long long out_bytes;
};

/* Without faults. In: *device, enumerated, which must outlive it. */
void usbfs_init(struct usbfs *p, struct sim_device *device, unsigned protocol_version);

/* Serves one ioctl of a program; a negative errno on failure. */
int usbfs_serve(struct usbfs *p, UMockdevIoctlClient *client, gulong request, UMockdevIoctlData *arg);

/* Whether no program has a request under way. */
bool usbfs_idle(const struct usbfs *p);

/* Drops all transfers, as a program does that opens the device. */
void usbfs_drop(struct usbfs *p);

#endif
