/* A KTX 2.0 writer for RGB9_E5 volumes, field by field after the Khronos specification, and the keys of our tables. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ref_table.h"

static uint8_t *put(uint8_t *p, uint64_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++)
        *p++ = (uint8_t)(value >> (8 * i));
    return p;
}

static void *allocate(size_t bytes)
{
    void *p = calloc(bytes + 1, 1);
    if (!p)
        abort();
    return p;
}

void ref_key_remove(struct ref_keys *k, const char *name)
{
    for (unsigned i = 0; i < k->count; i++)
        if (!strcmp(k->key[i].name, name)) {
            free(k->key[i].value);
            memmove(&k->key[i], &k->key[i + 1], (k->count - i - 1) * sizeof *k->key);
            k->count--;
            return;
        }
}

void ref_key_set(struct ref_keys *k, const char *name, const void *value, size_t bytes)
{
    uint8_t *copy = allocate(bytes);
    memcpy(copy, value, bytes);
    ref_key_remove(k, name);
    if (k->count == REF_MAX_KEYS)
        abort();
    unsigned at = k->count++;
    for (; at > 0 && strcmp(k->key[at - 1].name, name) > 0; at--)
        k->key[at] = k->key[at - 1];
    k->key[at] = (struct ref_key){name, copy, bytes};
}

void ref_key_set_text(struct ref_keys *k, const char *name, const char *text)
{
    ref_key_set(k, name, text, strlen(text) + 1);
}

void ref_keys_free(struct ref_keys *k)
{
    while (k->count)
        ref_key_remove(k, k->key[0].name);
}

static uint8_t *put_key(uint8_t *p, const struct ref_key *k)
{
    size_t name = strlen(k->name) + 1, n = name + k->bytes;
    p = put(p, n, 4);
    memcpy(p, k->name, name);
    memcpy(p + name, k->value, k->bytes);
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

void *ref_ktx2_write(unsigned width, unsigned height, unsigned depth, const uint32_t *texels, const struct ref_keys *k,
                     size_t *bytes)
{
    size_t count = (size_t)width * height * depth, room = 0;
    uint8_t descriptor[256];
    for (unsigned i = 0; i < k->count; i++)
        room += 8 + strlen(k->key[i].name) + 1 + k->key[i].bytes;
    uint8_t *keys = allocate(room), *end = keys;
    for (unsigned i = 0; i < k->count; i++)
        end = put_key(end, &k->key[i]);
    size_t dfd = 104, dfd_length = (size_t)(put_descriptor(descriptor) - descriptor);
    size_t kvd = dfd + dfd_length, kvd_length = (size_t)(end - keys), data = kvd + kvd_length;
    *bytes = data + 4 * count;
    uint8_t *file = malloc(*bytes), *p = file; /* no byte more: a sanitizer sees a read beyond */
    if (!file)
        abort();
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
    for (size_t i = 0; i < sizeof header / sizeof *header; i++)
        p = put(p, header[i], 4);
    p = put(put(p, 0, 8), 0, 8); /* no supercompression data */
    p = put(put(put(p, data, 8), 4 * count, 8), 4 * count, 8);
    memcpy(p, descriptor, dfd_length);
    memcpy(p + dfd_length, keys, kvd_length);
    p = file + data;
    for (size_t i = 0; i < count; i++)
        p = put(p, texels[i], 4);
    free(keys);
    return file;
}

void *ref_ktx2_make(unsigned width, unsigned height, unsigned depth, const uint32_t *texels, unsigned theta_max,
                    size_t *bytes)
{
    struct ref_keys k = {.count = 0};
    char decimal[16];
    snprintf(decimal, sizeof decimal, "%u", theta_max);
    ref_key_set_text(&k, "KTXwriter", "reference");
    ref_key_set_text(&k, "goniotile.kind", "specular_frame");
    ref_key_set_text(&k, "goniotile.theta_max", decimal);
    ref_key_set_text(&k, "goniotile.version", "1");
    void *file = ref_ktx2_write(width, height, depth, texels, &k, bytes);
    ref_keys_free(&k);
    return file;
}

