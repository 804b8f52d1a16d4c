/*
 * Opening a table file of either kind in gtlut.
 */
#ifndef HOST_TOOLS_GTLUT_TABLE_H
#define HOST_TOOLS_GTLUT_TABLE_H

#include "host_half_vector.h"
#include "host_specular_frame.h"
#include "lut.h"

struct table_file {
    void *data; /* the whole file; owned */
    size_t bytes;
    struct ktx2_view view;
    struct lut_table table;
    union {
        struct specular_frame_table specular_frame;
        struct half_vector half_vector; /* owned */
    };
};

/* True when the first bytes are those of a KTX 2.0 file. */
bool table_recognise(const void *data, size_t bytes);

/* Takes `data` over. Dies with EXIT_BAD_INPUT. */
void table_open(struct table_file *out, const char *path, void *data, size_t bytes);
void table_close(struct table_file *t);

/* The table as a BRDF; it stays the caller's. */
void table_source(struct brdf_source *out, const struct table_file *t);

/* Bytes of the re-packed copy in the file, 0 when there is none. */
uint32_t table_packed_bytes(const struct table_file *t);

/* Angles at which the albedo is reported, degrees. */
enum { TABLE_ALBEDO_ANGLES = 6 };
extern const double table_albedo_angles[TABLE_ALBEDO_ANGLES];

/* specular frame: theta_in of slice z in degrees. */
double table_theta_in(const struct specular_frame_table *t, uint32_t z);

/* half-vector: theta_h of row i and theta_d of plane j in degrees. Where a warp makes no step to a node, the nearest angle. */
double table_theta_h(const struct half_vector *t, uint32_t i);
double table_theta_d(const struct half_vector *t, uint32_t j);

#endif
