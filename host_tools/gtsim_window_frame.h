/* The frame that the window shows, fetched from the device, what it cost, and files of it. */
#ifndef HOST_TOOLS_GTSIM_WINDOW_FRAME_H
#define HOST_TOOLS_GTSIM_WINDOW_FRAME_H

#include "host_canvas.h"
#include "sim_device.h"

struct frame {
    struct sim_device *device;
    const char *record;   /* folder for each frame that differs from the one before, or NULL */
    struct canvas canvas; /* the last one; black before */
    char *refusal;        /* why the device has refused another since, or NULL */
    double seconds;       /* that it took here */
    struct usb_stats stats;
    struct usb_tile_stats *tiles; /* stats.tile_count of them */
    unsigned recorded;
};

/* The device and the folder are given. */
void frame_init(struct frame *f);
void frame_free(struct frame *f);

/* Asks the device for a frame and what it cost. */
void frame_fetch(struct frame *f);

/* Writes it to the first gtsim-NNNN.png of a folder that is not there. */
void frame_write(const struct frame *f, const char *folder);

#endif
