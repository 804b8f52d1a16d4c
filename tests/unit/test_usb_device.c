/* The USB device core's answers on endpoint 0 (USB 2.0, chapter 9), as a host on the bus sees them. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "device_fixture.h"

static int control(struct sim_device *d, unsigned type, unsigned request, unsigned value, unsigned index,
                   unsigned length, void *data)
{
    uint8_t setup[8] = {(uint8_t)type,  (uint8_t)request,      (uint8_t)value,  (uint8_t)(value >> 8),
                        (uint8_t)index, (uint8_t)(index >> 8), (uint8_t)length, (uint8_t)(length >> 8)};
    return sim_device_control(d, setup, data);
}

static int descriptor(struct sim_device *d, unsigned type, unsigned index, unsigned length, uint8_t *data)
{
    return control(d, 0x80, 6, type << 8 | index, 0, length, data);
}

static void device_descriptor_is_exact(void **state)
{
    static const uint8_t expected[18] = {18,   1,    0x01, 0x02, 0,    0, 0, 64, 0x09,
                                         0x12, 0x01, 0x00, 0x10, 0x00, 1, 2, 3,  1};
    struct sim_device *d = fixture_device(false, false);
    uint8_t data[64];
    (void)state;
    assert_int_equal(descriptor(d, 1, 0, 64, data), 18);
    assert_memory_equal(data, expected, 18);
    assert_int_equal(descriptor(d, 1, 0, 8, data), 8); /* the first thing a host asks */
    assert_int_equal(descriptor(d, 1, 1, 64, data), SIM_STALL);
    sim_device_destroy(d);
}

static void configuration_follows_the_speed(void **state)
{
    uint8_t expected[32] = {9, 2, 32, 0, 1, 1, 0,  0x80, 50, 9, 4, 0,    0, 2,  0xff, 0,
                            0, 0, 7,  5, 1, 2, 64, 0,    0,  7, 5, 0x81, 2, 64, 0,    0};
    uint8_t data[64];
    (void)state;
    struct sim_device *full = fixture_device(false, false), *high = fixture_device(true, false);
    assert_int_equal(descriptor(full, 2, 0, 255, data), 32);
    assert_memory_equal(data, expected, 32);
    assert_int_equal(descriptor(full, 2, 0, 9, data), 9);
    assert_int_equal(descriptor(full, 2, 1, 255, data), SIM_STALL);
    /* without high speed there is no other speed */
    assert_int_equal(descriptor(full, 6, 0, 255, data), SIM_STALL);
    assert_int_equal(descriptor(full, 7, 0, 255, data), SIM_STALL);

    static const uint8_t qualifier[10] = {10, 6, 0x01, 0x02, 0, 0, 0, 64, 1, 0};
    assert_int_equal(descriptor(high, 6, 0, 255, data), 10);
    assert_memory_equal(data, qualifier, 10);
    expected[1] = 7; /* at the other speed packets are of 64 bytes */
    assert_int_equal(descriptor(high, 7, 0, 255, data), 32);
    assert_memory_equal(data, expected, 32);
    expected[1] = 2;
    expected[22] = expected[29] = 0;
    expected[23] = expected[30] = 2;
    assert_int_equal(descriptor(high, 2, 0, 255, data), 32);
    assert_memory_equal(data, expected, 32);
    sim_device_destroy(full);
    sim_device_destroy(high);
}

/* A high-speed device behind a full-speed hub (9.6.2, 9.6.4). */
static void capable_device_at_full_speed_tells_of_the_other_speed(void **state)
{
    static const uint8_t qualifier[10] = {10, 6, 0x01, 0x02, 0, 0, 0, 64, 1, 0};
    static const uint8_t expected[32] = {9, 7, 32, 0, 1, 1, 0, 0x80, 50, 9, 4, 0,    0, 2, 0xff, 0,
                                         0, 0, 7,  5, 1, 2, 0, 2,    0,  7, 5, 0x81, 2, 0, 2,    0};
    struct sim_device *d = fixture_device(false, false);
    struct hal hal = *d->app.hal;
    uint8_t data[64];
    (void)state;
    hal.usb_high_speed_capable = true;
    d->app.usb.hal = &hal;
    assert_int_equal(descriptor(d, 6, 0, 255, data), 10);
    assert_memory_equal(data, qualifier, 10);
    assert_int_equal(descriptor(d, 7, 0, 255, data), 32);
    assert_memory_equal(data, expected, 32);
    assert_int_equal(descriptor(d, 2, 0, 255, data), 32); /* and of this one as before */
    assert_int_equal(data[1], 2);
    assert_int_equal(data[22], 64);
    sim_device_destroy(d);
}

