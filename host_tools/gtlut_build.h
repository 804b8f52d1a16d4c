/*
 * The parts of gtlut build: options, the two kinds of table, the report.
 */
#ifndef HOST_TOOLS_GTLUT_BUILD_H
#define HOST_TOOLS_GTLUT_BUILD_H

#include <stdbool.h>

#include "host_half_vector.h"
#include "host_metrics.h"
#include "host_specular_frame.h"
#include "lut.h"

struct build_options {
    const char *input, *output;
    enum lut_kind kind; /* 0: not given */
    bool json;
    struct specular_frame_options frame;
    bool swap;
    struct half_vector_options half_vector;
    bool packed;
    double max_de; /* 0: not given */
};

/* What is built from: always a BRDF, and a measurement when its directions lie on a grid. */
struct build_input {
    struct brdf_source source;
    bool is_measurement;
    struct measurement measurement;
    double reciprocity; /* of a measurement, relative error between its samples; NaN when none can be compared */
};

/* What has been built, for the report. */
struct build_result {
    enum lut_kind kind;
    uint32_t nodes[3];  /* phi_d, theta_d, theta_in; or h, d, t */
    size_t table_bytes; /* texels and warps */
    size_t packed_bytes, file_bytes;
    double seconds;
    struct metrics metrics; /* against the source; a half-vector table against the source made reciprocal */
};

/* Each builds, writes the file and reports. */
void build_specular_frame(const struct build_input *in, const struct build_options *o);
void build_half_vector(const struct build_input *in, const struct build_options *o);

/* Before the file is written: dies with EXIT_BAD_INPUT when the texels cannot hold the values, of which `clipped` were too large and
 * `largest` is the largest there is in a texel, in 1/sr; warns when they hold them coarsely. */
void build_judge(const struct build_result *r, size_t clipped, double largest, const char *path);

/* On stderr, and as JSON on stdout when asked to. Warns of albedos above 1. */
void build_report(const struct build_result *r, const struct brdf_source *table, const struct build_input *in,
                  bool json);

/* Monotonic, for printing only. */
double build_seconds(void);

#endif
