/*
 * The demo's scene keeps to stated counts, per tile and per frame: what a change of culling, binning or rasterizing costs
 * shows here, whatever machine the test runs on. The scene blob is the one that GONIOTILE_SIX_MODELS names.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>

#include "../unit/device_fixture.h"
#include "common.h"

enum { TILES = 40, TABLES = 6 }; /* 320 x 240; six materials */

/* About 10 % over what was measured when the limits were set. */
static const struct {
    const char *name;
    size_t offset; /* in struct usb_tile_stats */
    uint32_t tile, frame;
} limits[] = {
    {"triangles", offsetof(struct usb_tile_stats, triangles), 1060, 17300},
    {"pixels tested", offsetof(struct usb_tile_stats, tested), 2700, 49300},
    {"pixels covered", offsetof(struct usb_tile_stats, covered), 2048, 43600},
    {"pixel-lights shaded", offsetof(struct usb_tile_stats, shaded), 4650, 80000},
    {"texels fetched", offsetof(struct usb_tile_stats, fetches), 37200, 641000},
    {"modelled ticks", offsetof(struct usb_tile_stats, ticks), 6530000, 131000000},
};
static const uint32_t meshlet_limit = 1170, arena_limit = 8200;

static struct {
    struct usb_stats all;
    struct usb_tile_stats tiles[TILES];
} stats;

static uint32_t count_of(const struct usb_tile_stats *t, size_t offset)
{
    uint32_t count;
    memcpy(&count, (const uint8_t *)t + offset, sizeof count);
    return count;
}

/* Renders the frame once and fetches its statistics. */
static int setup(void **state)
{
    const char *path = getenv("GONIOTILE_SIX_MODELS");
    struct sim_config c = {0};
    static uint8_t pixels[320 * 240 * 2];
    uint8_t descriptors[64];
    struct usb_header h;
    size_t bytes;
    uint32_t want = 1;
    *state = NULL;
    if (!path)
        return 0;
    void *scene = read_file(path, SCENE_MAX_BYTES, &bytes);
    struct sim_device *d = sim_device_create(&c);
    if (!d || sim_device_enumerate(d, descriptors) < 0 ||
        !sim_device_push(d, 0, USB_SLOT_SCENE, scene, (uint32_t)bytes, &h) || h.status != USB_OK)
        return -1;
    void *table = fixture_table(100, &bytes); /* counts do not depend on what the tables say */
    for (uint32_t slot = 1; slot <= TABLES; slot++)
        if (!sim_device_push(d, slot, USB_SLOT_TABLE, table, (uint32_t)bytes, &h) || h.status != USB_OK)
            return -1;
    if (!sim_device_frame(d, pixels, &h) || h.status != USB_OK)
        return -1;
    if (!sim_device_request(d, USB_MSG_STATS, &want, sizeof want, &h, &stats, sizeof stats) || h.length != sizeof stats)
        return -1;
    free(table);
    free(scene);
    sim_device_destroy(d);
    *state = &stats;
    return 0;
}

static void every_tile_stays_within_its_counts(void **state)
{
    if (!*state)
        skip();
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        uint32_t most = 0, where = 0;
        for (uint32_t t = 0; t < TILES; t++) {
            uint32_t count = count_of(&stats.tiles[t], limits[i].offset);
            if (count > most) {
                most = count;
                where = t;
            }
        }
        printf("# %s: %u in tile %u, limit %u\n", limits[i].name, most, where, limits[i].tile);
        assert_in_range(most, 1, limits[i].tile);
    }
}

static void frame_stays_within_its_counts(void **state)
{
    if (!*state)
        skip();
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        uint32_t count = count_of(&stats.all.total, limits[i].offset);
        printf("# %s: %u, limit %u\n", limits[i].name, count, limits[i].frame);
        assert_in_range(count, 1, limits[i].frame);
    }
    printf("# meshlets visible: %u, limit %u\n", stats.all.meshlets_visible, meshlet_limit);
    assert_in_range(stats.all.meshlets_visible, 1, meshlet_limit);
    printf("# arena: %u bytes, limit %u\n", stats.all.arena_used, arena_limit);
    assert_in_range(stats.all.arena_used, 1, arena_limit);
}

/* What no scene can exceed: every pixel shaded for each of the three lights, eight texels each. */
static void counts_are_consistent(void **state)
{
    if (!*state)
        skip();
    for (uint32_t t = 0; t < TILES; t++) {
        const struct usb_tile_stats *s = &stats.tiles[t];
        assert_in_range(s->covered, 0, RASTER_TILE_WIDTH * RASTER_TILE_HEIGHT);
        assert_in_range(s->covered, 0, s->tested);
        assert_in_range(s->shaded, 0, 3 * s->covered);
        assert_in_range(s->fetches, 0, 8 * s->shaded);
        if (s->triangles == 0)
            assert_int_equal(s->tested, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_tile_stays_within_its_counts),
        cmocka_unit_test(frame_stays_within_its_counts),
        cmocka_unit_test(counts_are_consistent),
    };
    return cmocka_run_group_tests(tests, setup, NULL);
}
