/* Point cloud to regular grid: the second half of host_measurement.h. */
#include "host_measurement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

/* Angles as whole thousandths of a degree, so that "the same angle" is plain equality. */
struct key {
    int32_t theta_in, theta_out, phi;
    uint32_t point;
};

static int key_compare(const void *a, const void *b)
{
    const struct key *x = a, *y = b;
    if (x->theta_in != y->theta_in)
        return x->theta_in < y->theta_in ? -1 : 1;
    if (x->theta_out != y->theta_out)
        return x->theta_out < y->theta_out ? -1 : 1;
    return x->phi < y->phi ? -1 : x->phi > y->phi;
}

static struct key *keys_sorted(const struct measurement *m)
{
    struct key *keys = xmalloc(m->count * sizeof *keys);
    for (size_t i = 0; i < m->count; i++) {
        const struct measurement_point *p = &m->points[i];
        int32_t phi = (int32_t)lround(1e3 * (double)p->phi_out);
        keys[i] = (struct key){(int32_t)lround(1e3 * (double)p->theta_in), (int32_t)lround(1e3 * (double)p->theta_out),
                               phi == 360000 ? 0 : phi, (uint32_t)i};
    }
    qsort(keys, m->count, sizeof *keys, key_compare);
    return keys;
}

/* The rows of one slice must all have the first row's azimuths, and those must divide the full turn evenly. */
static char *slice_problem(const struct key *k, size_t count, size_t phi_count)
{
    for (size_t i = 1; i < count; i++) /* first: one too many would look like uneven steps */
        if (!key_compare(&k[i - 1], &k[i]))
            return xasprintf("two samples at theta_in %g, theta_out %g, phi_out %g; keep one", 1e-3 * k[i].theta_in,
                             1e-3 * k[i].theta_out, 1e-3 * k[i].phi);
    for (size_t i = 0; i < count; i++) {
        size_t column = i % phi_count;
        const struct key *first = &k[column], *row = &k[i - column];
        double want = 1e-3 * k->phi + (double)column * 360.0 / (double)phi_count;
        if (fabs(1e-3 * k[i].phi - want) > 1.6e-3 && row == k)
            return xasprintf(
                "at theta_in %g, theta_out %g phi_out %g stands where %zu equal steps of a full turn want %g; a "
                "table needs a regular grid",
                1e-3 * k[i].theta_in, 1e-3 * k[i].theta_out, 1e-3 * k[i].phi, phi_count, want);
        if (k[i].theta_out != row->theta_out || k[i].phi != first->phi)
            return xasprintf(
                "at theta_in %g, theta_out %g the sample at phi_out %g is missing or extra; every row needs the "
                "first row's %zu azimuths",
                1e-3 * row->theta_in, 1e-3 * row->theta_out, 1e-3 * first->phi, phi_count);
    }
    if (count % phi_count)
        return xasprintf(
            "at theta_in %g, theta_out %g has %zu azimuths where the first row has %zu; a table needs a regular "
            "grid",
            1e-3 * k->theta_in, 1e-3 * k[count - 1].theta_out, count % phi_count, phi_count);
    return NULL;
}

static size_t row_length(const struct key *k, size_t count)
{
    size_t n = 0;
    while (n < count && k[n].theta_out == k->theta_out)
        n++;
    return n;
}

static void slice_make(struct measurement_slice *s, const struct measurement *m, const struct key *k, size_t count)
{
    size_t phi_count = row_length(k, count);
    *s = (struct measurement_slice){.theta_in = 1e-3 * k->theta_in,
                                    .theta_count = count / phi_count,
                                    .phi_count = phi_count,
                                    .theta_out = xmalloc(count / phi_count * sizeof(double)),
                                    .phi_first = 1e-3 * k->phi,
                                    .rgb = xmalloc(3 * count * sizeof(double)),
                                    .mark = xmalloc(count),
                                    .theta_measured = -1};
    for (size_t i = 0; i < s->theta_count; i++)
        s->theta_out[i] = 1e-3 * k[i * phi_count].theta_out;
    for (size_t i = 0; i < count; i++) {
        const struct measurement_point *p = &m->points[k[i].point];
        for (int c = 0; c < 3; c++)
            s->rgb[3 * i + c] = (double)p->rgb[c];
        s->mark[i] = (uint8_t)p->mark;
        if (p->mark != MEASUREMENT_EXTRAPOLATED)
            s->theta_measured = 1e-3 * k[i].theta_out;
    }
}

