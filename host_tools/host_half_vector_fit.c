/* Least squares with a trilinear table: the normal equations couple a node with its 26 neighbours only, so they are formed
 * once per round and solved node by node, each to its own optimum (Gauss-Seidel), never below 0, and in the end only to values
 * that a texel can hold. */
#include "host_half_vector_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_rgb9e5.h"

enum { NEIGHBOURS = 27, SELF = 13 }; /* 9 (j' - j + 1) + 3 (i' - i + 1) + (k' - k + 1) */

struct equations {
    struct half_vector *t;
    size_t nodes;
    float *matrix; /* [node][NEIGHBOURS] */
    float *right;  /* [node][3] */
    float *value;  /* [node][3], the table in full precision */
};

/* Where every sample falls, found once, and how far the table was from it in the last round. */
struct placed {
    const struct fit_sample *sample;
    size_t count;
    struct half_vector_cell *cell;
    uint32_t *row;
    float *error; /* of g, root mean square over the channels */
};

static size_t tap(const struct half_vector *t, size_t corner, uint32_t m)
{
    return corner + (m & 1) + t->t * ((m >> 1 & 1) + (size_t)t->h * (m >> 2));
}

static float error_at(const struct equations *e, const struct placed *p, size_t n)
{
    const float *g = p->sample[n].g;
    float r = -g[0], green = -g[1], blue = -g[2];
    for (uint32_t m = 0; m < 8; m++) {
        const float w = p->cell[n].weight[m], *value = e->value + 3 * tap(e->t, p->cell[n].corner, m);
        r += w * value[0];
        green += w * value[1];
        blue += w * value[2];
    }
    return sqrtf((r * r + green * green + blue * blue) / 3);
}

/* Mean colour difference over the pixels, and each row cell's part of it. */
static double find_errors(double *row_error, const struct equations *e, struct placed *p)
{
    double sum = 0, pixels = 0;
    memset(row_error, 0, (e->t->h - 1) * sizeof *row_error);
    for (size_t n = 0; n < p->count; n++) {
        const struct fit_sample *s = &p->sample[n];
        p->error[n] = error_at(e, p, n);
        double error = (double)(p->error[n] * (s->pixels[0] * s->slope[0] + s->pixels[1] * s->slope[1]));
        row_error[p->row[n]] += error;
        sum += error;
        pixels += (double)(s->pixels[0] + s->pixels[1]);
    }
    for (uint32_t i = 0; i + 1 < e->t->h; i++)
        row_error[i] /= pixels;
    return sum / pixels;
}

/* Weight of a sample's squared error. In the first round (mean 0) that of the squared colour difference; later divided by the
 * difference the last round left, which makes the sum that of the differences themselves. */
static float sample_weight(const struct fit_sample *s, float error, float mean)
{
    float weight = 0;
    for (int k = 0; k < 2; k++) {
        float slope = s->slope[k], w = s->pixels[k] * slope * slope, left = slope * error, least = 0.3f * mean;
        weight += mean > 0 ? w * mean / sqrtf(left * left + least * least) : w;
    }
    return weight;
}

/* Position of tap q among the neighbours of tap m. */
static int neighbour_of(uint32_t q, uint32_t m)
{
    return SELF + 9 * ((int)(q >> 2) - (int)(m >> 2)) + 3 * ((int)(q >> 1 & 1) - (int)(m >> 1 & 1)) +
           ((int)(q & 1) - (int)(m & 1));
}

static void accumulate(struct equations *e, const struct placed *p, double mean)
{
    int neighbour[8][8];
    for (uint32_t m = 0; m < 8; m++)
        for (uint32_t q = 0; q < 8; q++)
            neighbour[m][q] = neighbour_of(q, m);
    memset(e->matrix, 0, e->nodes * NEIGHBOURS * sizeof *e->matrix);
    memset(e->right, 0, e->nodes * 3 * sizeof *e->right);
    for (size_t n = 0; n < p->count; n++) {
        const struct half_vector_cell *cell = &p->cell[n];
        const float *g = p->sample[n].g, weight = sample_weight(&p->sample[n], p->error[n], (float)mean);
        for (uint32_t m = 0; m < 8; m++) {
            size_t node = tap(e->t, cell->corner, m);
            float w = weight * cell->weight[m], *row = e->matrix + NEIGHBOURS * node, *right = e->right + 3 * node;
            for (int q = 0; q < 8; q++)
                row[neighbour[m][q]] += w * cell->weight[q];
            right[0] += w * g[0];
            right[1] += w * g[1];
            right[2] += w * g[2];
        }
    }
}

