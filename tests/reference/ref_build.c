#include "ref_build.h"

#include <math.h>

static const double degrees = 180 / 3.14159265358979323846;

/* The row's value at an azimuth: every column weighted by its hat function of width 360 / columns. */
static double row_value(const struct ref_measurement *m, int slice, int row, double phi, int channel)
{
    const double *data = m->rgb + ((long)slice * m->rows + row) * m->columns * 3 + channel;
    double step = 360.0 / m->columns, sum = 0;
    if (slice == 0) { /* light along the normal: the mean over all azimuths */
        for (int k = 0; k < m->columns; k++)
            sum += data[3 * k];
        return sum / m->columns;
    }
    if (m->columns == 1)
        return data[0];
    int near = (int)floor(phi / step);
    for (int k = near - 1; k <= near + 2; k++) {
        double weight = 1 - fabs(phi - k * step) / step;
        if (weight > 0)
            sum += weight * data[3 * ((k % m->columns + m->columns) % m->columns)];
    }
    return sum;
}

static double known_value(const struct ref_measurement *m, int slice, double theta, double phi, int channel)
{
    if (theta <= m->theta_out[0])
        return row_value(m, slice, 0, phi, channel);
    for (int i = 1; i < m->rows; i++)
        if (theta <= m->theta_out[i]) {
            double share = (theta - m->theta_out[i - 1]) / (m->theta_out[i] - m->theta_out[i - 1]);
            double below = row_value(m, slice, i - 1, phi, channel), above = row_value(m, slice, i, phi, channel);
            return below + share * (above - below);
        }
    return row_value(m, slice, m->rows - 1, phi, channel);
}

/* The Bezier curve (0,0), (l,1-l), (1,1) by de Casteljau, its parameter by bisection of the abscissa. */
static double fade(double x, double l)
{
    double lo = 0, hi = 1;
    for (int i = 0; i < 200; i++) {
        double t = (lo + hi) / 2, first = t * l, second = l + t * (1 - l);
        if (first + t * (second - first) < x)
            lo = t;
        else
            hi = t;
    }
    double t = hi, first = t * (1 - l), second = (1 - l) + t * l;
    return first + t * (second - first);
}

void ref_build_node(double rgb[3], const struct ref_measurement *m, int slice, int x, int y, int width, int height,
                    double p, double l)
{
    double theta_d = 180.0 * y / (height - 1) / degrees, phi_d = 360.0 * x / (width - 1) / degrees;
    double theta_in = m->theta_in[slice] / degrees;
    /* The light is in the half plane of azimuth 0. Axes of the lobe's frame: the mirror direction, the direction of growing
     * theta_d at phi_d = 0 (in the plane of incidence, away from the normal), and their cross product. */
    double mirror[3] = {-sin(theta_in), 0, cos(theta_in)};
    double away[3] = {-cos(theta_in), 0, -sin(theta_in)};
    double side[3] = {mirror[1] * away[2] - mirror[2] * away[1], mirror[2] * away[0] - mirror[0] * away[2],
                      mirror[0] * away[1] - mirror[1] * away[0]};
    double v[3];
    for (int i = 0; i < 3; i++)
        v[i] = cos(theta_d) * mirror[i] + sin(theta_d) * (cos(phi_d) * away[i] + sin(phi_d) * side[i]);

    double sine = sqrt(v[0] * v[0] + v[1] * v[1]);
    double theta = (fabs(v[2]) < 0.9 ? acos(v[2]) : v[2] > 0 ? asin(sine) : 180 / degrees - asin(sine)) * degrees;
    double phi = sine < 1e-8 ? 0 : atan2(v[1], v[0]) * degrees;
    double last = m->theta_out[m->rows - 1], a = 0;
    if (theta > 90)
        a = 1;
    else if (theta > last)
        a = fade((theta - last) / (90 - last), l);
    for (int c = 0; c < 3; c++)
        rgb[c] = known_value(m, slice, theta, phi, c) * ((1 - a) + a * p);
}
