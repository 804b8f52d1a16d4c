/*
 * The USB port of a device as a host controller sees it, whatever runs the firmware behind it. Results are those of sim.h's bus
 * functions: bytes, or a negative enum sim_result.
 */
#ifndef TESTS_GUEST_PORT_H
#define TESTS_GUEST_PORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct port {
    void *ctx;
    bool high_speed;
    bool (*plug)(void *ctx); /* power on; false when the device does not start */
    void (*unplug)(void *ctx);
    void (*reset)(void *ctx); /* bus reset */
    int (*setup)(void *ctx, const uint8_t setup[8]);
    int (*out)(void *ctx, uint8_t endpoint, const void *data, size_t bytes);
    int (*in)(void *ctx, uint8_t endpoint, void *data, size_t max);
    void (*run)(void *ctx);                /* time passes */
    void (*rest)(void *ctx, bool resting); /* the bus is silent for now: an emulator need not run on */
};

/* The firmware in this process, on the simulated board, at high speed. */
struct port port_sim(void);

/* The firmware on an emulated board, whose external memory is this file: `command` is run when the cable is plugged in and killed when
 * it is pulled. */
struct port port_mailbox(const char *file, char **command);

#endif
