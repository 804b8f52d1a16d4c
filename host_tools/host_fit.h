/*
 * Fits an analytic reflectance model of the renderer (SPEC.md, "A material") to a measurement: bounded nonlinear least squares
 * (Levenberg-Marquardt of the GNU Scientific Library over variables that a sine keeps in bounds, as in James and Roos 1975) of the
 * cube root of the BRDF times cos(theta_out), plus 0.001, over the solid angle that each sample stands for, every angle of incidence
 * counting the same, from several starts. Deterministic.
 */
#ifndef HOST_TOOLS_HOST_FIT_H
#define HOST_TOOLS_HOST_FIT_H

#include <stdint.h>

#include "host_measurement.h"
#include "host_source.h"

enum fit_model { FIT_LAFORTUNE_PHONG, FIT_BLINN_PHONG, FIT_GGX, FIT_MODELS };
enum { FIT_PARAMETERS = 7, FIT_STARTS = 12 };

/* Indices of parameters: kd 0..2, ks 3..5, exponent 6; of GGX: base colour 0..2, metalness 3, roughness 4. */
struct fit {
    enum fit_model model;
    int count; /* parameters in use */
    double parameter[FIT_PARAMETERS];
    double
        error; /* sqrt(sum w |f - g|^2 / sum w |g|^2) over all measured samples, f and g these roots, g the measurement's */
    int agreed;     /* starts, the best included, that ended within 1 % of the best error */
    size_t samples; /* measured ones; extrapolated ones do not count */
};

/* "lafortune_phong", "blinn_phong" or "ggx"; dies with EXIT_USAGE. */
enum fit_model fit_model_find(const char *name);

/* In: a grid with at least 8 measured samples that are not all black (else dies with EXIT_BAD_INPUT; `path` is for the message). */
void fit_make(struct fit *out, enum fit_model model, const struct measurement_grid *grid, uint64_t seed,
              const char *path);

/* BRDF in 1/sr for unit vectors with positive z. */
void fit_value(double rgb[3], const struct fit *fit, const double l[3], const double v[3]);

/* The same as a source; the fit stays the caller's. */
void fit_source(struct brdf_source *out, const struct fit *fit);

#endif
