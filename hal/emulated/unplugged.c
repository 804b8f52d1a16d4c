#include "board.h"

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

const struct hal board_unplugged = {
    .usb_event = usb_event,
    .usb_read = usb_read,
    .usb_write = usb_write,
    .usb_stall = usb_stall,
    .usb_set_address = usb_set_address,
    .flash_erase = flash_erase,
    .flash_program = flash_program,
    .write_allowed = write_allowed,
};
