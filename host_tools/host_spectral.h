/*
 * Spectra to linear sRGB: CIE 1931 2-degree observer, a stated illuminant, 380..780 nm in steps of 5 nm. The spectrum is linear
 * between its samples and constant beyond them (as ASTM E308 advises). Whatever the illuminant, its white becomes (1, 1, 1): other
 * whites than D65 are adapted (Bradford), as the renderer's own lights are given in sRGB.
 */
#ifndef HOST_TOOLS_HOST_SPECTRAL_H
#define HOST_TOOLS_HOST_SPECTRAL_H

#include <stddef.h>

enum spectral_illuminant { SPECTRAL_D65, SPECTRAL_E, SPECTRAL_A, SPECTRAL_ILLUMINANTS };

/* Dies with EXIT_USAGE. */
enum spectral_illuminant spectral_illuminant_find(const char *name);

struct spectral {
    size_t count;
    double (*weight)[3]; /* [count]: linear sRGB is the sum of value * weight; owned */
};

/* Warns when none of a file's wavelengths is visible: micrometres, or infrared. */
void spectral_look_at(const char *path, size_t line, const double *nm, size_t count);

/* In: `count` wavelengths in nm, at least 1, strictly ascending. */
void spectral_make(struct spectral *out, const double *nm, size_t count, enum spectral_illuminant illuminant);
void spectral_free(struct spectral *s);

/* Of a reflectance or BRDF sampled at those wavelengths. A saturated colour outside sRGB has a negative channel. */
void spectral_rgb(double rgb[3], const struct spectral *s, const double *values);

/* Tristimulus values relative to D65 white (0.95047, 1, 1.08883). */
void spectral_xyz_to_rgb(double rgb[3], const double xyz[3]);

#endif
