/*
 * The specular-frame table of Cezner and Havran 2024 in double precision, node by node from the definition.
 */
#ifndef TESTS_REFERENCE_REF_BUILD_H
#define TESTS_REFERENCE_REF_BUILD_H

/* A measurement: slices over theta_in, rows over theta_out, columns over phi_out = 360 k / columns degrees. */
struct ref_measurement {
    int slices, rows, columns;
    const double *theta_in, *theta_out; /* degrees, ascending */
    const double *rgb;                  /* [slices][rows][columns][3] */
};

/* Node (x, y) of `slice` of a width x height table; p and l are those of the extrapolation. At theta_out of 0 and 180 degrees,
 * where the azimuth is undefined, phi_out counts as 0. */
void ref_build_node(double rgb[3], const struct ref_measurement *m, int slice, int x, int y, int width, int height,
                    double p, double l);

#endif
