/*
 * What rungs of shading take. Where a meshlet shows a square of a x a pixels anywhere among cells of e x f, it meets on average
 * (a + e - 1)(a + f - 1)/(e f) of them, so that one number, 1/a, says all rates' samples; the cells of 4 x 4 that were counted say 1/a.
 */
#include "quality.h"

#include "block.h"

#define ONE_SHIFT 10
/* Of a pixel whose meshlet is flat, though it has no contrast: its normal and view are not the frame's and the region's. */
#define FLAT_ERROR 360u

const struct raster_model *raster_model_of(const struct raster_frame *f, const struct scene_material *m)
{
    const struct raster_parts *p = f->parts;
    const struct lut_table *t;
    switch (m->kind) {
    case SCENE_MATERIAL_MEASURED:
        t = m->slot < RASTER_MAX_SLOTS ? f->tables[m->slot] : NULL;
        return !t ? NULL : t->kind == LUT_HALF_VECTOR ? p->half_vector : p->specular_frame;
    case SCENE_MATERIAL_BLINN_PHONG:
        return p->blinn_phong;
    case SCENE_MATERIAL_METALLIC_ROUGHNESS:
        return p->metallic_roughness;
    default:
        return p->lafortune_phong;
    }
}

uint32_t raster_class_error(const struct raster_survey *s, uint32_t class_id, enum raster_rate rate)
{
    /* In 1/16: three colours times the mean square of the distance from a cell's centre, times what was measured: see DESIGN.md. */
    static const uint8_t factor[RASTER_RATE_FLAT] = {0, 18, 36, 68, 97};
    /* A meshlet is a cell, too: of a x a pixels, as many as 4 x 4 are 97. */
    const uint32_t flat = s->meshlets[class_id] ? 6u * s->total[class_id].pixels / s->meshlets[class_id] : 0;
    const uint32_t sixteenths = rate != RASTER_RATE_FLAT ? factor[rate] : flat > 120 ? flat : 120;
    uint64_t error = (uint64_t)s->detail[class_id] * sixteenths >> 4;
    if (rate == RASTER_RATE_FLAT)
        error += FLAT_ERROR * s->total[class_id].pixels; /* 2^9 2^13 */
    return error < 1u << 28 ? (uint32_t)error : 1u << 28;
}

uint32_t raster_taps_error(enum raster_taps taps, uint32_t pixels)
{
    static const uint8_t quarters[RASTER_TAPS_COUNT] = {0, 1, 18}; /* six models, DESIGN.md */
    return quarters[taps] * pixels >> 2;
}

/* Rounded down. In: x < 2^22. */
static uint32_t square_root(uint32_t x)
{
    uint32_t root = 0;
    for (uint32_t bit = 1u << 10; bit; bit >>= 1)
        if ((root + bit) * (root + bit) <= x)
            root += bit;
    return root;
}

uint32_t raster_samples_most(const struct raster *r, const struct raster_survey *s, uint32_t class_id,
                             const struct raster_area *a, enum raster_rate rate)
{
    if (rate == RASTER_RATE_FLAT)
        return fx_min_u(a->cells, s->meshlets[class_id]);
    if (rate == RASTER_RATE_1X1 && !r->sample_shift)
        return a->pixels;
    const unsigned parts = 4 + 2 * r->sample_shift - raster_cell_shift(r, rate, 0) - raster_cell_shift(r, rate, 1);
    return fx_min_u((uint32_t)a->cells << parts, a->pixels);
}

void raster_samples_likely(uint32_t samples[RASTER_RATE_COUNT], const struct raster *r, const struct raster_survey *s,
                           uint32_t class_id, const struct raster_area *a)
{
    const uint32_t one = 1u << ONE_SHIFT, edge = 4u << r->sample_shift; /* of a cell that was counted */
    /* sqrt(cells/pixels) = (a + edge - 1)/(edge a); cells <= pixels <= 2^12 */
    const uint32_t ratio = a->pixels ? square_root(((uint32_t)a->cells << 2 * ONE_SHIFT) / a->pixels) : one;
    const uint32_t inverse = edge * ratio > one ? (edge * ratio - one) / (edge - 1) : 0; /* 1/a <= 1 */
    for (int rate = 0; rate < RASTER_RATE_FLAT; rate++) {
        uint32_t n = a->pixels;
        for (unsigned i = 0; i < 2; i++) {
            const unsigned shift = raster_cell_shift(r, (unsigned)rate, i);
            n = (n * ((one + ((1u << shift) - 1) * inverse) >> shift) + one / 2) >> ONE_SHIFT;
        }
        samples[rate] = n;
    }
    if (!r->sample_shift)
        samples[RASTER_RATE_4X4] = a->cells;
    samples[RASTER_RATE_FLAT] = fx_min_u(a->cells, s->meshlets[class_id]);
}

uint32_t raster_region_blocks(const struct raster *r, unsigned planes, enum raster_rate rate)
{
    if (rate == RASTER_RATE_FLAT)
        return 1;
    const unsigned cell = raster_cell_shift(r, rate, 0) - r->sample_shift; /* the larger; pixels */
    return 1u << 2 * (RASTER_REGION_SHIFT - (planes > cell ? planes : cell));
}
