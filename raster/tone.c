/*
 * Exposed linear sRGB to display bytes: tone curve, then sRGB encode (IEC 61966-2-1).
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

uint32_t raster_tone(const uq12_20_t radiance[3], uint8_t tone_curve)
{
    uint32_t c[3] = {radiance[0], radiance[1], radiance[2]};
    if (tone_curve == SCENE_TONE_ACES) {
        int32_t curve[3];
        for (int i = 0; i < 3; i++) { /* <= 2^32, rows sum to 2^16 */
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
    return lut_srgb8(c[0]) | (uint32_t)lut_srgb8(c[1]) << 8 | (uint32_t)lut_srgb8(c[2]) << 16;
}
