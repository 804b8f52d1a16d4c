/*
 * Cornell University's `.brdf` text files: # comments, the number of wavelengths, the wavelengths in nm, then one line per
 * sample: theta_i phi_i theta_s phi_s and one BRDF value per wavelength. Angles are radians, or degrees in a file in which a theta
 * exceeds pi/2. Source: Program of Computer Graphics, "Reflectance Data" (graphics.cornell.edu/online/measurements/reflectance);
 * 31 or 65 wavelengths from 400 to 700 nm.
 */
#ifndef HOST_TOOLS_HOST_CORNELL_H
#define HOST_TOOLS_HOST_CORNELL_H

#include "host_import.h"

bool cornell_recognise(const uint8_t *data, size_t bytes);
void cornell_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
                  const struct import_options *options);

#endif
