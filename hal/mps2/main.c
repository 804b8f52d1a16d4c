/*
 * The firmware on an MPS2 board with a cable: USB through the mailbox, the flash a part of external memory, which outlives the emulator
 * when a file backs it. For ever: the device lives on the bus's power, so whoever pulls the cable ends the emulator.
 */
#include "app.h"
#include "board.h"
#include "costs/cortex_m4.h"
#include "mailbox_usb.h"

enum { ARENA_BYTES = 64 * 1024, FLASH_BLOCK_BYTES = 4096 };

_Static_assert(BOARD_FLASH_BYTES <= MAILBOX_OFFSET, "external memory");

static struct app app;
static uint64_t arena[ARENA_BYTES / 8];

static uint8_t *external(uint32_t offset)
{
    return (uint8_t *)(uintptr_t)(board_input + offset);
}

static int flash_erase(void *ctx, uint32_t offset)
{
    (void)ctx;
    if (offset % FLASH_BLOCK_BYTES || offset >= BOARD_FLASH_BYTES)
        report_failure("flash: erase outside the blocks");
    __builtin_memset(external(offset), 0xff, FLASH_BLOCK_BYTES);
    return HAL_OK;
}

static int flash_program(void *ctx, uint32_t offset, const void *data, uint32_t bytes)
{
    (void)ctx;
    if (offset % 4 || bytes % 4 || offset > BOARD_FLASH_BYTES || bytes > BOARD_FLASH_BYTES - offset)
        report_failure("flash: program outside the words");
    for (uint32_t i = 0; i < bytes; i++)
        if (external(offset)[i] != 0xff)
            report_failure("flash: program of a word that is not erased");
    __builtin_memcpy(external(offset), data, bytes);
    return HAL_OK;
}

_Noreturn void board_main(void)
{
    struct hal hal = board_unplugged;
    hal.flash = board_input;
    hal.flash_bytes = BOARD_FLASH_BYTES;
    hal.flash_block_bytes = FLASH_BLOCK_BYTES;
    hal.flash_erase = flash_erase;
    hal.flash_program = flash_program;
    hal.write_allowed = NULL;
    const struct app_config config = {
        .parts = &raster_all_parts,
        .width = BOARD_WIDTH,
        .height = BOARD_HEIGHT,
        .format = RASTER_RGB888,
        .slot_count = BOARD_SLOTS,
        .scene_bank_bytes = BOARD_SCENE_BANK_BYTES,
        .arena = arena,
        .arena_bytes = sizeof arena,
        .costs = &costs_cortex_m4,
        .budgets = &budget_scheduler,
        .serial = "GT-MPS2-0001",
    };
    if (app_init(&app, &hal, &config) != APP_OK)
        report_failure("the firmware refuses its configuration");
    mailbox_open(&hal, (struct mailbox *)(void *)external(MAILBOX_OFFSET));
    report_text("on\n");
    for (;;)
        app_poll(&app);
}
