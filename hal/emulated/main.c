/*
 * The firmware on an emulated board: frames of what the flash image holds go into the picture in external memory; the
 * second is reported and the emulator ends. The flash cannot be written, and no cable is ever plugged in.
 */
#include "app.h"
#include "board.h"
#include "costs/cortex_m7.h"

enum { FRAMES = 2, ARENA_BYTES = 64 * 1024, FLASH_BLOCK_BYTES = 4096, PIXEL_BYTES = 3 };

#define TILES (((BOARD_WIDTH - 1) / RASTER_TILE_WIDTH + 1) * ((BOARD_HEIGHT - 1) / RASTER_TILE_HEIGHT + 1))

static struct app app;
static uint64_t arena[ARENA_BYTES / 8];
static struct usb_tile_stats tile_stats[TILES];
static struct raster_memory memory;

static uint32_t clock_read(void *ctx)
{
    (void)ctx;
    return board_clock();
}

static int display_write(void *ctx, uint16_t x, uint16_t y, uint16_t w, uint16_t h, const void *pixels)
{
    (void)ctx;
    report_tile(x, y, w, h, pixels, BOARD_WIDTH, PIXEL_BYTES);
    return HAL_OK;
}

_Noreturn void board_main(void)
{
    struct hal hal = board_unplugged;
    hal.clock = clock_read;
    hal.display_write = display_write;
    hal.flash = board_input;
    hal.flash_bytes = BOARD_FLASH_BYTES;
    hal.flash_block_bytes = FLASH_BLOCK_BYTES;
    const struct app_config config = {
        .parts = &raster_all_parts,
        .width = BOARD_WIDTH,
        .height = BOARD_HEIGHT,
        .format = RASTER_RGB888,
        .slot_count = BOARD_SLOTS,
        .scene_bank_bytes = BOARD_SCENE_BANK_BYTES,
        .arena = arena,
        .arena_bytes = sizeof arena,
        .costs = &costs_cortex_m7,
        .budgets = &budget_scheduler,
        .memory = &memory,
        .tile_stats = tile_stats,
        .tile_stats_count = TILES,
        .serial = "GT-EMULATED",
    };
    if (app_init(&app, &hal, &config) != APP_OK)
        report_failure("the firmware refuses its configuration");
    if (!app.content.has_scene)
        report_failure("no scene in the flash image");
    while (app.frames < FRAMES) {
        app_poll(&app);
        if (app.frame.refused)
            report_failure("the frame cannot begin: a table or memory is missing");
    }
    report_text("frame");
    report_hex("hash", report_hash(REPORT_HASH_START, board_picture, BOARD_WIDTH * BOARD_HEIGHT * PIXEL_BYTES));
    report_number("instructions", app.stats.begin_ticks + app.stats.total.ticks);
    report_number("arena", app.stats.arena_used);
    report_number("stack", report_stack());
    report_text("\n");
    board_exit(BOARD_EXIT_OK);
}
