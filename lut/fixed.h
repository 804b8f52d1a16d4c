/*
 * Fixed-point types and the few integer helpers everything else is written in.
 *
 * Naming follows ARM's Qm.n with the sign bit counted in m: q17_15_t is an int32_t with 15 fraction bits,
 * uq12_20_t a uint32_t with 20. Right shifts of negative values are arithmetic on every supported compiler
 * (gcc and clang define it so); left shifts are only ever done on unsigned or non-negative values.
 * Nothing here divides by a 64-bit variable, allocates, recurses or keeps state.
 */
#ifndef LUT_FIXED_H
#define LUT_FIXED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef int32_t q17_15_t;   /* unit vectors and cosines: 1.0 = 32768 */
typedef int32_t q2_30_t;    /* rotation matrices, products of two q17_15_t: 1.0 = 2^30 */
typedef int32_t q16_16_t;   /* lengths in world units */
typedef int32_t q24_8_t;    /* screen coordinates in pixels, 8 sub-pixel bits */
typedef uint32_t uq16_16_t; /* irradiance, exposure, exponents */
typedef uint32_t uq12_20_t; /* exposed radiance on its way to the tone curve: 1.0 = display white; below 2^31 */

/* A direction; components q17_15_t, length 32768 within a few LSB unless said otherwise. */
struct vec3 {
    int32_t x, y, z;
};

/* Keeps a function out of line: where its arguments would be widened to 64 bits, or its registers spilled, if it were inlined, or where
 * copies of it save no time. */
#define FX_NOINLINE __attribute__((noinline))

/* Marks a function that runs seldom, once a frame or for few pixels: compiled for size. */
#define FX_COLD __attribute__((cold))

/* Number of leading zero bits. In: x != 0. Out: 0..31. */
static inline unsigned fx_clz(uint32_t x)
{
    return (unsigned)__builtin_clz(x);
}

/* High word of the 64-bit product, rounded towards minus infinity. Any arguments. */
static inline int32_t fx_mulhi(int32_t a, int32_t b)
{
    return (int32_t)(((int64_t)a * b) >> 32);
}

static inline uint32_t fx_mulhi_u(uint32_t a, uint32_t b)
{
    return (uint32_t)(((uint64_t)a * b) >> 32);
}

/* Square. In: |x| < 2^16. */
static inline uint32_t fx_square(int32_t x)
{
    return (uint32_t)x * (uint32_t)x;
}

/* x / pi, rounded down within one. */
static inline uint32_t fx_over_pi(uint32_t x)
{
    return fx_mulhi_u(x, 1367130551u); /* 2^32 / pi */
}

/* Sum that saturates at 2^31-1. In: a, b < 2^31. */
static inline uint32_t fx_add_sat(uint32_t a, uint32_t b)
{
    uint32_t s = a + b;
    return s > INT32_MAX ? INT32_MAX : s;
}

/* Sum that saturates at 2^32-1. */
static inline uint32_t fx_add_sat_u(uint32_t a, uint32_t b)
{
    uint32_t s = a + b;
    return s < a ? UINT32_MAX : s;
}

/* The nearest number below 2^31. */
static inline uint32_t fx_sat31(uint64_t x)
{
    return x > INT32_MAX ? INT32_MAX : (uint32_t)x;
}

static inline uint64_t fx_magnitude(int64_t x)
{
    return x < 0 ? (uint64_t)0 - (uint64_t)x : (uint64_t)x;
}

static inline int32_t fx_min(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static inline uint32_t fx_min_u(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

static inline int32_t fx_max(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

static inline int32_t fx_clamp(int32_t x, int32_t lo, int32_t hi)
{
    return x < lo ? lo : x > hi ? hi : x;
}

/* The nearest of 0 .. 2^bits - 1, and of -2^(bits - 1) .. 2^(bits - 1) - 1; bits is a constant. */
#ifdef __ARM_FEATURE_SAT
#define fx_clamp_bits(x, bits)   ((uint32_t)__builtin_arm_usat(x, bits))
#define fx_clamp_signed(x, bits) __builtin_arm_ssat(x, bits)
#else
static inline uint32_t fx_clamp_bits(int32_t x, unsigned bits)
{
    return (uint32_t)fx_clamp(x, 0, (int32_t)((1u << bits) - 1));
}

static inline int32_t fx_clamp_signed(int32_t x, unsigned bits)
{
    return fx_clamp(x, -(int32_t)(1u << (bits - 1)), (int32_t)((1u << (bits - 1)) - 1));
}
#endif

/* ~2^61 / x for a normalised x >= 2^31. Out: 2^29 .. 2^30, relative error <= 2^-27: one 16-bit division and one Newton
 * step, whose square of the first error (2^-15) is what remains. */
static inline uint32_t fx_recip(uint32_t x)
{
    uint32_t r0 = UINT32_MAX / (x >> 16);                         /* 2^48/x (1+d), 65537 <= r0 <= 131071 */
    int32_t d = (int32_t)(fx_mulhi_u(x, r0 << 15) - 0x80000000u); /* d * 2^31, |d| <= 2^-15 */
    return (r0 << 13) - (uint32_t)fx_mulhi((int32_t)(r0 << 13), d * 2);
}

/* Dot product of two vectors with |component| <= 2^15 (1.0 = 2^15).
 * Out: 1.0 = 2^30. Bound: unit vectors give |dot| <= 2^30 * (1 + 2^-12), inside int32. */
static inline q2_30_t fx_dot(struct vec3 a, struct vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

#endif
