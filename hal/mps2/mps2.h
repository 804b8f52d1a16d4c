/* What the files of this folder share. Addresses come from the board's linker script. */
#ifndef HAL_MPS2_MPS2_H
#define HAL_MPS2_MPS2_H

#include <stdint.h>

extern volatile uint32_t mps2_timer[];

/* timer_cmsdk.c or timer_sse.c. Ticks, counting up, wrapping at 2^32. */
void timer_start(void);
uint32_t timer_now(void);

#endif
