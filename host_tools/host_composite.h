/*
 * Specular-frame slices as a measurement: the composite image that gtlut export writes (all slices in row-major order in one EXR,
 * whose axes must be told), and a specular-frame or half-vector table file.
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

#endif
