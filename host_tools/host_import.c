#include "host_import.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_astm.h"
#include "host_composite.h"
#include "host_cornell.h"
#include "host_csv.h"
#include "host_merl.h"
#include "host_rgl.h"
#include "host_text.h"
#include "host_zemax.h"

#define MAX_FILE_BYTES ((size_t)1 << 30)

static void measurement_file_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
                                  const struct import_options *options)
{
    (void)options;
    measurement_parse(out, path, data, bytes);
}

static void rgl_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
                     const struct import_options *options)
{
    struct rgl *r = rgl_open(path, data, bytes);
    rgl_sample(out, r, path, options->geometry);
    rgl_close(r);
}

/* Not told by content: see import_read. */
static bool never(const uint8_t *data, size_t bytes)
{
    (void)data;
    (void)bytes;
    return false;
}

static bool csv_recognise(const uint8_t *data, size_t bytes)
{
    (void)data;
    (void)bytes;
    return true;
}

static void csv_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
                     const struct import_options *options)
{
    csv_parse(out, path, (char *)data, bytes, options->raw);
}

const struct import_format import_formats[] = {
    {"gtm", ".gtm", "what gtlut import writes", false, measurement_recognise, measurement_file_load},
    {"rgl", ".bsdf", "EPFL RGL material database, isotropic RGB", true, rgl_recognise, rgl_load},
    {"merl", ".binary", "MERL BRDF database", true, merl_recognise, merl_load},
    {"ktx2", ".ktx2", "a table that gtlut build wrote", true, table_file_recognise, table_file_load},
    {"composite", ".exr", "all slices of a table in one image (gtlut export); needs --axes", true, composite_recognise,
     composite_load},
    {"astm", ".astm .brdf .txt", "ASTM E1392 / E2387 scatter data: RGB, XYZ or spectral", false, astm_recognise,
     astm_load},
    {"zemax", ".bsdf", "Zemax OpticStudio tabular BSDF, monochrome or XYZ", false, zemax_recognise, zemax_load},
    {"cornell", ".brdf .txt", "Cornell University gonioreflectometer, spectral", false, cornell_recognise,
     cornell_load},
    {"sgd", ".csv:NAME", "one material of a table of shifted-gamma fits", true, never, NULL},
    {"csv", ".csv", "theta_in,theta_out,phi_out,R,G,B in any order, degrees", false, csv_recognise, csv_load},
};
const size_t import_format_count = sizeof import_formats / sizeof *import_formats;

const struct import_format *import_format_find(const char *name)
{
    for (size_t i = 0; i < import_format_count; i++)
        if (!strcmp(name, import_formats[i].name))
            return &import_formats[i];
    die(EXIT_USAGE, "--format: '%s' is no format; see gtlut formats", name);
}

const struct import_format *import_format_of(const uint8_t *data, size_t bytes)
{
    const struct import_format *f = import_formats;
    size_t mark = text_mark(data, bytes);
    data += mark;
    bytes -= mark;
    while (!f->recognise(data, bytes))
        f++;
    return f;
}

static void clean(struct measurement *m, const char *path)
{
    size_t negative = 0;
    for (size_t i = 0; i < m->count; i++) {
        struct measurement_point *p = &m->points[i];
        bool below = false;
        for (int c = 0; c < 3; c++) {
            if (!isfinite(p->rgb[c]))
                die(EXIT_BAD_INPUT,
                    "%s: the value at theta_in %g, theta_out %g, phi_out %g is not finite; gtlut check --repair fills "
                    "it",
                    path, p->theta_in, p->theta_out, p->phi_out);
            below |= p->rgb[c] < 0;
            p->rgb[c] = fmaxf(p->rgb[c], 0);
        }
        negative += below;
    }
    if (negative)
        warn("%s: %zu samples with negative values, set to 0", path, negative);
}

void import_load(struct measurement *out, const struct import_format *format, const char *path, uint8_t *data,
                 size_t bytes, const struct import_options *options)
{
    format->load(out, path, data, bytes, options);
    if (!out->count)
        die(EXIT_BAD_INPUT, "%s: no samples; the file is truncated", path);
    if (!options->raw)
        clean(out, path);
}

const struct import_format *import_read(struct measurement *out, const char *path, const struct import_options *options)
{
    if (fit_name_recognise(path)) {
        fit_name_load(out, path, options);
        return import_format_find("sgd");
    }
    size_t bytes;
    uint8_t *data = read_file(path, MAX_FILE_BYTES, &bytes);
    const struct import_format *format = import_format_of(data, bytes);
    import_load(out, format, path, data, bytes, options);
    free(data);
    return format;
}
