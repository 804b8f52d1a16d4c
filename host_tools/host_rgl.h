/*
 * EPFL RGL material files (.bsdf, "tensor_file" 1.0): isotropic RGB measurements in the adaptive parameterisation of Dupuy and
 * Jakob 2018, "An Adaptive Parameterization for Efficient Material Acquisition and Rendering".
 */
#ifndef HOST_TOOLS_HOST_RGL_H
#define HOST_TOOLS_HOST_RGL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_measurement.h"

struct rgl;

bool rgl_recognise(const uint8_t *data, size_t bytes);

/* Checks every offset, shape and value; dies with EXIT_BAD_INPUT. Keeps its own copy. Free with rgl_close. */
struct rgl *rgl_open(const char *path, const uint8_t *data, size_t bytes);
void rgl_close(struct rgl *r);

/* BRDF in 1/sr (the file stores it times cos(theta_o)), negative interpolation results as 0. Angles in radians:
 * theta_in in [0, pi/2), theta_out in [0, pi/2), phi_out as in host_measurement.h. theta_in beyond the file's last is clamped
 * to it. */
void rgl_value(double rgb[3], const struct rgl *r, double theta_in, double theta_out, double phi_out);

/* The file's last theta_i in degrees. */
double rgl_theta_in(const struct rgl *r);

/* The material at every direction of the geometry; incidence beyond the file's last is marked as extrapolated. */
void rgl_sample(struct measurement *out, const struct rgl *r, const char *source, const struct measurement_geometry *g);

#endif
