/*
 * Writes a KTX 2.0 file (Khronos KTX File Format Specification 2.0) holding one 3-D texture of RGB9_E5 words.
 * The reader is lut/ktx2.h.
 */
#ifndef HOST_TOOLS_HOST_KTX2_H
#define HOST_TOOLS_HOST_KTX2_H

#include <stddef.h>
#include <stdint.h>

struct ktx2_pair {
    const char *key;   /* NUL-terminated UTF-8 */
    const void *value; /* `bytes` bytes; when that is 0, NUL-terminated UTF-8, whose NUL is stored */
    size_t bytes;
};

/* The whole file, malloc'd. In: width*height*depth texels, x fastest; pairs in ascending byte order of their
 * keys, as the specification wants them. */
uint8_t *ktx2_compose(size_t *bytes, const uint32_t *texels, uint32_t width, uint32_t height, uint32_t depth,
                      const struct ktx2_pair *pairs, size_t pair_count);

#endif
