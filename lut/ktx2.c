/* Strict reader of the one KTX 2.0 layout that SPEC.md, "Table file", describes. */
#include "ktx2.h"

enum {
    LEVEL_INDEX = 80,
    DESCRIPTOR = LEVEL_INDEX + 24,
    DESCRIPTOR_BYTES = 124,
    KEY_VALUES = DESCRIPTOR + DESCRIPTOR_BYTES
};

static const uint8_t identifier[12] = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};

/* One channel: the mantissa, then the exponent all three share. */
#define SAMPLES(channel, bit)                                                                                          \
    bit, 0, 8, channel, 0, 0, 0, 0, 0, 0, 0, 0, 0x00, 0x21, 0, 0, /* 0..8448 */                                        \
        27, 0, 4, channel | 0x20, 0, 0, 0, 0, 15, 0, 0, 0, 31, 0, 0, 0

// clang-format off
static const uint8_t descriptor[DESCRIPTOR_BYTES] = {
    124, 0, 0, 0, 0, 0, 0, 0,                         /* total size; Khronos basic descriptor */
    2, 0, 120, 0, 1, 1, 1, 0,                         /* version, block size; RGBSDA, BT.709, linear, no flags */
    0, 0, 0, 0, 4, 0, 0, 0, 0, 0, 0, 0,               /* 1x1x1x1 block, 4 bytes in plane 0 */
    SAMPLES(0, 0), SAMPLES(1, 9), SAMPLES(2, 18),
};
// clang-format on

const char *lut_status_text(enum lut_status s)
{
    static const char *const text[LUT_STATUS_COUNT] = {
        [LUT_OK] = "no error",
        [LUT_ERR_TRUNCATED] = "the file's size is not what its header says",
        [LUT_ERR_ALIGNMENT] = "the buffer is not 4-aligned",
        [LUT_ERR_IDENTIFIER] = "not a KTX 2.0 file",
        [LUT_ERR_FORMAT] = "not uncompressed E5B9G9R9 texels",
        [LUT_ERR_DIMENSIONS] = "not one 3-D image of an accepted size",
        [LUT_ERR_DESCRIPTOR] = "the data format descriptor is not that of E5B9G9R9",
        [LUT_ERR_KEY_VALUES] = "the key/value data is malformed",
        [LUT_ERR_KIND] = "the kind of table is missing or unknown",
        [LUT_ERR_VERSION] = "the table's version is missing or newer than this reader",
        [LUT_ERR_AXES] = "the table's axes are missing or out of range",
        [LUT_ERR_WARP] = "a warp is missing, not monotone or does not end at the last node",
        [LUT_ERR_EXPONENT] = "the cell exponents or the scale are missing or out of range",
        [LUT_ERR_SLABS] = "the re-packed copy is cut short, points outside itself or contradicts its cells",
    };
    return (unsigned)s < LUT_STATUS_COUNT ? text[s] : "unknown status";
}

static uint32_t read32(const uint8_t *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

/* True when the 64-bit field at p is `value`. */
static bool equals64(const uint8_t *p, uint32_t value)
{
    return read32(p) == value && read32(p + 4) == 0;
}

static bool equals_bytes(const uint8_t *a, const uint8_t *b, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        if (a[i] != b[i]) {
            return false;
        }
    }
    return true;
}

/* Bytes up to and without the first NUL, or `limit` when there is none. */
FX_COLD static uint32_t string_length(const uint8_t *s, uint32_t limit)
{
    uint32_t n = 0;
    while (n < limit && s[n] != 0) {
        n++;
    }
    return n;
}

/* Every entry: length, a NUL-terminated key of at least one byte, value, zeros up to a multiple of 4. */
static bool key_values_valid(const uint8_t *kvd, uint32_t bytes)
{
    while (bytes > 0) {
        uint32_t length = bytes >= 4 ? read32(kvd) : 0;
        if (length < 2 || length > bytes - 4) {
            return false;
        }
        uint32_t padding = (0u - length) & 3; /* length + 4 <= bytes: no overflow */
        uint32_t key = string_length(kvd + 4, length);
        if (key == 0 || key == length || padding > bytes - 4 - length) {
            return false;
        }
        for (uint32_t i = 0; i < padding; i++) {
            if (kvd[4 + length + i] != 0) {
                return false;
            }
        }
        kvd += 4 + length + padding;
        bytes -= 4 + length + padding;
    }
    return true;
}

