/* A small simulated device and content for it, for the tests of the firmware. */
#ifndef TESTS_UNIT_DEVICE_FIXTURE_H
#define TESTS_UNIT_DEVICE_FIXTURE_H

#include <stdlib.h>
#include <string.h>

#include "ref_blob.h"
#include "ref_table.h"
#include "sim_device.h"

enum { FIXTURE_BANK = 3 * SIM_FLASH_BLOCK, FIXTURE_CAPACITY = FIXTURE_BANK - 256 };

/* 100 x 40 pixels (four tiles, cut at the right and bottom), scene and two table slots. */
static inline struct sim_device *fixture_device(bool high_speed, bool display)
{
    struct sim_config c = {
        .width = 100,
        .height = 40,
        .format = RASTER_RGB888,
        .display = display,
        .high_speed = high_speed,
        .slot_count = 3,
        .table_bank_bytes = FIXTURE_BANK,
        .scene_bank_bytes = FIXTURE_BANK,
    };
    struct sim_device *d = sim_device_create(&c);
    uint8_t descriptors[64];
    assert_non_null(d);
    assert_int_equal(sim_device_enumerate(d, descriptors), 18 + 32);
    return d;
}

/* A table of one colour everywhere, as a file (free() it). */
static inline void *fixture_table(uint32_t mantissa, size_t *bytes)
{
    uint32_t texels[9 * 5 * 2];
    for (size_t i = 0; i < sizeof texels / sizeof *texels; i++)
        texels[i] = mantissa | mantissa << 9 | mantissa << 18 | 15u << 27;
    return ref_ktx2_make(9, 5, 2, texels, 60000, bytes);
}

/* One triangle over all four tiles, not their corners, its material measured from table slot 0, one light (free() it). */
static inline void *fixture_scene(size_t *bytes)
{
    static const int16_t vertices[3][3] = {{-8000, -8000, 0}, {8000, -8000, 0}, {0, 8000, 0}};
    static const uint16_t triangles[1][3] = {{0, 1, 2}};
    struct ref_blob b;
    ref_blob_init(&b);
    ref_blob_light(&b, (const double[3]){0, 0, 1}, 1);
    unsigned material = ref_blob_material(&b, SCENE_MATERIAL_MEASURED, 0, 0.5, "first");
    unsigned mesh = ref_blob_mesh(&b, vertices, triangles, 1);
    ref_blob_object(&b, mesh, material, (const double[3]){0, 0, -0.6}, 1 / 8192.0);
    void *blob = ref_blob_finish(&b, bytes);
    ref_blob_free(&b);
    return blob;
}

#endif
