#include "oled.h"

#define REGISTER(address) (*(volatile uint32_t *)(uintptr_t)(address))

/* System control */
#define RCGC1 0x400fe104u
#define RCGC2 0x400fe108u
/* SSI0 */
#define SSI_CONTROL0 0x40008000u
#define SSI_CONTROL1 0x40008004u
#define SSI_DATA     0x40008008u
#define SSI_STATUS   0x4000800cu
#define SSI_PRESCALE 0x40008010u
#define SSI_NOT_FULL 0x02u
#define SSI_RECEIVED 0x04u
#define SSI_BUSY     0x10u
/* GPIO ports A and C: the address carries a mask of the bits written */
#define PORT_A          0x40004000u
#define PORT_C          0x40006000u
#define GPIO_DATA(mask) ((mask) << 2)
#define GPIO_DIRECTION  0x400u
#define GPIO_ALTERNATE  0x420u
#define GPIO_DIGITAL    0x51cu
#define PIN_SELECT      0x08u /* PA3, low: selected */
#define PIN_DATA        0x80u /* PC7, high: data, low: command */
#define PINS_SSI        0x34u /* PA2, PA4, PA5 */

/* SSD0323 commands */
#define COLUMNS 0x15u /* first, last byte of a row */
#define ROWS    0x75u
#define REMAP   0xa0u
#define TURN_ON 0xafu

static void transfer(uint8_t byte)
{
    while (!(REGISTER(SSI_STATUS) & SSI_NOT_FULL))
        ;
    REGISTER(SSI_DATA) = byte;
    while (REGISTER(SSI_STATUS) & SSI_BUSY)
        ;
    while (REGISTER(SSI_STATUS) & SSI_RECEIVED)
        (void)REGISTER(SSI_DATA);
}

static void command(const uint8_t *bytes, uint32_t count)
{
    REGISTER(PORT_C + GPIO_DATA(PIN_DATA)) = 0;
    while (count--)
        transfer(*bytes++);
    REGISTER(PORT_C + GPIO_DATA(PIN_DATA)) = PIN_DATA;
}

void oled_init(void)
{
    static const uint8_t on[] = {REMAP, 0x52, TURN_ON};
    REGISTER(RCGC1) |= 0x10; /* SSI0 */
    REGISTER(RCGC2) |= 0x05; /* ports A and C */
    REGISTER(PORT_A + GPIO_DIRECTION) |= PIN_SELECT;
    REGISTER(PORT_A + GPIO_ALTERNATE) |= PINS_SSI;
    REGISTER(PORT_A + GPIO_DIGITAL) |= PINS_SSI | PIN_SELECT;
    REGISTER(PORT_C + GPIO_DIRECTION) |= PIN_DATA;
    REGISTER(PORT_C + GPIO_DIGITAL) |= PIN_DATA;
    REGISTER(SSI_CONTROL1) = 0;
    REGISTER(SSI_PRESCALE) = 2;
    REGISTER(SSI_CONTROL0) = 7; /* 8 bits */
    REGISTER(SSI_CONTROL1) = 2; /* on */
    REGISTER(PORT_A + GPIO_DATA(PIN_SELECT)) = 0;
    command(on, sizeof on);
}

static uint32_t grey(const uint8_t *rgb)
{
    return (77u * rgb[0] + 150u * rgb[1] + 29u * rgb[2]) >> 12; /* 77 + 150 + 29 = 256: 0..15 */
}

void oled_write(uint16_t x, uint16_t y, uint16_t w, uint16_t h, const uint8_t *rgb)
{
    uint8_t window[] = {COLUMNS, (uint8_t)(x / 2), (uint8_t)((x + w) / 2 - 1), ROWS, (uint8_t)y, (uint8_t)(y + h - 1)};
    command(window, sizeof window);
    for (uint32_t pair = 0; pair < w * h / 2u; pair++, rgb += 6)
        transfer((uint8_t)(grey(rgb) << 4 | grey(rgb + 3)));
}
