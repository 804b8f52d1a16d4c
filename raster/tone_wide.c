/*
 * The sRGB encode of eight values at once (wide.h): the bits of lut_srgb8.
 */
#if defined(__AVX2__)
#include "func_tables.h"
#include "wide.h"

enum { GROUPS = 3 * RASTER_BATCH / WIDE_LANES };

void raster_srgb_wide(uint8_t code[3 * RASTER_BATCH], const uint32_t *linear, uint32_t count)
{
    const wide octaves = wide_load(func_srgb_octave + 1), first = wide_all(func_srgb_octave[0]);
    wide value[GROUPS], by[GROUPS], node[GROUPS];
    for (uint32_t i = 0; WIDE_LANES * i < count; i++) {
        const wide x = wide_max(wide_min(wide_load(linear + WIDE_LANES * i), wide_all((1u << 20) - 1)), wide_all(3281));
        const struct wide_normal n = wide_normalise(x, x, 19);
        value[i] = n.v;
        by[i] = n.by;
        node[i] = n.v >> 13 & 63;
    }
    uint32_t *const at = wide_lanes(node);
    for (uint32_t i = 0; WIDE_LANES * i < count; i++)
        for (uint32_t j = WIDE_LANES * i; j < WIDE_LANES * (i + 1); j++)
            at[j] = func_srgb_power[at[j]];
    for (uint32_t i = 0; WIDE_LANES * i < count; i++) {
        const wide x = wide_max(wide_load(linear + WIDE_LANES * i), wide_all(0)),
                   p = node[i] + (node[i] & 4095) * (value[i] >> 1 & 4095);
        const wide octave = wide_select((wide)(by[i] == 0), first, wide_look_up(octaves, by[i] - 1));
        const wide power = (wide_mulhi(p, octave) - 56727962u) >> 22;
        const wide line = (x * 843418u + (1u << 27)) >> 28;
        const wide y = wide_select(wide_below(x, wide_all(3281)), line, power);
        const wide_bytes bytes =
            __builtin_shufflevector((wide_bytes)y, (wide_bytes)y, 0, 4, 8, 12, 16, 20, 24, 28, 0, 0, 0, 0, 0, 0, 0, 0,
                                    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
        __builtin_memcpy(code + WIDE_LANES * i, &bytes, WIDE_LANES);
    }
}
#endif
