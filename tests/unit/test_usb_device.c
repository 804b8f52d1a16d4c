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
    static const uint8_t expected[18] = {18,   1,    0x00, 0x02, 0,    0, 0, 64, 0x09,
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

    static const uint8_t qualifier[10] = {10, 6, 0x00, 0x02, 0, 0, 0, 64, 1, 0};
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
    assert_int_equal(control(d, 0x00, 9, 0, 0, 0, NULL), 0); /* back to the address state */
    assert_int_equal(control(d, 0x80, 8, 0, 0, 1, data), 1);
    assert_int_equal(data[0], 0);
    sim_device_destroy(d);
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
        {0x80, 6, 0, 15, 0, 0, 5, 0},                                    /* BOS */
        {0x80, 6, 0, 0x22, 0, 0, 9, 0},                                  /* HID report */
        {0x00, 7, 0, 1, 0, 0, 18, 0},                                    /* SET_DESCRIPTOR, with data */
        {0x00, 3, 1, 0, 0, 0, 0, 0},                                     /* remote wake-up */
        {0x00, 3, 2, 0, 0, 1, 0, 0},                                     /* test mode */
        {0x02, 3, 0, 0, 2, 0, 0, 0},                                     /* halt of an endpoint there is not */
        {0x02, 3, 1, 0, 1, 0, 0, 0},                                     /* other feature of an endpoint */
        {0x82, 12, 0, 0, 0x81, 0, 2, 0}, {0xc0, 1, 0, 0, 0, 0, 8, 0},    /* vendor */
        {0x40, 1, 0, 0, 0, 0, 0, 0},     {0x21, 0x22, 0, 0, 0, 0, 0, 0}, /* class */
        {0x80, 5, 0, 0, 0, 0, 0, 0},     {0x00, 9, 1, 0, 0, 0, 4, 0},    /* SET_CONFIGURATION with data */
        {0x80, 0, 0, 0, 0, 0, 1, 0},                                     /* GET_STATUS of one byte */
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
        cmocka_unit_test(strings_name_maker_product_and_serial_number),
        cmocka_unit_test(full_packet_that_ends_early_is_followed_by_an_empty_one),
        cmocka_unit_test(address_takes_effect_after_the_status_stage),
        cmocka_unit_test(states_allow_what_chapter_9_says),
        cmocka_unit_test(halt_is_set_reported_and_cleared),
        cmocka_unit_test(unknown_requests_stall_and_the_next_one_is_served),
        cmocka_unit_test(new_setup_replaces_an_unfinished_transfer),
        cmocka_unit_test(unplugged_device_is_gone_and_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
