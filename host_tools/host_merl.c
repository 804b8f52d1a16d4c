#include "host_merl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

enum { THETA_H = 90, THETA_D = 90, PHI_D = 180, CELLS = THETA_H * THETA_D * PHI_D, HEADER_BYTES = 12 };

static const double pi = 3.14159265358979323846;
static const uint8_t header[HEADER_BYTES] = {THETA_H, 0, 0, 0, THETA_D, 0, 0, 0, PHI_D, 0, 0, 0};

bool merl_recognise(const uint8_t *data, size_t bytes)
{
    return bytes >= HEADER_BYTES && !memcmp(data, header, HEADER_BYTES);
}

static double get_f64(const uint8_t *p)
{
    uint64_t u = 0;
    for (int i = 7; i >= 0; i--)
        u = u << 8 | p[i];
    double x;
    memcpy(&x, &u, 8);
    return x;
}

/* The two cells whose centres are around position x of an axis, and the second one's weight. */
struct pair {
    int cell[2];
    double t;
};

static struct pair pair_at(double x, int cells, bool around)
{
    double whole = floor(x - 0.5), t = x - 0.5 - whole;
    int i = (int)whole;
    if (around)
        return (struct pair){{(i + cells) % cells, (i + 1) % cells}, t};
    return (struct pair){{i < 0 ? 0 : i >= cells ? cells - 1 : i, i + 1 >= cells ? cells - 1 : i + 1}, t};
}

/* Half and difference angles of light at theta_in in the plane of azimuth 0 and a view direction. */
static void angles_of(double *theta_h, double *theta_d, double *phi_d, double theta_in, double theta_out,
                      double phi_out)
{
    double l[3] = {sin(theta_in), 0, cos(theta_in)};
    double v[3] = {sin(theta_out) * cos(phi_out), sin(theta_out) * sin(phi_out), cos(theta_out)};
    double h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]}, length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    double across = hypot(h[0], h[1]), ch = h[2] / length, sh = across / length;
    double cp = across > 0 ? h[0] / across : 1, sp = across > 0 ? h[1] / across : 0;
    /* l turned by -phi_h about the normal and by -theta_h about y: h becomes the pole. */
    double x = cp * l[0], y = -sp * l[0], d[3] = {ch * x - sh * l[2], y, sh * x + ch * l[2]};
    *theta_h = atan2(across, h[2]);
    *theta_d = atan2(hypot(d[0], d[1]), d[2]);
    *phi_d = atan2(d[1], d[0]);
    *phi_d += *phi_d < 0 ? pi : 0; /* reciprocity: phi_d and phi_d + pi are the same */
}

static enum measurement_mark value(double rgb[3], const void *ctx, double theta_in, double theta_out, double phi_out)
{
    static const double scale[3] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};
    const uint8_t *values = ctx;
    double theta_h, theta_d, phi_d;
    angles_of(&theta_h, &theta_d, &phi_d, theta_in, theta_out, phi_out);
    struct pair h = pair_at(THETA_H * sqrt(theta_h / (pi / 2)), THETA_H, false);
    struct pair d = pair_at(THETA_D * theta_d / (pi / 2), THETA_D, false);
    struct pair p = pair_at(PHI_D * phi_d / pi, PHI_D, true);
    /* Cells that were not measured are left out; when all were not, theta_d decreases until one was. */
    for (enum measurement_mark mark = MEASURED;; mark = MEASUREMENT_EXTRAPOLATED) {
        double sum = 0;
        memset(rgb, 0, 3 * sizeof *rgb);
        for (int corner = 0; corner < 8; corner++) {
            int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
            double w = (i ? h.t : 1 - h.t) * (j ? d.t : 1 - d.t) * (k ? p.t : 1 - p.t), x[3];
            int cell = p.cell[k] + PHI_D * (d.cell[j] + THETA_D * h.cell[i]);
            for (int c = 0; c < 3; c++)
                x[c] = get_f64(values + 8 * ((size_t)cell + (size_t)c * CELLS));
            if (x[0] < 0 || x[1] < 0 || x[2] < 0)
                continue;
            sum += w;
            for (int c = 0; c < 3; c++)
                rgb[c] += w * scale[c] * x[c];
        }
        if (sum > 1e-9 || d.cell[1] == 0) {
            for (int c = 0; c < 3; c++)
                rgb[c] = sum > 1e-9 ? rgb[c] / sum : 0;
            return mark;
        }
        d.cell[0] -= d.cell[0] > 0;
        d.cell[1]--;
    }
}

void merl_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
               const struct import_options *options)
{
    const size_t want = HEADER_BYTES + (size_t)3 * 8 * CELLS;
    if (bytes != want)
        die(EXIT_BAD_INPUT, "%s: %zu bytes where this format has %zu; the file is truncated or has a tail", path, bytes,
            want);
    const uint8_t *values = data + HEADER_BYTES;
    for (size_t i = 0; i < (size_t)3 * CELLS && !options->raw; i++)
        if (!isfinite(get_f64(values + 8 * i)))
            die(EXIT_BAD_INPUT, "%s: value %zu is not finite; the file is damaged", path, i);
    measurement_init(out, path);
    measurement_sample(out, options->geometry, value, values, 90);
}
