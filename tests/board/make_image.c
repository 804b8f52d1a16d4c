/*
 * Makes a flash image as the firmware's own table store writes it: a simulated device of the board's layout takes the scene and the tables
 * over its bus.
 *
 *   make_image OUT.img BLOCKS_OF_SCENE_BANK BLOCKS_OF_TABLE_BANK SCENE.blob TABLE.ktx2...
 *
 * Banks are counted in blocks of 4 KB. Tables fill slots 0, 1, ... in order; the image has as many table slots.
 */
#include "common.h"
#include "sim_device.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { MAX_BLOCKS = 1024 };

static void push(struct sim_device *d, uint32_t slot, const char *path)
{
    struct usb_header h = {0};
    size_t bytes;
    void *content = read_file(path, SCENE_MAX_BYTES, &bytes);
    uint32_t kind = slot == 0 ? USB_SLOT_SCENE : USB_SLOT_TABLE;
    if (!sim_device_push(d, slot, kind, content, (uint32_t)bytes, &h))
        die(EXIT_USB, "%s: the simulated device did not answer", path);
    if (h.status != USB_OK)
        die(EXIT_REFUSED, "%s: %zu bytes refused by slot %u: status %u, detail %u", path, bytes, slot, h.status,
            h.detail);
    free(content);
}

int main(int argc, char **argv)
{
    uint8_t descriptors[64];
    common_set_name("make_image", NULL);
    if (argc < 6 || argc - 4 > (int)USB_MAX_SLOTS)
        die(EXIT_USAGE, "usage: make_image OUT.img SCENE_BLOCKS TABLE_BLOCKS SCENE.blob TABLE.ktx2...");
    unlink(argv[1]);
    struct sim_config config = {
        .slot_count = (uint8_t)(argc - 4),
        .scene_bank_bytes = (uint32_t)parse_long("SCENE_BLOCKS", argv[2], 1, MAX_BLOCKS) * SIM_FLASH_BLOCK,
        .table_bank_bytes = (uint32_t)parse_long("TABLE_BLOCKS", argv[3], 1, MAX_BLOCKS) * SIM_FLASH_BLOCK,
        .flash_file = argv[1]};
    struct sim_device *d = sim_device_create(&config);
    if (!d || sim_device_enumerate(d, descriptors) < 0)
        die(EXIT_INTERNAL, "no simulated device");
    for (int i = 4; i < argc; i++)
        push(d, (uint32_t)(i - 4), argv[i]);
    if (!sim_device_destroy(d))
        die(EXIT_FILE, "%s: not written", argv[1]);
    return EXIT_OK;
}
