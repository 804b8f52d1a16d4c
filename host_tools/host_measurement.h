/*
 * A measured reflectance: a point cloud of an isotropic BRDF, and the regular grid a table is built from.
 *
 * Angles are degrees. theta is measured from the surface normal; phi_out is the azimuth of the outgoing
 * direction relative to the incident one: 0 is back towards the light, 180 the mirror side. Values are BRDF
 * in 1/sr, linear sRGB primaries. Two angles are the same when they agree to a thousandth of a degree.
 */
#ifndef HOST_TOOLS_HOST_MEASUREMENT_H
#define HOST_TOOLS_HOST_MEASUREMENT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MEASUREMENT_MAX_POINTS (1u << 24)

/* Where a sample comes from; kept through the measurement file up to the pictures. */
enum measurement_mark {
    MEASURED = 0,
    MEASUREMENT_EXTRAPOLATED = 1, /* outside the angles that the instrument covered */
    MEASUREMENT_FILLED = 2        /* inside them, but put in by interpolation: a blind spot, a bad sample */
};

struct measurement_point {
    float theta_in;  /* [0, 90) */
    float theta_out; /* [0, 90] */
    float phi_out;   /* [0, 360) */
    float rgb[3];    /* finite, >= 0; what import_load was told to keep as it is may be anything */
    uint32_t mark;   /* enum measurement_mark */
};

struct measurement {
    char source[64]; /* printable ASCII, NUL-padded: where the data came from */
    size_t count, room;
    struct measurement_point *points; /* any order; owned */
};

/* The sampling plans of `gtlut measure` and `gtlut import`: theta_in from 0 in theta_in_count equal steps,
 * theta_out and phi_out in steps of one degree, theta_out up to theta_out_max inclusive, phi_out 0..359. */
struct measurement_geometry {
    const char *name;
    double theta_in_step;
    int theta_in_count, theta_out_max;
};

/* "minidiff" or "dense"; dies with EXIT_USAGE. */
const struct measurement_geometry *measurement_geometry_find(const char *name);

/* `out` starts empty with `source` reduced to the last component of a path and to printable ASCII. */
void measurement_init(struct measurement *out, const char *source);
void measurement_add(struct measurement *m, const struct measurement_point *point);
void measurement_free(struct measurement *m);

/* Adds the BRDF `value` (1/sr, angles in radians; it tells how it knows) at every direction of the geometry. theta_in above
 * `theta_in_last` degrees is marked as extrapolated. */
void measurement_sample(struct measurement *m, const struct measurement_geometry *g,
                        enum measurement_mark (*value)(double rgb[3], const void *ctx, double theta_in,
                                                       double theta_out, double phi_out),
                        const void *ctx, double theta_in_last);

/* Reads a measurement file (SPEC.md, "Measurement file") or CSV, told apart by content. Dies with EXIT_FILE or
 * EXIT_BAD_INPUT. */
void measurement_read(struct measurement *out, const char *path);

/* The same from the `bytes` bytes of a file and a NUL after them, which are cut up in place; `path` is for messages. */
void measurement_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes);

/* A measurement file only. */
bool measurement_recognise(const uint8_t *data, size_t bytes);
void measurement_parse(struct measurement *out, const char *path, const uint8_t *data, size_t bytes);

/* Writes a measurement file, atomically. */
void measurement_write(const struct measurement *m, const char *path);

/* One incident angle on a full grid. phi_out of column k is phi_first + k * 360 / phi_count. */
struct measurement_slice {
    double theta_in;
    size_t theta_count, phi_count;
    double *theta_out; /* ascending */
    double phi_first;  /* [0, 360) */
    double *rgb;       /* [theta_count][phi_count][3] */
    uint8_t *mark;     /* [theta_count][phi_count]: enum measurement_mark */
    /* The largest theta_out with a sample that is not extrapolated; -1 when the whole slice is extrapolated. */
    double theta_measured;
};

struct measurement_grid {
    size_t count;
    struct measurement_slice *slices; /* ascending theta_in, from 0 in equal steps */
};

/* Why the points do not form what is described above (which direction is missing, doubled or off the grid), malloc'd; NULL when
 * they do. */
char *measurement_grid_problem(const struct measurement *m);

/* Sorts the points into slices. Dies with EXIT_BAD_INPUT, saying measurement_grid_problem, when
 * they form none. `path` is for messages. */
void measurement_grid_make(struct measurement_grid *out, const struct measurement *m, const char *path);
void measurement_grid_free(struct measurement_grid *g);

/* Bilinear in (theta_out, phi_out); theta_out is clamped to the slice's range, phi_out (any degrees) wraps.
 */
void measurement_slice_value(double rgb[3], const struct measurement_slice *s, double theta_out, double phi_out);

#endif
