/* Between the parts of host_check.h. */
#ifndef HOST_TOOLS_HOST_CHECK_INTERNAL_H
#define HOST_TOOLS_HOST_CHECK_INTERNAL_H

#include "host_check.h"

double check_luminance(const double rgb[3]);

/* Sorts the values; NaN of none. */
double check_median(double *values, size_t count);

/* Measured, or filled in by an earlier repair. */
bool check_usable(uint8_t state);

/* Albedo, coverage, reciprocity, quantity. */
void check_physics(struct check *c);

#endif
