#include "port.h"

#include "common.h"
#include "sim_device.h"

static bool plug(void *ctx)
{
    struct sim_device *d = ctx;
    sim_plug(d->board);
    return true;
}

static void unplug(void *ctx)
{
    struct sim_device *d = ctx;
    sim_unplug(d->board);
    sim_device_poll(d);
}

static void reset(void *ctx)
{
    struct sim_device *d = ctx;
    sim_bus_reset(d->board);
    sim_device_poll(d);
}

static int setup(void *ctx, const uint8_t packet[8])
{
    struct sim_device *d = ctx;
    return sim_setup(d->board, packet);
}

static int out(void *ctx, uint8_t endpoint, const void *data, size_t bytes)
{
    struct sim_device *d = ctx;
    return sim_out(d->board, endpoint, data, bytes);
}

static int in(void *ctx, uint8_t endpoint, void *data, size_t max)
{
    struct sim_device *d = ctx;
    return sim_in(d->board, endpoint, data, max);
}

static void run(void *ctx)
{
    sim_device_poll(ctx);
}

static void rest(void *ctx, bool resting)
{
    (void)ctx;
    (void)resting;
}

struct port port_sim(void)
{
    const struct sim_config config = {.format = RASTER_RGB888, .high_speed = true};
    struct sim_device *d = sim_device_create(&config);
    if (!d)
        die(EXIT_INTERNAL, "the simulated device does not start");
    return (struct port){d, true, plug, unplug, reset, setup, out, in, run, rest};
}
