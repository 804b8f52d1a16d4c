/* The reference's models as sources of BRDFs, and random numbers. */
#ifndef TESTS_UNIT_BRDF_FIXTURE_H
#define TESTS_UNIT_BRDF_FIXTURE_H

#include <stdint.h>

#include "ref_models.h"

static const struct ref_material lambert = {.kind = REF_LAMBERT, .kd = {0.8, 0.5, 0.2}};
static const struct ref_material rough = {
    .kind = REF_MICROFACET, .kd = {0.5, 0.3, 0.1}, .roughness = 0.6, .eta = {1.5, 1.5, 1.5}};

/* struct brdf_source.value; ctx is a struct ref_material. */
static inline void model_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    ref_model_value(rgb, ctx, (const double[3]){0, 0, 1}, l, v);
}

/* 0 <= x < 1 */
static inline double random_unit(uint32_t *state)
{
    *state = *state * 1664525 + 1013904223;
    return (*state >> 8) * 0x1p-24;
}

#endif
