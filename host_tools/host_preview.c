/* What the pictures share (host_preview_internal.h). */
#include "host_preview_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degrees = 180 / 3.14159265358979323846;

void preview_free(struct preview *p)
{
    free(p->title);
    source_close(&p->source);
    measurement_grid_free(&p->samples);
    *p = (struct preview){0};
}

double preview_luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

uint8_t preview_srgb(double linear)
{
    double x = fmin(fmax(linear, 0), 1);
    return (uint8_t)lround(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055));
}

void preview_direction(double d[3], double theta, double phi)
{
    d[0] = sin(theta / degrees) * cos(phi / degrees);
    d[1] = sin(theta / degrees) * sin(phi / degrees);
    d[2] = cos(theta / degrees);
}

/* --- marks --- */

/* Of the sample nearest to a direction. */
static enum measurement_mark sample_mark(const struct measurement_slice *s, double theta_out, double phi_out)
{
    size_t row = 0;
    if (theta_out > s->theta_out[s->theta_count - 1] + 1e-6)
        return MEASUREMENT_EXTRAPOLATED;
    while (row + 1 < s->theta_count && s->theta_out[row + 1] - theta_out < theta_out - s->theta_out[row])
        row++;
    double column = (phi_out - s->phi_first) / 360 * (double)s->phi_count;
    long k = lround(column) % (long)s->phi_count;
    return s->mark[row * s->phi_count + (size_t)(k < 0 ? k + (long)s->phi_count : k)];
}

static enum measurement_mark pair_mark(const struct measurement_grid *g, const double in[3], const double out[3])
{
    double theta_in = acos(fmin(in[2], 1)) * degrees, theta_out = acos(fmin(out[2], 1)) * degrees;
    double phi = atan2(in[0] * out[1] - in[1] * out[0], in[0] * out[0] + in[1] * out[1]) * degrees;
    size_t k = 0;
    if (g->count > 1 && theta_in > g->slices[g->count - 1].theta_in + 1e-6)
        return MEASUREMENT_EXTRAPOLATED;
    while (k + 1 < g->count && g->slices[k + 1].theta_in - theta_in < theta_in - g->slices[k].theta_in)
        k++;
    return sample_mark(&g->slices[k], theta_out, phi);
}

enum measurement_mark preview_mark(const struct preview *p, const double l[3], const double v[3])
{
    if (p->samples.count) {
        enum measurement_mark there = pair_mark(&p->samples, l, v);
        return there == MEASURED ? there : pair_mark(&p->samples, v, l) == MEASURED ? MEASURED : there;
    }
    bool beyond = acos(fmin(l[2], 1)) * degrees > p->source.theta_in + 1e-6 ||
                  acos(fmin(v[2], 1)) * degrees > p->source.theta_out + 1e-6;
    return beyond ? MEASUREMENT_EXTRAPOLATED : MEASURED;
}

/* --- how they look --- */

static const struct {
    uint8_t ink[3];
    const char *colour, *text;
} looks[] = {[MEASUREMENT_EXTRAPOLATED] = {{0xe0, 0x9f, 0x3e}, "#b87a1c", "extrapolated beyond the measured angles"},
             [MEASUREMENT_FILLED] = {{0x7b, 0x4f, 0xa3}, "#7b4fa3", "filled in by interpolation"}};

void preview_hatch(uint8_t rgb[3], enum measurement_mark mark, int x, int y)
{
    bool inked = mark == MEASUREMENT_FILLED ? (unsigned)(x - y + 65536) % 4 < 2 : (unsigned)(x + y) % 8 < 2;
    if (mark != MEASURED && inked)
        memcpy(rgb, looks[mark].ink, 3);
}

void preview_legend(struct gnuplot *g, unsigned marks)
{
    double x = 0.02;
    for (int mark = MEASUREMENT_EXTRAPOLATED; mark <= MEASUREMENT_FILLED; mark++)
        if (marks >> mark & 1) {
            fprintf(g->to, "set label %d '/// %s' at screen %g,0.025 left tc rgb '%s' noenhanced front\n", 9000 + mark,
                    looks[mark].text, x, looks[mark].colour);
            x = 0.55;
        }
}
