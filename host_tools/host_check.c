#include "host_check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_check_internal.h"
#include "host_resample.h"

static const double degree = 3.14159265358979323846 / 180;

double check_distance(double theta_in, double theta_out, double phi_out, bool mirror)
{
    double s = sin(theta_in * degree) * (mirror ? -1 : 1), c = cos(theta_in * degree), so = sin(theta_out * degree);
    double x = so * cos(phi_out * degree) - s, y = so * sin(phi_out * degree), z = cos(theta_out * degree) - c;
    return 2 * asin(fmin(sqrt(x * x + y * y + z * z) / 2, 1)) / degree;
}

double check_luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; /* IEC 61966-2-1 */
}

/* --- the lattice --- */

/* Distinct angles in thousandths of a degree. */
struct angles {
    size_t count, room;
    int32_t *value;
};

static void angles_add(struct angles *a, int32_t x)
{
    size_t lo = 0, hi = a->count;
    while (lo < hi) {
        size_t middle = (lo + hi) / 2;
        if (a->value[middle] < x)
            lo = middle + 1;
        else
            hi = middle;
    }
    if (lo < a->count && a->value[lo] == x)
        return;
    if (a->count == a->room)
        a->value = xrealloc(a->value, (a->room = a->room ? 2 * a->room : 64) * sizeof *a->value);
    memmove(a->value + lo + 1, a->value + lo, (a->count++ - lo) * sizeof *a->value);
    a->value[lo] = x;
}

static size_t angles_find(const struct angles *a, int32_t x)
{
    size_t lo = 0, hi = a->count;
    while (hi - lo > 1) {
        size_t middle = (lo + hi) / 2;
        *(a->value[middle] <= x ? &lo : &hi) = middle;
    }
    return lo;
}

static int32_t thousandths(float x)
{
    return (int32_t)lround(1e3 * (double)x);
}

static int32_t phi_thousandths(float x)
{
    return thousandths(x) % 360000;
}

enum { MAX_DISTINCT = 8192 };

/* The angles that occur. False when there are so many that the samples cannot be a grid. */
static bool collect(struct angles set[3], const struct measurement *m)
{
    memset(set, 0, 3 * sizeof *set);
    for (size_t i = 0; i < m->count; i++) {
        const struct measurement_point *p = &m->points[i];
        angles_add(&set[0], thousandths(p->theta_in));
        angles_add(&set[1], thousandths(p->theta_out));
        angles_add(&set[2], phi_thousandths(p->phi_out));
        if (set[0].count > MAX_DISTINCT || set[1].count > MAX_DISTINCT || set[2].count > MAX_DISTINCT)
            return false;
    }
    return m->count >= (double)set[0].count * (double)set[1].count * (double)set[2].count / 2;
}

static double *degrees_of(const struct angles *a, size_t count)
{
    double *out = xmalloc(count * sizeof *out);
    for (size_t i = 0; i < count; i++)
        out[i] = 1e-3 * a->value[i];
    return out;
}

static void slices_make(struct check *c, const struct angles set[3], const struct measurement *m)
{
    c->count = set[0].count;
    c->slices = xcalloc(c->count, sizeof *c->slices);
    for (size_t i = 0; i < m->count; i++) { /* each slice ends with its own largest theta_out */
        struct check_slice *s = &c->slices[angles_find(&set[0], thousandths(m->points[i].theta_in))];
        size_t rows = angles_find(&set[1], thousandths(m->points[i].theta_out)) + 1;
        s->theta_count = rows > s->theta_count ? rows : s->theta_count;
    }
    for (size_t i = 0; i < c->count; i++) {
        struct check_slice *s = &c->slices[i];
        s->theta_in = 1e-3 * set[0].value[i];
        s->phi_count = set[2].count;
        s->theta_out = degrees_of(&set[1], s->theta_count);
        s->phi_out = degrees_of(&set[2], s->phi_count);
        size_t cells = s->theta_count * s->phi_count;
        s->rgb = xcalloc(cells, sizeof *s->rgb);
        s->state = xmalloc(cells);
        memset(s->state, CHECK_MISSING, cells);
    }
}

static enum check_state state_of(struct check *c, const struct measurement_point *p)
{
    bool nan = false, infinite = false, negative = false;
    for (int k = 0; k < 3; k++) {
        nan |= isnan(p->rgb[k]) != 0;
        infinite |= isinf(p->rgb[k]) != 0;
        negative |= p->rgb[k] < 0;
    }
    c->nan += nan;
    c->infinite += infinite && !nan;
    c->negative += negative && !nan && !infinite;
    c->extrapolated += p->mark == MEASUREMENT_EXTRAPOLATED;
    c->filled += p->mark == MEASUREMENT_FILLED;
    if (nan || infinite)
        return CHECK_NOT_FINITE;
    return p->mark == MEASUREMENT_EXTRAPOLATED ? CHECK_EXTRAPOLATED
           : p->mark == MEASUREMENT_FILLED     ? CHECK_FILLED
                                               : CHECK_GOOD;
}

