/*
 * half_vector_arm.h's loops for cores without DSP instructions.
 * At sp: 0 a.dx, z.dx; 8 a, z, b at x = 0 of the row r2; 20 b.dx; 24 the term likewise, term.dx; 32 l.x, l.y, l.z; 44 struct
 * half_vector_loop; 84 unlit pixels; 88 a.base, z.base, a.dy, z.dy; 104 b.base, term.base, b.dy, term.dy. z: those of a and b in a
 * word.
 */
#include "half_vector_arm.h"

#if defined(RASTER_ARM) && !defined(__ARM_FEATURE_DSP)

/* What loops share, and between it what differs by taps: the node in r3 and what is between nodes, from t, term and u in r8, r6 and r9
 * and the slabs in r11; how many bits the ratio is shifted up; and, with a scale that is not 0, S of the three channels in r8, r10, lr. */
#define LOOP(name, node, ratio_bits, sums)                                                                             \
    "    .syntax unified\n"                                                                                            \
    "    .section .text." name ", \"ax\", %progbits\n"                                                                 \
    "    .global " name "\n"                                                                                           \
    "    .type   " name ", %function\n"                                                                                \
    "    .thumb_func\n"                                                                                                \
    "    .p2align 3\n"                                                                                                 \
    "" name ":\n"                                                                                                      \
    "    push    {r4-r11, lr}\n"                                                                                       \
    "    sub     sp, sp, #124\n"                                                                                       \
    "    add     lr, sp, #44\n"                                                                                        \
    "    ldm     r3, {r3-r12}\n"                                                                                       \
    "    stm     lr, {r3-r12}\n"                                                                                       \
    "    movs    r3, #0\n"                                                                                             \
    "    str     r3, [sp, #84]\n"                                                                                      \
    "    ldm     r2!, {r4-r12}\n" /* base, dx, dy of a, b, z */                                                        \
    "    strd    r5, r11, [sp]\n"                                                                                      \
    "    str     r8, [sp, #20]\n"                                                                                      \
    "    strd    r4, r10, [sp, #88]\n"                                                                                 \
    "    strd    r6, r12, [sp, #96]\n"                                                                                 \
    "    str     r7, [sp, #104]\n"                                                                                     \
    "    str     r9, [sp, #112]\n"                                                                                     \
    "    ldm     r2, {r4-r8}\n" /* the term's, l */                                                                    \
    "    str     r4, [sp, #108]\n"                                                                                     \
    "    str     r6, [sp, #116]\n"                                                                                     \
    "    str     r5, [sp, #28]\n"                                                                                      \
    "    sxth    r3, r7\n"                                                                                             \
    "    asrs    r7, r7, #16\n"                                                                                        \
    "    strd    r3, r7, [sp, #32]\n"                                                                                  \
    "    str     r8, [sp, #40]\n"                                                                                      \
    "    mvn     r2, #0\n"                                                                                             \
    "1:  ldm     r0!, {r3-r6}\n" /* r3 = n.xy, r4 = n.z, r5 = n.v, r6 = at */                                          \
    "    ldrd    r7, r8, [sp, #32]\n"                                                                                  \
    "    ldr     r9, [sp, #40]\n"                                                                                      \
    "    sxth    r10, r3\n"     /* r10 = n.x */                                                                        \
    "    asr     r3, r3, #16\n" /* r3 = n.y */                                                                         \
    "    mul     r7, r10, r7\n"                                                                                        \
    "    mla     r7, r3, r8, r7\n"                                                                                     \
    "    mla     r7, r4, r9, r7\n" /* r7 = n.l */                                                                      \
    "    cmp     r7, #0\n"                                                                                             \
    "    ble     4f\n"                                                                                                 \
    "    cmp     r2, r6, lsr #8\n"                                                                                     \
    "    bne     3f\n"                                                                                                 \
    "2:  ldm     sp, {r8, r9, r11, r12}\n" /* planes at x */                                                           \
    "    uxtb    r6, r6\n"                                                                                             \
    "    add     r5, r5, r7\n" /* r5 = both */                                                                         \
    "    mla     r11, r6, r8, r11\n"                                                                                   \
    "    mla     r12, r6, r9, r12\n"                                                                                   \
    "    sxth    r8, r11\n"                                                                                            \
    "    asr     r11, r11, #16\n"                                                                                      \
    "    sxth    r9, r12\n"                                                                                            \
    "    asr     r12, r12, #16\n"                                                                                      \
    "    mul     r8, r10, r8\n"                                                                                        \
    "    mla     r8, r3, r11, r8\n"                                                                                    \
    "    mla     r8, r4, r9, r8\n" /* n.a */                                                                           \
    "    ldrd    r9, r11, [sp, #16]\n"                                                                                 \
    "    mla     r9, r6, r11, r9\n"                                                                                    \
    "    sxth    r11, r9\n"                                                                                            \
    "    asr     r9, r9, #16\n"                                                                                        \
    "    mul     r10, r10, r11\n"                                                                                      \
    "    mla     r10, r3, r9, r10\n"                                                                                   \
    "    mla     r10, r4, r12, r10\n" /* n.b */                                                                        \
    "    ldrd    r3, r4, [sp, #24]\n"                                                                                  \
    "    lsr     r5, r5, #15\n"                                                                                        \
    "    udiv    r7, r7, r5\n"     /* r7 = ratio */                                                                    \
    "    mla     r6, r6, r4, r3\n" /* r6 = term */                                                                     \
    "    smull   r3, r8, r8, r8\n" /* na2 */                                                                           \
    "    smull   r3, r10, r10, r10\n"                                                                                  \
    "    add     r10, r10, r8\n"    /* s2 */                                                                           \
    "    add     r10, r10, #4096\n" /* y */                                                                            \
    "    lsr     r5, r10, #10\n"                                                                                       \
    "    udiv    r8, r8, r5\n"                                                                                         \
    "    ldrd    r3, r11, [sp, #44]\n" /* the h axis */                                                                \
    "    usat    r10, #28, r10\n"      /* x */                                                                         \
    "    clz     r12, r10\n"                                                                                           \
    "    lsl     r10, r10, r12\n"                                                                                      \
    "    lsr     r9, r10, #28\n"                                                                                       \
    "    sub     r9, r9, r12, lsl #3\n"                                                                                \
    "    ubfx    r10, r10, #17, #11\n"                                                                                 \
    "    ldr     r9, [r3, r9, lsl #1]\n" /* both ends of the step */                                                   \
    "    uxth    r3, r9\n"                                                                                             \
    "    rsb     r9, r3, r9, lsr #16\n"                                                                                \
    "    lsl     r3, r3, #11\n"                                                                                        \
    "    mla     r9, r9, r10, r3\n"      /* r9 = u */                                                                  \
    "    sub     r11, r11, r7, lsl #7\n" /* the t axis */                                                              \
    "    smull   r3, r11, r11, r11\n"    /* far */                                                                     \
    "    cmp     r8, r11\n"                                                                                            \
    "    it      lo\n"                                                                                                 \
    "    movlo   r8, r11\n" /* t2 */                                                                                   \
    "    ldrh    r3, [sp, #52]\n"                                                                                      \
    "    ldrh    r4, [sp, #56]\n"                                                                                      \
    "    lsr     r11, r6, #16\n"                                                                                       \
    "    mul     r8, r8, r3\n" /* node t, 16 fraction bits */                                                          \
    "    lsr     r10, r9, #20\n"                                                                                       \
    "    mla     r10, r11, r4, r10\n"                                                                                  \
    "    ldrd    r11, r12, [sp, #60]\n"                                                                                \
    "    ldr     r10, [r11, r10, lsl #2]\n" /* r10 = the cell's record */                                              \
        node                                /* r3 = node */                                                            \
    "    add     r3, r3, r3, lsl #1\n"                                                                                 \
    "    add     r11, r11, r10, lsr #8\n"                                                                              \
    "    sub     r12, r12, r10\n"        /* lowest byte: shift */                                                      \
    "    add     r11, r11, r3, lsl #2\n" /* r11 = node t of row h */                                                   \
    "    lsl     r7, r7, #" ratio_bits "\n"                                                                            \
    "    lsrs    r7, r7, r12\n"       /* a negative shift gives 0, too */                                              \
    "    beq     5f\n" sums           /* S */                                                                          \
    "    ldrd    r3, r4, [sp, #68]\n" /* colour */                                                                     \
    "    ldrd    r5, r6, [sp, #76]\n"                                                                                  \
    "    ldm     r1, {r7, r9, r11}\n"                                                                                  \
    "    umull   r12, r8, r8, r3\n"                                                                                    \
    "    umull   r12, r10, r10, r4\n"                                                                                  \
    "    umull   r12, lr, lr, r5\n"                                                                                    \
    "    add     r7, r7, r8\n"                                                                                         \
    "    add     r9, r9, r10\n"                                                                                        \
    "    add     r11, r11, lr\n"                                                                                       \
    "    cmp     r0, r6\n"                                                                                             \
    "    stm     r1!, {r7, r9, r11}\n"                                                                                 \
    "    bne     1b\n"                                                                                                 \
    "    b       7f\n"                                                                                                 \
    "3:  lsr     r2, r6, #8\n" /* a row's first pixel that is lit */                                                   \
    "    add     r12, sp, #88\n"                                                                                       \
    "    ldm     r12!, {r8, r9, r11, lr}\n"                                                                            \
    "    mla     r8, r2, r11, r8\n"                                                                                    \
    "    mla     r9, r2, lr, r9\n"                                                                                     \
    "    strd    r8, r9, [sp, #8]\n"                                                                                   \
    "    ldm     r12, {r8, r9, r11, lr}\n"                                                                             \
    "    mla     r8, r2, r11, r8\n"                                                                                    \
    "    mla     r9, r2, lr, r9\n"                                                                                     \
    "    str     r8, [sp, #16]\n"                                                                                      \
    "    str     r9, [sp, #24]\n"                                                                                      \
    "    b       2b\n"                                                                                                 \
    "4:  ldrd    r3, r4, [sp, #80]\n" /* not lit */                                                                    \
    "    add     r1, r1, #12\n"                                                                                        \
    "    add     r4, r4, #1\n"                                                                                         \
    "    cmp     r0, r3\n"                                                                                             \
    "    str     r4, [sp, #84]\n"                                                                                      \
    "    bne     1b\n"                                                                                                 \
    "    b       7f\n"                                                                                                 \
    "5:  sxtb    r12, r12\n" /* a scale of 0: too small, or a negative shift */                                        \
    "    cmp     r12, #0\n"                                                                                            \
    "    blt     6f\n"                                                                                                 \
    "    ldr     r3, [sp, #80]\n"                                                                                      \
    "    add     r1, r1, #12\n"                                                                                        \
    "    cmp     r0, r3\n"                                                                                             \
    "    bne     1b\n"                                                                                                 \
    "    b       7f\n"                                                                                                 \
    "6:  sub     r0, r0, #16\n"                                                                                        \
    "7:  ldr     r1, [sp, #84]\n"                                                                                      \
    "    add     sp, sp, #124\n"                                                                                       \
    "    pop     {r4-r11, pc}\n"                                                                                       \
    "    .size   " name ", . - " name "\n"                                                                             \
    "    .text\n"

