/*
 * half_vector_arm.h's loops for cores with DSP instructions. A word of the table's copy has two planes' 15 bits, which one smuad
 * weighs.
 * At sp: 0 a.dx, z.dx, b.dx; 12 a, z, b, term of the row at at = 0; 28 term.dx; 32 l.xy; 36 l.z, in its upper half where the next row
 * begins; 40 struct half_vector_loop; 80 unlit pixels; 88 a.base, z.base, a.dy, z.dy; 104 b.base, term.base, b.dy, term.dy.
 * z: those of a and b in a word. A pixel's `at` is x + 256 y: with dy - 256 dx for dy, at dx is what its x adds.
 * r0: pixel, r1: its radiance, r2: sp + 64.
 */
#include "half_vector_arm.h"

#if defined(RASTER_ARM) && defined(__ARM_FEATURE_DSP)

/* What loops share, and between it what differs by taps: d's fraction in r10; weights, or the nearest node of the slabs at r12, from that,
 * u in r5 and node t in r8; how many bits the ratio is shifted up; what is done beside that; and, with a scale that is not 0, S of the
 * three channels in r3-r5. Instructions that multiply stand beside others, with which Cortex-M7 pairs them. */
#define LOOP(name, fraction, weights, ratio_bits, beside, sums)                                                        \
    "    .syntax unified\n"                                                                                            \
    "    .section .text." name ", \"ax\", %progbits\n"                                                                 \
    "    .global " name "\n"                                                                                           \
    "    .type   " name ", %function\n"                                                                                \
    "    .thumb_func\n"                                                                                                \
    "    .p2align 3\n" name ":\n"                                                                                      \
    "    push    {r4-r11, lr}\n"                                                                                       \
    "    sub     sp, sp, #120\n"                                                                                       \
    "    add     lr, sp, #40\n"                                                                                        \
    "    ldm     r3, {r3-r12}\n"                                                                                       \
    "    stm     lr, {r3-r12}\n"                                                                                       \
    "    movs    r3, #0\n"                                                                                             \
    "    str     r3, [sp, #80]\n"                                                                                      \
    "    ldm     r2!, {r4-r12}\n" /* base, dx, dy of a, b, z */                                                        \
    "    str     r5, [sp]\n"                                                                                           \
    "    strd    r11, r8, [sp, #4]\n"                                                                                  \
    "    sub     r6, r6, r5, lsl #8\n"                                                                                 \
    "    sub     r9, r9, r8, lsl #8\n"                                                                                 \
    "    sub     r12, r12, r11, lsl #8\n"                                                                              \
    "    strd    r4, r10, [sp, #88]\n"                                                                                 \
    "    strd    r6, r12, [sp, #96]\n"                                                                                 \
    "    ldm     r2, {r4-r6, r10, r11}\n" /* the term's, l */                                                          \
    "    sub     r6, r6, r5, lsl #8\n"                                                                                 \
    "    uxth    r11, r11\n"                                                                                           \
    "    strd    r7, r4, [sp, #104]\n"                                                                                 \
    "    strd    r9, r6, [sp, #112]\n"                                                                                 \
    "    str     r5, [sp, #28]\n"                                                                                      \
    "    strd    r10, r11, [sp, #32]\n"                                                                                \
    "    add     r2, sp, #64\n"                                                                                        \
    "1:  ldm     r0!, {r3-r6}\n" /* r3 = n.xy, r4 = n.z, r5 = n.v, r6 = at */                                          \
    "    ldrd    r7, r8, [sp, #32]\n"                                                                                  \
    "    smuad   r7, r3, r7\n"                                                                                         \
    "    smlabb  r7, r4, r8, r7\n" /* r7 = n.l */                                                                      \
    "    cmp     r7, #0\n"                                                                                             \
    "    ble     4f\n"                                                                                                 \
    "    cmp     r6, r8, asr #16\n"                                                                                    \
    "    bge     3f\n"                                                                                                 \
    "2:  ldm     sp, {r8-r12, lr}\n" /* planes at x */                                                                 \
    "    add     r5, r5, r7\n"       /* r5 = both */                                                                   \
    "    mla     r11, r6, r8, r11\n"                                                                                   \
    "    mla     lr, r6, r10, lr\n"                                                                                    \
    "    lsr     r5, r5, #15\n"                                                                                        \
    "    smuad   r8, r3, r11\n"                                                                                        \
    "    mla     r12, r6, r9, r12\n"                                                                                   \
    "    smuad   r10, r3, lr\n"                                                                                        \
    "    smlabb  r8, r4, r12, r8\n"   /* n.a */                                                                        \
    "    smlabt  r10, r4, r12, r10\n" /* n.b */                                                                        \
    "    smmul   r8, r8, r8\n"        /* na2 */                                                                        \
    "    udiv    r7, r7, r5\n"        /* r7 = ratio */                                                                 \
    "    smmla   r10, r10, r10, r8\n" /* s2 */                                                                         \
    "    ldrd    r3, r4, [sp, #24]\n"                                                                                  \
    "    add     r10, r10, #4096\n" /* y */                                                                            \
    "    lsr     r5, r10, #10\n"                                                                                       \
    "    udiv    r8, r8, r5\n"                                                                                         \
    "    usat    r10, #28, r10\n"                  /* x */                                                             \
    "    mla     r6, r6, r4, r3\n"                 /* r6 = term */                                                     \
    "    ldmdb   r2, {r3, r4, r9, r11, r12, lr}\n" /* warp, half, width, height, slabs, top */                         \
    "    clz     r5, r10\n"                                                                                            \
    "    lsl     r10, r10, r5\n"                                                                                       \
    "    sub     r3, r3, r5, lsl #4\n"                                                                                 \
    "    lsr     r5, r10, #28\n"                                                                                       \
    "    ubfx    r10, r10, #17, #11\n"                                                                                 \
    "    sub     r4, r4, r7, lsl #7\n"                                                                                 \
    "    ldr     r5, [r3, r5, lsl #1]\n" /* both ends of the warp's step */                                            \
    "    rsb     r10, r10, r10, lsl #16\n"                                                                             \
    "    add     r10, r10, #2048\n"                                                                                    \
    "    smmul   r4, r4, r4\n"  /* far */                                                                              \
    "    smuad   r5, r5, r10\n" /* r5 = u */                                                                           \
        fraction                /* r10 */                                                                              \
    "    lsr     r3, r5, #20\n"                                                                                        \
    "    smlatb  r3, r6, r11, r3\n"                                                                                    \
    "    cmp     r8, r4\n"                                                                                             \
    "    it      lo\n"                                                                                                 \
    "    movlo   r8, r4\n" /* t2 */                                                                                    \
    "    lsl     r7, r7, #" ratio_bits "\n"                                                                            \
    "    smulbb  r8, r8, r9\n"            /* node t, 16 fraction bits */                                               \
    "    ldr     r3, [r12, r3, lsl #2]\n" /* r3 = the cell's record */                                                 \
        weights                           /* r6, r8, r12 */                                                            \
    "    add     r12, r12, r3, lsr #8\n"                                                                               \
    "    smlatt  r12, r8, r9, r12\n" /* r12 = node t of row h */                                                       \
    "    sub     lr, lr, r3\n"       /* lowest byte: shift */                                                          \
        beside                       /* r6, r8, r9 */                                                                  \
    "    lsrs    r7, r7, lr\n"       /* a negative shift gives 0, too */                                               \
    "    beq     5f\n" sums          /* r3-r5 */                                                                       \
    "    ldm     r2, {r6-r8, lr}\n"  /* colour, end */                                                                 \
    "    ldm     r1, {r10-r12}\n"                                                                                      \
    "    smmla   r10, r3, r6, r10\n"                                                                                   \
    "    smmla   r11, r4, r7, r11\n"                                                                                   \
    "    smmla   r12, r5, r8, r12\n"                                                                                   \
    "    cmp     r0, lr\n"                                                                                             \
    "    stm     r1!, {r10-r12}\n"                                                                                     \
    "    bne     1b\n"                                                                                                 \
    "    b       7f\n"                                                                                                 \
    "3:  lsr     lr, r6, #8\n" /* a row's first pixel that is lit */                                                   \
    "    add     r12, sp, #88\n"                                                                                       \
    "    ldm     r12!, {r8-r11}\n"                                                                                     \
    "    mla     r8, lr, r10, r8\n"                                                                                    \
    "    mla     r9, lr, r11, r9\n"                                                                                    \
    "    strd    r8, r9, [sp, #12]\n"                                                                                  \
    "    ldm     r12, {r8-r11}\n"                                                                                      \
    "    mla     r8, lr, r10, r8\n"                                                                                    \
    "    mla     r9, lr, r11, r9\n"                                                                                    \
    "    strd    r8, r9, [sp, #20]\n"                                                                                  \
    "    add     lr, lr, #1\n"                                                                                         \
    "    lsl     lr, lr, #8\n"                                                                                         \
    "    strh    lr, [sp, #38]\n"                                                                                      \
    "    b       2b\n"                                                                                                 \
    "4:  ldrd    r3, r4, [sp, #76]\n" /* not lit */                                                                    \
    "    add     r1, r1, #12\n"                                                                                        \
    "    add     r4, r4, #1\n"                                                                                         \
    "    cmp     r0, r3\n"                                                                                             \
    "    str     r4, [sp, #80]\n"                                                                                      \
    "    bne     1b\n"                                                                                                 \
    "    b       7f\n"                                                                                                 \
    "5:  sxtb    lr, lr\n" /* a scale of 0: too small, or a negative shift */                                          \
    "    cmp     lr, #0\n"                                                                                             \
    "    blt     6f\n"                                                                                                 \
    "    ldr     r3, [sp, #76]\n"                                                                                      \
    "    add     r1, r1, #12\n"                                                                                        \
    "    cmp     r0, r3\n"                                                                                             \
    "    bne     1b\n"                                                                                                 \
    "    b       7f\n"                                                                                                 \
    "6:  sub     r0, r0, #16\n"                                                                                        \
    "7:  ldr     r1, [sp, #80]\n"                                                                                      \
    "    add     sp, sp, #120\n"                                                                                       \
    "    pop     {r4-r11, pc}\n"                                                                                       \
    "    .size   " name ", . - " name "\n"                                                                             \
    "    .text\n"

