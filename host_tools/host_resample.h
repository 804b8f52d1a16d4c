/*
 * An irregular cloud of samples brought onto a regular grid.
 */
#ifndef HOST_TOOLS_HOST_RESAMPLE_H
#define HOST_TOOLS_HOST_RESAMPLE_H

#include "host_measurement.h"

/*
 * Between two measured angles of incidence the value is interpolated at the same direction around the mirror direction, so that
 * lobes stay whole; within one, by a moving least-squares plane through the nearest samples (Levin 1998), which meets each
 * sample and never leaves their range. Beyond the first and last angle of incidence, and outside the hull of the nearest samples,
 * the nearest known values are carried on and marked as extrapolated. In: `cloud` with at least one sample, values finite.
 * Dies with EXIT_BAD_INPUT when there are many angles of incidence with hardly a sample each.
 */
void measurement_resample(struct measurement *out, const struct measurement *cloud,
                          const struct measurement_geometry *g);

/* Angles of incidence in the cloud. */
size_t measurement_slice_count(const struct measurement *cloud);

#endif
