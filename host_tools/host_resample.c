#include "host_resample.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

enum { NEAREST = 12, BUCKETS = 48 };
enum {
    MOST_SPARSE = 90
}; /* angles of incidence with fewer samples than NEAREST: what lies between two of them is a guess */

static const double pi = 3.14159265358979323846;

struct sample {
    double v[3];
    const struct measurement_point *point;
    int next; /* in its bucket, or -1 */
};

/* One angle of incidence; samples are found by their place in the plane of the surface. */
struct slice {
    double theta_in; /* radians */
    size_t count;
    struct sample *samples;
    int bucket[BUCKETS][BUCKETS]; /* first sample, or -1 */
};

struct cloud {
    size_t count;
    struct slice *slices;
};

static void vector_of(double v[3], double theta, double phi)
{
    v[0] = sin(theta) * cos(phi);
    v[1] = sin(theta) * sin(phi);
    v[2] = cos(theta);
}

static int bucket_of(double x)
{
    int i = (int)((x + 1) / 2 * BUCKETS);
    return i < 0 ? 0 : i >= BUCKETS ? BUCKETS - 1 : i;
}

static int compare_theta_in(const void *a, const void *b)
{
    const struct measurement_point *const *x = a, *const *y = b;
    return ((*x)->theta_in > (*y)->theta_in) - ((*x)->theta_in < (*y)->theta_in);
}

static const struct measurement_point **sorted(const struct measurement *m)
{
    const struct measurement_point **order = xmalloc(m->count * sizeof *order);
    for (size_t i = 0; i < m->count; i++)
        order[i] = &m->points[i];
    qsort(order, m->count, sizeof *order, compare_theta_in);
    return order;
}

static size_t slice_end(const struct measurement_point **order, size_t from, size_t count)
{
    size_t to = from;
    while (to < count && (double)order[to]->theta_in - (double)order[from]->theta_in <= 1.6e-3)
        to++;
    return to;
}

size_t measurement_slice_count(const struct measurement *m)
{
    const struct measurement_point **order = sorted(m);
    size_t count = 0;
    for (size_t from = 0; from < m->count; from = slice_end(order, from, m->count))
        count++;
    free(order);
    return count;
}

static void slice_make(struct slice *s, const struct measurement_point **order, size_t count)
{
    s->theta_in = (double)order[0]->theta_in * pi / 180;
    s->count = count;
    s->samples = xmalloc(count * sizeof *s->samples);
    memset(s->bucket, -1, sizeof s->bucket);
    for (size_t i = 0; i < count; i++) {
        struct sample *p = &s->samples[i];
        p->point = order[i];
        vector_of(p->v, (double)order[i]->theta_out * pi / 180, (double)order[i]->phi_out * pi / 180);
        int *first = &s->bucket[bucket_of(p->v[0])][bucket_of(p->v[1])];
        p->next = *first;
        *first = (int)i;
    }
}

static void cloud_make(struct cloud *out, const struct measurement *m)
{
    const struct measurement_point **order = sorted(m);
    *out = (struct cloud){0};
    for (size_t from = 0, to; from < m->count; from = to) {
        to = slice_end(order, from, m->count);
        out->slices = xrealloc(out->slices, (out->count + 1) * sizeof *out->slices);
        slice_make(&out->slices[out->count++], order + from, to - from);
    }
    free(order);
}

static void cloud_free(struct cloud *c)
{
    for (size_t i = 0; i < c->count; i++)
        free(c->slices[i].samples);
    free(c->slices);
}

/* The samples nearest to a direction, ascending by squared distance. */
struct nearest {
    int count;
    const struct sample *sample[NEAREST];
    double d2[NEAREST];
};