#define FRACTION_8 "    ubfx    r10, r6, #10, #6\n" /* fd */

/* (256-ft)(64-fd) | (256-ft) fd << 16 and ft (64-fd) | ft fd << 16 */
#define WEIGHTS_8                                                                                                      \
    "    rsb     r6, r10, r10, lsl #16\n"                                                                              \
    "    ubfx    r4, r8, #8, #8\n"                                                                                     \
    "    add     r6, r6, #64\n"

#define BESIDE_8                                                                                                       \
    "    mul     r8, r4, r6\n" /* r8 = of node t+1 */                                                                  \
    "    lsl     r9, r5, #12\n"

#define SUMS_8                                                                                                         \
    "    umull   r3, r9, r7, r9\n"        /* r9 = scale1 */                                                            \
    "    rsb     r6, r8, r6, lsl #8\n"    /* r6 = of node t */                                                         \
    "    uxtah   lr, r12, r11, ror #16\n" /* lr = node t of row h+1 */                                                 \
    "    ldm     r12, {r3-r5, r10-r12}\n" /* row h */                                                                  \
    "    sub     r7, r7, r9\n"            /* r7 = scale0 */                                                            \
    "    smuad   r3, r3, r6\n"                                                                                         \
    "    smuad   r4, r4, r6\n"                                                                                         \
    "    smuad   r5, r5, r6\n"                                                                                         \
    "    smlad   r3, r10, r8, r3\n"                                                                                    \
    "    smlad   r4, r11, r8, r4\n"                                                                                    \
    "    smlad   r5, r12, r8, r5\n"                                                                                    \
    "    smmul   r3, r3, r7\n"                                                                                         \
    "    smmul   r4, r4, r7\n"                                                                                         \
    "    smmul   r5, r5, r7\n"                                                                                         \
    "    ldm     lr!, {r7, r10-r12}\n" /* row h+1 */                                                                   \
    "    smuad   r7, r7, r6\n"                                                                                         \
    "    smuad   r10, r10, r6\n"                                                                                       \
    "    smuad   r11, r11, r6\n"                                                                                       \
    "    smlad   r7, r12, r8, r7\n"                                                                                    \
    "    ldrd    r6, r12, [lr]\n"                                                                                      \
    "    smlad   r10, r6, r8, r10\n"                                                                                   \
    "    smlad   r11, r12, r8, r11\n"                                                                                  \
    "    smmla   r3, r7, r9, r3\n"                                                                                     \
    "    smmla   r4, r10, r9, r4\n"                                                                                    \
    "    smmla   r5, r11, r9, r5\n"

