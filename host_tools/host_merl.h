/*
 * MERL database `.binary`: three i32 (90, 90, 180), then planes R, G, B of f64 over theta_h, theta_d and phi_d (folded to [0, pi)),
 * the half vector's angle and the difference angles of Rusinkiewicz 1998; rows of theta_h stand at 90 (i/90)^2 degrees. Values
 * are scaled by 1/1500, 1.15/1500 and 1.66/1500; a negative one is invalid. Cell i of an axis covers i to i+1.
 * Source: Matusik, Pfister, Brand and McMillan 2003, "A Data-Driven Reflectance Model"; the database's README.
 */
#ifndef HOST_TOOLS_HOST_MERL_H
#define HOST_TOOLS_HOST_MERL_H

#include "host_import.h"

bool merl_recognise(const uint8_t *data, size_t bytes);
void merl_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
               const struct import_options *options);

#endif