static void string_is(struct sim_device *d, unsigned index, const char *text)
{
    uint8_t data[256];
    int n = descriptor(d, 3, index, 255, data);
    assert_int_equal(n, 2 + 2 * strlen(text));
    assert_int_equal(data[0], n);
    assert_int_equal(data[1], 3);
    for (size_t i = 0; text[i]; i++) {
        assert_int_equal(data[2 + 2 * i], text[i]);
        assert_int_equal(data[3 + 2 * i], 0);
    }
}

static void strings_name_maker_product_and_serial_number(void **state)
{
    struct sim_device *d = fixture_device(false, false);
    uint8_t data[256];
    static const uint8_t languages[4] = {4, 3, 0x09, 0x04};
    (void)state;
    assert_int_equal(descriptor(d, 3, 0, 255, data), 4);
    assert_memory_equal(data, languages, 4);
    string_is(d, 1, "Goniotile");
    string_is(d, 2, "Goniotile");
    string_is(d, 3, "GT-SIM-0001");
    assert_int_equal(descriptor(d, 3, 4, 255, data), SIM_STALL);
    sim_device_destroy(d);
}

/* 31 characters make 64 bytes: exactly one packet, so only a zero-length one tells that no more comes. */
static void full_packet_that_ends_early_is_followed_by_an_empty_one(void **state)
{
    struct sim_config c = {.slot_count = 2,
                           .table_bank_bytes = SIM_FLASH_BLOCK,
                           .scene_bank_bytes = SIM_FLASH_BLOCK,
                           .serial = "0123456789012345678901234567890"};
    struct sim_device *d = sim_device_create(&c);
    uint8_t packet[64], descriptors[64];
    (void)state;
    assert_non_null(d);
    sim_device_enumerate(d, descriptors);
    for (unsigned wanted = 64; wanted <= 255; wanted += 191) {
        const uint8_t setup[8] = {0x80, 6, 3, 3, 9, 4, (uint8_t)wanted, 0};
        sim_setup(d->board, setup);
        sim_device_poll(d);
        assert_int_equal(sim_in(d->board, 0x80, packet, 64), 64);
        sim_device_poll(d);
        assert_int_equal(sim_in(d->board, 0x80, packet, 64), wanted == 64 ? SIM_NAK : 0);
        sim_out(d->board, 0x00, NULL, 0);
        sim_device_poll(d);
    }
    string_is(d, 3, c.serial);
    sim_device_destroy(d);
    c.serial = "01234567890123456789012345678901";
    assert_null(sim_device_create(&c)); /* one more does not fit */
}

static void address_takes_effect_after_the_status_stage(void **state)
{
    struct sim_device *d = fixture_device(false, false);
    static const uint8_t setup[8] = {0x00, 5, 42};
    uint8_t packet[64];
    (void)state;
    sim_bus_reset(d->board);
    sim_setup(d->board, setup);
    for (int i = 0; i < 5; i++)
        sim_device_poll(d);
    assert_int_equal(sim_address(d->board), 0);
    assert_int_equal(sim_in(d->board, 0x80, packet, 64), 0);
    assert_int_equal(sim_address(d->board), 42);
    assert_int_equal(control(d, 0x00, 5, 128, 0, 0, NULL), SIM_STALL);
    assert_int_equal(control(d, 0x00, 5, 7, 1, 0, NULL), SIM_STALL);
    assert_int_equal(control(d, 0x00, 5, 7, 0, 0, NULL), 0);
    assert_int_equal(sim_address(d->board), 7);
    sim_bus_reset(d->board);
    sim_device_poll(d);
    assert_int_equal(sim_address(d->board), 0);
    sim_device_destroy(d);
}