#define FRACTION_4 "    ubfx    r10, r6, #2, #14\n" /* f */

/* 2^14 - f | f << 16 */
#define WEIGHTS_4                                                                                                      \
    "    rsb     r6, r10, r10, lsl #16\n"                                                                              \
    "    add     r8, r8, #32768\n" /* the nearer node */                                                               \
    "    add     r6, r6, #16384\n"

#define BESIDE_4 "    lsl     r9, r5, #12\n"

#define SUMS_4                                                                                                         \
    "    umull   r3, r9, r7, r9\n"        /* r9 = scale1 */                                                            \
    "    uxtah   lr, r12, r11, ror #16\n" /* lr = node t of row h+1 */                                                 \
    "    ldm     r12, {r3-r5}\n"          /* row h */                                                                  \
    "    sub     r7, r7, r9\n"            /* r7 = scale0 */                                                            \
    "    smuad   r3, r3, r6\n"                                                                                         \
    "    smuad   r4, r4, r6\n"                                                                                         \
    "    smuad   r5, r5, r6\n"                                                                                         \
    "    ldm     lr, {r10-r12}\n" /* row h+1 */                                                                        \
    "    smmul   r3, r3, r7\n"                                                                                         \
    "    smmul   r4, r4, r7\n"                                                                                         \
    "    smmul   r5, r5, r7\n"                                                                                         \
    "    smuad   r10, r10, r6\n"                                                                                       \
    "    smuad   r11, r11, r6\n"                                                                                       \
    "    smuad   r12, r12, r6\n"                                                                                       \
    "    smmla   r3, r10, r9, r3\n"                                                                                    \
    "    smmla   r4, r11, r9, r4\n"                                                                                    \
    "    smmla   r5, r12, r9, r5\n"

