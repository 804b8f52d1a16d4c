/* The CRC-32 of protocol and flash, against its definition bit by bit. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "crc32.h"

static void crc_is_that_of_ieee_802_3(void **state)
{
    uint8_t data[300];
    uint32_t seed = 1;
    (void)state;
    assert_int_equal(crc32_update(0, "123456789", 9), 0xcbf43926);
    assert_int_equal(crc32_update(0, "", 0), 0);
    for (size_t i = 0; i < sizeof data; i++)
        data[i] = (uint8_t)(seed = seed * 1664525 + 1013904223, seed >> 24);
    uint32_t crc = 0xffffffff;
    for (size_t i = 0; i < sizeof data; i++) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc & 1 ? crc >> 1 ^ 0xedb88320 : crc >> 1;
        assert_int_equal(crc32_update(0, data, i + 1), ~crc);
        assert_int_equal(crc32_update(crc32_update(0, data, i / 3), data + i / 3, i + 1 - i / 3), ~crc);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(crc_is_that_of_ieee_802_3),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
