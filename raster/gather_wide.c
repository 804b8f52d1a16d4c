/*
 * Normals of surfaces side by side, eight at once (wide.h): the bits of raster_eye_normal.
 */
#if defined(__AVX2__)
#include "wide.h"

/* d 2^17 / den, rounded down, at most 2^16. In: d <= 2^15; den 2^16 .. 2^18. */
static inline wide ratio_of(wide d, wide den)
{
    const wide up = wide_below(den, wide_all(1u << 17)) & 1;
    const wide inverse = wide_reciprocal(wide_min(den << up >> 2, wide_all(65535)));
    wide q = (d << up) * inverse >> 16, rest = (d << 17) - q * den; /* off by less than 8 */
    const wide more = wide_shift_signed(wide_shift_signed(rest << up, 8) * inverse, 25);
    q += more;
    rest -= more * den;
    return q + wide_below(rest, wide_all(0)) + wide_below(rest, den) + 1;
}

/* High words of 32 (f[0] x + f[1] y + f[2] z). */
static inline wide row_high(const int16_t f[3], const wide c[3])
{
    wide_long even = {0, 0, 0, 0}, odd = even;
    for (int i = 0; i < 3; i++) {
        const wide_int k = (wide_int)wide_all((uint32_t)(f[i] * 32));
        even += (wide_long)__builtin_ia32_pmuldq256((wide_int)c[i], k);
        odd += (wide_long)__builtin_ia32_pmuldq256((wide_int)((wide_long)c[i] >> 32), k);
    }
    return wide_high_words(even, odd);
}

static inline wide clamp16(wide x)
{
    return wide_min(wide_max(x, wide_all((uint32_t)-32768)), wide_all(32767));
}

uint32_t raster_gather_wide(struct raster_batch_pixel out[8], const struct raster_surface s[8],
                            const struct raster_slot *slot, const int32_t view[3], const struct raster_plane plane[3],
                            uint32_t at)
{
    const unsigned shift = slot->normal_shift;
    const wide iota = {0, 1, 2, 3, 4, 5, 6, 7};
    const wide s0 = wide_load(&s[0].depth_slot), s1 = wide_load(&s[4].depth_slot);
    const wide depth = __builtin_shufflevector(s0, s1, 0, 2, 4, 6, 8, 10, 12, 14),
               uv = __builtin_shufflevector(s0, s1, 1, 3, 5, 7, 9, 11, 13, 15);
    wide d = (depth >> 8) + (uint32_t)((1 << shift >> 1) - (int32_t)DEPTH_BIAS);
    d = wide_max(wide_shift_signed(d, (int)shift), wide_all(64));
    wide den = d * d + wide_dot16(uv, uv), k = wide_all(0); /* 2^12 .. 2^30, to 2^28 .. 2^30 */
    for (unsigned step = 8; step; step >>= 1) {
        const wide by = wide_below(den, wide_all(1u << (30 - 2 * step))) & step;
        den <<= 2 * by;
        k += by;
    }
    d <<= k;
    const wide m = ratio_of(d, (den + (1u << 11)) >> 12);
    const wide local[3] = {(wide_shift_signed(uv << 16, 16) << k) * m, (wide_shift_signed(uv, 16) << k) * m,
                           d * m - (1u << 28)};
    wide n[3], nv = wide_all(0);
    for (int i = 0; i < 3; i++) {
        n[i] = row_high(slot->frame + 3 * i, local);
        nv += n[i] * wide_shift_signed((uint32_t)view[i] + iota * plane[i].dx, VIEW_PLANE_BITS);
        n[i] = clamp16(n[i]);
    }
    const wide xy = (n[0] & 0xffff) | n[1] << 16, place = at + iota;
    const wide low0 = __builtin_shufflevector(xy, n[2], 0, 8, 1, 9, 4, 12, 5, 13),
               low1 = __builtin_shufflevector(xy, n[2], 2, 10, 3, 11, 6, 14, 7, 15),
               high0 = __builtin_shufflevector(nv, place, 0, 8, 1, 9, 4, 12, 5, 13),
               high1 = __builtin_shufflevector(nv, place, 2, 10, 3, 11, 6, 14, 7, 15);
    const wide pixels04 = __builtin_shufflevector(low0, high0, 0, 1, 8, 9, 4, 5, 12, 13),
               pixels15 = __builtin_shufflevector(low0, high0, 2, 3, 10, 11, 6, 7, 14, 15),
               pixels26 = __builtin_shufflevector(low1, high1, 0, 1, 8, 9, 4, 5, 12, 13),
               pixels37 = __builtin_shufflevector(low1, high1, 2, 3, 10, 11, 6, 7, 14, 15);
    uint32_t *to = &out[0].normal_xy;
    wide_store_words(to, __builtin_shufflevector(pixels04, pixels15, 0, 1, 2, 3, 8, 9, 10, 11));
    wide_store_words(to + 8, __builtin_shufflevector(pixels26, pixels37, 0, 1, 2, 3, 8, 9, 10, 11));
    wide_store_words(to + 16, __builtin_shufflevector(pixels04, pixels15, 4, 5, 6, 7, 12, 13, 14, 15));
    wide_store_words(to + 24, __builtin_shufflevector(pixels26, pixels37, 4, 5, 6, 7, 12, 13, 14, 15));
    return wide_mask(wide_below(nv, wide_all(1u << 23)));
}
#endif