/* Pulls neighbours along each axis together, a thousandth as strongly as the weaker one's samples do, and nodes that no sample
 * reaches to those that one does. */
static void regularise(struct equations *e)
{
    const struct half_vector *t = e->t;
    const uint32_t extent[3] = {t->t, t->h, t->d};
    const size_t stride[3] = {1, t->t, (size_t)t->t * t->h};
    static const int neighbour[3] = {1, 3, 9};
    float *diagonal = xmalloc(e->nodes * sizeof *diagonal);
    for (size_t n = 0; n < e->nodes; n++)
        diagonal[n] = e->matrix[NEIGHBOURS * n + SELF];
    for (size_t n = 0; n < e->nodes; n++)
        for (int axis = 0; axis < 3; axis++) {
            if (n / stride[axis] % extent[axis] + 1 == extent[axis])
                continue;
            float *a = e->matrix + NEIGHBOURS * n + SELF, *b = a + NEIGHBOURS * stride[axis];
            float x = diagonal[n], y = diagonal[n + stride[axis]];
            float pull = 1e-3f * fminf(x, y) + 1e-6f * fmaxf(x, y) + 1e-30f;
            a[0] += pull;
            b[0] += pull;
            a[neighbour[axis]] -= pull;
            b[-neighbour[axis]] -= pull;
        }
    free(diagonal);
}

/* right - matrix * value at a node. */
static void residual(float r[3], const struct equations *e, uint32_t i, uint32_t j, uint32_t k)
{
    const struct half_vector *t = e->t;
    size_t node = k + (size_t)t->t * (i + (size_t)t->h * j);
    const float *row = e->matrix + NEIGHBOURS * node;
    memcpy(r, e->right + 3 * node, 3 * sizeof *r);
    for (uint32_t dj = j ? 0 : 1; dj < 3 && j + dj <= t->d; dj++)
        for (uint32_t di = i ? 0 : 1; di < 3 && i + di <= t->h; di++) {
            const float *value = e->value + 3 * ((size_t)t->t * (i + di - 1 + (size_t)t->h * (j + dj - 1)));
            for (uint32_t dk = k ? 0 : 1; dk < 3 && k + dk <= t->t; dk++) {
                float w = row[9 * dj + 3 * di + dk];
                for (uint32_t c = 0; c < 3; c++)
                    r[c] -= w * value[3 * (k + dk - 1) + c];
            }
        }
}

/* The nearest value a texel holds, and its word. */
static uint32_t round_to_texel(float x[3], int scale)
{
    const double rgb[3] = {ldexp((double)x[0], -scale), ldexp((double)x[1], -scale), ldexp((double)x[2], -scale)};
    uint32_t word = rgb9e5_encode(rgb);
    for (int c = 0; c < 3; c++)
        x[c] = ldexpf((float)(word >> 9 * c & 511), (int)(word >> 27) - 24 + scale);
    return word;
}

/* Moves `count` nodes from (i, j, k) along t together to where the squared error is least. */
static void relax(struct equations *e, uint32_t i, uint32_t j, uint32_t k, uint32_t count, bool rounding)
{
    size_t first = k + (size_t)e->t->t * (i + (size_t)e->t->h * j);
    float sum[3] = {0}, stiffness = 0, x[3];
    for (uint32_t n = 0; n < count; n++) {
        const float *self = e->matrix + NEIGHBOURS * (first + n) + SELF;
        float r[3];
        residual(r, e, i, j, k + n);
        stiffness += self[0] + (n ? self[-1] : 0) + (n + 1 < count ? self[1] : 0);
        for (int c = 0; c < 3; c++)
            sum[c] += r[c];
    }
    for (int c = 0; c < 3; c++)
        x[c] = fmaxf(e->value[3 * first + (size_t)c] + sum[c] / stiffness, 0);
    uint32_t word = rounding ? round_to_texel(x, e->t->scale) : 0;
    for (uint32_t n = 0; n < count; n++) {
        memcpy(e->value + 3 * (first + n), x, sizeof x);
        e->t->texels[first + n] = word;
    }
}