static void states_allow_what_chapter_9_says(void **state)
{
    struct sim_device *d = fixture_device(false, false);
    uint8_t data[64];
    (void)state;
    sim_bus_reset(d->board); /* default state */
    assert_int_equal(descriptor(d, 1, 0, 18, data), 18);
    assert_int_equal(control(d, 0x00, 9, 1, 0, 0, NULL), SIM_STALL);
    assert_int_equal(control(d, 0x80, 8, 0, 0, 1, data), SIM_STALL);
    assert_int_equal(control(d, 0x80, 0, 0, 0, 2, data), SIM_STALL);
    assert_int_equal(control(d, 0x00, 5, 1, 0, 0, NULL), 0); /* address state */
    assert_int_equal(control(d, 0x80, 8, 0, 0, 1, data), 1);
    assert_int_equal(data[0], 0);
    assert_int_equal(control(d, 0x80, 0, 0, 0, 2, data), 2);
    assert_int_equal(data[0] | data[1], 0); /* bus powered */
    assert_int_equal(control(d, 0x82, 0, 0, 0x00, 2, data), 2);
    assert_int_equal(control(d, 0x82, 0, 0, 0x81, 2, data), SIM_STALL);
    assert_int_equal(control(d, 0x81, 0, 0, 0, 2, data), SIM_STALL);
    assert_int_equal(control(d, 0x81, 10, 0, 0, 1, data), SIM_STALL);
    assert_int_equal(control(d, 0x01, 11, 0, 0, 0, NULL), SIM_STALL);
    assert_int_equal(control(d, 0x02, 1, 0, 0x81, 0, NULL), SIM_STALL);
    assert_int_equal(control(d, 0x00, 9, 2, 0, 0, NULL), SIM_STALL);
    assert_int_equal(control(d, 0x00, 9, 1, 0, 0, NULL), 0); /* configured state */
    assert_int_equal(control(d, 0x80, 8, 0, 0, 1, data), 1);
    assert_int_equal(data[0], 1);
    assert_int_equal(control(d, 0x81, 0, 0, 0, 2, data), 2);
    assert_int_equal(control(d, 0x81, 0, 0, 1, 2, data), SIM_STALL);
    assert_int_equal(control(d, 0x81, 10, 0, 0, 1, data), 1);
    assert_int_equal(data[0], 0);
    assert_int_equal(control(d, 0x01, 11, 0, 0, 0, NULL), 0);
    assert_int_equal(control(d, 0x01, 11, 1, 0, 0, NULL), SIM_STALL);
    assert_int_equal(control(d, 0x00, 5, 9, 0, 0, NULL), SIM_STALL);
    assert_int_equal(control(d, 0x00, 9, 0x101, 0, 0, NULL), SIM_STALL);
    assert_int_equal(control(d, 0x00, 9, 0, 0, 0, NULL), 0); /* back to the address state: no bulk transfers */
    assert_int_equal(sim_out(d->board, 1, "x", 1), SIM_STALL);
    assert_int_equal(sim_in(d->board, 0x81, data, 64), SIM_STALL);
    assert_int_equal(control(d, 0x82, 0, 0, 0x81, 2, data), SIM_STALL);
    assert_int_equal(control(d, 0x80, 8, 0, 0, 1, data), 1);
    assert_int_equal(data[0], 0);
    sim_device_destroy(d);
}

static void windows_finds_winusb_by_the_descriptors(void **state)
{
    static const uint8_t bos[33] = {5,    15,   33,   0,    1,    28,   16,   5,    0,    0xdf, 0x60,
                                    0xdd, 0xd8, 0x89, 0x45, 0xc7, 0x4c, 0x9c, 0xd2, 0x65, 0x9d, 0x9e,
                                    0x64, 0x8a, 0x9f, 0x00, 0x00, 0x03, 0x06, 162,  0,    0x20, 0};
    static const uint8_t head[52] = {10,  0,   0,   0, 0,   0, 3,   6, 162, 0, 20,  0, 3,   0, 'W', 'I', 'N', 'U',
                                     'S', 'B', 0,   0, 0,   0, 0,   0, 0,   0, 0,   0, 132, 0, 4,   0,   7,   0,
                                     42,  0,   'D', 0, 'e', 0, 'v', 0, 'i', 0, 'c', 0, 'e', 0, 'I', 0};
    static const char name[] = "DeviceInterfaceGUIDs", guid[] = "{6D3B1F6E-52C4-4F0B-9E0B-5C1A7E2D9A41}";
    (void)state;
    for (int speed = 0; speed < 2; speed++) {
        struct sim_device *d = fixture_device(speed, false);
        uint8_t data[512];
        assert_int_equal(descriptor(d, 15, 0, 5, data), 5); /* hosts ask for the header first */
        assert_memory_equal(data, bos, 5);
        assert_int_equal(descriptor(d, 15, 0, 255, data), sizeof bos);
        assert_memory_equal(data, bos, sizeof bos);
        for (unsigned length = 1; length < 300; length++) {
            memset(data, 0xa5, sizeof data);
            unsigned n = (unsigned)control(d, 0xc0, 0x20, 0, 7, length, data);
            assert_int_equal(n, length < 162 ? length : 162);
            assert_int_equal(data[n], 0xa5);
        }
        assert_memory_equal(data, head, sizeof head);
        for (size_t i = 0; i < sizeof name; i++)
            assert_int_equal(data[38 + 2 * i] | data[39 + 2 * i] << 8, name[i]);
        assert_int_equal(data[80] | data[81] << 8, 80);
        for (size_t i = 0; i < sizeof guid; i++)
            assert_int_equal(data[82 + 2 * i] | data[83 + 2 * i] << 8, guid[i]);
        assert_int_equal(data[160] | data[161], 0); /* the list of strings ends with an empty one */
        sim_device_destroy(d);
    }
}

