#include "interpolate.h"

/* Splits weight w, at most 2^20, by the fraction: the upper part is returned and taken off w, so that the total stays. */
static uint32_t weight_split(uint32_t *w, uint32_t fraction)
{
    uint32_t upper = (uint32_t)(((uint64_t)*w * fraction + 32768) >> 16);
    *w -= upper;
    return upper;
}

struct tap {
    uint32_t texel, weight;
};

/* Fetches a row's two texels and splits the row's weight between them. Returns the largest exponent so far. */
static uint32_t row_fetch(struct tap out[2], const uint32_t *row, struct lut_cell x, uint32_t weight, uint32_t largest)
{
    out[0].texel = row[0];
    out[1].texel = row[x.step];
    out[1].weight = weight_split(&weight, x.fraction);
    out[0].weight = weight;
    largest = out[0].texel >> 27 > largest ? out[0].texel >> 27 : largest;
    return out[1].texel >> 27 > largest ? out[1].texel >> 27 : largest;
}

struct lut_rgb lut_interpolate(const uint32_t *texels, uint32_t width, uint32_t height, struct lut_cell x,
                               struct lut_cell y, struct lut_cell z)
{
    struct tap taps[8];
    uint32_t w00 = 1u << 20, w10 = weight_split(&w00, z.fraction);
    uint32_t w01 = weight_split(&w00, y.fraction), w11 = weight_split(&w10, y.fraction);
    const uint32_t *first = texels + (z.node * height + y.node) * width + x.node; /* < 2^24 */
    const uint32_t *second = first + z.step * width * height;
    uint32_t row = y.step * width;
    uint32_t largest = row_fetch(taps, first, x, w00, 0);
    largest = row_fetch(taps + 2, first + row, x, w01, largest);
    largest = row_fetch(taps + 4, second, x, w10, largest);
    largest = row_fetch(taps + 6, second + row, x, w11, largest);

    struct lut_rgb sum = {{0, 0, 0}, (int32_t)largest - 24 - 20};
    for (int i = 0; i < 8; i++) {
        struct lut_rgb m = lut_rgb9e5_decode(taps[i].texel);
        uint32_t weight = taps[i].weight >> (largest - (taps[i].texel >> 27));
        for (int k = 0; k < 3; k++) {
            sum.c[k] += m.c[k] * weight;
        }
    }
    return sum;
}
