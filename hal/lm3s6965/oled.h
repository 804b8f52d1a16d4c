/* The board's display: SSD0323, 128 x 64 pixels of 16 greys, on SSI0. */
#ifndef HAL_LM3S6965_OLED_H
#define HAL_LM3S6965_OLED_H

#include <stdint.h>

#define OLED_WIDTH  128u
#define OLED_HEIGHT 64u

void oled_init(void);

/* Shows w x h RGB888 pixels, rows without padding, as grey (BT.601 luma of the encoded values, its upper four bits). In:
 * x and w even, the rectangle inside the display. */
void oled_write(uint16_t x, uint16_t y, uint16_t w, uint16_t h, const uint8_t *rgb);

#endif
