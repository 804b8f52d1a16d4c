/* What `render` and `window` ask of the simulated device: content in, a picture out. */
#ifndef HOST_TOOLS_GTSIM_DEVICE_H
#define HOST_TOOLS_GTSIM_DEVICE_H

#include "sim_device.h"

struct device_content {
    const char *scene; /* file, or NULL: none */
    const char *atlas; /* file, or NULL: none; fills slots 0, 1, ... before `tables` */
    const char *tables[RASTER_MAX_SLOTS];
    uint32_t model; /* enum scene_material_kind for all materials, or MODEL_OF_SCENE */
};

/* --atlas, --table and --model, as an argp child; its input is a struct device_content. */
extern const struct argp content_argp;

/* Bytes for a frame that let any scene be looked at: more than a device has. */
#define DEVICE_ARENA_BYTES ((size_t)4 << 20)

/* Frames with a budget learn from those before; after so many more a still picture has settled. */
enum { LEARNING_FRAMES = 7 };

/* Pushes files and sets the model. Dies with EXIT_FILE, EXIT_BAD_INPUT or EXIT_REFUSED when a file is not what it should be. */
void device_load(struct sim_device *d, const struct device_content *content);

/* Why a frame was refused and what to do, malloc'd; NULL when `status` is USB_OK. */
char *device_refusal(const struct sim_device *d, uint32_t status, uint32_t detail);

#endif
