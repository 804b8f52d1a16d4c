/*
 * Zemax OpticStudio tabular BSDF (`.bsdf` text): Source, Symmetry, SpectralContent, ScatterType, SampleRotation, AngleOfIncidence,
 * ScatterAzimuth, ScatterRadial, then per channel (Monochrome, or TristimulusX, Y, Z) DataBegin, per angle `TIS x` and one row of
 * radials per azimuth, DataEnd. Degrees; azimuth and radial are around the mirror direction, azimuth 0 points at the normal and
 * grows counter-clockwise seen from outside. Directions below the surface are skipped.
 * Source: Ron Rykowski, "BSDF Data Interchange file format specification", Zemax knowledge base (support.zemax.com, article
 * 1500005486801).
 */
#ifndef HOST_TOOLS_HOST_ZEMAX_H
#define HOST_TOOLS_HOST_ZEMAX_H

#include "host_import.h"

bool zemax_recognise(const uint8_t *data, size_t bytes);
void zemax_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
                const struct import_options *options);

#endif
