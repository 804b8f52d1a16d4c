#include "lab.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "ref_blob.h"
#include "ref_table.h"

enum { BANK = 3 * SIM_FLASH_BLOCK };

static _Noreturn void broken(const char *what)
{
    fprintf(stderr, "lab: %s\n", what);
    abort();
}

static void table_make(struct lab *lab, enum lab_content c, uint32_t mantissa, unsigned height)
{
    static uint32_t texels[9 * 150 * 2];
    for (size_t i = 0; i < 9 * 2 * height; i++)
        texels[i] = mantissa | mantissa << 9 | mantissa << 18 | 15u << 27;
    lab->data[c] = ref_ktx2_make(9, height, 2, texels, 60000, &lab->bytes[c]);
}

/* One triangle over all tiles, measured, from table slot 0, under one light. */
static void scene_make(struct lab *lab, enum lab_content c, int16_t top)
{
    const int16_t vertices[3][3] = {{-8000, -8000, 0}, {8000, -8000, 0}, {0, top, 0}};
    static const uint16_t triangles[1][3] = {{0, 1, 2}};
    struct ref_blob b;
    ref_blob_init(&b);
    ref_blob_light(&b, (const double[3]){0, 0, 1}, 1);
    unsigned material = ref_blob_material(&b, SCENE_MATERIAL_MEASURED, 0, 0.5, "first");
    unsigned mesh = ref_blob_mesh(&b, vertices, triangles, 1);
    ref_blob_object(&b, mesh, material, (const double[3]){0, 0, -0.6}, 1 / 8192.0);
    lab->data[c] = ref_blob_finish(&b, &lab->bytes[c]);
    ref_blob_free(&b);
}

struct lab *lab_create(bool high_speed, bool display)
{
    const struct sim_config config = {.width = LAB_WIDTH,
                                      .height = LAB_HEIGHT,
                                      .format = RASTER_RGB888,
                                      .high_speed = high_speed,
                                      .display = display,
                                      .slot_count = LAB_SLOTS,
                                      .table_bank_bytes = BANK,
                                      .scene_bank_bytes = BANK};
    struct lab *lab = calloc(1, sizeof *lab);
    if (!lab || !(lab->device = sim_device_create(&config)))
        broken("no device");
    sim_flash(lab->device->board, &lab->flash_bytes);
    static const struct {
        uint32_t mantissa;
        unsigned height;
    } tables[] = {
        [LAB_SMALL_A] = {200, 29}, [LAB_SMALL_B] = {90, 30}, [LAB_SMALL_C] = {30, 28}, [LAB_MIDDLE_A] = {150, 62},
        [LAB_MIDDLE_B] = {60, 63}, [LAB_BIG_A] = {180, 146}, [LAB_BIG_B] = {70, 145},  [LAB_BIG_C] = {20, 147}};
    for (enum lab_content c = LAB_SMALL_A; c <= LAB_BIG_C; c++)
        table_make(lab, c, tables[c].mantissa, tables[c].height);
    scene_make(lab, LAB_SCENE_A, 8000);
    scene_make(lab, LAB_SCENE_B, 4000);
    for (int scene = 0; scene < 2; scene++)
        for (enum lab_content c = LAB_SMALL_A; c <= LAB_BIG_C; c++) {
            struct usb_header h;
            lab_start(lab, NULL);
            lab_push(lab, 0, LAB_SCENE_A + scene);
            lab_push(lab, 1, c);
            if (!sim_device_frame(lab->device, lab->pictures[scene][c], &h) || h.status != USB_OK)
                broken("no picture");
        }
    return lab;
}

void lab_destroy(struct lab *lab)
{
    for (int c = 0; c < LAB_CONTENTS; c++)
        free(lab->data[c]);
    sim_device_destroy(lab->device);
    free(lab);
}

void lab_start(struct lab *lab, const uint8_t *image)
{
    uint32_t bytes;
    uint8_t *flash = sim_flash(lab->device->board, &bytes), descriptors[64];
    if (image)
        memcpy(flash, image, bytes);
    else
        memset(flash, 0xff, bytes);
    sim_device_restart(lab->device);
    if (sim_device_enumerate(lab->device, descriptors) < 0 && !sim_power_is_cut(lab->device->board))
        broken("the device does not enumerate");
}