static size_t slice_length(const struct key *k, size_t count)
{
    size_t n = 0;
    while (n < count && k[n].theta_in == k->theta_in)
        n++;
    return n;
}

/* Of the sorted points. */
static char *grid_problem(const struct key *keys, size_t count)
{
    size_t slices = 0, length;
    for (size_t from = 0; from < count; from += length, slices++) {
        length = slice_length(keys + from, count - from);
        char *problem = slice_problem(keys + from, length, row_length(keys + from, length));
        if (problem)
            return problem;
    }
    if (!slices)
        return xstrdup("no samples; measure some");
    double last = 1e-3 * keys[count - 1].theta_in;
    for (size_t from = 0, i = 0; from < count; from += slice_length(keys + from, count - from), i++) {
        double theta_in = 1e-3 * keys[from].theta_in, want = slices > 1 ? last * (double)i / (double)(slices - 1) : 0;
        if (fabs(theta_in - want) > 1.6e-3)
            return xasprintf("theta_in %g stands where equal steps from 0 to %g want %g; measure at equal steps",
                             theta_in, last, want);
    }
    return NULL;
}

char *measurement_grid_problem(const struct measurement *m)
{
    struct key *keys = keys_sorted(m);
    char *problem = grid_problem(keys, m->count);
    free(keys);
    return problem;
}

void measurement_grid_make(struct measurement_grid *out, const struct measurement *m, const char *path)
{
    struct key *keys = keys_sorted(m);
    char *problem = grid_problem(keys, m->count);
    if (problem)
        die(EXIT_BAD_INPUT, "%s: %s, or resample: gtlut import --geometry dense", path, problem);
    memset(out, 0, sizeof *out);
    for (size_t from = 0, length; from < m->count; from += length) {
        length = slice_length(keys + from, m->count - from);
        out->slices = xrealloc(out->slices, (out->count + 1) * sizeof *out->slices);
        slice_make(&out->slices[out->count++], m, keys + from, length);
    }
    free(keys);
}

void measurement_grid_free(struct measurement_grid *g)
{
    for (size_t i = 0; i < g->count; i++) {
        free(g->slices[i].theta_out);
        free(g->slices[i].rgb);
        free(g->slices[i].mark);
    }
    free(g->slices);
    memset(g, 0, sizeof *g);
}

void measurement_slice_value(double rgb[3], const struct measurement_slice *s, double theta_out, double phi_out)
{
    size_t lo = 0, hi = s->theta_count - 1;
    while (hi - lo > 1) {
        size_t middle = (lo + hi) / 2;
        *(s->theta_out[middle] <= theta_out ? &lo : &hi) = middle;
    }
    double width = s->theta_out[hi] - s->theta_out[lo];
    double t = width > 0 ? fmin(fmax((theta_out - s->theta_out[lo]) / width, 0), 1) : 0;

    double column = (phi_out - s->phi_first) * ((double)s->phi_count / 360), whole = floor(column), u = column - whole;
    long n = (long)s->phi_count, left = (long)whole % n;
    left += left < 0 ? n : 0;
    long right = left + 1 < n ? left + 1 : 0;

    const double *low = s->rgb + 3 * lo * s->phi_count, *high = s->rgb + 3 * hi * s->phi_count;
    for (int c = 0; c < 3; c++) {
        double a = (1 - u) * low[3 * left + c] + u * low[3 * right + c];
        double b = (1 - u) * high[3 * left + c] + u * high[3 * right + c];
        rgb[c] = (1 - t) * a + t * b;
    }
}
