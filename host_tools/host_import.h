/*
 * The file formats that a measurement can come from: one table, one small file per format.
 */
#ifndef HOST_TOOLS_HOST_IMPORT_H
#define HOST_TOOLS_HOST_IMPORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_measurement.h"
#include "host_spectral.h"

struct import_options {
    const struct measurement_geometry *geometry; /* where functions are evaluated and clouds resampled; never NULL */
    enum spectral_illuminant illuminant;         /* of spectral data */
    uint32_t width, height, depth;               /* axes of a composite image; width 0: not given */
    double theta_max;                            /* of a composite image's last slice, degrees, above 0 */
    bool raw; /* keep what is negative, infinite or not a number, for a check to find */
};

struct import_format {
    const char *name, *extensions, *description;
    bool evaluated; /* a function of any two directions, evaluated at the geometry; else samples, which are kept */
    /* Looks at no more than the bytes. */
    bool (*recognise)(const uint8_t *data, size_t bytes);
    /* In: the file's bytes and a NUL after them, which may be cut up in place. `out` is new. Dies with EXIT_BAD_INPUT. */
    void (*load)(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
                 const struct import_options *options);
};

/* The last one, CSV, takes what no other recognises. */
extern const struct import_format import_formats[];
extern const size_t import_format_count;

/* By name; dies with EXIT_USAGE. */
const struct import_format *import_format_find(const char *name);

/* By content, never NULL. */
const struct import_format *import_format_of(const uint8_t *data, size_t bytes);

/* Reads a file of any of the formats, or FILE.csv:NAME. Unless options->raw, negative values become 0, counted in a warning, and a value that is not
 * finite is refused. Dies with EXIT_FILE or EXIT_BAD_INPUT. Returns the format. */
const struct import_format *import_read(struct measurement *out, const char *path,
                                        const struct import_options *options);

/* The same from the file's bytes and a NUL after them. */
void import_load(struct measurement *out, const struct import_format *format, const char *path, uint8_t *data,
                 size_t bytes, const struct import_options *options);

#endif
