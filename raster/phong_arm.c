/*
 * phong.h's arithmetic for Cortex-M cores of ARMv7-M and later, instruction by instruction, since a compiler runs out of registers.
 *
 * Planes are taken at x + 256 y, as a pixel's place is stored: for row y from base + y (dy - 256 dx).
 * r0 pixel, r1 radiance, r2 y, lr = &k->colour[1]. At sp: 0 a.dx, z.dx, a, z, b.dx, b in row r2; 24 a.dy, z.dy, a.base, z.base, b.dy, b.base,
 * each dy less 256 dx; 48 l.xy, l.z, without DSP instructions l.x, l.y, l.z. z: those of a and b in a word.
 */
#include "phong.h"

#ifdef RASTER_ARM

_Static_assert(sizeof(struct raster_batch_pixel) == 16 && offsetof(struct raster_block_light, l_xy) == 48 &&
                   offsetof(struct raster_block_light, l_z) == 52 && PLANE_A_XY == 0 && PLANE_B_XY == 1 &&
                   PLANE_AB_Z == 2 && offsetof(struct phong_loop, colour[1]) == 16 &&
                   offsetof(struct phong_loop, nodes) == 36,
               "the loop's offsets");

#ifdef __ARM_FEATURE_DSP
#define STORE_L "    strd    r4, r5, [sp, #48]\n"
#define LOAD_L  "    ldrd    r8, r9, [sp, #48]\n"
/* r7 = n.l, from n.xy, n.z in r3, r4 */
#define N_L                                                                                                            \
    "    smuad   r7, r3, r8\n"                                                                                         \
    "    smlabb  r7, r4, r9, r7\n"
/* the place r6's planes; r5 = n.a, r8 = n.b, r11 = the lobe's offset, r12 = its nodes */
#define N_AB                                                                                                           \
    "    ldm     sp, {r5, r8-r12}\n"                                                                                   \
    "    mla     r9, r6, r5, r9\n"                                                                                     \
    "    mla     r10, r6, r8, r10\n"                                                                                   \
    "    mla     r12, r6, r11, r12\n"                                                                                  \
    "    smuad   r5, r3, r9\n"                                                                                         \
    "    smuad   r8, r3, r12\n"                                                                                        \
    "    ldrd    r11, r12, [lr, #16]\n"                                                                                \
    "    smlabb  r5, r4, r10, r5\n"                                                                                    \
    "    smlabt  r8, r4, r10, r8\n"
#else
#define STORE_L                                                                                                        \
    "    sxth    r3, r4\n"                                                                                             \
    "    asrs    r4, r4, #16\n"                                                                                        \
    "    strd    r3, r4, [sp, #48]\n"                                                                                  \
    "    str     r5, [sp, #56]\n"
#define LOAD_L                                                                                                         \
    "    ldrd    r8, r9, [sp, #48]\n"                                                                                  \
    "    ldr     r11, [sp, #56]\n"
/* leaves n.x in r10, n.y in r3 */
#define N_L                                                                                                            \
    "    sxth    r10, r3\n"                                                                                            \
    "    asr     r3, r3, #16\n"                                                                                        \
    "    mul     r7, r10, r8\n"                                                                                        \
    "    mla     r7, r3, r9, r7\n"                                                                                     \
    "    mla     r7, r4, r11, r7\n"
#define N_AB                                                                                                           \
    "    ldm     sp, {r5, r8, r9, r11}\n"                                                                              \
    "    mla     r9, r6, r5, r9\n"                                                                                     \
    "    mla     r11, r6, r8, r11\n"                                                                                   \
    "    sxth    r12, r9\n"                                                                                            \
    "    asr     r9, r9, #16\n"                                                                                        \
    "    mul     r5, r10, r12\n"                                                                                       \
    "    mla     r5, r3, r9, r5\n"                                                                                     \
    "    sxth    r12, r11\n"                                                                                           \
    "    mla     r5, r4, r12, r5\n"                                                                                    \
    "    ldrd    r8, r9, [sp, #16]\n"                                                                                  \
    "    mla     r9, r6, r8, r9\n"                                                                                     \
    "    asr     r11, r11, #16\n"                                                                                      \
    "    sxth    r8, r9\n"                                                                                             \
    "    asr     r9, r9, #16\n"                                                                                        \
    "    mul     r8, r10, r8\n"                                                                                        \
    "    mla     r8, r3, r9, r8\n"                                                                                     \
    "    mla     r8, r4, r11, r8\n"                                                                                    \
    "    ldrd    r11, r12, [lr, #16]\n"
#endif

