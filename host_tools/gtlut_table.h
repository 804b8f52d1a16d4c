/*
 * Opening a table file in gtlut.
 */
#ifndef HOST_TOOLS_GTLUT_TABLE_H
#define HOST_TOOLS_GTLUT_TABLE_H

#include "lut.h"

struct table_file {
    void *data; /* the whole file; owned */
    size_t bytes;
    struct ktx2_view view;
    struct lut_table table;
    double theta_max; /* degrees */
};

/* True when the first bytes are those of a KTX 2.0 file. */
bool table_recognise(const void *data, size_t bytes);

/* Takes `data` over. Dies with EXIT_BAD_INPUT. */
void table_open(struct table_file *out, const char *path, void *data, size_t bytes);
void table_close(struct table_file *t);

/* theta_in of slice z in degrees. */
double table_theta_in(const struct table_file *t, uint32_t z);

#endif
