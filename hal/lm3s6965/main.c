/*
 * The firmware on the smallest board: scene and table are built into its flash, frames go to the OLED for ever. The first
 * one is reported on the UART.
 *
 * Built with a tile of 32 x 32 pixels: 64 KB of SRAM hold the stack, the firmware's state and the arena.
 */
#include "app.h"
#include "board.h"
#include "image.h"
#include "oled.h"

enum { ARENA_BYTES = 8 * 1024, FLASH_BLOCK_BYTES = 1024 };

/* What the built-in scene takes. */
static const struct raster_parts parts = {
    .specular_frame = &raster_specular_frame_model,
    .lafortune_phong = &raster_lafortune_phong_model,
};

static struct app app;
static uint64_t arena[ARENA_BYTES / 8];

static uint32_t clock_read(void *ctx)
{
    (void)ctx;
    return board_clock();
}

static int display_write(void *ctx, uint16_t x, uint16_t y, uint16_t w, uint16_t h, const void *pixels)
{
    (void)ctx;
    oled_write(x, y, w, h, pixels);
    return HAL_OK;
}

_Noreturn void board_main(void)
{
    struct hal hal = board_unplugged;
    hal.clock = clock_read;
    hal.display_write = display_write;
    hal.flash = lm3s6965_image;
    hal.flash_bytes = (uint32_t)(lm3s6965_image_end - lm3s6965_image);
    hal.flash_block_bytes = FLASH_BLOCK_BYTES;
    const struct app_config config = {
        .width = OLED_WIDTH,
        .height = OLED_HEIGHT,
        .format = RASTER_RGB888,
        .slot_count = 2,
        .scene_bank_bytes = IMAGE_SCENE_BANK_BYTES,
        .parts = &parts,
        .arena = arena,
        .arena_bytes = sizeof arena,
        .serial = "GT-LM3S6965",
    };
    oled_init();
    if (app_init(&app, &hal, &config) != APP_OK)
        report_failure("the firmware refuses its configuration");
    if (!app.content.has_scene)
        report_failure("no scene in the flash image");
    while (app.frames == 0) {
        app_poll(&app);
        if (app.frame.refused)
            report_failure("the frame cannot begin: a table or memory is missing");
    }
    report_text("frame");
    report_number("instructions", app.stats.begin_ticks + app.stats.total.ticks);
    report_number("arena", app.stats.arena_used);
    report_number("stack", report_stack());
    report_text("\n");
    for (;;)
        app_poll(&app);
}
