#include "gtsim_device.h"

#include <stdlib.h>
#include <string.h>

#include "gtsim.h"
#include "host_atlas.h"
#include "host_model.h"

static void parse_table(struct device_content *c, char *arg)
{
    char *equals = strchr(arg, '=');
    if (!equals)
        die(EXIT_USAGE, "--table: '%s' has no slot; write SLOT=FILE", arg);
    *equals = 0;
    c->tables[parse_long("--table SLOT", arg, 0, RASTER_MAX_SLOTS - 1)] = equals + 1;
    *equals = '='; /* `window` starts itself again with these arguments */
}

static error_t parse_option(int key, char *arg, struct argp_state *state)
{
    struct device_content *c = state->input;
    switch (key) {
    case 't':
        parse_table(c, arg);
        return 0;
    case 'A':
        c->atlas = arg;
        return 0;
    case 'm':
        c->model = model_find(arg);
        if (c->model == MODEL_OF_SCENE && strcmp(arg, "scene"))
            die(EXIT_USAGE, "--model: no model '%s'; it is one of " MODEL_NAMES ", scene", arg);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option options[] = {
    {"table", 't', "SLOT=FILE", 0, "a table into a table slot, 0 to 15; repeat for more", 0},
    {"atlas", 'A', "FILE", 0, "the tables of an atlas into slots 0, 1, ...; a --table takes the place of one", 0},
    {"model", 'm', "MODEL", 0, MODEL_NAMES " or scene (scene)", 0},
    {0}};
const struct argp content_argp = {options, parse_option, NULL, NULL, NULL, NULL, NULL};

/* Loads what came from a file into the device's slot. */
static void slot_fill(struct sim_device *d, uint32_t slot, const char *path, const uint8_t *data, size_t bytes)
{
    struct usb_header h;
    uint32_t kind = slot ? USB_SLOT_TABLE : USB_SLOT_SCENE;
    if (!bytes)
        die(EXIT_BAD_INPUT, "%s: empty; give a %s", path, slot ? "table" : "scene");
    if (!sim_device_push(d, slot, kind, data, (uint32_t)bytes, &h))
        die(EXIT_INTERNAL, "%s: the simulated device does not answer", path);
    if (h.status == USB_ERR_CONTENT && kind == USB_SLOT_TABLE)
        die(EXIT_BAD_INPUT, "%s: not a valid table: %s; build it again with gtlut", path,
            lut_status_text((enum lut_status)h.detail));
    if (h.status == USB_ERR_CONTENT)
        die(EXIT_BAD_INPUT, "%s: not a valid scene: %s; build it again with gtscene", path,
            scene_status_text((enum scene_status)h.detail));
    if (h.status == USB_ERR_TOO_LARGE)
        die(EXIT_REFUSED, "%s: %zu bytes, the slot's bank holds %u; build a smaller one", path, bytes, h.detail);
    if (h.status != USB_OK)
        die(EXIT_REFUSED, "%s: refused by the device: status %u, detail %u", path, h.status, h.detail);
}

static void slot_load(struct sim_device *d, uint32_t slot, const char *path)
{
    size_t bytes;
    uint8_t *data = read_file(path, SCENE_MAX_BYTES, &bytes);
    if (atlas_recognise(data, bytes))
        die(EXIT_BAD_INPUT, "%s: an atlas; give it with --atlas", path);
    slot_fill(d, slot, path, data, bytes);
    free(data);
}

static void atlas_load(struct sim_device *d, const char *path)
{
    struct atlas a;
    size_t bytes;
    uint8_t *data = read_file(path, ATLAS_MAX_BYTES, &bytes);
    atlas_open(&a, path, data, bytes);
    if (a.tables > RASTER_MAX_SLOTS)
        die(EXIT_REFUSED, "%s: %u tables, the device has %u slots; give fewer", path, a.tables, RASTER_MAX_SLOTS);
    for (uint32_t i = 0; i < a.tables; i++) {
        size_t table_bytes;
        uint8_t *table = atlas_table(&table_bytes, &a, i);
        slot_fill(d, i + 1, path, table, table_bytes);
        free(table);
    }
    free(data);
}

void device_load(struct sim_device *d, const struct device_content *content)
{
    uint32_t payload[2] = {USB_SET_MODEL, content->model};
    struct usb_header h;
    if (content->scene)
        slot_load(d, 0, content->scene);
    if (content->atlas)
        atlas_load(d, content->atlas);
    for (uint32_t i = 0; i < RASTER_MAX_SLOTS; i++)
        if (content->tables[i])
            slot_load(d, i + 1, content->tables[i]);
    if (content->model == MODEL_OF_SCENE)
        return;
    if (!sim_device_request(d, USB_MSG_SET, payload, sizeof payload, &h, NULL, 0))
        die(EXIT_INTERNAL, "the simulated device does not answer");
    if (h.status == USB_ERR_STATE)
        die(EXIT_REFUSED, "--model: the device has no scene; give one");
    if (h.status != USB_OK)
        die(EXIT_INTERNAL, "the simulated device refuses the model");
}

char *device_refusal(const struct sim_device *d, uint32_t status, uint32_t detail)
{
    switch (status) {
    case USB_OK:
        return NULL;
    case USB_ERR_STATE:
        return xasprintf("the device has no scene; push one");
    case USB_ERR_TABLE:
        return xasprintf("the table slot of material %u is empty; give --table SLOT=FILE", detail);
    case USB_ERR_RENDER:
        return xasprintf("cannot be rendered: %s", raster_status_text((enum raster_status)detail));
    case USB_ERR_BUDGET:
        return xasprintf("the budget is %u ticks per tile, the scene needs %u; give a larger --budget",
                         d->app.content.tile_budget, detail);
    case USB_ERR_MEMORY:
        return xasprintf("the frame needs %u bytes of memory, the device has %zu", detail, d->config.arena_bytes);
    default:
        return xasprintf("refused by the device: status %u, detail %u", status, detail);
    }
}