bool lab_try_push(struct lab *lab, uint32_t slot, enum lab_content content)
{
    struct usb_header h;
    struct usb_info info;
    const uint8_t *data = lab->data[content];
    uint32_t bytes = (uint32_t)lab->bytes[content];
    if (!sim_device_request(lab->device, USB_MSG_INFO, NULL, 0, &h, &info, sizeof info))
        return false;
    if (info.upload_slot != slot || info.upload_length != bytes || info.upload_crc != crc32(0, data, bytes) ||
        info.upload_found != crc32(0, data, info.upload_received))
        return sim_device_push(lab->device, slot, slot ? USB_SLOT_TABLE : USB_SLOT_SCENE, data, bytes, &h) &&
               h.status == USB_OK;
    lab->resumed++;
    lab->device->content_crc = info.upload_found;
    h.status = USB_OK;
    for (uint32_t at = info.upload_received, n; at < bytes && h.status == USB_OK; at += n) {
        uint8_t message[USB_MAX_PAYLOAD];
        n = bytes - at < USB_MAX_DATA ? bytes - at : USB_MAX_DATA;
        memcpy(message, &at, 4);
        memcpy(message + 4, data + at, n);
        if (!sim_device_request(lab->device, USB_MSG_DATA, message, 4 + n, &h, NULL, 0))
            return false;
    }
    return h.status == USB_OK && sim_device_request(lab->device, USB_MSG_COMMIT, NULL, 0, &h, NULL, 0) &&
           h.status == USB_OK;
}

void lab_push(struct lab *lab, uint32_t slot, enum lab_content content)
{
    if (!lab_try_push(lab, slot, content))
        broken("a push fails that nothing disturbs");
}

int lab_slot(struct lab *lab, uint32_t slot)
{
    uint32_t bytes;
    const uint8_t *found = table_store_content(&lab->device->app.store, slot, &bytes);
    if (!found)
        return LAB_NOTHING;
    for (int c = LAB_NOTHING + 1; c < LAB_CONTENTS; c++)
        if (bytes == lab->bytes[c] && memcmp(found, lab->data[c], bytes) == 0)
            return c;
    return -1;
}

const char *lab_check(struct lab *lab, const enum lab_content content[LAB_SLOTS])
{
    static uint8_t picture[LAB_PICTURE];
    struct usb_header h;
    struct usb_info info;
    if (!sim_device_request(lab->device, USB_MSG_INFO, NULL, 0, &h, &info, sizeof info) || h.status != USB_OK)
        return "the device does not answer";
    for (uint32_t s = 0; s < LAB_SLOTS; s++) {
        enum lab_content c = content[s];
        if (lab_slot(lab, s) != (int)c)
            return "a slot holds other than it should";
        uint32_t crc = c ? (uint32_t)crc32(0, lab->data[c], (uInt)lab->bytes[c]) : 0;
        if (info.slots[s].bytes != lab->bytes[c] || info.slots[s].crc != crc)
            return "the device says other than a slot holds";
        struct usb_verify verify = {s};
        if (!sim_device_request(lab->device, USB_MSG_VERIFY, &verify, sizeof verify, &h, NULL, 0) ||
            h.status != (c ? USB_OK : USB_ERR_STATE) || h.detail != crc)
            return "a slot does not verify";
    }
    if (!sim_device_frame(lab->device, picture, &h))
        return "the device does not render";
    enum usb_status expected = !content[0] ? USB_ERR_STATE : !content[1] ? USB_ERR_TABLE : USB_OK;
    if (h.status != expected)
        return "a frame ends otherwise than it should";
    if (expected == USB_OK && memcmp(picture, lab->pictures[content[0] - LAB_SCENE_A][content[1]], LAB_PICTURE) != 0)
        return "the picture is not that of the slots' contents";
    return NULL;
}
