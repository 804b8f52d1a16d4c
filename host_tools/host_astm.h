/*
 * ASTM E1392 / E2387 text files of angle-resolved scatter: `KEY value` lines, of which `NUM_POINTS n` and `VARS names` matter, then
 * one line of comma-separated numbers per sample. Names: theta_i, phi_i, theta_s, phi_s (radians; the mirror side is phi_s - phi_i
 * = pi) and the BRDF as R, G, B (linear sRGB), as X, Y, Z, or per wavelength (450nm).
 * Sources: ASTM E2387-05, "Standard Practice for Goniometric Optical Scatter Measurements"; the files of Cornell University's Program
 * of Computer Graphics (graphics.cornell.edu/online/measurements/reflectance).
 */
#ifndef HOST_TOOLS_HOST_ASTM_H
#define HOST_TOOLS_HOST_ASTM_H

#include "host_import.h"

bool astm_recognise(const uint8_t *data, size_t bytes);
void astm_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
               const struct import_options *options);

#endif