__asm__("    .syntax unified\n"
        "    .section .text.raster_shade_lafortune_phong_loop, \"ax\", %progbits\n"
        "    .global raster_shade_lafortune_phong_loop\n"
        "    .type   raster_shade_lafortune_phong_loop, %function\n"
        "    .thumb_func\n"
        "    .p2align 3\n"
        "raster_shade_lafortune_phong_loop:\n"
        "    push    {r4-r11, lr}\n"
        "    sub     sp, sp, #60\n"
        "    add     lr, r3, #16\n"
        "    ldm     r2!, {r4-r12}\n" /* base, dx, dy of a, b, z */
        "    strd    r5, r11, [sp]\n"
        "    str     r8, [sp, #16]\n"
        "    sub     r6, r6, r5, lsl #8\n"
        "    sub     r12, r12, r11, lsl #8\n"
        "    sub     r9, r9, r8, lsl #8\n"
        "    strd    r6, r12, [sp, #24]\n"
        "    strd    r4, r10, [sp, #32]\n"
        "    strd    r9, r7, [sp, #40]\n"
        "    ldrd    r4, r5, [r2, #12]\n" STORE_L "    mvn     r2, #0\n"
        "1:  ldm     r0!, {r3-r6}\n" /* r3 = n.xy, r4 = n.z, r6 = at */
        LOAD_L N_L "    cmp     r7, #0\n"
        "    ble     4f\n"
        "2:  cmp     r2, r6, lsr #8\n"
        "    bne     6f\n"
        "3:\n" N_AB "    smull   r3, r4, r5, r5\n"
        "    smlal   r3, r4, r8, r8\n" /* r4 = s2 */
        "    ldm     r1, {r8-r10}\n"
        /* the lobe */
        "    add     r4, r11, r4, lsl #1\n"
        "    cmp     r11, r4, lsr #9\n" /* the offset is 2^-9 of where the lobe ends */
        "    bls     8f\n"
        "    clz     r3, r4\n"
        "    lsl     r4, r4, r3\n"
        "    lsr     r5, r4, #27\n"
        "    sub     r5, r5, r3, lsl #4\n"
        "    ldr     r5, [r12, r5, lsl #1]\n" /* both ends of the step */
        "    ubfx    r4, r4, #12, #15\n"
        "    ldmdb   lr, {r6, r11, r12}\n"
        "    uxth    r3, r5\n"
        "    sub     r5, r3, r5, lsr #16\n"
        "    lsl     r3, r3, #15\n"
        "    mls     r3, r5, r4, r3\n"
        "    umull   r3, r4, r3, r7\n" /* r4 = power */
        /* colour; flags stay to the end */
        "    cmp     r0, r6\n"
        "    umlal   r3, r8, r11, r7\n"
        "    umlal   r3, r8, r12, r4\n"
        "    ldm     lr, {r5, r6, r11, r12}\n"
        "    umlal   r3, r9, r5, r7\n"
        "    umlal   r3, r9, r6, r4\n"
        "    umlal   r3, r10, r11, r7\n"
        "    umlal   r3, r10, r12, r4\n"
        "    stm     r1!, {r8-r10}\n"
        "    bne     1b\n"
        "    b       9f\n"
        /* the first of pixels that are not lit */
        "4:  ldrd    r5, r12, [lr, #-16]\n"
        "    sub     r5, r5, r0\n"
        "    str     r5, [lr, #-16]\n"
        "5:  add     r1, r1, #12\n"
        "    cmp     r0, r12\n"
        "    beq     7f\n"
        "    ldm     r0!, {r3-r6}\n" N_L "    cmp     r7, #0\n"
        "    ble     5b\n"
        "    ldr     r5, [lr, #-16]\n"
        "    add     r5, r5, r0\n"
        "    str     r5, [lr, #-16]\n"
        "    b       2b\n"
        /* a row's first pixel that is lit */
        "6:  lsr     r2, r6, #8\n"
        "    add     r12, sp, #24\n"
        "    ldm     r12!, {r5, r8, r9, r11}\n"
        "    mla     r9, r2, r5, r9\n"
        "    mla     r11, r2, r8, r11\n"
        "    strd    r9, r11, [sp, #8]\n"
        "    ldrd    r5, r8, [r12]\n"
        "    mla     r8, r2, r5, r8\n"
        "    str     r8, [sp, #20]\n"
        "    b       3b\n"
        /* the last one is not */
        "7:  ldr     r5, [lr, #-16]\n"
        "    add     r5, r5, r0\n"
        "    add     r5, r5, #16\n"
        "    str     r5, [lr, #-16]\n"
        "    b       9f\n"
        /* outside of the lobe */
        "8:  ldrd    r6, r11, [lr, #-12]\n"
        "    movs    r3, #0\n"
        "    ldm     lr, {r4, r5, r12}\n"
        "    cmp     r0, r6\n"
        "    umlal   r3, r8, r11, r7\n"
        "    umlal   r3, r9, r4, r7\n"
        "    umlal   r3, r10, r12, r7\n"
        "    stm     r1!, {r8-r10}\n"
        "    bne     1b\n"
        "9:  add     sp, sp, #60\n"
        "    pop     {r4-r11, pc}\n"
        "    .size   raster_shade_lafortune_phong_loop, . - raster_shade_lafortune_phong_loop\n"
        "    .text\n");

#endif
