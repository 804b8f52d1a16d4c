/*
 * UART and clock of the MPS2 and MPS3 boards. Addresses and the clock's ratio come from the linker script.
 *
 * Under `-icount shift=6` an instruction takes 64 ns, which is 1.28 to 2.05 ticks of the board's timer: more than
 * one, so that a difference of ticks tells instructions to within one.
 */
#include "board.h"
#include "mps2.h"

extern volatile uint32_t mps2_uart[];
extern uint8_t mps2_clock_mul[], mps2_clock_shift[];

enum { UART_DATA = 0, UART_STATE = 1, UART_CONTROL = 2, UART_DIVIDER = 4 };

static struct {
    uint64_t ticks;
    uint32_t last;
} clock_state;

void board_init(void)
{
    mps2_uart[UART_CONTROL] = 1; /* transmit */
    mps2_uart[UART_DIVIDER] = 16;
    timer_start();
    clock_state.last = timer_now();
}

uint32_t board_clock(void)
{
    uint32_t now = timer_now();
    clock_state.ticks += now - clock_state.last;
    clock_state.last = now;
    return (uint32_t)(clock_state.ticks * (uintptr_t)mps2_clock_mul >> (uintptr_t)mps2_clock_shift);
}

void board_put(char c)
{
    while (mps2_uart[UART_STATE] & 1)
        ;
    mps2_uart[UART_DATA] = (uint8_t)c;
}
