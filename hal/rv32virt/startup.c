/*
 * Startup of the riscv32 `virt` machine in machine mode: stacks and their guard, traps.
 *
 * The end of the stack is a region of the physical memory protection that allows nothing, locked so that it binds
 * machine mode. Nothing answers at address 0: an access there traps by itself. Traps have a stack of their own.
 */
#include "board.h"

extern uint8_t rv32_guard[], rv32_guard_bytes[];
extern uint32_t rv32_bss_start[], rv32_bss_end[], rv32_fault_stack_top[];

#define PMP_LOCKED 0x80u
#define PMP_NAPOT  0x18u /* a power-of-two region; read, write, execute: none */

#define CSR_READ(value, csr)  __asm__ volatile("csrr %0, " #csr : "=r"(value))
#define CSR_WRITE(csr, value) __asm__ volatile("csrw " #csr ", %0" ::"r"(value))

void rv32_reset(void);

__attribute__((naked, section(".reset"))) void rv32_reset(void)
{
    __asm__("la sp, board_stack_top\n"
            "j rv32_start\n");
}

__attribute__((used)) static void fault_report(void)
{
    uint32_t value;
    report_text("fault");
    CSR_READ(value, mcause);
    report_number("cause", value);
    CSR_READ(value, mtval);
    report_hex("address", value);
    if (value - (uintptr_t)rv32_guard < (uintptr_t)rv32_guard_bytes)
        report_text(" stack overflow");
    CSR_READ(value, mepc);
    report_hex("pc", value);
    report_text("\n");
    board_exit(BOARD_EXIT_FAULT);
}

/* Compressed code may place it at odd halfwords, mtvec may not. */
__attribute__((naked, aligned(4))) static void fault(void)
{
    __asm__("la sp, rv32_fault_stack_top\n"
            "j %0\n"
            :
            : "i"(fault_report));
}

__attribute__((used)) void rv32_start(void)
{
    uint32_t *here;
    __asm__ volatile("mv %0, sp" : "=r"(here));
    CSR_WRITE(mtvec, fault);
    for (uint32_t *p = board_stack_bottom; p < here; p++)
        *(volatile uint32_t *)p = BOARD_STACK_PAINT;
    for (uint32_t *p = rv32_bss_start; p < rv32_bss_end; p++)
        *p = 0;
    CSR_WRITE(pmpaddr0, (uintptr_t)rv32_guard >> 2 | ((uintptr_t)rv32_guard_bytes / 8 - 1));
    CSR_WRITE(pmpcfg0, PMP_LOCKED | PMP_NAPOT);
    board_init();
    board_main();
}