/* Cell (i, j): the largest exponent of its 4T texels. */
static unsigned cell_exponent(const struct ref_half *f, unsigned i, unsigned j)
{
    unsigned largest = 0;
    for (unsigned corner = 0; corner < 4; corner++)
        for (unsigned k = 0; k < f->t; k++) {
            unsigned e = f->texels[k + f->t * (i + corner % 2 + f->h * (j + corner / 2))] >> 27;
            largest = e > largest ? e : largest;
        }
    return largest;
}

/* A texel's channel as the slabs hold it. */
static uint32_t slab_mantissa(uint32_t texel, unsigned channel, unsigned exponent)
{
    unsigned shift = exponent - (texel >> 27);
    return shift > 31 ? 0 : ((texel >> (9 * channel) & 511) << 6) >> shift;
}

static uint8_t *put_slab_row(uint8_t *p, const struct ref_half *f, unsigned i, unsigned j, unsigned exponent)
{
    for (unsigned k = 0; k < f->t; k++)
        for (unsigned c = 0; c < 3; c++) {
            uint32_t near = f->texels[k + f->t * (i + f->h * j)], far = f->texels[k + f->t * (i + f->h * (j + 1))];
            p = put(p, slab_mantissa(near, c, exponent) | slab_mantissa(far, c, exponent) << 16, 4);
        }
    return p;
}

static void set_slabs(struct ref_keys *keys, const struct ref_half *f)
{
    unsigned rows = f->h - 1, planes = f->d - 1, row_bytes = 12 * f->t;
    uint8_t *value = allocate((size_t)rows * planes * (4 + 2 * row_bytes)), *p = value + 4 * rows * planes;
    for (unsigned j = 0; j < planes; j++)
        for (unsigned i = 0; i < rows; i++) {
            unsigned e = cell_exponent(f, i, j);
            if (i == 0 || e != cell_exponent(f, i - 1, j))
                p = put_slab_row(p, f, i, j, e);
            put(value + 4 * (j * rows + i), (uint64_t)(p - value - row_bytes) << 8 | e, 4);
            p = put_slab_row(p, f, i + 1, j, e);
        }
    ref_key_set(keys, "goniotile.slabs", value, (size_t)(p - value));
    free(value);
}

static void set_warp(struct ref_keys *k, const char *name, const uint16_t *warp, unsigned nodes)
{
    uint8_t value[2 * REF_WARP_H];
    for (unsigned i = 0; i < nodes; i++)
        put(value + 2 * i, warp[i], 2);
    ref_key_set(k, name, value, 2 * nodes);
}

void ref_half_keys(struct ref_keys *k, const struct ref_half *f)
{
    uint8_t cells[128 * 128];
    unsigned rows = f->h - 1, planes = f->d - 1;
    k->count = 0;
    ref_key_set_text(k, "KTXwriter", "reference");
    ref_key_set_text(k, "goniotile.kind", "half_vector");
    ref_key_set_text(k, "goniotile.version", "1");
    for (unsigned i = 0; i < rows * planes; i++)
        cells[i] = (uint8_t)cell_exponent(f, i % rows, i / rows);
    ref_key_set(k, "goniotile.cells", cells, rows * planes);
    set_warp(k, "goniotile.warph", f->warp_h, REF_WARP_H);
    set_warp(k, "goniotile.warpd", f->warp_d, REF_WARP_D);
    if (f->scale) {
        char decimal[16];
        snprintf(decimal, sizeof decimal, "%d", f->scale);
        ref_key_set_text(k, "goniotile.scale", decimal);
    }
    if (f->slabs)
        set_slabs(k, f);
}

void *ref_half_make(const struct ref_half *f, size_t *bytes)
{
    struct ref_keys k;
    ref_half_keys(&k, f);
    void *file = ref_ktx2_write(f->t, f->h, f->d, f->texels, &k, bytes);
    ref_keys_free(&k);
    return file;
}
