#include "host_ktx2.h"

#include <string.h>

#include "common.h"

enum {
    VK_FORMAT_E5B9G9R9_UFLOAT_PACK32 = 123,
    HEADER_BYTES = 80,
    LEVEL_INDEX_BYTES = 24,
    DFD_SAMPLES = 6,
    DFD_BLOCK_BYTES = 24 + 16 * DFD_SAMPLES,
    DFD_BYTES = 4 + DFD_BLOCK_BYTES
};

static uint8_t *put_u16(uint8_t *p, uint32_t x)
{
    p[0] = (uint8_t)x;
    p[1] = (uint8_t)(x >> 8);
    return p + 2;
}

static uint8_t *put_u32(uint8_t *p, uint32_t x)
{
    return put_u16(put_u16(p, x & 0xffff), x >> 16);
}

static uint8_t *put_u64(uint8_t *p, uint64_t x)
{
    return put_u32(put_u32(p, (uint32_t)x), (uint32_t)(x >> 32));
}

/* Khronos Data Format Specification 1.3, basic descriptor block of a shared-exponent format: every channel is
 * a mantissa sample and a sample of the common exponent. */
static uint8_t *put_descriptor(uint8_t *p)
{
    p = put_u32(p, DFD_BYTES);
    p = put_u32(p, 0); /* vendor Khronos, basic format */
    p = put_u16(p, 2); /* descriptor version of KDF 1.3 */
    p = put_u16(p, DFD_BLOCK_BYTES);
    p = put_u32(p, 1 | 1 << 8 | 1 << 16); /* RGBSDA, BT.709 primaries, linear transfer, no flags */
    p = put_u32(p, 0);                    /* texel block 1 x 1 x 1 x 1 */
    p = put_u64(p, 4);                    /* plane 0: 4 bytes */
    for (uint32_t channel = 0; channel < 3; channel++) {
        p = put_u32(p, 9 * channel | 8u << 16 | channel << 24); /* bit offset, bit length - 1, channel */
        p = put_u32(p, 0);                                      /* sample position */
        p = put_u32(p, 0);
        p = put_u32(p, 8448);
        p = put_u32(p, 27 | 4u << 16 | (channel | 0x20) << 24); /* 0x20: exponent */
        p = put_u32(p, 0);
        p = put_u32(p, 15); /* bias */
        p = put_u32(p, 31); /* largest exponent */
    }
    return p;
}

static size_t value_bytes(const struct ktx2_pair *pair)
{
    return pair->bytes ? pair->bytes : strlen(pair->value) + 1;
}

static size_t pair_bytes(const struct ktx2_pair *pair)
{
    return strlen(pair->key) + 1 + value_bytes(pair);
}

static size_t padded(size_t bytes)
{
    return (bytes + 3) & ~(size_t)3;
}

uint8_t *ktx2_compose(size_t *bytes, const uint32_t *texels, uint32_t width, uint32_t height, uint32_t depth,
                      const struct ktx2_pair *pairs, size_t pair_count)
{
    static const uint8_t identifier[12] = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};
    size_t dfd = HEADER_BYTES + LEVEL_INDEX_BYTES, kvd = dfd + DFD_BYTES, kvd_bytes = 0;
    for (size_t i = 0; i < pair_count; i++)
        kvd_bytes += 4 + padded(pair_bytes(&pairs[i]));
    size_t level = kvd + kvd_bytes, count = (size_t)width * height * depth;
    *bytes = level + 4 * count;
    uint8_t *file = xcalloc(*bytes, 1), *p = file; /* zeroed: padding is */

    memcpy(p, identifier, sizeof identifier);
    p = put_u32(p + sizeof identifier, VK_FORMAT_E5B9G9R9_UFLOAT_PACK32);
    p = put_u32(p, 4); /* typeSize */
    p = put_u32(p, width);
    p = put_u32(p, height);
    p = put_u32(p, depth);
    p = put_u32(p, 0); /* no array layers */
    p = put_u32(p, 1); /* face */
    p = put_u32(p, 1); /* level */
    p = put_u32(p, 0); /* no supercompression */
    p = put_u32(p, (uint32_t)dfd);
    p = put_u32(p, DFD_BYTES);
    p = put_u32(p, (uint32_t)(kvd_bytes ? kvd : 0));
    p = put_u32(p, (uint32_t)kvd_bytes);
    p = put_u64(p, 0); /* supercompression global data */
    p = put_u64(p, 0);
    p = put_u64(p, level);
    p = put_u64(p, 4 * count);
    p = put_u64(p, 4 * count); /* uncompressed */
    p = put_descriptor(p);
    for (size_t i = 0; i < pair_count; i++) {
        size_t key_bytes = strlen(pairs[i].key) + 1, n = pair_bytes(&pairs[i]);
        p = put_u32(p, (uint32_t)n);
        memcpy(p, pairs[i].key, key_bytes);
        memcpy(p + key_bytes, pairs[i].value, value_bytes(&pairs[i]));
        p += padded(n);
    }
    for (size_t i = 0; i < count; i++)
        p = put_u32(p, texels[i]);
    return file;
}