#define NODE_8                                                                                                         \
    "    lsr     r3, r8, #16\n"                                                                                        \
    "    ubfx    r8, r8, #8, #8\n"  /* r8 = ft */                                                                      \
    "    ubfx    r6, r6, #10, #6\n" /* r6 = fd */

/* A row's sum of one channel by 8 taps, in a register, times scale; the others say where its four numbers are from r11 on: planes d and
 * d+1 of node t, then of t+1. Their weights are in r6, r5, r4, r3. Clobbers r12. */
#define ROW_SUM(sum, scale, low0, high0, low1, high1)                                                                  \
    "    ldrh    " sum ", [r11, #" low0 "]\n"                                                                          \
    "    ldrh    r12, [r11, #" high0 "]\n"                                                                             \
    "    mul     " sum ", " sum ", r6\n"                                                                               \
    "    mla     " sum ", r12, r5, " sum "\n"                                                                          \
    "    ldrh    r12, [r11, #" low1 "]\n"                                                                              \
    "    mla     " sum ", r12, r4, " sum "\n"                                                                          \
    "    ldrh    r12, [r11, #" high1 "]\n"                                                                             \
    "    mla     " sum ", r12, r3, " sum "\n"                                                                          \
    "    umull   r12, " sum ", " sum ", " scale "\n"
