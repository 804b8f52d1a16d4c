/*
 * What is wrong or missing in a measurement, and its repair.
 */
#ifndef HOST_TOOLS_HOST_CHECK_H
#define HOST_TOOLS_HOST_CHECK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_measurement.h"

enum check_state {
    CHECK_GOOD,
    CHECK_EXTRAPOLATED,
    CHECK_FILLED, /* marked so in the file */
    CHECK_MISSING,
    CHECK_NOT_FINITE,
    CHECK_BLIND,  /* in the spot around the light: missing, not finite or below 5 % of what is around it */
    CHECK_OUTLIER /* beyond its neighbours by far: three times their spread and the slice's noise from their median */
};

/* One angle of incidence: all combinations of its theta_out and phi_out, present or not. Angles in degrees, ascending. */
struct check_slice {
    double theta_in;
    size_t theta_count, phi_count;
    double *theta_out, *phi_out;
    double (*rgb)[3];         /* [theta_count][phi_count] */
    uint8_t *state;           /* the same, enum check_state */
    double covered;           /* share of the hemisphere's projected solid angle that was measured */
    double albedo[3];         /* of the measured part, samples that are bad taken as the mean of their row */
    double albedo_carried[3]; /* the same with the last row carried on to the horizon */
};

/* Degrees of azimuth that one sample may stand for. */
enum { CHECK_PHI_GAP = 30 };

/* What the values seem to be. */
enum check_quantity { CHECK_BRDF, CHECK_TIMES_COSINE, CHECK_OVER_COSINE, CHECK_UNCLEAR };

struct check {
    size_t points, irregular; /* irregular: samples were too scattered and were resampled first: their number */
    size_t nan, infinite, negative, doubled, extrapolated, filled; /* samples */
    size_t missing, blind, outliers;                               /* cells of the grid */
    double blind_radius;                                           /* degrees from the light, 0 without blind spot */
    double phi_gap;         /* degrees, the largest between two phi_out where they matter: of slices off the normal */
    double covered_least;   /* of the slices with any sample that is not extrapolated; 1 without one */
    char *coverage_problem; /* too little for a table to be the material's; NULL when there is none */
    char *grid_problem;     /* why no table can be built from it as it is; NULL when one can */
    size_t reciprocal_pairs;
    /* Cosine-weighted relative RMSE between f(l,v) and f(v,l) of the values as they are, divided by cos(theta_out), and
     * multiplied by it; 0 without pairs. */
    double reciprocity[3];
    double
        exponent; /* median e by which f(l,v)/f(v,l) follows (cos v / cos l)^e: 0 for a BRDF, 1 when it was multiplied by cosine */
    double
        trend; /* slope of ln f over ln cos(theta_out) towards grazing, out of the plane of incidence; NaN when unknown */
    enum check_quantity quantity;
    size_t count;
    struct check_slice *slices; /* ascending theta_in */
};

/* In: samples as import_read leaves them with `raw`; resampled to `g` when they are no grid with holes. */
void check_make(struct check *out, const struct measurement *m, const struct measurement_geometry *g);
void check_free(struct check *c);

/* The largest albedo of any channel and slice, carried on to the horizon. */
double check_albedo_max(const struct check *c);

/* Fills what is missing, not finite, blind or an outlier by the membrane that the samples around span, sets negative values to 0,
 * and undoes a cosine (quantity) unless it is unclear. With `blind_only` no more than the blind spot and negative values. Returns the
 * number of cells filled. */
size_t check_repair(struct check *c, bool blind_only);

/* The grid's samples, filled ones marked. */
void check_measurement(struct measurement *out, const struct check *c, const char *source);

/* Finds the blind spot in raw samples, fills it and says so; whatever else is not finite dies with EXIT_BAD_INPUT. */
void check_fill_blind_spot(struct measurement *m, const char *path);

/* Angle between an outgoing direction and the light (mirror: its mirror direction), degrees. */
double check_distance(double theta_in, double theta_out, double phi_out, bool mirror);

#endif
