#include "host_zemax.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common.h"
#include "host_text.h"

enum { MAX_ANGLES = 4096 };

struct axis {
    size_t count;
    double *value;
};

struct layout {
    struct axis rotation, incidence, azimuth, radial;
    bool plane, xyz; /* symmetrical to the plane of incidence; three channels */
};

bool zemax_recognise(const uint8_t *data, size_t bytes)
{
    return text_begins(data, bytes, "AngleOfIncidence") || text_begins(data, bytes, "SpectralContent");
}

static void read_axis(struct axis *a, struct text_reader *r, const char *name, double lo, double hi)
{
    a->count = text_count(r, name, MAX_ANGLES);
    if (a->value)
        die(EXIT_BAD_INPUT, "%s:%zu: %s a second time; the file is damaged", r->path, r->line, name);
    a->value = xmalloc(a->count * sizeof *a->value);
    for (size_t i = 0; i < a->count; i++) {
        double x = a->value[i] = text_number(r, name, text_token(r), false);
        if (!(x >= lo && x <= hi) || (i && !(x > a->value[i - 1])))
            die(EXIT_BAD_INPUT, "%s:%zu: %s %g; the angles must ascend from %g to %g", r->path, r->line, name, x, lo,
                hi);
    }
}

/* One of two words; true for the second. */
static bool read_choice(struct text_reader *r, const char *key, const char *no, const char *yes)
{
    const char *word = text_token(r);
    if (!word || (strcasecmp(word, no) && strcasecmp(word, yes)))
        die(EXIT_BAD_INPUT, "%s:%zu: %s is '%.40s', want %s or %s", r->path, r->line, key, word ? word : "", no, yes);
    return !strcasecmp(word, yes);
}

/* Up to the first channel; returns its name. */
static const char *read_header(struct layout *l, struct text_reader *r)
{
    const char *key;
    while ((key = text_token(r)) && strcmp(key, "Monochrome") && strncmp(key, "Tristimulus", 11)) {
        if (!strcmp(key, "Symmetry"))
            l->plane = read_choice(r, key, "Asymmetrical", "PlaneSymmetrical");
        else if (!strcmp(key, "SpectralContent"))
            l->xyz = read_choice(r, key, "Monochrome", "XYZ");
        else if (!strcmp(key, "ScatterType"))
            read_choice(r, key, "BRDF", "BRDF");
        else if (!strcmp(key, "SampleRotation"))
            read_axis(&l->rotation, r, key, -360, 360);
        else if (!strcmp(key, "AngleOfIncidence"))
            read_axis(&l->incidence, r, key, 0, 89.999);
        else if (!strcmp(key, "ScatterAzimuth"))
            read_axis(&l->azimuth, r, key, 0, 360);
        else if (!strcmp(key, "ScatterRadial"))
            read_axis(&l->radial, r, key, 0, 180);
        else if (!strcmp(key, "Source"))
            text_token(r);
        else
            die(EXIT_BAD_INPUT, "%s:%zu: '%.40s' is no key of this format; the file is damaged", r->path, r->line, key);
    }
    if (!l->incidence.value || !l->azimuth.value || !l->radial.value)
        die(EXIT_BAD_INPUT,
            "%s:%zu: AngleOfIncidence, ScatterAzimuth or ScatterRadial is missing; the file is truncated", r->path,
            r->line);
    if (l->rotation.count > 1)
        die(EXIT_BAD_INPUT, "%s: anisotropic, %zu sample rotations; only isotropic materials (1) fit a table", r->path,
            l->rotation.count);
    return key;
}

static void read_channel(double *values, struct text_reader *r, const struct layout *l)
{
    text_want(r, text_token(r), "DataBegin");
    for (size_t i = 0; i < l->incidence.count; i++) {
        text_want(r, text_token(r), "TIS");
        text_number(r, "a total integrated scatter", text_token(r), true);
        for (size_t k = 0; k < l->azimuth.count * l->radial.count; k++)
            *values++ = text_number(r, "a BSDF value", text_token(r), true);
    }
    text_want(r, text_token(r), "DataEnd");
}

/* The direction at (radial, azimuth) around the mirror direction of light at theta_in; false below the surface. */
static bool direction(double angle[4], double theta_in, double radial, double azimuth)
{
    const double degree = 3.14159265358979323846 / 180;
    double s = sin(theta_in * degree), c = cos(theta_in * degree), sr = sin(radial * degree), cr = cos(radial * degree);
    /* Around the mirror direction: x towards the normal, y counter-clockwise of it. */
    double x = sr * cos(azimuth * degree), y = sr * sin(azimuth * degree);
    double v[3] = {c * x - s * cr, y, s * x + c * cr};
    angle[0] = theta_in;
    angle[1] = 0;
    angle[2] = atan2(hypot(v[0], v[1]), v[2]) / degree;
    angle[3] = atan2(v[1], v[0]) / degree;
    return angle[2] <= 90;
}

void zemax_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
                const struct import_options *options)
{
    (void)options; /* tristimulus values are taken as relative to D65 */
    static const char *const channels[] = {"TristimulusX", "TristimulusY", "TristimulusZ"};
    struct text_reader r;
    struct layout l = {0};
    text_open(&r, path, data, bytes);
    const char *name = read_header(&l, &r);
    size_t per_angle = l.azimuth.count * l.radial.count, count = l.incidence.count * per_angle;
    if (count > MEASUREMENT_MAX_POINTS)
        die(EXIT_BAD_INPUT, "%s: %zu values, the limit is %u; thin them out", path, count, MEASUREMENT_MAX_POINTS);
    double *values[3] = {0};
    for (int c = 0; c < (l.xyz ? 3 : 1); c++, name = text_token(&r)) {
        text_want(&r, name, l.xyz ? channels[c] : "Monochrome");
        values[c] = xmalloc(count * sizeof(double));
        read_channel(values[c], &r, &l);
    }
    measurement_init(out, path);
    for (size_t i = 0; i < count; i++) {
        double radial = l.radial.value[i % l.radial.count], azimuth = l.azimuth.value[i % per_angle / l.radial.count];
        double angle[4], rgb[3] = {values[0][i], values[0][i], values[0][i]};
        if (l.xyz)
            spectral_xyz_to_rgb(rgb, (double[3]){values[0][i], values[1][i], values[2][i]});
        /* At the mirror direction itself all azimuths are one; so are 0 and 360. */
        if ((radial < 1e-6 && i % per_angle >= l.radial.count) || (azimuth > 360 - 1e-6 && l.azimuth.value[0] < 1e-6))
            continue;
        double theta_in = l.incidence.value[i / per_angle];
        if (direction(angle, theta_in, radial, azimuth))
            text_add(out, &r, angle, rgb);
        if (l.plane && azimuth > 1e-6 && azimuth < 180 - 1e-6 && direction(angle, theta_in, radial, -azimuth))
            text_add(out, &r, angle, rgb);
    }
    struct axis *axes[] = {&l.rotation, &l.incidence, &l.azimuth, &l.radial};
    for (int i = 0; i < 4; i++)
        free(axes[i]->value);
    for (int c = 0; c < 3; c++)
        free(values[c]);
}