#define RED(sum, scale)   ROW_SUM(sum, scale, "0", "2", "12", "14")
#define GREEN(sum, scale) ROW_SUM(sum, scale, "4", "6", "16", "18")
#define BLUE(sum, scale)  ROW_SUM(sum, scale, "8", "10", "20", "22")
#define NEXT_ROW          "    ldrh    r12, [sp, #58]\n    add     r11, r11, r12\n"
#define ADD(sum, more)    "    add     " sum ", " sum ", " more "\n"

#define SUMS_8                                                                                                         \
    "    lsl     r9, r9, #12\n"                                                                                        \
    "    umull   r3, r9, r7, r9\n" /* r9 = scale1 */                                                                   \
    "    sub     r7, r7, r9\n"     /* r7 = scale0 */                                                                   \
    "    mul     r3, r8, r6\n"     /* weights */                                                                       \
    "    rsb     r4, r3, r8, lsl #6\n"                                                                                 \
    "    rsb     r5, r3, r6, lsl #8\n"                                                                                 \
    "    rsb     r6, r8, #256\n"                                                                                       \
    "    rsb     r6, r5, r6, lsl #6\n" RED("r8", "r7") GREEN("r10", "r7") BLUE("lr", "r7") NEXT_ROW RED("r7", "r9")    \
        ADD("r8", "r7") GREEN("r7", "r9") ADD("r10", "r7") BLUE("r7", "r9") ADD("lr", "r7")

#define NODE_4                                                                                                         \
    "    add     r8, r8, #32768\n"                                                                                     \
    "    lsr     r3, r8, #16\n"                                                                                        \
    "    ubfx    r6, r6, #2, #14\n" /* r6 = f */

#define SUMS_4                                                                                                         \
    "    ldrh    r8, [r11]\n" /* row h */                                                                              \
    "    ldrh    r10, [r11, #4]\n"                                                                                     \
    "    ldrh    lr, [r11, #8]\n"                                                                                      \
    "    ldrh    r3, [r11, #2]\n"                                                                                      \
    "    ldrh    r4, [r11, #6]\n"                                                                                      \
    "    ldrh    r12, [r11, #10]\n"                                                                                    \
    "    rsb     r5, r6, #16384\n"                                                                                     \
    "    mul     r8, r8, r5\n"                                                                                         \
    "    mul     r10, r10, r5\n"                                                                                       \
    "    mul     lr, lr, r5\n"                                                                                         \
    "    mla     r8, r3, r6, r8\n"                                                                                     \
    "    mla     r10, r4, r6, r10\n"                                                                                   \
    "    mla     lr, r12, r6, lr\n"                                                                                    \
    "    lsl     r9, r9, #12\n"                                                                                        \
    "    umull   r3, r9, r7, r9\n" /* r9 = scale1 */                                                                   \
    "    ldrh    r12, [sp, #58]\n"                                                                                     \
    "    sub     r7, r7, r9\n" /* r7 = scale0 */                                                                       \
    "    add     r11, r11, r12\n"                                                                                      \
    "    umull   r12, r8, r8, r7\n"                                                                                    \
    "    umull   r12, r10, r10, r7\n"                                                                                  \
    "    umull   r12, lr, lr, r7\n"                                                                                    \
    "    ldrh    r3, [r11]\n" /* row h+1 */                                                                            \
    "    ldrh    r4, [r11, #4]\n"                                                                                      \
    "    ldrh    r7, [r11, #2]\n"                                                                                      \
    "    ldrh    r12, [r11, #6]\n"                                                                                     \
    "    mul     r3, r3, r5\n"                                                                                         \
    "    mul     r4, r4, r5\n"                                                                                         \
    "    mla     r3, r7, r6, r3\n"                                                                                     \
    "    mla     r4, r12, r6, r4\n"                                                                                    \
    "    ldrh    r7, [r11, #8]\n"                                                                                      \
    "    ldrh    r12, [r11, #10]\n"                                                                                    \
    "    mul     r7, r7, r5\n"                                                                                         \
    "    mla     r7, r12, r6, r7\n"                                                                                    \
    "    umull   r12, r3, r3, r9\n"                                                                                    \
    "    umull   r12, r4, r4, r9\n"                                                                                    \
    "    umull   r12, r7, r7, r9\n"                                                                                    \
    "    add     r8, r8, r3\n"                                                                                         \
    "    add     r10, r10, r4\n"                                                                                       \
    "    add     lr, lr, r7\n"

#define NODE_1                                                                                                         \
    "    ldrh    r4, [sp, #58]\n"                                                                                      \
    "    add     r8, r8, #32768\n"                                                                                     \
    "    lsr     r3, r8, #16\n"                                                                                        \
    "    ubfx    r6, r6, #15, #1\n" /* plane */                                                                        \
    "    ubfx    r9, r9, #19, #1\n" /* row */                                                                          \
    "    add     r11, r11, r6, lsl #1\n"                                                                               \
    "    mla     r11, r9, r4, r11\n"

#define SUMS_1                                                                                                         \
    "    ldrh    r8, [r11]\n"                                                                                          \
    "    ldrh    r10, [r11, #4]\n"                                                                                     \
    "    ldrh    lr, [r11, #8]\n"                                                                                      \
    "    lsl     r8, r8, #16\n"                                                                                        \
    "    lsl     r10, r10, #16\n"                                                                                      \
    "    lsl     lr, lr, #16\n"                                                                                        \
    "    umull   r12, r8, r8, r7\n"                                                                                    \
    "    umull   r12, r10, r10, r7\n"                                                                                  \
    "    umull   r12, lr, lr, r7\n"

__asm__(LOOP("raster_half_vector_loop", NODE_8, "16", SUMS_8));
__asm__(LOOP("raster_half_vector_loop_four", NODE_4, "16", SUMS_4));
__asm__(LOOP("raster_half_vector_loop_one", NODE_1, "14", SUMS_1));
#endif