/* Sweeps over all nodes, forth and back. Row h = 0 and plane d = 0 are constant in t, where the azimuth is undefined. */
static void solve(struct equations *e, int sweeps, bool rounding)
{
    const struct half_vector *t = e->t;
    for (int sweep = 0; sweep < sweeps; sweep++)
        for (uint32_t n = 0; n < t->h * t->d; n++) {
            uint32_t line = sweep & 1 ? t->h * t->d - 1 - n : n, i = line % t->h, j = line / t->h;
            if (!i || !j)
                relax(e, i, j, 0, t->t, rounding);
            else
                for (uint32_t k = 0; k < t->t; k++)
                    relax(e, i, j, k, 1, rounding);
        }
}

/* A first guess: every node the weighted mean of its samples; those without take the one before. */
static void guess(struct equations *e)
{
    for (size_t n = 0; n < e->nodes; n++)
        for (int c = 0; c < 3; c++) {
            float all = 0;
            for (int m = 0; m < NEIGHBOURS; m++)
                all += e->matrix[NEIGHBOURS * n + (size_t)m];
            float *value = e->value + 3 * n + c;
            *value = all > 0 ? e->right[3 * n + (size_t)c] / all : n ? value[-3] : 0;
        }
}

static void set_scale(struct equations *e)
{
    float largest = 0;
    for (size_t n = 0; n < 3 * e->nodes; n++)
        largest = fmaxf(largest, e->value[n]);
    int exponent;
    frexpf(largest, &exponent);                      /* largest < 2^exponent */
    e->t->scale = exponent > 15 ? exponent - 15 : 0; /* half of the largest texel: room for the rounding */
    if (e->t->scale > HALF_VECTOR_MAX_SCALE)
        e->t->scale = HALF_VECTOR_MAX_SCALE;
}

double half_vector_fit(struct half_vector *t, double *row_error, const struct fit_samples *s, int rounds)
{
    size_t nodes = (size_t)t->t * t->h * t->d;
    struct equations e = {t, nodes, xmalloc(nodes * NEIGHBOURS * sizeof(float)), xmalloc(nodes * 3 * sizeof(float)),
                          xcalloc(nodes, 3 * sizeof(float))};
    struct placed p = {.sample = s->sample, .count = fit_samples_count(s)};
    p.cell = xmalloc(p.count * sizeof *p.cell);
    p.row = xmalloc(p.count * sizeof *p.row);
    p.error = xcalloc(p.count, sizeof *p.error);
    if (!t->texels)
        t->texels = xmalloc(nodes * sizeof *t->texels);
    for (size_t n = 0; n < p.count; n++) {
        double row = half_vector_row(t->warp_h, (double)s->sample[n].s2);
        half_vector_cell(&p.cell[n], t, row, half_vector_plane(t->warp_d, (double)s->sample[n].y),
                         (double)s->sample[n].t2);
        p.row[n] = (uint32_t)fmin(row, t->h - 2);
    }

    double mean = 0;
    for (int round = 0; round < rounds; round++) {
        if (round)
            mean = find_errors(row_error, &e, &p);
        accumulate(&e, &p, mean);
        if (!round)
            guess(&e);
        regularise(&e);
        solve(&e, round ? 8 : 20, false);
    }
    set_scale(&e);
    solve(&e, 4, true);
    mean = find_errors(row_error, &e, &p);
    free(p.error);
    free(p.row);
    free(p.cell);
    free(e.value);
    free(e.right);
    free(e.matrix);
    return mean;
}
