/*
 * Startup of a Cortex-M board: vectors, memory, stacks and their guard, faults, exit through semihosting.
 *
 * The program runs on the process stack; faults are served on the main stack, so that they can still be told
 * when the process stack is what failed. ARMv7-M guards the stack's end and the vectors (thus address 0) by two
 * regions of the MPU that allow nothing. ARMv8-M has no such permission: there the stack has a limit register,
 * and the MPU lists what exists, without the vectors.
 */
#include "board.h"

#define REGISTER(address) (*(volatile uint32_t *)(uintptr_t)(address))

#define VTOR        0xe000ed08u
#define SHCSR       0xe000ed24u
#define CFSR        0xe000ed28u
#define HFSR        0xe000ed2cu
#define MMFAR       0xe000ed34u
#define BFAR        0xe000ed38u
#define MPU_CTRL    0xe000ed94u
#define MPU_RNR     0xe000ed98u
#define MPU_RBAR    0xe000ed9cu
#define MPU_RLAR    0xe000eda0u /* v7-M: RASR */
#define MPU_MAIR0   0xe000edc0u
#define ENABLE      1u
#define PRIVDEFENA  4u
#define STACK_LIMIT (1u << 20) /* in CFSR: the stack pointer met its limit */

extern uint8_t cortex_m_guard[], cortex_m_guard_bytes[];
extern uint8_t cortex_m_code_start[], cortex_m_code_bytes[], cortex_m_ram_start[], cortex_m_ram_bytes[];
extern uint8_t cortex_m_external_start[], cortex_m_external_bytes[];
extern uint32_t cortex_m_fault_stack_top[];
extern uint32_t cortex_m_data_start[], cortex_m_data_end[], cortex_m_bss_start[], cortex_m_bss_end[];
extern const uint32_t cortex_m_data_load[];

#define VECTORS_BYTES 256u

#define SEMIHOSTING_EXIT    0x20u /* SYS_EXIT_EXTENDED: takes a code */
#define APPLICATION_STOPPED 0x20026u

void cortex_m_reset(void);
void cortex_m_start(void);
static void fault(void);

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    cortex_m_fault_stack_top, (const void *)cortex_m_reset, (const void *)fault, (const void *)fault,
    (const void *)fault,      (const void *)fault,          (const void *)fault, (const void *)fault,
    (const void *)fault,      (const void *)fault,          (const void *)fault, (const void *)fault,
    (const void *)fault,      (const void *)fault,          (const void *)fault, (const void *)fault,
};

/* To the process stack, then on in C. */
__attribute__((naked)) void cortex_m_reset(void)
{
    __asm__("ldr r0, =board_stack_top\n"
            "msr psp, r0\n"
            "movs r0, #2\n"
            "msr control, r0\n"
            "isb\n"
            "b %0\n"
            :
            : "i"(cortex_m_start));
}

#if __ARM_ARCH >= 8
/* Inclusive last byte; execution allowed where `code`. Everything normal memory or device, read and write but code. */
static void region_allow(uint32_t number, uintptr_t first, uintptr_t bytes, bool code, bool device)
{
    REGISTER(MPU_RNR) = number;
    REGISTER(MPU_RBAR) = (uint32_t)first | (code ? 2u << 1 : 0u << 1 | 1u);
    REGISTER(MPU_RLAR) = (uint32_t)((first + bytes - 1) & ~31u) | (device ? 1u << 1 : 0u) | ENABLE;
}

static void memory_protect(void)
{
    __asm__ volatile("msr psplim, %0" ::"r"(board_stack_bottom));
    REGISTER(MPU_MAIR0) = 0x0044; /* 0: normal, not cached; 1: device */
    region_allow(0, (uintptr_t)cortex_m_code_start + VECTORS_BYTES, (uintptr_t)cortex_m_code_bytes - VECTORS_BYTES,
                 true, false);
    region_allow(1, (uintptr_t)cortex_m_ram_start, (uintptr_t)cortex_m_ram_bytes, false, false);
    region_allow(2, (uintptr_t)cortex_m_external_start, (uintptr_t)cortex_m_external_bytes, false, false);
    region_allow(3, 0x40000000, 0x20000000, false, true);
    REGISTER(MPU_CTRL) = ENABLE;
}
#else
/* Forbids `bytes`, a power of two, at `first`, aligned to that. */
static void region_forbid(uint32_t number, uintptr_t first, uintptr_t bytes)
{
    REGISTER(MPU_RNR) = number;
    REGISTER(MPU_RBAR) = (uint32_t)first;
    REGISTER(MPU_RLAR) = 1u << 28 | (30u - (uint32_t)__builtin_clz(bytes)) << 1 | ENABLE;
}

static void memory_protect(void)
{
    region_forbid(0, (uintptr_t)cortex_m_code_start, VECTORS_BYTES);
    region_forbid(1, (uintptr_t)cortex_m_guard, (uintptr_t)cortex_m_guard_bytes);
    REGISTER(MPU_CTRL) = ENABLE | PRIVDEFENA;
}
#endif

__attribute__((used)) void cortex_m_start(void)
{
    uint32_t *here;
    __asm__ volatile("mov %0, sp" : "=r"(here));
    for (uint32_t *p = board_stack_bottom; p < here; p++)
        *(volatile uint32_t *)p = BOARD_STACK_PAINT;
    const uint32_t *from = cortex_m_data_load;
    for (uint32_t *p = cortex_m_data_start; p < cortex_m_data_end; p++)
        *p = *from++;
    for (uint32_t *p = cortex_m_bss_start; p < cortex_m_bss_end; p++)
        *p = 0;
    REGISTER(VTOR) = (uint32_t)(uintptr_t)vectors;
    REGISTER(SHCSR) |= 7u << 16; /* memory, bus and usage faults have handlers of their own */
    memory_protect();
    __asm__ volatile("dsb\nisb" ::: "memory");
    board_init();
    board_main();
}

__attribute__((used)) static void fault_report(const uint32_t *frame)
{
    uint32_t number;
    __asm__ volatile("mrs %0, ipsr" : "=r"(number));
    report_text("fault");
    report_number("exception", number);
    report_hex("cfsr", REGISTER(CFSR));
    report_hex("hfsr", REGISTER(HFSR));
    report_hex("mmfar", REGISTER(MMFAR));
    report_hex("bfar", REGISTER(BFAR));
    /* what the core pushed, if it could */
    if (!(REGISTER(CFSR) & STACK_LIMIT) && frame >= board_stack_bottom && frame + 8 <= board_stack_top)
        report_hex("pc", frame[6]);
    else
        report_text(" stack overflow");
    report_text("\n");
    board_exit(BOARD_EXIT_FAULT);
}

/* On the main stack, which nobody else uses. */
__attribute__((naked)) static void fault(void)
{
    __asm__("mrs r0, psp\n"
            "b %0\n"
            :
            : "i"(fault_report));
}

_Noreturn void board_exit(unsigned code)
{
    const uint32_t block[2] = {APPLICATION_STOPPED, code};
    register uint32_t operation __asm__("r0") = SEMIHOSTING_EXIT;
    register const uint32_t *argument __asm__("r1") = block;
    for (;;)
        __asm__ volatile("bkpt 0xab" : "+r"(operation) : "r"(argument) : "memory");
}