static void place_samples(struct check *c, const struct angles set[3], const struct measurement *m)
{
    for (size_t i = 0; i < m->count; i++) {
        const struct measurement_point *p = &m->points[i];
        struct check_slice *s = &c->slices[angles_find(&set[0], thousandths(p->theta_in))];
        size_t cell = angles_find(&set[1], thousandths(p->theta_out)) * s->phi_count +
                      angles_find(&set[2], phi_thousandths(p->phi_out));
        c->doubled += s->state[cell] != CHECK_MISSING;
        s->state[cell] = (uint8_t)state_of(c, p);
        for (int k = 0; k < 3; k++)
            s->rgb[cell][k] = (double)p->rgb[k];
    }
    /* One sample along the normal stands for all its azimuths. */
    for (size_t i = 0; i < c->count; i++) {
        struct check_slice *s = &c->slices[i];
        size_t from = 0;
        while (from < s->phi_count && s->state[from] == CHECK_MISSING)
            from++;
        for (size_t k = 0; k < s->phi_count && s->theta_out[0] < 1e-6 && from < s->phi_count; k++)
            if (s->state[k] == CHECK_MISSING) {
                memcpy(s->rgb[k], s->rgb[from], sizeof *s->rgb);
                s->state[k] = s->state[from];
            }
    }
}

/* --- blind spot and outliers --- */

static int compare_double(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double check_median(double *values, size_t count)
{
    qsort(values, count, sizeof *values, compare_double);
    return count ? (values[(count - 1) / 2] + values[count / 2]) / 2 : NAN;
}

bool check_usable(uint8_t state)
{
    return state == CHECK_GOOD || state == CHECK_FILLED;
}

/* Cells next to (row, column), up to eight; across the ends of phi, not across the pole. */
static size_t neighbours(size_t out[8], const struct check_slice *s, size_t cell)
{
    size_t row = cell / s->phi_count, column = cell % s->phi_count, n = 0;
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) {
            size_t y = row + (size_t)dy, x = (column + s->phi_count + (size_t)dx) % s->phi_count;
            if ((dx || dy) && y < s->theta_count && (s->phi_count > 2 || !dx))
                out[n++] = y * s->phi_count + x;
        }
    return n;
}

enum { BLIND_LIMIT = 15 }; /* degrees: no instrument hides more */

static void find_blind_spot(struct check *c, struct check_slice *s)
{
    size_t cells = s->theta_count * s->phi_count, n = 0, open = 0, used = 0;
    double *ring = xmalloc(cells * sizeof *ring), *distance = xmalloc(cells * sizeof *distance);
    size_t *queue = xmalloc(cells * sizeof *queue), around[8];
    bool *bad = xcalloc(cells, sizeof *bad);
    for (size_t i = 0; i < cells; i++) {
        distance[i] = check_distance(s->theta_in, s->theta_out[i / s->phi_count], s->phi_out[i % s->phi_count], false);
        if (distance[i] > BLIND_LIMIT && distance[i] < 2 * BLIND_LIMIT && check_usable(s->state[i]))
            ring[n++] = check_luminance(s->rgb[i]);
    }
    double level = n ? 0.05 * check_median(ring, n) : 0;
    for (size_t i = 0; i < cells; i++) {
        bad[i] = distance[i] <= BLIND_LIMIT && (s->state[i] == CHECK_MISSING || s->state[i] == CHECK_NOT_FINITE ||
                                                (s->state[i] == CHECK_GOOD && n && check_luminance(s->rgb[i]) < level));
        if (bad[i] && distance[i] < 2) {
            queue[used++] = i;
            bad[i] = false;
        }
    }
    for (; open < used; open++) {
        size_t count = neighbours(around, s, queue[open]);
        for (size_t k = 0; k < count; k++)
            if (bad[around[k]]) {
                queue[used++] = around[k];
                bad[around[k]] = false;
            }
    }
    /* What goes on to the limit is no spot: values that fade towards the horizon, or a grid that ends there. */
    bool spot = true;
    for (size_t i = 0; i < used; i++)
        spot = spot && distance[queue[i]] < BLIND_LIMIT - 1;
    for (size_t i = 0; i < used; i++) {
        s->state[queue[i]] = spot ? CHECK_BLIND : s->state[queue[i]];
        c->blind_radius = spot ? fmax(c->blind_radius, distance[queue[i]]) : c->blind_radius;
    }
    c->blind += spot ? used : 0;
    free(ring);
    free(distance);
    free(queue);
    free(bad);
}

