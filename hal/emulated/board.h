/*
 * What an emulated board gives to the programs that run on it: the firmware's main.c in this folder and the
 * benchmarks in tests/board. Each board implements the first part in its own folder; the second part, in
 * report.c, is the same for all.
 *
 * Startup runs board_main on a stack of BOARD_STACK bytes, filled with BOARD_STACK_PAINT beforehand, whose end
 * is guarded where the core can. A fault prints what is known and leaves the emulator with BOARD_EXIT_FAULT.
 */
#ifndef HAL_EMULATED_BOARD_H
#define HAL_EMULATED_BOARD_H

#include "hal.h"

#define BOARD_STACK_PAINT 0x5aa5c33cu
#define BOARD_EXIT_OK     0u
#define BOARD_EXIT_FAILED 1u
#define BOARD_EXIT_FAULT  70u

/* The flash image at board_input: slot 0 for the scene, six for tables of 361 x 181 x 4. */
#define BOARD_WIDTH            320u
#define BOARD_HEIGHT           240u
#define BOARD_SLOTS            7u
#define BOARD_SCENE_BANK_BYTES (1024u << 10)
#define BOARD_TABLE_BANK_BYTES (1056u << 10)
#define BOARD_FLASH_BYTES      (2 * BOARD_SCENE_BANK_BYTES + 2 * (BOARD_SLOTS - 1) * BOARD_TABLE_BANK_BYTES)

/* From the linker script. External memory: a flash image or other input at its start, preloaded by the emulator,
 * and room for a picture behind it. */
extern const uint8_t board_input[];
extern uint8_t board_picture[];
extern uint32_t board_stack_bottom[], board_stack_top[];

/* Clock and UART on; startup calls it. */
void board_init(void);

/* The program. Startup calls it once; it ends with board_exit. */
_Noreturn void board_main(void);

/* Instructions executed since reset, wrapping at 2^32. To be called at least once in 2^31 instructions. */
uint32_t board_clock(void);

void board_put(char c);
_Noreturn void board_exit(unsigned code);

/* unplugged.c: no cable is ever plugged in, the flash is not for writing. To be copied and completed. */
extern const struct hal board_unplugged;

/* --- report.c --- */

void report_text(const char *text);
void report_number(const char *label, uint32_t value); /* " label value" */
void report_hex(const char *label, uint32_t value);    /* " label 0123abcd" */

/* Says why on a line and leaves the emulator with BOARD_EXIT_FAILED. */
_Noreturn void report_failure(const char *why);

/* FNV-1a, 32 bits. Start with REPORT_HASH_START. */
#define REPORT_HASH_START 2166136261u
uint32_t report_hash(uint32_t hash, const void *data, size_t bytes);

/* Copies a tile into the picture at board_picture, whose rows are `width` pixels long. */
void report_tile(uint16_t x, uint16_t y, uint16_t w, uint16_t h, const void *pixels, uint32_t width,
                 uint32_t pixel_bytes);

/* Bytes of stack used at the deepest so far. */
uint32_t report_stack(void);

#endif
