/* The CMSDK timer 0: 32 bits, counting down. */
#include "mps2.h"

enum { CONTROL = 0, VALUE = 1, RELOAD = 2 };

void timer_start(void)
{
    mps2_timer[RELOAD] = UINT32_MAX;
    mps2_timer[VALUE] = UINT32_MAX;
    mps2_timer[CONTROL] = 1;
}

uint32_t timer_now(void)
{
    return ~mps2_timer[VALUE];
}
