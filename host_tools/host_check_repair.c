/* Repair of a checked measurement (host_check.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_check_internal.h"

static const double degree = 3.14159265358979323846 / 180;

static bool unknown(uint8_t state)
{
    return state == CHECK_MISSING || state == CHECK_NOT_FINITE;
}

static bool to_fill(uint8_t state, bool blind_only)
{
    if (blind_only)
        return state == CHECK_BLIND;
    return state == CHECK_MISSING || state == CHECK_NOT_FINITE || state == CHECK_BLIND || state == CHECK_OUTLIER;
}

/* The up to four known neighbours of a cell and their weights, the inverse squares of their distances. */
static int edges(size_t cell[4], double weight[4], const struct check_slice *s, size_t at, bool blind_only)
{
    size_t n = s->phi_count, row = at / n, column = at % n, left = (column + n - 1) % n, right = (column + 1) % n;
    int count = 0;
    double sine = fmax(sin(s->theta_out[row] * degree), 1e-3);
    for (int k = 0; k < 2; k++) {
        size_t other = k ? right : left;
        if (n < 2 || (blind_only && unknown(s->state[row * n + other])))
            continue;
        double step = fabs(s->phi_out[other] - s->phi_out[column]);
        step = fmax(fmin(step, 360 - step), 1e-3) * sine;
        cell[count] = row * n + other;
        weight[count++] = 1 / (step * step);
    }
    for (int k = 0; k < 2; k++) {
        size_t other = row + (k ? 1 : (size_t)-1);
        if (other >= s->theta_count || (blind_only && unknown(s->state[other * n + column])))
            continue;
        double step = s->theta_out[other] - s->theta_out[row];
        cell[count] = other * n + column;
        weight[count++] = 1 / (step * step);
    }
    return count;
}

/* Solves the discrete Laplace equation over the bad cells by relaxation, the good ones held. */
static size_t fill_slice(struct check_slice *s, bool blind_only)
{
    enum { SWEEPS = 2000 };
    size_t cells = s->theta_count * s->phi_count, count = 0, good = 0;
    size_t *bad = xmalloc(cells * sizeof *bad);
    double mean[3] = {0}, largest = 0;
    for (size_t i = 0; i < cells; i++) {
        if (to_fill(s->state[i], blind_only))
            bad[count++] = i;
        if (unknown(s->state[i]) || s->state[i] == CHECK_BLIND || s->state[i] == CHECK_OUTLIER)
            continue;
        good++;
        for (int c = 0; c < 3; c++) {
            mean[c] += s->rgb[i][c];
            largest = fmax(largest, s->rgb[i][c]);
        }
    }
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++)
            s->rgb[bad[i]][c] = good ? mean[c] / (double)good : 0;
    double change = count ? INFINITY : 0;
    for (int sweep = 0; sweep < SWEEPS && change > 1e-7 * largest; sweep++) {
        change = 0;
        for (size_t i = 0; i < count; i++) {
            size_t cell[4];
            double weight[4], sum = 0, x[3] = {0};
            int n = edges(cell, weight, s, bad[sweep & 1 ? count - 1 - i : i], blind_only);
            double *rgb = s->rgb[bad[sweep & 1 ? count - 1 - i : i]];
            for (int k = 0; k < n; k++) {
                sum += weight[k];
                for (int c = 0; c < 3; c++)
                    x[c] += weight[k] * s->rgb[cell[k]][c];
            }
            for (int c = 0; c < 3 && sum > 0; c++) {
                change = fmax(change, fabs(x[c] / sum - rgb[c]));
                rgb[c] = x[c] / sum;
            }
        }
    }
    for (size_t i = 0; i < count; i++)
        s->state[bad[i]] = CHECK_FILLED;
    free(bad);
    return count;
}

static void undo_cosine(struct check_slice *s, enum check_quantity quantity)
{
    for (size_t i = 0; i < s->theta_count * s->phi_count; i++) {
        double cosine = fmax(cos(s->theta_out[i / s->phi_count] * degree), 0.01);
        for (int c = 0; c < 3; c++)
            s->rgb[i][c] *= quantity == CHECK_TIMES_COSINE ? 1 / cosine : cosine;
    }
}

size_t check_repair(struct check *c, bool blind_only)
{
    size_t filled = 0;
    for (size_t i = 0; i < c->count; i++) {
        struct check_slice *s = &c->slices[i];
        for (size_t k = 0; k < s->theta_count * s->phi_count; k++)
            for (int channel = 0; channel < 3; channel++)
                if (s->rgb[k][channel] < 0)
                    s->rgb[k][channel] = 0;
        filled += fill_slice(s, blind_only);
        if (blind_only)
            continue;
        if (c->quantity == CHECK_TIMES_COSINE || c->quantity == CHECK_OVER_COSINE)
            undo_cosine(s, c->quantity);
    }
    return filled;
}

void check_measurement(struct measurement *out, const struct check *c, const char *source)
{
    measurement_init(out, source);
    for (size_t i = 0; i < c->count; i++) {
        const struct check_slice *s = &c->slices[i];
        for (size_t k = 0; k < s->theta_count * s->phi_count; k++) {
            if (unknown(s->state[k]) || s->state[k] == CHECK_BLIND)
                continue;
            uint32_t mark = s->state[k] == CHECK_FILLED         ? MEASUREMENT_FILLED
                            : s->state[k] == CHECK_EXTRAPOLATED ? MEASUREMENT_EXTRAPOLATED
                                                                : MEASURED;
            const double *rgb = s->rgb[k];
            measurement_add(out, &(struct measurement_point){(float)s->theta_in,
                                                             (float)s->theta_out[k / s->phi_count],
                                                             (float)s->phi_out[k % s->phi_count],
                                                             {(float)rgb[0], (float)rgb[1], (float)rgb[2]},
                                                             mark});
        }
    }
}

void check_fill_blind_spot(struct measurement *m, const char *path)
{
    struct check c;
    check_make(&c, m, measurement_geometry_find("minidiff"));
    if (c.irregular)
        die(EXIT_BAD_INPUT, "%s: %s, but a blind spot is found on a grid only; leave --fill-blind-spot out", path,
            c.grid_problem);
    if (c.blind)
        warn("%s: blind spot of %.1f degrees around the light: %zu samples interpolated across it", path,
             c.blind_radius, c.blind);
    else
        warn("%s: no blind spot found", path);
    for (size_t i = 0; i < c.count; i++)
        for (size_t k = 0; k < c.slices[i].theta_count * c.slices[i].phi_count; k++)
            if (c.slices[i].state[k] == CHECK_NOT_FINITE)
                die(EXIT_BAD_INPUT, "%s: values outside the blind spot are not finite; gtlut check --repair fills them",
                    path);
    check_repair(&c, true);
    struct measurement filled;
    check_measurement(&filled, &c, m->source);
    measurement_free(m);
    *m = filled;
    check_free(&c);
}