/* d's and h's fractions are their highest bits. */
#define FRACTION_1 "    ubfx    r10, r6, #15, #1\n" /* plane */

#define WEIGHTS_1                                                                                                      \
    "    ubfx    r5, r5, #19, #1\n" /* row */                                                                          \
    "    add     r8, r8, #32768\n"  /* the nearer node */                                                              \
    "    smlabt  r12, r5, r11, r12\n"                                                                                  \
    "    add     r12, r12, r10, lsl #1\n"

#define BESIDE_1

#define SUMS_1                                                                                                         \
    "    ldrh    r3, [r12]\n"                                                                                          \
    "    ldrh    r4, [r12, #4]\n"                                                                                      \
    "    ldrh    r5, [r12, #8]\n"                                                                                      \
    "    smulwb  r3, r7, r3\n"                                                                                         \
    "    smulwb  r4, r7, r4\n"                                                                                         \
    "    smulwb  r5, r7, r5\n"

__asm__(LOOP("raster_half_vector_loop", FRACTION_8, WEIGHTS_8, "16", BESIDE_8, SUMS_8));
__asm__(LOOP("raster_half_vector_loop_four", FRACTION_4, WEIGHTS_4, "16", BESIDE_4, SUMS_4));
__asm__(LOOP("raster_half_vector_loop_one", FRACTION_1, WEIGHTS_1, "14", BESIDE_1, SUMS_1));
#endif