static void offer(struct nearest *n, const struct sample *s, const double v[3])
{
    double x = s->v[0] - v[0], y = s->v[1] - v[1], z = s->v[2] - v[2], d2 = x * x + y * y + z * z;
    if (n->count == NEAREST && d2 >= n->d2[NEAREST - 1])
        return;
    int i = n->count < NEAREST ? n->count++ : NEAREST - 1;
    for (; i && n->d2[i - 1] > d2; i--) {
        n->d2[i] = n->d2[i - 1];
        n->sample[i] = n->sample[i - 1];
    }
    n->d2[i] = d2;
    n->sample[i] = s;
}

static void find_nearest(struct nearest *n, const struct slice *s, const double v[3])
{
    int x = bucket_of(v[0]), y = bucket_of(v[1]);
    n->count = 0;
    /* Rings of buckets around the direction's own; what lies beyond ring r is at least r buckets away. */
    for (int ring = 0; ring < BUCKETS; ring++) {
        double reach = 2.0 / BUCKETS * (ring - 1);
        if (n->count == NEAREST && ring && reach > 0 && reach * reach > n->d2[NEAREST - 1])
            return;
        for (int i = x - ring; i <= x + ring; i++)
            for (int j = y - ring; j <= y + ring; j += i == x - ring || i == x + ring || !ring ? 1 : 2 * ring)
                if (i >= 0 && j >= 0 && i < BUCKETS && j < BUCKETS)
                    for (int k = s->bucket[i][j]; k >= 0; k = s->samples[k].next)
                        offer(n, &s->samples[k], v);
    }
}

/* Coordinates of a sample around the direction in two axes perpendicular to it. */
struct place {
    double x, y;
};

static void places_of(struct place *out, const struct nearest *n, const double v[3])
{
    double s = hypot(v[0], v[1]), cp = s > 0 ? v[0] / s : 1, sp = s > 0 ? v[1] / s : 0;
    const double a[3] = {v[2] * cp, v[2] * sp, -s}, b[3] = {-sp, cp, 0};
    for (int i = 0; i < n->count; i++) {
        const double *w = n->sample[i]->v;
        out[i] = (struct place){a[0] * w[0] + a[1] * w[1] + a[2] * w[2], b[0] * w[0] + b[1] * w[1] + b[2] * w[2]};
    }
}

