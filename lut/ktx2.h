/*
 * Read-only view of a KTX 2.0 file (Khronos KTX File Format Specification 2.0) that holds one 3-D texture of
 * E5B9G9R9_UFLOAT_PACK32 words. The bytes are read in place; every offset and length is checked against the
 * file's size, and against each other, before it is used.
 */
#ifndef LUT_KTX2_H
#define LUT_KTX2_H

#include "fixed.h"

enum lut_status {
    LUT_OK = 0,
    LUT_ERR_TRUNCATED,  /* shorter, or longer, than its own header and level index say */
    LUT_ERR_ALIGNMENT,  /* the buffer is not 4-aligned */
    LUT_ERR_IDENTIFIER, /* not KTX 2.0 */
    LUT_ERR_FORMAT, /* vkFormat, typeSize or supercompression other than what section "Table file" of SPEC.md says */
    LUT_ERR_DIMENSIONS, /* zero, too large, not 3-D, layers, faces or levels */
    LUT_ERR_DESCRIPTOR, /* data format descriptor differs from the one SPEC.md gives */
    LUT_ERR_KEY_VALUES, /* key/value data malformed */
    LUT_ERR_KIND,       /* goniotile.kind missing or unknown */
    LUT_ERR_VERSION,    /* goniotile.version missing or newer than this reader */
    LUT_ERR_AXES,       /* goniotile.* metadata missing, out of range or inconsistent with the dimensions */
    LUT_ERR_WARP,       /* a warp missing, of the wrong length, decreasing, or not from the first to the last node */
    LUT_ERR_EXPONENT,   /* cell exponents missing or above 31, scale out of range */
    LUT_ERR_SLABS,      /* the re-packed copy is cut short, points outside itself or contradicts its cells */
    LUT_STATUS_COUNT
};

/* A short lower-case English sentence for a status, constant storage. */
const char *lut_status_text(enum lut_status s);

struct ktx2_view {
    const uint32_t *texels; /* width*height*depth words, x fastest; points into the file */
    uint32_t width, height, depth;
    const uint8_t *kvd; /* key/value data */
    uint32_t kvd_bytes;
};

/* Largest extent accepted on any axis; the product of all three is at most 2^24 texels (64 MB). */
#define KTX2_MAX_EXTENT 4096u
#define KTX2_MAX_TEXELS (1u << 24)

/* Validates and fills *out (untouched on error). In: file of exactly `bytes` bytes, 4-aligned, stays owned by the
 * caller and must outlive the view. No texel is read. */
enum lut_status ktx2_open(struct ktx2_view *out, const void *file, size_t bytes);

/* Value bytes of a key in an opened view, or NULL; of duplicates the first. *bytes excludes a terminating NUL if
 * there is one. */
const uint8_t *ktx2_find(const struct ktx2_view *v, const char *key, uint32_t *bytes);
/* The same with every byte counted, for values that are not text. Any alignment but that of the key's length. */
const uint8_t *ktx2_find_bytes(const struct ktx2_view *v, const char *key, uint32_t *bytes);

#endif
