/* A KTX 2.0 writer for exactly one kind of file, field by field after the Khronos specification. */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ref_table.h"

static uint8_t *put(uint8_t *p, uint64_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++) {
        *p++ = (uint8_t)(value >> (8 * i));
    }
    return p;
}

static uint8_t *put_key(uint8_t *p, const char *key, const char *value)
{
    size_t n = strlen(key) + 1 + strlen(value) + 1;
    p = put(p, n, 4);
    strcpy((char *)p, key);
    strcpy((char *)p + strlen(key) + 1, value);
    return put(p + n, 0, (4 - n % 4) % 4);
}

static uint8_t *put_descriptor(uint8_t *p)
{
    p = put(p, 4 + 24 + 6 * 16, 4);
    p = put(p, 0, 4);                                  /* Khronos, basic descriptor */
    p = put(put(p, 2, 2), 24 + 6 * 16, 2);             /* version 1.3, block size */
    p = put(put(put(put(p, 1, 1), 1, 1), 1, 1), 0, 1); /* RGBSDA, BT.709, linear, no flags */
    p = put(put(p, 0, 4), 4, 8);                       /* 1x1x1x1 texel block, 4 bytes in plane 0 */
    for (unsigned channel = 0; channel < 3; channel++) {
        p = put(put(put(p, 9 * channel, 2), 8, 1), channel, 1);
        p = put(put(put(p, 0, 4), 0, 4), 8448, 4);
        p = put(put(put(p, 27, 2), 4, 1), channel | 0x20, 1);
        p = put(put(put(p, 0, 4), 15, 4), 31, 4);
    }
    return p;
}

void *ref_ktx2_make(unsigned width, unsigned height, unsigned depth, const uint32_t *texels, unsigned theta_max,
                    size_t *bytes)
{
    uint8_t keys[256], descriptor[256], *k = keys;
    char decimal[16];
    snprintf(decimal, sizeof decimal, "%u", theta_max);
    k = put_key(k, "KTXwriter", "reference");
    k = put_key(k, "goniotile.kind", "specular_frame");
    k = put_key(k, "goniotile.theta_max", decimal);
    k = put_key(k, "goniotile.version", "1");
    size_t count = (size_t)width * height * depth, dfd = 104,
           dfd_length = (size_t)(put_descriptor(descriptor) - descriptor);
    size_t kvd = dfd + dfd_length, kvd_length = (size_t)(k - keys), data = kvd + kvd_length;
    *bytes = data + 4 * count;
    uint8_t *file = malloc(*bytes), *p = file;
    if (!file) {
        abort();
    }
    memcpy(p, "\xabKTX 20\xbb\r\n\x1a\n", 12);
    const uint32_t header[] = {123,
                               4,
                               width,
                               height,
                               depth,
                               0,
                               1,
                               1,
                               0,
                               (uint32_t)dfd,
                               (uint32_t)dfd_length,
                               (uint32_t)kvd,
                               (uint32_t)kvd_length};
    p += 12;
    for (size_t i = 0; i < sizeof header / sizeof *header; i++) {
        p = put(p, header[i], 4);
    }
    p = put(put(p, 0, 8), 0, 8); /* no supercompression data */
    p = put(put(put(p, data, 8), 4 * count, 8), 4 * count, 8);
    memcpy(p, descriptor, dfd_length);
    memcpy(p + dfd_length, keys, kvd_length);
    p = file + data;
    for (size_t i = 0; i < count; i++) {
        p = put(p, texels[i], 4);
    }
    return file;
}
