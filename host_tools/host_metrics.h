/*
 * How far a table is from the BRDF it was built from, in double precision. Everything is deterministic.
 */
#ifndef HOST_TOOLS_HOST_METRICS_H
#define HOST_TOOLS_HOST_METRICS_H

#include "host_source.h"

enum { METRICS_BANDS = 3 };

/* theta_in of the bands in degrees: 0..60, 60..75, 75..87. */
extern const double metrics_band[METRICS_BANDS][2];

/* CIE 1976 colour difference of two colours, linear sRGB, D65; 0..1 is what a display shows. */
double metrics_difference(const double a[3], const double b[3]);

/*
 * Three pictures of a sphere, 96 x 96, orthographic, pixel (i, j) at x = 2i/95 - 1, y = 1 - 2j/95, each under one directional
 * light, 30, 80 and 140 degrees off the view axis, of irradiance pi: a white diffuse surface that faces it is 1. Pixels
 * count where x^2 + y^2 < 0.998 and n.l > 0.01. Values are clipped to 0..1.
 */
struct metrics {
    double de_mean, de_p99; /* CIE 1976 colour difference, sRGB primaries, D65, over the pixels of all three pictures */
    double psnr;            /* dB, peak 1, over the sRGB-encoded channels; at most 120 */
    double
        band[METRICS_BANDS]; /* E: sqrt(sum |(f - g) n.v|^2 / sum |g n.v|^2), theta_out below 88 degrees, g the truth */
};

/* The pictures only: about 17000 evaluations of each. `band` is left alone. */
void metrics_pictures(struct metrics *out, const struct brdf_source *f, const struct brdf_source *truth);

/* Pictures and bands: about 54000 evaluations of each. */
void metrics_compare(struct metrics *out, const struct brdf_source *f, const struct brdf_source *truth);

/* Directional-hemispherical reflectance for light at theta_in, 0..89 degrees: the mean of f over the hemisphere weighted with
 * n.v, times pi, so exact for a constant. 160 x 160 directions in rings around the mirror direction, denser towards it. */
void metrics_albedo(double rgb[3], const struct brdf_source *f, double theta_in);

/* sqrt(sum |(f(l,v) - f(v,l)) n.v|^2 / sum |f(l,v) n.v|^2), theta_in 0..75, theta_out below 88 degrees. 0 when f is black. */
double metrics_reciprocity(const struct brdf_source *f);

#endif
