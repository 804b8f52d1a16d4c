/* What lut_eval chooses from. Not for embedders. */
#ifndef LUT_KINDS_H
#define LUT_KINDS_H

#include "lut.h"

/* Wrapping sums: equal to fx_dot for unit vectors, and defined for any others. */
static inline int32_t dot_wrapping(struct vec3 a, struct vec3 b)
{
    return (int32_t)((uint32_t)(a.x * b.x) + (uint32_t)(a.y * b.y) + (uint32_t)(a.z * b.z));
}

/* f(l,v) as lut_eval says. In: n.l > 0, n.v > 0. */
struct lut_rgb lut_specular_frame(const struct lut_table *t, struct vec3 n, struct vec3 l, struct vec3 v);
struct lut_rgb lut_half_vector(const struct lut_table *t, struct vec3 n, struct vec3 l, struct vec3 v);

#endif
