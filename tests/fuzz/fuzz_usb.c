/*
 * Control requests: any SETUP packets, data and status stages in any order, resets and unplugging in between. The host never gets more
 * than it asked for, and a bus reset brings the device back.
 *
 * Input: a byte of the speed, then operations of one byte (low three bits: which; the rest: a count) and their arguments.
 */
#include "fuzz.h"
#include "sim_device.h"

enum { BANK = SIM_FLASH_BLOCK };

static void operate(struct sim_device *d, struct input *in)
{
    static uint8_t asked; /* what the last SETUP allows, in packets of 64 */
    uint8_t setup[8] = {0}, packet[64], op = input_byte(in);
    const uint8_t *bytes;
    size_t n;
    switch (op & 7) {
    case 0: /* a SETUP packet */
    case 1:
        n = input_bytes(&bytes, in, sizeof setup);
        memcpy(setup, bytes, n);
        sim_setup(d->board, setup);
        asked = (uint8_t)(setup[7] ? 4 : (setup[6] + 63) / 64);
        break;
    case 2: /* a packet of data or status */
        n = input_bytes(&bytes, in, op >> 3);
        sim_out(d->board, 0x00, bytes, n);
        break;
    case 3: {
        int taken = sim_in(d->board, 0x80, packet, sizeof packet);
        CLAIM(taken <= (asked ? (int)sizeof packet : 0));
        break;
    }
    case 4: /* a whole transfer */
        n = input_bytes(&bytes, in, sizeof setup);
        memcpy(setup, bytes, n);
        if (setup[0] & 0x80) {
            uint32_t length = setup[6] | (uint32_t)setup[7] << 8;
            uint8_t *data = malloc(length + 1);
            CLAIM(data && sim_device_control(d, setup, data) <= (int)length);
            free(data);
        } else if (!setup[6] && !setup[7]) {
            CLAIM(sim_device_control(d, setup, NULL) <= 0);
        }
        break;
    case 5:
        sim_bus_reset(d->board);
        break;
    case 6:
        if (op >> 3 & 1)
            sim_plug(d->board);
        else
            sim_unplug(d->board);
        break;
    default:
        for (unsigned i = 0; i < op >> 3; i++)
            sim_device_poll(d);
    }
    if (op & 0x80)
        sim_device_poll(d);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes)
{
    struct input in = {data, bytes};
    struct sim_config c = {.width = 16,
                           .height = 16,
                           .slot_count = 2,
                           .table_bank_bytes = BANK,
                           .scene_bank_bytes = BANK,
                           .high_speed = input_byte(&in) & 1};
    struct sim_device *d = sim_device_create(&c);
    uint8_t descriptors[64];
    CLAIM(d);
    sim_plug(d->board);
    while (in.left)
        operate(d, &in);
    sim_unplug(d->board);
    CLAIM(sim_device_enumerate(d, descriptors) == 18 + 32);
    sim_device_destroy(d);
    return 0;
}
