/*
 * BRDFs given as functions, as measurements: the composite image that gtlut export writes (all slices in row-major order in one EXR,
 * whose axes must be told), a specular-frame or half-vector table file, and one material of a table of fits.
 */
#ifndef HOST_TOOLS_HOST_COMPOSITE_H
#define HOST_TOOLS_HOST_COMPOSITE_H

#include "host_import.h"

bool composite_recognise(const uint8_t *data, size_t bytes);
void composite_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
                    const struct import_options *options);

bool table_file_recognise(const uint8_t *data, size_t bytes);
void table_file_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
                     const struct import_options *options);

/* True for FILE.csv:NAME when there is no file of the whole name. */
bool fit_name_recognise(const char *path);
void fit_name_load(struct measurement *out, const char *path, const struct import_options *options);

#endif