/* A read of no bytes has no data stage, whatever its direction bit says. */
static void read_of_nothing_goes_straight_to_its_status(void **state)
{
    struct sim_device *d = fixture_device(false, false);
    static const uint8_t setup[8] = {0x80, 6, 0, 1, 0, 0, 0, 0};
    uint8_t data[64];
    (void)state;
    sim_setup(d->board, setup);
    sim_device_poll(d);
    assert_int_equal(sim_in(d->board, 0x80, data, 64), 0);
    sim_device_poll(d);
    assert_int_equal(sim_in(d->board, 0x80, data, 64), SIM_NAK);
    assert_int_equal(descriptor(d, 1, 0, 18, data), 18);
    sim_device_destroy(d);
}

/* A controller with no room for some calls, whose packets the host takes in the call that queues them. */
static struct {
    const struct hal *hal;
    struct sim *board;
    int no_room, sets;
} quick;

static int quick_write(void *ctx, uint8_t endpoint, const void *data, size_t bytes)
{
    uint8_t packet[64];
    if (quick.no_room-- > 0)
        return HAL_AGAIN;
    int result = quick.hal->usb_write(ctx, endpoint, data, bytes);
    sim_in(quick.board, endpoint, packet, sizeof packet);
    return result;
}

static void quick_set_address(void *ctx, uint8_t address)
{
    quick.sets++;
    quick.hal->usb_set_address(ctx, address);
}

static void address_is_known_before_its_status_packet_is_queued(void **state)
{
    static const uint8_t setup[8] = {0x00, 5, 42};
    (void)state;
    for (int no_room = 0; no_room < 3; no_room++) {
        struct sim_device *d = fixture_device(false, false);
        struct hal hal = *d->app.hal;
        quick.hal = d->app.hal;
        quick.board = d->board;
        quick.no_room = no_room;
        quick.sets = 0;
        hal.usb_write = quick_write;
        hal.usb_set_address = quick_set_address;
        d->app.usb.hal = &hal;
        sim_bus_reset(d->board);
        sim_device_poll(d);
        sim_setup(d->board, setup);
        for (int i = 0; i < no_room; i++) {
            sim_device_poll(d);
            assert_int_equal(d->app.usb.state, USB_STATE_DEFAULT);
            assert_int_equal(sim_address(d->board), 0);
        }
        sim_device_poll(d);
        assert_int_equal(sim_address(d->board), 42);
        assert_int_equal(d->app.usb.state, USB_STATE_ADDRESS);
        assert_int_equal(quick.sets, no_room + 1);
        sim_device_destroy(d);
    }
}

/* The address state begins with the status stage of SET_ADDRESS, not before. */
static void unfinished_set_address_changes_no_state(void **state)
{
    struct sim_device *d = fixture_device(false, false);
    static const uint8_t address[8] = {0x00, 5, 9}, configure[8] = {0x00, 9, 1};
    uint8_t data[64];
    (void)state;
    sim_bus_reset(d->board);
    sim_device_poll(d);
    sim_setup(d->board, address); /* and another SETUP before the firmware sees it */
    sim_setup(d->board, configure);
    sim_device_poll(d);
    assert_int_equal(sim_in(d->board, 0x80, data, 64), SIM_STALL);
    assert_int_equal(d->app.usb.state, USB_STATE_DEFAULT);
    assert_int_equal(control(d, 0x00, 5, 0, 0, 0, NULL), 0); /* address 0 stays in the default state */
    assert_int_equal(d->app.usb.state, USB_STATE_DEFAULT);
    assert_int_equal(control(d, 0x00, 5, 9, 0, 0, NULL), 0);
    assert_int_equal(d->app.usb.state, USB_STATE_ADDRESS);
    assert_int_equal(control(d, 0x00, 5, 0, 0, 0, NULL), 0); /* and leads back to it */
    assert_int_equal(d->app.usb.state, USB_STATE_DEFAULT);
    sim_device_destroy(d);
}

