/* The protocol's framing: any packets, interruptions and replies, in any order, for ever. The USB core below it and the CRC are unknown. */
#include "crc32.h"
#include "protocol.h"
#include "prove.h"

size_t usb_device_packet(const struct usb_device *d)
{
    (void)d;
    return Frama_C_interval(0, 1) ? USB_FULL_SPEED_BULK : USB_HIGH_SPEED_BULK;
}

int usb_device_read(struct usb_device *d, void *data, size_t max)
{
    (void)d;
    for (size_t i = 0; i < max; i++)
        ((uint8_t *)data)[i] = (uint8_t)Frama_C_interval(0, 255);
    return Frama_C_interval(0, 1) ? HAL_AGAIN : Frama_C_interval(0, (int)max);
}

int usb_device_write(struct usb_device *d, const void *data, size_t bytes)
{
    volatile uint8_t sum = 0;
    (void)d;
    for (size_t i = 0; i < bytes; i++)
        sum ^= ((const uint8_t *)data)[i];
    return Frama_C_interval(HAL_ERROR, HAL_OK);
}

void usb_device_halt_out(struct usb_device *d)
{
    (void)d;
}

uint32_t crc32_update(uint32_t crc, const void *data, size_t bytes)
{
    (void)crc;
    (void)data;
    (void)bytes;
    return Frama_C_unsigned_int_interval(0, UINT32_MAX);
}

int main(void)
{
    static struct usb_device usb;
    static struct protocol p;
    static struct usb_info info;
    static uint8_t tail[64 * 32 * 3];
    protocol_init(&p, &usb);
    while (Frama_C_interval(0, 1)) {
        if (Frama_C_interval(0, 1))
            protocol_clear_out(&p);
        if (Frama_C_interval(0, 1))
            protocol_clear_in(&p);
        protocol_receive(&p);
        if (p.state == PROTOCOL_REQUEST && !p.sending) {
            protocol_reply(&p, USB_OK, 0, &info, Frama_C_unsigned_int_interval(0, sizeof info), tail,
                           Frama_C_unsigned_int_interval(0, sizeof tail));
            protocol_done(&p);
        }
        protocol_send(&p);
    }
    return 0;
}
