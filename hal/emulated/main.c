/*
 * The firmware on an emulated board: frames of what the flash image holds go into the picture in external memory; the
 * second is reported and the emulator ends. The flash cannot be written, and no cable is ever plugged in.
 */
#include "app.h"
#include "board.h"

enum { FRAMES = 2, ARENA_BYTES = 64 * 1024, FLASH_BLOCK_BYTES = 4096, PIXEL_BYTES = 3 };

#define TILES (((BOARD_WIDTH - 1) / RASTER_TILE_WIDTH + 1) * ((BOARD_HEIGHT - 1) / RASTER_TILE_HEIGHT + 1))

static struct app app;
static uint64_t arena[ARENA_BYTES / 8];
static struct usb_tile_stats tile_stats[TILES];

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

static enum hal_usb_event usb_event(void *ctx, uint8_t setup[8])
{
    (void)ctx;
    (void)setup;
    return HAL_USB_NONE;
}

static int usb_read(void *ctx, uint8_t endpoint, void *data, size_t max)
{
    (void)ctx;
    (void)endpoint;
    (void)data;
    (void)max;
    return HAL_AGAIN;
}

static int usb_write(void *ctx, uint8_t endpoint, const void *data, size_t bytes)
{
    (void)ctx;
    (void)endpoint;
    (void)data;
    (void)bytes;
    return HAL_AGAIN;
}

static void usb_stall(void *ctx, uint8_t endpoint, bool stalled)
{
    (void)ctx;
    (void)endpoint;
    (void)stalled;
}

static void usb_set_address(void *ctx, uint8_t address)
{
    (void)ctx;
    (void)address;
}

static int flash_erase(void *ctx, uint32_t offset)
{
    (void)ctx;
    (void)offset;
    return HAL_FORBIDDEN;
}

static int flash_program(void *ctx, uint32_t offset, const void *data, uint32_t bytes)
{
    (void)ctx;
    (void)offset;
    (void)data;
    (void)bytes;
    return HAL_FORBIDDEN;
}

static bool write_allowed(void *ctx)
{
    (void)ctx;
    return false;
}

static const struct hal hal = {
    .clock = clock_read,
    .display_write = display_write,
    .usb_event = usb_event,
    .usb_read = usb_read,
    .usb_write = usb_write,
    .usb_stall = usb_stall,
    .usb_set_address = usb_set_address,
    .flash = board_input,
    .flash_bytes = BOARD_FLASH_BYTES,
    .flash_block_bytes = FLASH_BLOCK_BYTES,
    .flash_erase = flash_erase,
    .flash_program = flash_program,
    .write_allowed = write_allowed,
};

static _Noreturn void fail(const char *why)
{
    report_text(why);
    report_text("\n");
    board_exit(BOARD_EXIT_FAILED);
}

_Noreturn void board_main(void)
{
    const struct app_config config = {
        .width = BOARD_WIDTH,
        .height = BOARD_HEIGHT,
        .format = RASTER_RGB888,
        .slot_count = BOARD_SLOTS,
        .scene_bank_bytes = BOARD_SCENE_BANK_BYTES,
        .arena = arena,
        .arena_bytes = sizeof arena,
        .tile_stats = tile_stats,
        .tile_stats_count = TILES,
        .serial = "GT-EMULATED",
    };
    if (app_init(&app, &hal, &config) != APP_OK)
        fail("the firmware refuses its configuration");
    if (!app.content.has_scene)
        fail("no scene in the flash image");
    while (app.frames < FRAMES) {
        app_poll(&app);
        if (app.frame.refused)
            fail("the frame cannot begin: a table or memory is missing");
    }
    report_text("frame");
    report_hex("hash", report_hash(REPORT_HASH_START, board_picture, BOARD_WIDTH * BOARD_HEIGHT * PIXEL_BYTES));
    report_number("instructions", app.stats.begin_ticks + app.stats.total.ticks);
    report_number("arena", app.stats.arena_used);
    report_number("stack", report_stack());
    report_text("\n");
    board_exit(BOARD_EXIT_OK);
}