/* Every request there is and many there are not, in every state: each is answered or stalled, never left hanging, and the
 * next one is served. */
static void every_request_ends_in_every_state(void **state)
{
    static const uint16_t indices[] = {0x00, 0x01, 0x80, 0x81, 0x02, 0x100};
    struct sim_device *d = fixture_device(true, false);
    (void)state;
    for (int stage = 0; stage < 3; stage++)
        for (unsigned type = 0; type < 256; type += type % 32 == 3 ? 29 : 1) /* recipients 0 to 3 of every type */
            for (unsigned request = 0; request < 14; request++)
                for (size_t i = 0; i < sizeof indices / sizeof *indices; i++)
                    for (unsigned value = 0; value < 3; value++) {
                        uint8_t data[256] = {0};
                        sim_bus_reset(d->board);
                        if (stage > 0)
                            assert_int_equal(control(d, 0x00, 5, 7, 0, 0, NULL), 0);
                        if (stage > 1)
                            assert_int_equal(control(d, 0x00, 9, 1, 0, 0, NULL), 0);
                        unsigned length = type & 0x80 ? 1 + value % 2 : 0;
                        int n = control(d, type, request, value, indices[i], length, data);
                        assert_true(n == SIM_STALL || (n >= 0 && n <= (int)length));
                        assert_true(stage > 0 || n == SIM_STALL || request == 5 || request == 6);
                        assert_int_equal(descriptor(d, 1, 0, 18, data), 18);
                    }
    sim_device_destroy(d);
}

/* Pulled or reset after any number of steps of any stage of any state, the device enumerates again and serves. */
static void unplug_and_reset_at_any_moment(void **state)
{
    static const uint8_t setups[][8] = {
        {0x80, 6, 3, 3, 9, 4, 255, 0}, {0xc0, 0x20, 0, 0, 7, 0, 162, 0}, {0x00, 5, 99, 0, 0, 0, 0, 0},
        {0x00, 9, 1, 0, 0, 0, 0, 0},   {0x02, 3, 0, 0, 0x81, 0, 0, 0},   {0x02, 3, 0, 0, 0x01, 0, 0, 0},
        {0x01, 11, 0, 0, 0, 0, 0, 0},  {0x00, 9, 0, 0, 0, 0, 0, 0},      {0x80, 0, 0, 0, 0, 0, 2, 0},
    };
    (void)state;
    for (size_t s = 0; s < sizeof setups / sizeof *setups; s++)
        for (int stage = 0; stage < 3; stage++)
            for (int steps = 0; steps < 6; steps++)
                for (int how = 0; how < 3; how++) {
                    struct sim_device *d = fixture_device(how == 1, false);
                    struct usb_header h;
                    uint8_t data[256];
                    sim_bus_reset(d->board);
                    if (stage > 0)
                        control(d, 0x00, 5, 7, 0, 0, NULL);
                    if (stage > 1)
                        control(d, 0x00, 9, 1, 0, 0, NULL);
                    sim_setup(d->board, setups[s]);
                    for (int i = 0; i < steps; i++) {
                        sim_device_poll(d);
                        if (i % 2)
                            sim_in(d->board, 0x80, data, 64);
                    }
                    if (how < 2)
                        sim_unplug(d->board);
                    else
                        sim_bus_reset(d->board);
                    if (steps % 2)
                        sim_device_poll(d);
                    assert_int_equal(sim_address(d->board), 0);
                    assert_int_equal(sim_device_enumerate(d, data), 50);
                    assert_int_equal(control(d, 0x82, 0, 0, 0x81, 2, data), 2);
                    assert_int_equal(data[0], 0); /* no halt is left */
                    assert_true(sim_device_request(d, USB_MSG_INFO, NULL, 0, &h, NULL, 0));
                    sim_device_destroy(d);
                }
}

