/*
 * A board's part of board.h on the host, for programs that are measured on boards: the same pictures must come out. Input comes from standard
 * input, and time stands still.
 */
#include <stdio.h>
#include <stdlib.h>

#define board_input board_h_input /* const there, filled here */
#include "board.h"
#undef board_input

uint8_t board_input[8 << 20], board_picture[BOARD_WIDTH * BOARD_HEIGHT * 3];
uint32_t board_stack_bottom[1], board_stack_top[1];

uint32_t board_clock(void)
{
    return 0;
}

void board_put(char c)
{
    putchar(c);
}

_Noreturn void board_exit(unsigned code)
{
    exit((int)code);
}

int main(void)
{
    if (!fread(board_input, 1, sizeof board_input, stdin))
        return 1;
    board_main();
}
