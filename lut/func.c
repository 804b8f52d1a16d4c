/* Elementary functions: see func.h for units and errors, func_tables.h for the nodes. */
#include "func.h"
#include "func_tables.h"

/* Second-order (Bessel) interpolation between t[0] and t[1]; t[-1] and t[2] must exist. In: f in [0, 1] with
 * 1.0 = 2^31. Differences of neighbours are below 2^28 in every table, so no sum overflows. Everything is written in
 * g = f - 1, which is never positive: compilers then multiply signed by signed, in one instruction. */
static int32_t interpolate(const int32_t *t, uint32_t f)
{
    int32_t g = (int32_t)(f ^ 0x80000000u);
    int32_t d1 = t[1] - t[0];
    int32_t d2 = t[2] - t[1] - t[0] + t[-1];                              /* twice the mean second difference */
    int32_t bow = fx_mulhi(g, g) + (g >> 1);                              /* -f (1-f), 1.0 = 2^30 */
    return t[1] + (int32_t)(((int64_t)d1 * g) >> 31) + fx_mulhi(d2, bow); /* bow * d2 / 4 */
}

uint32_t lut_rsqrt(uint32_t x, unsigned *shift)
{
    unsigned z = fx_clz(x) & ~1u;
    uint32_t f = x << z;         /* [2^30, 2^32): [1, 4) with 1.0 = 2^30 */
    uint32_t i = (f >> 26) - 16; /* 0..47 */
    uint32_t a = func_rsqrt[i], b = func_rsqrt[i + 1];
    uint32_t y = (a << 16) - (a - b) * (f >> 10 & 0xffff);     /* 1.0 = 2^31, chord: at most 4e-4 too large */
    uint32_t d = (3u << 28) - fx_mulhi_u(f, fx_mulhi_u(y, y)); /* 3 - f y^2, 1.0 = 2^28 */
    uint32_t m = fx_mulhi_u(y, d) << 3;                        /* y d / 2, 1.0 = 2^31; at most 2^31 */
    *shift = 16 - z / 2;
    return m < 1u << 30 ? 1u << 30 : m;
}

uint32_t lut_log2(uint32_t x)
{
    unsigned z = fx_clz(x);
    uint32_t m = x << z; /* 1.0 = 2^31 */
    uint32_t i = m >> 25 & 63;
    uint32_t f = m << 6 & INT32_MAX;
    return (31 - z) * (1u << 25) + (uint32_t)interpolate(func_log2 + 1 + i, f);
}

uint32_t lut_exp2_neg(uint32_t y)
{
    uint32_t n = y >> 25;
    if (n >= 31) {
        return 0;
    }
    uint32_t m = (uint32_t)interpolate(func_exp2 + 1 + (y >> 21 & 15), y << 10 & INT32_MAX);
    return (m + (1u << n >> 1)) >> n; /* m <= 2^30 */
}

uint32_t lut_angle_from_sin2_half(uint32_t s2)
{
    if (s2 == 0) {
        return 0;
    }
    if (s2 > 1u << 29) {
        s2 = 1u << 29;
    }
    /* angle = sqrt(s2) g(s2), g smooth */
    uint32_t g = (uint32_t)interpolate(func_angle + 1 + (s2 >> 26), s2 << 5 & INT32_MAX); /* 1.0 = 2^31 */
    unsigned shift;
    uint32_t r = lut_rsqrt(s2, &shift);
    uint32_t s = fx_mulhi_u(s2 << (32 - 2 * shift), r); /* sqrt(s2) * 2^(45 - shift), below 2^31 */
    shift = 16 - shift;                                 /* 1..15 */
    return (fx_mulhi_u(s, g) + (1u << shift >> 1)) >> shift;
}

uint32_t lut_turn(int32_t y, int32_t x)
{
    uint32_t ax = x < 0 ? 0u - (uint32_t)x : (uint32_t)x;
    uint32_t ay = y < 0 ? 0u - (uint32_t)y : (uint32_t)y; /* at most 2^31 */
    uint32_t small = ax < ay ? ax : ay, large = ax < ay ? ay : ax;
    if (large == 0) {
        return 0;
    }
    unsigned z = fx_clz(large);
    uint32_t d = fx_add_sat_u(large << z, 1u << 15) >> 16; /* 2^15..2^16-1 */
    uint32_t q = fx_add_sat_u(small << z, d >> 1) / d;     /* small/large, 1.0 = 2^16 */
    if (q > 65535) {
        q = 65535;
    }
    uint32_t a = (uint32_t)interpolate(func_atan + 1 + (q >> 12), (q & 4095) << 19);
    a = ax < ay ? (1u << 26) - a : a;
    a = x < 0 ? (1u << 27) - a : a;
    return (y < 0 ? (1u << 28) - a : a) & ((1u << 28) - 1);
}