static void halt_is_set_reported_and_cleared(void **state)
{
    struct sim_device *d = fixture_device(false, false);
    uint8_t data[64];
    (void)state;
    for (unsigned endpoint = 0x01; endpoint <= 0x81; endpoint += 0x80) {
        assert_int_equal(control(d, 0x02, 3, 0, endpoint, 0, NULL), 0);
        assert_int_equal(control(d, 0x82, 0, 0, endpoint, 2, data), 2);
        assert_int_equal(data[0], 1);
        assert_int_equal(control(d, 0x82, 0, 0, endpoint ^ 0x80, 2, data), 2);
        assert_int_equal(data[0], 0);
        assert_int_equal(endpoint == 1 ? sim_out(d->board, 1, "x", 1) : sim_in(d->board, 0x81, data, 64), SIM_STALL);
        assert_int_equal(control(d, 0x02, 1, 0, endpoint, 0, NULL), 0);
        assert_int_equal(control(d, 0x82, 0, 0, endpoint, 2, data), 2);
        assert_int_equal(data[0], 0);
        assert_int_equal(endpoint == 1 ? sim_out(d->board, 1, "x", 1) : sim_in(d->board, 0x81, data, 64),
                         endpoint == 1 ? 1 : SIM_NAK);
    }
    assert_int_equal(control(d, 0x02, 3, 0, 0x01, 0, NULL), 0);
    assert_int_equal(control(d, 0x00, 9, 1, 0, 0, NULL), 0); /* configuring clears halts, too */
    assert_int_equal(control(d, 0x82, 0, 0, 0x01, 2, data), 2);
    assert_int_equal(data[0], 0);
    sim_device_destroy(d);
}

static void unknown_requests_stall_and_the_next_one_is_served(void **state)
{
    static const uint8_t unknown[][8] = {
        {0x80, 6, 1, 15, 0, 0, 5, 0},                                     /* a second BOS */
        {0x80, 6, 0xee, 3, 0, 0, 18, 0},                                  /* Microsoft's first try, a string */
        {0xc0, 0x20, 0, 0, 8, 0, 162, 0},                                 /* other indices of Microsoft's request */
        {0xc0, 0x20, 1, 0, 7, 0, 162, 0},                                 /* with a value */
        {0xc1, 0x20, 0, 0, 7, 0, 162, 0},                                 /* to the interface */
        {0x40, 0x20, 0, 0, 8, 0, 0, 0},                                   /* alternative enumeration */
        {0xa0, 0, 0, 0, 0, 0, 2, 0},                                      /* class request with a standard number */
        {0x80, 6, 0, 0x22, 0, 0, 9, 0},                                   /* HID report */
        {0x00, 7, 0, 1, 0, 0, 18, 0},                                     /* SET_DESCRIPTOR, with data */
        {0x00, 3, 1, 0, 0, 0, 0, 0},                                      /* remote wake-up: not offered, so */
        {0x00, 1, 1, 0, 0, 0, 0, 0},                                      /* neither set nor cleared (9.4.1, 9.4.9) */
        {0x00, 3, 2, 0, 0, 1, 0, 0},                                      /* test mode */
        {0x02, 3, 0, 0, 2, 0, 0, 0},                                      /* halt of an endpoint there is not */
        {0x02, 3, 1, 0, 1, 0, 0, 0},                                      /* other feature of an endpoint */
        {0x82, 12, 0, 0, 0x81, 0, 2, 0},  {0xc0, 1, 0, 0, 0, 0, 8, 0},    /* vendor */
        {0x40, 1, 0, 0, 0, 0, 0, 0},      {0x21, 0x22, 0, 0, 0, 0, 0, 0}, /* class */
        {0x80, 5, 0, 0, 0, 0, 0, 0},      {0x00, 9, 1, 0, 0, 0, 4, 0},    /* SET_CONFIGURATION with data */
        {0x80, 0, 0, 0, 0, 0, 1, 0},                                      /* GET_STATUS of one byte */
        {0x83, 0, 0, 0, 0, 0, 2, 0},
    };
    struct sim_device *d = fixture_device(false, false);
    uint8_t data[256] = {0};
    (void)state;
    for (size_t i = 0; i < sizeof unknown / sizeof *unknown; i++) {
        assert_int_equal(sim_device_control(d, unknown[i], data), SIM_STALL);
        assert_int_equal(descriptor(d, 1, 0, 18, data), 18);
    }
    sim_device_destroy(d);
}

