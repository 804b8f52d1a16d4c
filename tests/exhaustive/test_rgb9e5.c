/* lut_rgb9e5_decode for every one of the 2^32 words. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>

#include "ref_table.h"
#include "rgb9e5.h"

/* The words are composed by counting through their fields, so that no bit is extracted the way decode does. */
static void every_word_decodes_to_its_fields(void **state)
{
    uint32_t word = 0;
    uint64_t words = 0;
    (void)state;
    for (int exponent = 0; exponent < 32; exponent++) {
        uint32_t wrong = 0;
        for (uint32_t blue = 0; blue < 512; blue++) {
            for (uint32_t green = 0; green < 512; green++) {
                for (uint32_t red = 0; red < 512; red++) {
                    struct lut_rgb t = lut_rgb9e5_decode(word + red);
                    wrong |= (t.c[0] ^ red) | (t.c[1] ^ green) | (t.c[2] ^ blue) | (uint32_t)(t.e ^ (exponent - 24));
                }
                word += 512;
                words += 512;
            }
        }
        assert_int_equal(wrong, 0);
    }
    assert_int_equal(word, 0);
    assert_true(words == 1ull << 32);
}

/* mantissa / 512 * 2^(exponent - 15), and the same by summing single bits. */
static void every_mantissa_and_exponent_has_its_value(void **state)
{
    (void)state;
    for (uint32_t exponent = 0; exponent < 32; exponent++) {
        for (uint32_t m = 0; m < 512; m++) {
            for (int channel = 0; channel < 3; channel++) {
                uint32_t word = exponent << 27 | m << (9 * channel) | (0x1ffu & ~m) << (9 * ((channel + 1) % 3));
                struct lut_rgb t = lut_rgb9e5_decode(word);
                double bits[3], value = ldexp(m / 512.0, (int)exponent - 15);
                ref_rgb9e5_decode(bits, word);
                assert_true(ldexp(t.c[channel], t.e) == value);
                assert_true(bits[channel] == value);
            }
        }
    }
    struct lut_rgb largest = lut_rgb9e5_decode(0xffffffff);
    assert_true(ldexp(largest.c[2], largest.e) == 65408);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_word_decodes_to_its_fields),
        cmocka_unit_test(every_mantissa_and_exponent_has_its_value),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