static enum lut_status check_dimensions(uint32_t *texels, const uint8_t *p)
{
    uint32_t w = read32(p + 20), h = read32(p + 24), d = read32(p + 28);
    if (w - 1 >= KTX2_MAX_EXTENT || h - 1 >= KTX2_MAX_EXTENT || d - 1 >= KTX2_MAX_EXTENT || read32(p + 32) != 0 ||
        read32(p + 36) != 1 || read32(p + 40) != 1) {
        return LUT_ERR_DIMENSIONS;
    }
    if (w * h > KTX2_MAX_TEXELS / d) { /* w h <= 2^24 */
        return LUT_ERR_DIMENSIONS;
    }
    *texels = w * h * d;
    return LUT_OK;
}

enum lut_status ktx2_open(struct ktx2_view *out, const void *file, size_t bytes)
{
    const uint8_t *p = file;
    uint32_t texels;
    if (((uintptr_t)file & 3) != 0) {
        return LUT_ERR_ALIGNMENT;
    }
    if (bytes < sizeof identifier) {
        return LUT_ERR_TRUNCATED;
    }
    if (!equals_bytes(p, identifier, sizeof identifier)) {
        return LUT_ERR_IDENTIFIER;
    }
    if (bytes < KEY_VALUES) {
        return LUT_ERR_TRUNCATED;
    }
    /* vkFormat, typeSize, supercompression scheme, its global data */
    if (read32(p + 12) != 123 || read32(p + 16) != 4 || read32(p + 44) != 0 || !equals64(p + 64, 0) ||
        !equals64(p + 72, 0)) {
        return LUT_ERR_FORMAT;
    }
    enum lut_status s = check_dimensions(&texels, p);
    if (s != LUT_OK) {
        return s;
    }
    if (read32(p + 48) != DESCRIPTOR || read32(p + 52) != DESCRIPTOR_BYTES ||
        !equals_bytes(p + DESCRIPTOR, descriptor, DESCRIPTOR_BYTES)) {
        return LUT_ERR_DESCRIPTOR;
    }
    /* The parts follow each other without gaps: key/value data is a multiple of 4 long, so the texels are aligned. */
    uint32_t kvd_bytes = read32(p + 60);
    if (read32(p + 56) != (kvd_bytes == 0 ? 0 : KEY_VALUES)) {
        return LUT_ERR_KEY_VALUES;
    }
    if (kvd_bytes > bytes - KEY_VALUES) {
        return LUT_ERR_TRUNCATED;
    }
    if (!key_values_valid(p + KEY_VALUES, kvd_bytes)) {
        return LUT_ERR_KEY_VALUES;
    }
    uint32_t data = KEY_VALUES + kvd_bytes; /* wraps only in files that are too large anyway */
    if (!equals64(p + LEVEL_INDEX, data) || !equals64(p + LEVEL_INDEX + 8, 4 * texels) ||
        !equals64(p + LEVEL_INDEX + 16, 4 * texels) || bytes - data != 4 * texels) {
        return LUT_ERR_TRUNCATED;
    }
    out->texels = (const uint32_t *)(const void *)(p + data);
    out->width = read32(p + 20);
    out->height = read32(p + 24);
    out->depth = read32(p + 28);
    out->kvd = p + KEY_VALUES;
    out->kvd_bytes = kvd_bytes;
    return LUT_OK;
}

const uint8_t *ktx2_find_bytes(const struct ktx2_view *v, const char *key, uint32_t *bytes)
{
    const uint8_t *p = v->kvd, *end = v->kvd + v->kvd_bytes;
    const uint8_t *name = (const uint8_t *)key;
    uint32_t name_bytes = string_length(name, UINT32_MAX) + 1; /* with its NUL */
    while (p < end) {
        uint32_t length = read32(p);
        if (name_bytes <= length && equals_bytes(p + 4, name, name_bytes)) {
            *bytes = length - name_bytes;
            return p + 4 + name_bytes;
        }
        p += 4 + ((length + 3) & ~3u);
    }
    return NULL;
}

const uint8_t *ktx2_find(const struct ktx2_view *v, const char *key, uint32_t *bytes)
{
    const uint8_t *value = ktx2_find_bytes(v, key, bytes);
    if (value != NULL && *bytes > 0 && value[*bytes - 1] == 0) {
        --*bytes;
    }
    return value;
}
