/* The half-vector table as a file and as a function; its builder is host_half_vector_build.c. */
#include "host_half_vector.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_half_vector_fit.h"
#include "ktx2.h"

void half_vector_free(struct half_vector *t)
{
    free(t->texels);
    t->texels = NULL;
}

size_t half_vector_bytes(const struct half_vector *t)
{
    return (size_t)4 * t->t * t->h * t->d + sizeof t->warp_h + sizeof t->warp_d;
}

/* --- evaluation --- */

static double between(const uint16_t *warp, int nodes, double position)
{
    int k = (int)fmin(position, nodes - 2);
    return (warp[k] + (position - k) * (warp[k + 1] - warp[k])) / 512;
}

double half_vector_segment(double s2)
{
    int e;
    double mantissa = frexp(fmin(s2 + 0x1p-16, 1), &e); /* 1/2..1 */
    return 8 * (e + 15) + 8 * (2 * mantissa - 1);
}

double half_vector_segment_s2(double segment)
{
    double octave = floor(segment / 8);
    return ldexp(1 + segment / 8 - octave, (int)octave - 16) - 0x1p-16;
}

double half_vector_row(const uint16_t warp_h[HALF_VECTOR_WARP_H], double s2)
{
    return between(warp_h, HALF_VECTOR_WARP_H, half_vector_segment(s2));
}

double half_vector_plane(const uint16_t warp_d[HALF_VECTOR_WARP_D], double y)
{
    return between(warp_d, HALF_VECTOR_WARP_D, fmin(fmax(y, 0), 1) * (HALF_VECTOR_WARP_D - 1));
}

void half_vector_cell(struct half_vector_cell *out, const struct half_vector *t, double row, double plane, double t2)
{
    double column = t2 * (t->t - 1);
    uint32_t i = (uint32_t)fmin(row, t->h - 2), j = (uint32_t)fmin(plane, t->d - 2),
             k = (uint32_t)fmin(column, t->t - 2);
    double a = row - i, b = plane - j, c = column - k;
    out->corner = k + (size_t)t->t * (i + (size_t)t->h * j);
    for (int m = 0; m < 8; m++)
        out->weight[m] = (float)((m & 1 ? c : 1 - c) * (m & 2 ? a : 1 - a) * (m & 4 ? b : 1 - b));
}

/* SPEC.md, "Half-vector table". Where an angle is undefined the table is constant over it, and 0 does. */
static void parameters(double *s2, double *y, double *t2, const double l[3], const double v[3])
{
    double h2 = 0, d2 = 0;
    for (int k = 0; k < 3; k++) {
        h2 += (l[k] + v[k]) * (l[k] + v[k]);
        d2 += (l[k] - v[k]) * (l[k] - v[k]);
    }
    double sum = l[2] + v[2], difference = l[2] - v[2];
    *s2 = ((l[0] + v[0]) * (l[0] + v[0]) + (l[1] + v[1]) * (l[1] + v[1])) / h2;
    *y = (1 + sqrt(d2) / 2 - sqrt(h2) / 2) / 2;
    if (*s2 <= h2 / 4)
        *t2 = d2 > 0 && *s2 > 0 ? difference * difference / (d2 * *s2) : 0;
    else
        *t2 = difference * difference / (sum * sum);
    *t2 = fmin(*t2, 1);
}

void half_vector_value(double rgb[3], const struct half_vector *t, const double l[3], const double v[3])
{
    double s2, y, t2;
    parameters(&s2, &y, &t2, l, v);
    struct half_vector_cell cell;
    half_vector_cell(&cell, t, half_vector_row(t->warp_h, s2), half_vector_plane(t->warp_d, y), t2);
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (uint32_t m = 0; m < 8; m++) {
        uint32_t w = t->texels[cell.corner + (m & 1) + t->t * ((m >> 1 & 1) + t->h * (m >> 2))];
        double unit = ldexp((double)cell.weight[m] / (l[2] + v[2]), (int)(w >> 27) - 24 + t->scale);
        for (int c = 0; c < 3; c++)
            rgb[c] += (w >> 9 * c & 511) * unit;
    }
}

static void table_value(double rgb[3], const void *ctx, const double l[3], const double v[3])
{
    half_vector_value(rgb, ctx, l, v);
}

void half_vector_source(struct brdf_source *out, const struct half_vector *t, const char *name)
{
    *out = (struct brdf_source){
        .value = table_value, .ctx = (void *)t, .theta_in = 90, .theta_out = 90, .symmetric = true};
    snprintf(out->name, sizeof out->name, "%s", name);
}

/* --- the file --- */

static void read_warp(uint16_t *warp, int nodes, const struct ktx2_view *file, const char *key)
{
    uint32_t bytes;
    const uint8_t *p = ktx2_find_bytes(file, key, &bytes);
    for (int i = 0; i < nodes; i++)
        warp[i] = (uint16_t)(p[2 * i] | p[2 * i + 1] << 8);
}

void half_vector_read(struct half_vector *out, const struct ktx2_view *file)
{
    size_t count = (size_t)file->width * file->height * file->depth;
    *out = (struct half_vector){
        .t = file->width, .h = file->height, .d = file->depth, .texels = xmalloc(count * sizeof *out->texels)};
    memcpy(out->texels, file->texels, count * sizeof *out->texels);
    read_warp(out->warp_h, HALF_VECTOR_WARP_H, file, "goniotile.warph");
    read_warp(out->warp_d, HALF_VECTOR_WARP_D, file, "goniotile.warpd");
    uint32_t bytes;
    const uint8_t *scale = ktx2_find(file, "goniotile.scale", &bytes);
    char text[8] = "";
    if (scale)
        memcpy(text, scale, bytes < sizeof text ? bytes : sizeof text - 1);
    out->scale = (int)strtol(text, NULL, 10);
}