static int compare_double(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Whether the samples leave no half-plane around the direction empty. */
static bool surrounded(const struct place *p, int count)
{
    double turn[NEAREST];
    for (int i = 0; i < count; i++) {
        if (p[i].x * p[i].x + p[i].y * p[i].y < 1e-10)
            return true; /* on a sample */
        turn[i] = atan2(p[i].y, p[i].x);
    }
    qsort(turn, (size_t)count, sizeof *turn, compare_double);
    double gap = count ? turn[0] + 2 * pi - turn[count - 1] : 2 * pi;
    for (int i = 1; i < count; i++)
        gap = fmax(gap, turn[i] - turn[i - 1]);
    return gap <= pi + 1e-6;
}

/* Weights of the samples: their sum is 1, and applied to a plane they give its value at the direction. */
static void plane_weights(double weight[NEAREST], const struct nearest *n, const struct place *p, bool inside)
{
    double reach = n->d2[n->count - 1] * 1.0201 + 1e-12, m[6] = {0}, w[NEAREST], sum = 0;
    for (int i = 0; i < n->count; i++) {
        double fade = 1 - n->d2[i] / reach;
        w[i] = fade * fade / (n->d2[i] + 1e-9);
        sum += w[i];
    }
    for (int i = 0; i < n->count; i++) {
        w[i] /= sum;
        m[0] += w[i] * p[i].x;
        m[1] += w[i] * p[i].y;
        m[2] += w[i] * p[i].x * p[i].x;
        m[3] += w[i] * p[i].x * p[i].y;
        m[4] += w[i] * p[i].y * p[i].y;
    }
    /* Minimises sum (a_i^2 / w_i) under sum a_i = 1, sum a_i x_i = sum a_i y_i = 0: a_i = w_i (1 + g x_i + h y_i) / scale. */
    double ridge = 1e-6 * (m[2] + m[4]), xx = m[2] + ridge, yy = m[4] + ridge, det = xx * yy - m[3] * m[3];
    double g = inside && det > 0 ? (-m[0] * yy + m[1] * m[3]) / det : 0;
    double h = inside && det > 0 ? (-m[1] * xx + m[0] * m[3]) / det : 0;
    double scale = 1 + g * m[0] + h * m[1];
    if (!(scale > 1e-6)) {
        g = h = 0;
        scale = 1;
    }
    for (int i = 0; i < n->count; i++)
        weight[i] = w[i] * (1 + g * p[i].x + h * p[i].y) / scale;
}

static enum measurement_mark slice_value(double rgb[3], const struct slice *s, const double v[3])
{
    struct nearest n;
    struct place p[NEAREST];
    double weight[NEAREST];
    find_nearest(&n, s, v);
    places_of(p, &n, v);
    bool inside = surrounded(p, n.count);
    plane_weights(weight, &n, p, inside);
    for (int c = 0; c < 3; c++) {
        double sum = 0, lo = INFINITY, hi = -INFINITY;
        for (int i = 0; i < n.count; i++) {
            double x = (double)n.sample[i]->point->rgb[c];
            sum += weight[i] * x;
            lo = fmin(lo, x);
            hi = fmax(hi, x);
        }
        rgb[c] = fmin(fmax(sum, lo), hi);
    }
    return inside ? (enum measurement_mark)n.sample[0]->point->mark : MEASUREMENT_EXTRAPOLATED;
}

/* The direction that stands to the mirror direction of `to` as v does to that of `from`: a turn in the plane of incidence. */
static void follow_mirror(double out[3], const double v[3], double from, double to)
{
    double s = sin(to - from), c = cos(to - from);
    out[0] = c * v[0] - s * v[2];
    out[1] = v[1];
    out[2] = s * v[0] + c * v[2];
    if (out[2] < 0.01) /* at or below the horizon: stay where v is */
        memcpy(out, v, 3 * sizeof *out);
}

static enum measurement_mark cloud_value(double rgb[3], const void *ctx, double theta_in, double theta_out,
                                         double phi_out)
{
    const struct cloud *cloud = ctx;
    double v[3], at[3], low[3], high[3];
    vector_of(v, theta_out, phi_out);
    size_t i = 0;
    while (i + 1 < cloud->count && cloud->slices[i + 1].theta_in <= theta_in)
        i++;
    const struct slice *a = &cloud->slices[i], *b = i + 1 < cloud->count ? a + 1 : a;
    follow_mirror(at, v, theta_in, a->theta_in);
    enum measurement_mark mark = slice_value(low, a, at), other = mark;
    double t = 0;
    if (b != a && theta_in > a->theta_in + 1e-5) {
        t = fmin((theta_in - a->theta_in) / (b->theta_in - a->theta_in), 1);
        follow_mirror(at, v, theta_in, b->theta_in);
        other = slice_value(high, b, at);
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = t > 0 ? (1 - t) * low[c] + t * high[c] : low[c];
    bool covered =
        theta_in >= a->theta_in - 3e-5 && mark != MEASUREMENT_EXTRAPOLATED && other != MEASUREMENT_EXTRAPOLATED;
    return covered ? mark > other ? mark : other : MEASUREMENT_EXTRAPOLATED;
}

void measurement_resample(struct measurement *out, const struct measurement *m, const struct measurement_geometry *g)
{
    struct cloud cloud;
    size_t slices = measurement_slice_count(m);
    if (slices > MOST_SPARSE && m->count < NEAREST * slices)
        die(EXIT_BAD_INPUT,
            "%s: %zu samples at %zu angles of incidence, fewer than %d at each; round theta_in to the angles that were "
            "meant",
            m->source, m->count, slices, NEAREST);
    cloud_make(&cloud, m);
    measurement_init(out, m->source);
    measurement_sample(out, g, cloud_value, &cloud, cloud.slices[cloud.count - 1].theta_in * 180 / pi);
    cloud_free(&cloud);
}
