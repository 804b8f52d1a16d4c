/* Unknown values for the drivers, Frama-C's own; and a copy with a body, so that each of its accesses is checked. */
#ifndef TESTS_PROVE_PROVE_H
#define TESTS_PROVE_PROVE_H

#include <stddef.h>
#include <stdint.h>

#include "__fc_builtin.h"

static inline void *prove_copy(void *to, const void *from, size_t bytes)
{
    for (size_t i = 0; i < bytes; i++)
        ((uint8_t *)to)[i] = ((const uint8_t *)from)[i];
    return to;
}

#define __builtin_memcpy prove_copy

#endif
