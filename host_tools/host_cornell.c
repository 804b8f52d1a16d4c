#include "host_cornell.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_text.h"

enum { MAX_WAVELENGTHS = 1024, ANGLES = 4 };

/* The first line that is no comment holds a whole number and nothing else. */
bool cornell_recognise(const uint8_t *data, size_t bytes)
{
    for (size_t at = 0; at < bytes;) {
        const uint8_t *newline = memchr(data + at, '\n', bytes - at);
        size_t end = newline ? (size_t)(newline - data) : bytes;
        while (at < end && isspace(data[at]))
            at++;
        if (at < end && data[at] != '#') {
            size_t digits = at;
            while (digits < end && isdigit(data[digits]))
                digits++;
            bool some = digits > at;
            while (digits < end && isspace(data[digits]))
                digits++;
            return some && digits == end;
        }
        at = end + 1;
    }
    return false;
}

struct row {
    size_t line;
    double angle[ANGLES], rgb[3];
};

void cornell_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
                  const struct import_options *options)
{
    struct text_reader r;
    struct spectral s;
    double cells[ANGLES + MAX_WAVELENGTHS], nm[MAX_WAVELENGTHS];
    text_open(&r, path, data, bytes);
    size_t wavelengths = text_count(&r, "wavelengths", MAX_WAVELENGTHS);
    for (size_t i = 0; i < wavelengths; i++) {
        nm[i] = text_number(&r, "a wavelength", text_token(&r), false);
        if (!(nm[i] > (i ? nm[i - 1] : 0)))
            die(EXIT_BAD_INPUT, "%s:%zu: wavelength %g; they must be above 0 and ascend", path, r.line, nm[i]);
    }
    if (r.token && *r.token)
        die(EXIT_BAD_INPUT, "%s:%zu: more than %zu wavelengths in this line", path, r.line, wavelengths);
    spectral_look_at(path, r.line, nm, wavelengths);
    spectral_make(&s, nm, wavelengths, options->illuminant);

    struct row *rows = NULL;
    size_t used = 0, room = 0;
    double theta_max = 0;
    for (char *line; (line = text_line(&r)); used++) {
        if (used == room)
            rows = xrealloc(rows, (room = room ? 2 * room : 1024) * sizeof *rows);
        struct row *row = &rows[used];
        text_numbers(cells, ANGLES + wavelengths, ANGLES, &r, line);
        row->line = r.line;
        memcpy(row->angle, cells, sizeof row->angle);
        spectral_rgb(row->rgb, &s, cells + ANGLES);
        theta_max = fmax(theta_max, fmax(fabs(cells[0]), fabs(cells[2])));
    }
    const double pi = 3.14159265358979323846;
    double unit = theta_max > pi / 2 + 1e-3 ? 1 : 180 / pi;
    measurement_init(out, path);
    for (size_t i = 0; i < used; i++) {
        for (int a = 0; a < ANGLES; a++)
            rows[i].angle[a] *= unit;
        r.line = rows[i].line;
        text_add(out, &r, rows[i].angle, rows[i].rgb);
    }
    free(rows);
    spectral_free(&s);
}
