/* lm3s6965.img, made beforehand, is found through the assembler's include path. */
    .section .flash_image, "a"
    .balign 1024
    .global lm3s6965_image, lm3s6965_image_end
lm3s6965_image:
    .incbin "lm3s6965.img"
lm3s6965_image_end:
