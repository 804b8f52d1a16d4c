/*
 * half_vector_arm.h's loop for cores with DSP instructions. A word of the table's copy has two planes' 15 bits, which one smuad
 * weighs.
 * At sp: 0 a.dx, z.dx, b.dx; 12 a, z, b, term at x = 0 of the row r2; 28 term.dx; 32 l.xy, l.z; 40 struct half_vector_loop; 80 unlit
 * pixels; 84 a.base, z.base, a.dy, z.dy; 100 b.base, term.base, b.dy, term.dy. z: those of a and b in a word.
 */
#include "half_vector_arm.h"

#if defined(HALF_VECTOR_ARM) && defined(__ARM_FEATURE_DSP)
__asm__("    .syntax unified\n"
        "    .section .text.raster_half_vector_loop, \"ax\", %progbits\n"
        "    .global raster_half_vector_loop\n"
        "    .type   raster_half_vector_loop, %function\n"
        "    .thumb_func\n"
        "    .p2align 3\n"
        "raster_half_vector_loop:\n"
        "    push    {r4-r11, lr}\n"
        "    sub     sp, sp, #116\n"
        "    add     lr, sp, #40\n"
        "    ldm     r3, {r3-r12}\n"
        "    stm     lr, {r3-r12}\n"
        "    movs    r3, #0\n"
        "    ldm     r2!, {r4-r12}\n" /* base, dx, dy of a, b, z */
        "    str     r5, [sp]\n"
        "    strd    r11, r8, [sp, #4]\n"
        "    strd    r3, r4, [sp, #80]\n"
        "    strd    r10, r6, [sp, #88]\n"
        "    strd    r12, r7, [sp, #96]\n"
        "    ldm     r2, {r4-r6, r10, r11}\n" /* the term's, l */
        "    strd    r4, r9, [sp, #104]\n"
        "    str     r6, [sp, #112]\n"
        "    str     r5, [sp, #28]\n"
        "    strd    r10, r11, [sp, #32]\n"
        "    mvn     r2, #0\n"
        "1:  ldm     r0!, {r3-r6}\n" /* r3 = n.xy, r4 = n.z, r5 = n.v, r6 = at */
        "    ldrd    r7, r8, [sp, #32]\n"
        "    smuad   r7, r3, r7\n"
        "    smlabb  r7, r4, r8, r7\n" /* r7 = n.l */
        "    cmp     r7, #0\n"
        "    ble     4f\n"
        "    cmp     r2, r6, lsr #8\n"
        "    bne     3f\n"
        /* planes at x */
        "2:  ldm     sp, {r8-r12, lr}\n"
        "    uxtb    r6, r6\n"
        "    mla     r11, r6, r8, r11\n"
        "    mla     r12, r6, r9, r12\n"
        "    mla     lr, r6, r10, lr\n"
        "    smuad   r8, r3, r11\n"
        "    smuad   r10, r3, lr\n"
        "    smlabb  r8, r4, r12, r8\n"   /* n.a */
        "    smlabt  r10, r4, r12, r10\n" /* n.b */
        "    ldrd    r3, r4, [sp, #24]\n"
        "    add     r5, r5, r7\n"        /* r5 = both */
        "    mla     r6, r6, r4, r3\n"    /* r6 = term */
        "    smmul   r8, r8, r8\n"        /* r8 = na2 */
        "    smmla   r10, r10, r10, r8\n" /* s2 */
        "    ldrd    r3, r11, [sp, #40]\n"
        "    add     r10, r10, #4096\n" /* y */
        "    lsr     r5, r5, #15\n"
        "    udiv    r7, r7, r5\n" /* r7 = ratio */
        "    lsr     r5, r10, #10\n"
        "    udiv    r8, r8, r5\n"
        /* the h axis */
        "    usat    r10, #28, r10\n" /* x */
        "    clz     r12, r10\n"
        "    lsl     r10, r10, r12\n"
        "    lsr     r9, r10, #28\n"
        "    sub     r9, r9, r12, lsl #3\n"
        "    ubfx    r10, r10, #17, #11\n"
        "    ldr     r9, [r3, r9, lsl #1]\n" /* both ends of the step */
        "    rsb     r10, r10, r10, lsl #16\n"
        "    add     r10, r10, #2048\n"
        "    smuad   r9, r9, r10\n" /* r9 = u */
        /* the t axis */
        "    sub     r11, r11, r7, lsl #7\n"
        "    ldrd    r3, r4, [sp, #48]\n"
        "    smmul   r11, r11, r11\n" /* far */
        "    lsr     r10, r9, #20\n"
        "    cmp     r8, r11\n"
        "    it      lo\n"
        "    movlo   r8, r11\n" /* t2 */
        "    ldrd    r11, r12, [sp, #56]\n"
        "    smlatb  r10, r6, r4, r10\n"
        "    smulbb  r8, r8, r3\n"              /* node t, 16 fraction bits */
        "    ldr     r10, [r11, r10, lsl #2]\n" /* r10 = the cell's record */
        /* weights (256-ft)(64-fd) | (256-ft) fd << 16 and ft (64-fd) | ft fd << 16 */
        "    ubfx    r6, r6, #10, #6\n"
        "    ubfx    r5, r8, #8, #8\n"
        "    rsb     r6, r6, r6, lsl #16\n"
        "    add     r6, r6, #64\n"
        "    add     r11, r11, r10, lsr #8\n"
        "    smlatt  r11, r8, r3, r11\n" /* r11 = node t of row h */
        "    mul     r8, r5, r6\n"       /* r8 = of node t+1 */
        "    sub     r12, r12, r10\n"    /* lowest byte: shift */
        "    lsl     r7, r7, #16\n"
        "    rsb     r6, r8, r6, lsl #8\n" /* r6 = of node t */
        "    lsrs    r7, r7, r12\n"        /* a negative shift gives 0, too */
        "    beq     5f\n"
        "    lsl     r9, r9, #12\n"
        "    umull   r3, r9, r7, r9\n"        /* r9 = scale1 */
        "    uxtah   r12, r11, r4, ror #16\n" /* r12 = node t of row h+1 */
        "    sub     r7, r7, r9\n"            /* r7 = scale0 */
        /* row h */
        "    ldm     r11, {r3-r5, r10, r11, lr}\n"
        "    smuad   r3, r3, r6\n"
        "    smuad   r4, r4, r6\n"
        "    smuad   r5, r5, r6\n"
        "    smlad   r3, r10, r8, r3\n"
        "    smlad   r4, r11, r8, r4\n"
        "    smlad   r5, lr, r8, r5\n"
        "    smmul   r3, r3, r7\n"
        "    smmul   r4, r4, r7\n"
        "    smmul   r5, r5, r7\n"
        /* row h+1 */
        "    ldm     r12!, {r7, r10, r11, lr}\n"
        "    smuad   r7, r7, r6\n"
        "    smuad   r10, r10, r6\n"
        "    smuad   r11, r11, r6\n"
        "    ldrd    r6, r12, [r12]\n"
        "    smlad   r7, lr, r8, r7\n"
        "    smlad   r10, r6, r8, r10\n"
        "    smlad   r11, r12, r8, r11\n"
        "    smmla   r3, r7, r9, r3\n"
        "    smmla   r4, r10, r9, r4\n"
        "    smmla   r5, r11, r9, r5\n"
        /* colour */
        "    ldrd    r6, r7, [sp, #64]\n"
        "    ldrd    r8, lr, [sp, #72]\n"
        "    ldm     r1, {r10-r12}\n"
        "    smmla   r10, r3, r6, r10\n"
        "    smmla   r11, r4, r7, r11\n"
        "    smmla   r12, r5, r8, r12\n"
        "    cmp     r0, lr\n"
        "    stm     r1!, {r10-r12}\n"
        "    bne     1b\n"
        "    b       7f\n"
        /* a row's first pixel that is lit */
        "3:  lsr     r2, r6, #8\n"
        "    add     r12, sp, #84\n"
        "    ldm     r12!, {r8-r11}\n"
        "    mla     r8, r2, r10, r8\n"
        "    mla     r9, r2, r11, r9\n"
        "    strd    r8, r9, [sp, #12]\n"
        "    ldm     r12, {r8-r11}\n"
        "    mla     r8, r2, r10, r8\n"
        "    mla     r9, r2, r11, r9\n"
        "    strd    r8, r9, [sp, #20]\n"
        "    b       2b\n"
        /* not lit */
        "4:  ldrd    r3, r4, [sp, #76]\n"
        "    add     r1, r1, #12\n"
        "    add     r4, r4, #1\n"
        "    cmp     r0, r3\n"
        "    str     r4, [sp, #80]\n"
        "    bne     1b\n"
        "    b       7f\n"
        /* a scale of 0: too small, or a negative shift */
        "5:  sxtb    r12, r12\n"
        "    cmp     r12, #0\n"
        "    blt     6f\n"
        "    ldr     r3, [sp, #76]\n"
        "    add     r1, r1, #12\n"
        "    cmp     r0, r3\n"
        "    bne     1b\n"
        "    b       7f\n"
        "6:  sub     r0, r0, #16\n"
        "7:  ldr     r1, [sp, #80]\n"
        "    add     sp, sp, #116\n"
        "    pop     {r4-r11, pc}\n"
        "    .size   raster_half_vector_loop, . - raster_half_vector_loop\n"
        "    .text\n");

#endif
