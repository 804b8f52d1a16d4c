/*
 * EPFL RGL isotropic RGB materials (Dupuy and Jakob 2018) in double precision, by integrating the tabulated densities afresh
 * for every direction. For trusted, well-formed files only: it asserts.
 */
#ifndef TESTS_REFERENCE_REF_RGL_H
#define TESTS_REFERENCE_REF_RGL_H

#include <stddef.h>

struct ref_rgl;

struct ref_rgl *ref_rgl_open(const unsigned char *file, size_t bytes);
void ref_rgl_close(struct ref_rgl *r);

/* BRDF in 1/sr for unit vectors, z the normal. */
void ref_rgl_value(double rgb[3], const struct ref_rgl *r, const double wi[3], const double wo[3]);

/* The file's angle of incidence number `index`, radians. */
double ref_rgl_angle(const struct ref_rgl *r, int index);

/* For light from theta_i at azimuth 0 and a facet's normal at (theta_m, phi): the density of visible normals per solid angle, from
 * its image; the density of normals D; the projected area sigma. Up to one factor that the first and the last share. */
void ref_rgl_terms(double terms[3], const struct ref_rgl *r, double theta_i, double theta_m, double phi);

#endif
