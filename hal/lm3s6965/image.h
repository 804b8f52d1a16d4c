/* The flash image linked into flash: the store's banks, two for the scene, two for one table of 91 x 46 x 4. */
#ifndef HAL_LM3S6965_IMAGE_H
#define HAL_LM3S6965_IMAGE_H

#include <stdint.h>

#define IMAGE_SCENE_BANK_BYTES (6u * 4096u)

extern const uint8_t lm3s6965_image[], lm3s6965_image_end[];

#endif
