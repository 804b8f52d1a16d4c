/*
 * Measurements as CSV (SPEC.md, "CSV"): what an instrument's own export is brought to.
 */
#ifndef HOST_TOOLS_HOST_CSV_H
#define HOST_TOOLS_HOST_CSV_H

#include "host_measurement.h"

/* In: `text` of `bytes` bytes and a NUL after them; it is cut up in place. Negative values become 0 and are
 * counted in a warning, values that are not finite are refused; `raw` keeps both. Dies with EXIT_BAD_INPUT naming the line of the first
 * malformed row. */
void csv_parse(struct measurement *out, const char *path, char *text, size_t bytes, bool raw);

#endif
