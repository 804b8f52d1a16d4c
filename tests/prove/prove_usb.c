/* The USB device core: any events, SETUP packets and results of the controller, in any order, for ever. */
#include "prove.h"
#include "usb_device.h"

static enum hal_usb_event event(void *ctx, uint8_t setup[8])
{
    (void)ctx;
    for (int i = 0; i < 8; i++)
        setup[i] = (uint8_t)Frama_C_interval(0, 255);
    return (enum hal_usb_event)Frama_C_interval(HAL_USB_NONE, HAL_USB_SETUP);
}

/* Writes the first and the last byte that it may. */
static int read(void *ctx, uint8_t endpoint, void *data, size_t max)
{
    (void)ctx;
    (void)endpoint;
    ((uint8_t *)data)[0] = ((uint8_t *)data)[max - 1] = 0;
    return Frama_C_interval(HAL_ERROR, 64);
}

/* Reads all that it is given. */
static int write(void *ctx, uint8_t endpoint, const void *data, size_t bytes)
{
    volatile uint8_t sum = 0;
    (void)ctx;
    (void)endpoint;
    for (size_t i = 0; i < bytes; i++)
        sum ^= ((const uint8_t *)data)[i];
    return Frama_C_interval(HAL_ERROR, HAL_OK);
}

static void stall(void *ctx, uint8_t endpoint, bool stalled)
{
    (void)ctx;
    (void)endpoint;
    (void)stalled;
}

static void set_address(void *ctx, uint8_t address)
{
    (void)ctx;
    (void)address;
}

int main(void)
{
    struct usb_device usb;
    struct hal hal = {.usb_event = event,
                      .usb_read = read,
                      .usb_write = write,
                      .usb_stall = stall,
                      .usb_set_address = set_address,
                      .usb_high_speed = Frama_C_interval(0, 1),
                      .usb_high_speed_capable = Frama_C_interval(0, 1)};
    usb_device_init(&usb, &hal, "GT-0001");
    while (Frama_C_interval(0, 1))
        usb_device_poll(&usb);
    return 0;
}
