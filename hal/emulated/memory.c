/*
 * The four functions that compilers call by themselves. Words where both sides are aligned alike, eight at a
 * time for the clearing of a tile and the copying of rows.
 */
#include <stddef.h>
#include <stdint.h>

typedef uint32_t __attribute__((may_alias)) word;

void *memset(void *to, int value, size_t bytes)
{
    uint8_t *p = to;
    uint32_t pattern = (uint8_t)value * 0x01010101u;
    for (; bytes && (uintptr_t)p % 4; bytes--)
        *p++ = (uint8_t)value;
    word *w = (word *)(void *)p;
    for (; bytes >= 32; bytes -= 32, w += 8)
        w[0] = w[1] = w[2] = w[3] = w[4] = w[5] = w[6] = w[7] = pattern;
    for (; bytes >= 4; bytes -= 4)
        *w++ = pattern;
    for (p = (uint8_t *)w; bytes; bytes--)
        *p++ = (uint8_t)value;
    return to;
}

void *memcpy(void *restrict to, const void *restrict from, size_t bytes)
{
    uint8_t *p = to;
    const uint8_t *q = from;
    if (((uintptr_t)p ^ (uintptr_t)q) % 4 == 0) {
        for (; bytes && (uintptr_t)p % 4; bytes--)
            *p++ = *q++;
        word *w = (word *)(void *)p;
        const word *v = (const word *)(const void *)q;
        for (; bytes >= 16; bytes -= 16, w += 4, v += 4) {
            word a = v[0], b = v[1], c = v[2], d = v[3];
            w[0] = a, w[1] = b, w[2] = c, w[3] = d;
        }
        for (; bytes >= 4; bytes -= 4)
            *w++ = *v++;
        p = (uint8_t *)w;
        q = (const uint8_t *)v;
    }
    while (bytes--)
        *p++ = *q++;
    return to;
}

void *memmove(void *to, const void *from, size_t bytes)
{
    uint8_t *p = to;
    const uint8_t *q = from;
    if ((uintptr_t)p - (uintptr_t)q >= bytes)
        return memcpy(to, from, bytes);
    while (bytes--)
        p[bytes] = q[bytes];
    return to;
}

int memcmp(const void *a, const void *b, size_t bytes)
{
    const uint8_t *p = a, *q = b;
    for (; bytes; bytes--, p++, q++)
        if (*p != *q)
            return *p - *q;
    return 0;
}
