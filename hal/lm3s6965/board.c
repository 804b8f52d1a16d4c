/*
 * UART and clock of the LM3S6965 evaluation board under QEMU.
 *
 * The clock is SysTick: 24 bits at 12.5 MHz. Under `-icount shift=7` an instruction takes 128 ns, 1.6 ticks: ticks tell
 * instructions to within one. board_clock is to be called at least once in 2^24 ticks, 10.4 million instructions.
 */
#include "board.h"

#define REGISTER(address) (*(volatile uint32_t *)(uintptr_t)(address))

#define SYSTICK_CONTROL 0xe000e010u
#define SYSTICK_RELOAD  0xe000e014u
#define SYSTICK_VALUE   0xe000e018u
#define SYSTICK_MASK    0xffffffu
#define UART0_DATA      0x4000c000u
#define UART0_FLAGS     0x4000c018u
#define UART0_CONTROL   0x4000c030u
#define UART_FULL       0x20u

static struct {
    uint64_t ticks;
    uint32_t last;
} clock_state;

void board_init(void)
{
    REGISTER(UART0_CONTROL) = 0x301; /* on, transmit, receive */
    REGISTER(SYSTICK_RELOAD) = SYSTICK_MASK;
    REGISTER(SYSTICK_VALUE) = 0;
    REGISTER(SYSTICK_CONTROL) = 5; /* on, processor clock, no interrupt */
    clock_state.last = REGISTER(SYSTICK_VALUE);
}

uint32_t board_clock(void)
{
    uint32_t now = REGISTER(SYSTICK_VALUE);
    clock_state.ticks += (clock_state.last - now) & SYSTICK_MASK;
    clock_state.last = now;
    return (uint32_t)(clock_state.ticks * 5 >> 3);
}

void board_put(char c)
{
    while (REGISTER(UART0_FLAGS) & UART_FULL)
        ;
    REGISTER(UART0_DATA) = (uint8_t)c;
}