static void new_setup_replaces_an_unfinished_transfer(void **state)
{
    static const uint8_t string[8] = {0x80, 6, 3, 3, 9, 4, 255, 0}, address[8] = {0x00, 5, 99};
    struct sim_device *d = fixture_device(false, false);
    uint8_t data[64];
    (void)state;
    sim_setup(d->board, string);
    sim_device_poll(d);
    assert_int_equal(descriptor(d, 1, 0, 18, data), 18);
    assert_int_equal(data[0], 18);
    sim_bus_reset(d->board);
    sim_setup(d->board, address);
    sim_device_poll(d); /* its status stage is never fetched */
    assert_int_equal(descriptor(d, 1, 0, 18, data), 18);
    assert_int_equal(sim_address(d->board), 0);
    sim_device_destroy(d);
}

/* The next SETUP arrives between two steps of the firmware on endpoint 0, before each of its calls in turn. */
static struct {
    const struct hal *hal;
    struct sim *board;
    int calls; /* until it arrives */
} busy;

static void busy_call(void)
{
    static const uint8_t device[8] = {0x80, 6, 0, 1, 0, 0, 18, 0};
    if (busy.calls-- == 0)
        sim_setup(busy.board, device);
}

static int busy_write(void *ctx, uint8_t endpoint, const void *data, size_t bytes)
{
    busy_call();
    return busy.hal->usb_write(ctx, endpoint, data, bytes);
}

static void busy_stall(void *ctx, uint8_t endpoint, bool stalled)
{
    busy_call();
    busy.hal->usb_stall(ctx, endpoint, stalled);
}

static void busy_set_address(void *ctx, uint8_t address)
{
    busy_call();
    busy.hal->usb_set_address(ctx, address);
}

static void setup_in_the_midst_of_a_step_gets_its_own_answer(void **state)
{
    static const uint8_t before[][8] = {
        {0x80, 6, 3, 3, 9, 4, 255, 0}, {0xc0, 0x20, 0, 0, 7, 0, 162, 0}, {0x00, 5, 99}, {0x00, 7, 0, 1}};
    struct sim_device *d = fixture_device(false, false);
    struct hal hal = *d->app.hal;
    uint8_t data[64];
    (void)state;
    busy.hal = d->app.hal;
    busy.board = d->board;
    hal.usb_write = busy_write;
    hal.usb_stall = busy_stall;
    hal.usb_set_address = busy_set_address;
    for (size_t i = 0; i < sizeof before / sizeof *before; i++)
        for (int calls = 0; calls < 4; calls++) {
            d->app.usb.hal = busy.hal;
            sim_bus_reset(d->board);
            sim_device_poll(d);
            sim_setup(d->board, before[i]);
            d->app.usb.hal = &hal;
            busy.calls = calls;
            sim_device_poll(d);
            if (busy.calls >= 0) /* not so many calls */
                continue;
            busy.calls = -1;
            for (int n = 0; n < 3; n++)
                sim_device_poll(d);
            assert_int_equal(sim_in(d->board, 0x80, data, 64), 18);
            assert_int_equal(data[1], 1);
            assert_int_equal(sim_in(d->board, 0x80, data, 64), SIM_NAK);
            assert_int_equal(sim_out(d->board, 0x00, NULL, 0), 0);
            assert_int_equal(sim_address(d->board), 0);
        }
    d->app.usb.hal = busy.hal;
    sim_device_destroy(d);
}

/* Suspend is a bus without any activity. Whatever was under way stays as it is, however long, and goes on (9.1.1.6): address,
 * configuration, halts, an upload, half a message, half a control transfer. */