/* How a sample stands to its neighbours. */
struct standing {
    double off, median, spread; /* of luminance: distance from the median of the neighbours */
    bool extreme;               /* above or below all of them */
};

/* False where nothing can be said. */
static bool stand(struct standing *out, const struct check_slice *s, size_t cell, double mirror_radius)
{
    double theta = s->theta_out[cell / s->phi_count], phi = s->phi_out[cell % s->phi_count], v[8];
    size_t around[8], n = 0, count = neighbours(around, s, cell);
    /* A lobe narrower than the grid is no outlier, nor is its foot. */
    if (s->state[cell] != CHECK_GOOD || theta < 1e-6 || check_distance(s->theta_in, theta, phi, true) < mirror_radius)
        return false;
    for (size_t k = 0; k < count; k++)
        if (check_usable(s->state[around[k]]))
            v[n++] = check_luminance(s->rgb[around[k]]);
    if (n < 5)
        return false;
    double x = check_luminance(s->rgb[cell]), median = check_median(v, n);
    /* The neighbours' own extremes may be outliers, too: one on each side is left out. At the edge, where all of them lie to one side,
     * their whole range counts. */
    double spread = n == 8 ? fmax(v[6] - median, median - v[1]) : v[n - 1] - v[0];
    *out = (struct standing){fabs(x - median), fabs(median), spread, x < v[0] || x > v[n - 1]};
    return true;
}

static void find_outliers(struct check *c, struct check_slice *s)
{
    size_t cells = s->theta_count * s->phi_count, used = 0;
    double rows = (double)s->theta_count - 1, span = s->theta_out[s->theta_count - 1] - s->theta_out[0];
    double mirror_radius = fmax(5, rows > 0 ? 3 * span / rows : 90);
    double *relative = xmalloc(cells * sizeof *relative);
    uint8_t *state = xmalloc(cells); /* judged by the neighbours as they are, in any order */
    memcpy(state, s->state, cells);
    struct standing x;
    for (size_t i = 0; i < cells; i++)
        if (stand(&x, s, i, mirror_radius) && x.median > 0)
            relative[used++] = x.off / x.median;
    /* The slice's own noise; 0.6745 sigma is the median of a normal deviate. */
    double noise = used ? 6 * check_median(relative, used) / 0.6745 : 0;
    for (size_t i = 0; i < cells; i++)
        if (stand(&x, s, i, mirror_radius) && x.extreme && x.off > 3 * x.spread + fmax(0.1, noise) * x.median &&
            x.off > 1e-6) {
            state[i] = CHECK_OUTLIER;
            c->outliers++;
        }
    memcpy(s->state, state, cells);
    free(state);
    free(relative);
}

void check_make(struct check *out, const struct measurement *m, const struct measurement_geometry *g)
{
    struct angles set[3];
    struct measurement grid = {.points = NULL};
    *out = (struct check){.points = m->count};
    if (!collect(set, m)) {
        struct measurement finite;
        measurement_init(&finite, m->source);
        for (size_t i = 0; i < m->count; i++)
            if (state_of(out, &m->points[i]) != CHECK_NOT_FINITE)
                measurement_add(&finite, &m->points[i]);
        out->irregular = m->count;
        if (finite.count)
            measurement_resample(&grid, &finite, g);
        measurement_free(&finite);
        for (int i = 0; i < 3; i++)
            free(set[i].value);
        collect(set, &grid);
        m = &grid;
        out->extrapolated = out->filled = 0; /* counted again, in the grid */
    }
    out->grid_problem = out->irregular ? xstrdup("the samples are scattered; gtlut import resamples them")
                                       : measurement_grid_problem(m);
    size_t nan = out->nan, infinite = out->infinite, negative = out->negative;
    slices_make(out, set, m);
    place_samples(out, set, m);
    if (out->irregular) { /* those of the file, not of the resampled grid */
        out->nan = nan;
        out->infinite = infinite;
        out->negative = negative;
    }
    for (size_t i = 0; i < out->count; i++) {
        struct check_slice *s = &out->slices[i];
        if (!out->irregular) {
            find_blind_spot(out, s);
            find_outliers(out, s);
        }
        for (size_t k = 0; k < s->theta_count * s->phi_count; k++)
            out->missing += s->state[k] == CHECK_MISSING;
    }
    check_physics(out);
    for (int i = 0; i < 3; i++)
        free(set[i].value);
    measurement_free(&grid);
}

void check_free(struct check *c)
{
    for (size_t i = 0; i < c->count; i++) {
        free(c->slices[i].theta_out);
        free(c->slices[i].phi_out);
        free(c->slices[i].rgb);
        free(c->slices[i].state);
    }
    free(c->slices);
    free(c->grid_problem);
    free(c->coverage_problem);
}
