/* The system counter of the SSE-300, seen through timer 0: 64 bits, of which the low 32 do. */
#include "mps2.h"

extern volatile uint32_t mps2_counter[];

void timer_start(void)
{
    mps2_counter[0] = 1;
}

uint32_t timer_now(void)
{
    return mps2_timer[0];
}
