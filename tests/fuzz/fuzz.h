/*
 * What the fuzz harnesses share: libFuzzer's entry point and a reader that takes an input apart.
 */
#ifndef TESTS_FUZZ_FUZZ_H
#define TESTS_FUZZ_FUZZ_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes);

/* Ends the run with a report when a claim about the product does not hold. */
#define CLAIM(condition)                                                                                               \
    do {                                                                                                               \
        if (!(condition))                                                                                              \
            __builtin_trap();                                                                                          \
    } while (0)

struct input {
    const uint8_t *data;
    size_t left;
};

/* The next byte; 0 when there is none. */
static inline uint8_t input_byte(struct input *in)
{
    if (!in->left)
        return 0;
    in->left--;
    return *in->data++;
}

/* The next bytes, fewer at the end; returns their number. */
static inline size_t input_bytes(const uint8_t **bytes, struct input *in, size_t wanted)
{
    size_t n = wanted < in->left ? wanted : in->left;
    *bytes = in->data;
    in->data += n;
    in->left -= n;
    return n;
}

/* A copy in a heap block of exactly its size, so that the sanitizer sees any access beyond (free() it). */
static inline void *exact_copy(const uint8_t *data, size_t bytes)
{
    void *copy = malloc(bytes ? bytes : 1);
    CLAIM(copy);
    return bytes ? memcpy(copy, data, bytes) : copy;
}

#endif
