#include "board.h"

void report_text(const char *text)
{
    while (*text)
        board_put(*text++);
}

void report_number(const char *label, uint32_t value)
{
    char digits[11], *d = digits + sizeof digits - 1;
    *d = 0;
    do {
        *--d = (char)('0' + value % 10);
        value /= 10;
    } while (value);
    board_put(' ');
    report_text(label);
    board_put(' ');
    report_text(d);
}

void report_hex(const char *label, uint32_t value)
{
    board_put(' ');
    report_text(label);
    board_put(' ');
    for (int shift = 28; shift >= 0; shift -= 4)
        board_put("0123456789abcdef"[value >> shift & 15]);
}

_Noreturn void report_failure(const char *why)
{
    report_text(why);
    report_text("\n");
    board_exit(BOARD_EXIT_FAILED);
}

uint32_t report_hash(uint32_t hash, const void *data, size_t bytes)
{
    const uint8_t *p = data;
    while (bytes--)
        hash = (hash ^ *p++) * 16777619u;
    return hash;
}

void report_tile(uint16_t x, uint16_t y, uint16_t w, uint16_t h, const void *pixels, uint32_t width,
                 uint32_t pixel_bytes)
{
    for (uint32_t row = 0; row < h; row++)
        __builtin_memcpy(board_picture + ((y + row) * width + x) * pixel_bytes,
                         (const uint8_t *)pixels + row * w * pixel_bytes, w * pixel_bytes);
}

uint32_t report_stack(void)
{
    const uint32_t *p = board_stack_bottom;
    while (*p == BOARD_STACK_PAINT)
        p++;
    return (uint32_t)(board_stack_top - p) * 4;
}
