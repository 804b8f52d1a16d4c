/*
 * Exposed linear sRGB to finished pixels: tone curve, then sRGB encode (IEC 61966-2-1), then packing; or neither curve for
 * SCENE_TONE_LINEAR.
 *
 * SCENE_TONE_ACES is Stephen Hill's fit of the ACES RRT and sRGB ODT (BakingLab, ACES.hlsl, 2016): a matrix into the
 * fit's space, a rational curve per channel, a matrix back. Matrices in Q16.
 */
#include "internal.h"
#include "func.h"

static const int32_t aces_in[9] = {
    39137, 23238, 3161,  /* 0.59719 0.35458 0.04823 */
    4981,  59529, 1026,  /* 0.07600 0.90834 0.01566 */
    1861,  8771,  54904, /* 0.02840 0.13383 0.83777 */
};
static const int32_t aces_out[9] = {
    105169, -34805, -4828, /* 1.60475 -0.53108 -0.07367 */
    -6690,  72622,  -396,  /* -0.10208 1.10813 -0.00605 */
    -214,   -4768,  70518, /* -0.00327 -0.07276 1.07602 */
};

static void apply_aces(uint32_t c[3])
{
    int32_t curve[3];
    for (int i = 0; i < 3; i++) { /* < 2^32, rows sum to 2^16 */
        uint64_t x = ((uint64_t)c[0] * (uint32_t)aces_in[3 * i] + (uint64_t)c[1] * (uint32_t)aces_in[3 * i + 1] +
                      (uint64_t)c[2] * (uint32_t)aces_in[3 * i + 2]) >>
                     16;
        curve[i] = (int32_t)lut_aces_curve(x > UINT32_MAX ? UINT32_MAX : (uint32_t)x); /* <= 2^20 */
    }
    for (int i = 0; i < 3; i++) { /* |coefficients| sum below 2^18: 2^38 */
        int64_t x = ((int64_t)curve[0] * aces_out[3 * i] + (int64_t)curve[1] * aces_out[3 * i + 1] +
                     (int64_t)curve[2] * aces_out[3 * i + 2]) >>
                    16;
        c[i] = x < 0 ? 0 : (uint32_t)x;
    }
}

/* RGB565: nearest of 32 and 64 levels, (x * 31 + 127) / 255 without the division, exact for 0..255. */
static inline uint32_t pack(uint32_t red, uint32_t green, uint32_t blue, uint8_t format)
{
    if (format == RASTER_RGB565)
        return (red * 249 + 1014) >> 11 << 11 | (green * 253 + 505) >> 10 << 5 | (blue * 249 + 1014) >> 11;
    return red | green << 8 | blue << 16;
}

uint32_t raster_pack(uint32_t bgr, uint8_t format)
{
    return pack(bgr & 255, bgr >> 8 & 255, bgr >> 16 & 255, format);
}

/* One of 2^bits levels of equal width, white at 2^20 and above. Signed, for it is one instruction on ARM then. */
static inline uint32_t quantise(uq12_20_t x, unsigned bits)
{
    return (uint32_t)fx_clamp((int32_t)x >> (20 - bits), 0, (1 << bits) - 1);
}

void raster_finish_pixels(uint32_t *out, uq12_20_t radiance[][3], uint32_t count, uint8_t tone_curve, uint8_t format)
{
    if (tone_curve == SCENE_TONE_LINEAR) {
        const uint32_t *c = radiance[0];
        uint32_t *end = out + count;
        if (format == RASTER_RGB565) {
            for (; out != end; c += 3)
                *out++ = quantise(c[0], 5) << 11 | quantise(c[1], 6) << 5 | quantise(c[2], 5);
        } else {
            for (; out != end; c += 3)
                *out++ = quantise(c[0], 8) | quantise(c[1], 8) << 8 | quantise(c[2], 8) << 16;
        }
        return;
    }
#ifdef RASTER_WIDE
    if (tone_curve == SCENE_TONE_NONE) {
        uint8_t code[3 * RASTER_BATCH];
        raster_srgb_wide(code, radiance[0], 3 * count);
        for (uint32_t i = 0; i < count; i++)
            out[i] = pack(code[3 * i], code[3 * i + 1], code[3 * i + 2], format);
        return;
    }
#endif
    for (uint32_t i = 0; i < count; i++) {
        uint32_t c[3] = {radiance[i][0], radiance[i][1], radiance[i][2]};
        if (tone_curve == SCENE_TONE_ACES)
            apply_aces(c);
        out[i] = pack(lut_srgb8(c[0]), lut_srgb8(c[1]), lut_srgb8(c[2]), format);
    }
}

uint32_t raster_background(const struct raster_frame *f, uint8_t format)
{
    const uint8_t *b = f->output->background;
    return pack(b[0], b[1], b[2], format);
}
