/*
 * What a push costs the device: the firmware takes the requests at board_input (bench_usb makes them: u32 bytes of content, u32 bytes
 * of requests, then BEGIN, DATA and COMMIT as they go over the bus) in Full-Speed packets, and the instructions of all app_poll calls
 * until the last reply are counted: the packets' and the flash's copying, CRC and reading back included, erasing not.
 */
#include "app.h"
#include "board.h"
#include "costs/cortex_m7.h"

enum { FLASH_BLOCK_BYTES = 4096, SCENE_BANK = 2 * FLASH_BLOCK_BYTES, TABLE_BANK = 512 * FLASH_BLOCK_BYTES };

/* External memory behind the input. */
#define FLASH_OFFSET (4u << 20)
#define FLASH_BYTES  (2u * (SCENE_BANK + TABLE_BANK))

static struct app app;
static uint64_t arena[1024];

static struct {
    const uint8_t *requests;
    uint32_t bytes, sent, replies, refused, erasing;
    uint32_t event;
} bus;

static uint8_t *flash_bytes(void)
{
    return (uint8_t *)(uintptr_t)(board_input + FLASH_OFFSET);
}

/* Reset, address 1, configuration 1. */
static enum hal_usb_event usb_event(void *ctx, uint8_t setup[8])
{
    static const uint8_t setups[2][8] = {{0x00, 5, 1}, {0x00, 9, 1}};
    (void)ctx;
    if (bus.event > 2)
        return HAL_USB_NONE;
    if (bus.event++ == 0)
        return HAL_USB_RESET;
    __builtin_memcpy(setup, setups[bus.event - 2], 8);
    return HAL_USB_SETUP;
}

static int usb_read(void *ctx, uint8_t endpoint, void *data, size_t max)
{
    (void)ctx;
    uint32_t n = bus.bytes - bus.sent < USB_FULL_SPEED_BULK ? bus.bytes - bus.sent : USB_FULL_SPEED_BULK;
    if (endpoint != USB_ENDPOINT_OUT || n == 0 || n > max)
        return HAL_AGAIN;
    __builtin_memcpy(data, bus.requests + bus.sent, n);
    bus.sent += n;
    return (int)n;
}

static int usb_write(void *ctx, uint8_t endpoint, const void *data, size_t bytes)
{
    struct usb_header h;
    (void)ctx;
    if (endpoint != USB_ENDPOINT_IN)
        return HAL_OK;
    __builtin_memcpy(&h, data, sizeof h);
    bus.refused += bytes != sizeof h || h.status != USB_OK;
    bus.replies++;
    return HAL_OK;
}

static int flash_erase(void *ctx, uint32_t offset)
{
    uint32_t start = board_clock();
    (void)ctx;
    __builtin_memset(flash_bytes() + offset, 0xff, FLASH_BLOCK_BYTES);
    bus.erasing += board_clock() - start;
    return HAL_OK;
}

static int flash_program(void *ctx, uint32_t offset, const void *data, uint32_t bytes)
{
    (void)ctx;
    __builtin_memcpy(flash_bytes() + offset, data, bytes);
    return HAL_OK;
}

_Noreturn void board_main(void)
{
    struct hal hal = board_unplugged;
    const struct app_config config = {.parts = &raster_all_parts,
                                      .width = 64,
                                      .height = 32,
                                      .slot_count = 2,
                                      .scene_bank_bytes = SCENE_BANK,
                                      .arena = arena,
                                      .arena_bytes = sizeof arena,
                                      .costs = &costs_cortex_m7,
                                      .serial = "GT-EMULATED"};
    uint32_t sizes[2];
    __builtin_memcpy(sizes, board_input, sizeof sizes);
    hal.usb_event = usb_event;
    hal.usb_read = usb_read;
    hal.usb_write = usb_write;
    hal.flash = flash_bytes();
    hal.flash_bytes = FLASH_BYTES;
    hal.flash_block_bytes = FLASH_BLOCK_BYTES;
    hal.flash_erase = flash_erase;
    hal.flash_program = flash_program;
    hal.write_allowed = NULL;
    __builtin_memset(flash_bytes(), 0xff, FLASH_BYTES);
    if (app_init(&app, &hal, &config) != APP_OK)
        report_failure("the firmware refuses its configuration");
    while (app.usb.state != USB_STATE_CONFIGURED)
        app_poll(&app);
    bus.requests = board_input + sizeof sizes;
    uint32_t start = board_clock();
    bus.bytes = sizes[1];
    for (uint32_t idle = 0, before = 0; idle < 10; idle = bus.replies == before ? idle + 1 : 0) {
        before = bus.replies;
        app_poll(&app);
        if (app.store.slots[1].kind != USB_SLOT_EMPTY && !app.protocol.sending)
            break;
    }
    uint32_t instructions = board_clock() - start - bus.erasing;
    if (bus.refused || app.store.slots[1].length != sizes[0])
        report_failure("the push failed");
    report_text("push");
    report_number("bytes", sizes[0]);
    report_number("replies", bus.replies);
    report_number("instructions", instructions);
    report_text("\n");
    board_exit(BOARD_EXIT_OK);
}
