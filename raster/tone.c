/*
 * Exposed linear sRGB to finished pixels: tone curve, then sRGB encode (IEC 61966-2-1), then packing; or neither curve for
 * SCENE_TONE_LINEAR.
 *
 * SCENE_TONE_ACES is Stephen Hill's fit of the ACES RRT and sRGB ODT (BakingLab, ACES.hlsl, 2016): a matrix into the
 * fit's space, a rational curve per channel, a matrix back.
 */
#include "internal.h"
#include "display.h"

/* 1.0 = 2^32: the high word of a row's products has the operand's unit. Rows sum to 1. */
static const uint32_t aces_in[9] = {
    2564911519, 1522909504, 207146273,  /* 0.59719 0.35458 0.04823 */
    326417514,  3901290594, 67259188,   /* 0.07600 0.90834 0.01566 */
    121977071,  574795473,  3598194752, /* 0.02840 0.13383 0.83777 */
};
/* 1.0 = 2^22: from the curve's 2^30 to 2^20. Magnitudes in a row sum below 2^24. */
static const int32_t aces_out[9] = {
    6730809, -2227511, -308994, /* 1.60475 -0.53108 -0.07367 */
    -428155, 4647834,  -25376,  /* -0.10208 1.10813 -0.00605 */
    -13715,  -305178,  4513155, /* -0.00327 -0.07276 1.07602 */
};

static inline uint32_t curve(const uint32_t row[3], const uint32_t c[3])
{
    return lut_aces_curve(
        (uint32_t)(((uint64_t)c[0] * row[0] + (uint64_t)c[1] * row[1] + (uint64_t)c[2] * row[2]) >> 32));
}

static inline int32_t linear(const int32_t row[3], uint32_t red, uint32_t green, uint32_t blue)
{
    return (int32_t)(((int64_t)(int32_t)red * row[0] + (int64_t)(int32_t)green * row[1] +
                      (int64_t)(int32_t)blue * row[2]) >>
                     32);
}

/* To signed numbers in the same place. */
static void apply_aces(uint32_t *c, const uint32_t *end)
{
    const uint32_t *in = aces_in;
    const int32_t *out = aces_out;
    __asm__("" : "+r"(in), "+r"(out)); /* in memory, two to an instruction, instead of 18 constants */
    for (; c != end; c += 3) {
        const uint32_t red = curve(in, c), green = curve(in + 3, c), blue = curve(in + 6, c);
        c[0] = (uint32_t)linear(out, red, green, blue);
        c[1] = (uint32_t)linear(out + 3, red, green, blue);
        c[2] = (uint32_t)linear(out + 6, red, green, blue);
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

/* One of 2^bits levels of equal width, white at 2^20 and above. */
#define quantise(x, bits) fx_clamp_bits((int32_t)(x) >> (20 - (bits)), bits)

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
    if (tone_curve == SCENE_TONE_ACES)
        apply_aces(radiance[0], radiance[count]);
#ifdef RASTER_WIDE
    uint8_t code[3 * RASTER_BATCH];
    raster_srgb_wide(code, radiance[0], 3 * count);
    for (uint32_t i = 0; i < count; i++)
        out[i] = pack(code[3 * i], code[3 * i + 1], code[3 * i + 2], format);
#else
    for (const uint32_t *c = radiance[0], *end = radiance[count]; c != end; c += 3)
        *out++ = pack(lut_srgb8((int32_t)c[0]), lut_srgb8((int32_t)c[1]), lut_srgb8((int32_t)c[2]), format);
#endif
}

uint32_t raster_background(const struct raster_frame *f, uint8_t format)
{
    const uint8_t *b = f->output->background;
    return pack(b[0], b[1], b[2], format);
}
