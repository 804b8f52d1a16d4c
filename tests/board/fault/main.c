/*
 * Does what a fault handler must catch: the first byte at board_input says what. Prints "survived" when nothing caught it.
 */
#include "board.h"

/* Writes every frame, so that none is skipped; asks for 64 MB. */
__attribute__((noinline, noclone)) static uint32_t overflow(uint32_t depth)
{
    volatile uint32_t frame[16];
    for (uint32_t i = 0; i < 16; i++)
        frame[i] = depth;
    return depth == 1000000 ? 0 : overflow(depth + 1) + frame[depth % 16];
}

_Noreturn void board_main(void)
{
    volatile uint32_t *null = NULL;
    uint32_t result = 0;
    __asm__("" : "+r"(null)); /* the compiler is not to know */
    switch (board_input[0]) {
    case 's':
        result = overflow(1);
        break;
    case 'r':
        result = *null;
        break;
    case 'w':
        *null = 1;
        break;
    default:
        report_failure("no such fault");
    }
    report_text("survived");
    report_number("result", result);
    report_text("\n");
    board_exit(BOARD_EXIT_OK);
}