static uint32_t row_word(const struct half_vector *t, uint32_t k, uint32_t i, uint32_t j)
{
    return t->texels[k + t->t * (i + t->h * j)];
}

/* Largest exponent field of the texels of rows i, i+1 in planes j, j+1: [d-1][h-1]. */
static uint8_t *cells_make(const struct half_vector *t)
{
    uint8_t *cells = xmalloc((size_t)(t->h - 1) * (t->d - 1)), *cell = cells;
    for (uint32_t j = 0; j + 1 < t->d; j++)
        for (uint32_t i = 0; i + 1 < t->h; i++, cell++) {
            *cell = 0;
            for (uint32_t n = 0; n < 4 * t->t; n++) {
                uint32_t e = row_word(t, n >> 2, i + (n & 1), j + (n >> 1 & 1)) >> 27;
                *cell = (uint8_t)(e > *cell ? e : *cell);
            }
        }
    return cells;
}

static uint32_t aligned_mantissa(uint32_t word, int channel, uint32_t exponent)
{
    return exponent - (word >> 27) > 31 ? 0 : (word >> 9 * channel & 511) << 6 >> (exponent - (word >> 27));
}

/* Row i of planes j and j+1, aligned to one exponent: t x 3 words. */
static uint32_t *put_slab_row(uint32_t *p, const struct half_vector *t, uint32_t i, uint32_t j, uint32_t exponent)
{
    for (uint32_t k = 0; k < t->t; k++)
        for (int c = 0; c < 3; c++)
            *p++ = aligned_mantissa(row_word(t, k, i, j), c, exponent) |
                   aligned_mantissa(row_word(t, k, i, j + 1), c, exponent) << 16;
    return p;
}

/* SPEC.md, "Re-packed copy": records of all cells, then rows; a cell of the exponent of the one before shares a row with it. */
static uint32_t *slabs_make(size_t *bytes, const struct half_vector *t, const uint8_t *cells)
{
    size_t count = (size_t)(t->h - 1) * (t->d - 1), row = (size_t)3 * t->t;
    uint32_t *slabs = xmalloc((count + 2 * count * row) * sizeof *slabs), *p = slabs + count;
    for (uint32_t j = 0, n = 0; j + 1 < t->d; j++)
        for (uint32_t i = 0; i + 1 < t->h; i++, n++) {
            if (!i || cells[n] != cells[n - 1])
                p = put_slab_row(p, t, i, j, cells[n]);
            slabs[n] = (uint32_t)((size_t)(p - row - slabs) * 4) << 8 | cells[n];
            p = put_slab_row(p, t, i + 1, j, cells[n]);
        }
    *bytes = (size_t)(p - slabs) * 4;
    return slabs;
}

static int pair_compare(const void *a, const void *b)
{
    return strcmp(((const struct ktx2_pair *)a)->key, ((const struct ktx2_pair *)b)->key);
}

static void put_warp(uint8_t *p, const uint16_t *warp, int nodes)
{
    for (int i = 0; i < nodes; i++, p += 2) {
        p[0] = (uint8_t)warp[i];
        p[1] = (uint8_t)(warp[i] >> 8);
    }
}

uint8_t *half_vector_compose(size_t *bytes, const struct half_vector *t, const struct ktx2_pair *pairs,
                             size_t pair_count, bool packed)
{
    uint8_t warp_h[2 * HALF_VECTOR_WARP_H], warp_d[2 * HALF_VECTOR_WARP_D], *cells = cells_make(t);
    put_warp(warp_h, t->warp_h, HALF_VECTOR_WARP_H);
    put_warp(warp_d, t->warp_d, HALF_VECTOR_WARP_D);
    char scale[8];
    snprintf(scale, sizeof scale, "%d", t->scale);
    size_t slab_bytes = 0, n = pair_count;
    uint32_t *slabs = packed ? slabs_make(&slab_bytes, t, cells) : NULL;

    struct ktx2_pair *all = xmalloc((pair_count + 7) * sizeof *all);
    if (pair_count)
        memcpy(all, pairs, pair_count * sizeof *all);
    all[n++] = (struct ktx2_pair){"goniotile.version", "1", 0};
    all[n++] = (struct ktx2_pair){"goniotile.kind", "half_vector", 0};
    all[n++] = (struct ktx2_pair){"goniotile.warph", warp_h, sizeof warp_h};
    all[n++] = (struct ktx2_pair){"goniotile.warpd", warp_d, sizeof warp_d};
    all[n++] = (struct ktx2_pair){"goniotile.cells", cells, (size_t)(t->h - 1) * (t->d - 1)};
    if (t->scale)
        all[n++] = (struct ktx2_pair){"goniotile.scale", scale, 0};
    if (packed)
        all[n++] = (struct ktx2_pair){"goniotile.slabs", slabs, slab_bytes};
    qsort(all, n, sizeof *all, pair_compare);
    uint8_t *file = ktx2_compose(bytes, t->texels, t->t, t->h, t->d, all, n);
    free(all);
    free(slabs);
    free(cells);
    return file;
}