static void suspend_at_any_moment_changes_nothing(void **state)
{
    static const uint8_t string[8] = {0x80, 6, 3, 3, 9, 4, 255, 0}, status[8] = {0x80, 0, 0, 0, 0, 0, 2, 0};
    const struct usb_begin begin = {1, USB_SLOT_TABLE, 5000, 0x12345678};
    const uint8_t message[4 + 100] = {0};
    struct sim_device *d = fixture_device(true, true);
    struct usb_header h;
    struct usb_info info;
    size_t bytes;
    uint8_t data[256];
    (void)state;
    void *scene = fixture_scene(&bytes);
    assert_true(sim_device_push(d, 0, USB_SLOT_SCENE, scene, (uint32_t)bytes, &h) && h.status == USB_OK);
    assert_int_equal(control(d, 0x80, 0, 0, 0, 2, data), 2);
    assert_int_equal(data[0], 0); /* bus powered, and nothing that would let it wake the host up */
    assert_true(sim_device_request(d, USB_MSG_BEGIN, &begin, sizeof begin, &h, NULL, 0) && h.status == USB_OK);
    assert_true(sim_device_request(d, USB_MSG_DATA, message, sizeof message, &h, NULL, 0) && h.status == USB_OK);
    for (int moment = 0; moment < 4; moment++) {
        assert_int_equal(control(d, 0x02, moment % 2 ? 3 : 1, 0, 0x81, 0, NULL), 0);
        if (moment == 1) /* between SETUP and data */
            sim_setup(d->board, string);
        if (moment == 2) { /* between data and status */
            sim_setup(d->board, status);
            sim_device_poll(d);
            assert_int_equal(sim_in(d->board, 0x80, data, 64), 2);
        }
        if (moment == 3) /* in the middle of a header */
            assert_int_equal(sim_out(d->board, 1, "GT", 2), 2);
        for (int i = 0; i < 5000; i++)
            sim_device_poll(d);
        if (moment == 1)
            assert_int_equal(sim_in(d->board, 0x80, data, 64), 24);
        assert_int_equal(sim_address(d->board), 1);
        assert_int_equal(control(d, 0x80, 8, 0, 0, 1, data), 1);
        assert_int_equal(data[0], 1);
        assert_int_equal(control(d, 0x82, 0, 0, 0x81, 2, data), 2);
        assert_int_equal(data[0], moment % 2);
    }
    assert_int_equal(d->app.protocol.filled, 2); /* still there; a host that opens the device drops it */
    assert_int_equal(control(d, 0x02, 1, 0, 0x01, 0, NULL), 0);
    assert_int_equal(control(d, 0x02, 1, 0, 0x81, 0, NULL), 0);
    assert_true(sim_device_request(d, USB_MSG_INFO, NULL, 0, &h, &info, sizeof info) && h.status == USB_OK);
    assert_int_equal(info.upload_slot, 1);
    assert_int_equal(info.upload_received, 100);
    free(scene);
    sim_device_destroy(d);
}

static void unplugged_device_is_gone_and_comes_back(void **state)
{
    struct sim_device *d = fixture_device(true, false);
    uint8_t data[64];
    (void)state;
    sim_unplug(d->board);
    assert_int_equal(descriptor(d, 1, 0, 18, data), SIM_GONE);
    assert_int_equal(sim_out(d->board, 1, "x", 1), SIM_GONE);
    assert_int_equal(sim_in(d->board, 0x81, data, 64), SIM_GONE);
    sim_device_poll(d);
    assert_int_equal(sim_device_enumerate(d, data), 50);
    assert_int_equal(sim_address(d->board), 1);
    sim_device_destroy(d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(device_descriptor_is_exact),
        cmocka_unit_test(configuration_follows_the_speed),
        cmocka_unit_test(capable_device_at_full_speed_tells_of_the_other_speed),
        cmocka_unit_test(strings_name_maker_product_and_serial_number),
        cmocka_unit_test(full_packet_that_ends_early_is_followed_by_an_empty_one),
        cmocka_unit_test(address_takes_effect_after_the_status_stage),
        cmocka_unit_test(states_allow_what_chapter_9_says),
        cmocka_unit_test(windows_finds_winusb_by_the_descriptors),
        cmocka_unit_test(read_of_nothing_goes_straight_to_its_status),
        cmocka_unit_test(address_is_known_before_its_status_packet_is_queued),
        cmocka_unit_test(unfinished_set_address_changes_no_state),
        cmocka_unit_test(every_request_ends_in_every_state),
        cmocka_unit_test(unplug_and_reset_at_any_moment),
        cmocka_unit_test(halt_is_set_reported_and_cleared),
        cmocka_unit_test(unknown_requests_stall_and_the_next_one_is_served),
        cmocka_unit_test(new_setup_replaces_an_unfinished_transfer),
        cmocka_unit_test(setup_in_the_midst_of_a_step_gets_its_own_answer),
        cmocka_unit_test(suspend_at_any_moment_changes_nothing),
        cmocka_unit_test(unplugged_device_is_gone_and_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
