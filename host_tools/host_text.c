#include "host_text.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

static const char separators[] = " \t,";

size_t text_mark(const uint8_t *data, size_t bytes)
{
    return bytes >= 3 && !memcmp(data, "\xef\xbb\xbf", 3) ? 3 : 0;
}

void text_check_line_ends(const char *path, const char *text)
{
    if (!strchr(text, '\n') && strchr(text, '\r'))
        die(EXIT_BAD_INPUT, "%s: its lines end in CR alone; save it with LF or CR LF", path);
}

void text_open(struct text_reader *out, const char *path, uint8_t *data, size_t bytes)
{
    const uint8_t *nul = memchr(data, 0, bytes);
    if (nul)
        die(EXIT_BAD_INPUT, "%s: byte %zu is NUL in a text format; the file is damaged", path, (size_t)(nul - data));
    text_check_line_ends(path, (char *)data);
    *out = (struct text_reader){.path = path, .rest = (char *)data + text_mark(data, bytes)};
}

char *text_line(struct text_reader *r)
{
    while (r->rest) {
        char *line = r->rest, *end = strchr(line, '\n');
        r->rest = end ? end + 1 : NULL;
        end = end ? end : line + strlen(line);
        r->line++;
        while (end > line && isspace((unsigned char)end[-1]))
            end--;
        *end = 0;
        line += strspn(line, " \t");
        if (*line && *line != '#')
            return line;
    }
    return NULL;
}

char *text_token(struct text_reader *r)
{
    for (;;) {
        if (!r->token && !(r->token = text_line(r)))
            return NULL;
        char *token = r->token + strspn(r->token, separators), *end = token + strcspn(token, separators);
        r->token = *end ? end + 1 : NULL;
        *end = 0;
        if (*token)
            return token;
    }
}

double text_number(const struct text_reader *r, const char *what, const char *token, bool any)
{
    if (!token)
        die(EXIT_BAD_INPUT, "%s:%zu: the file ends where %s is wanted; it is truncated", r->path, r->line, what);
    double x;
    if (!decimal(token, &x))
        die(EXIT_BAD_INPUT, "%s:%zu: '%.40s' where %s is wanted; write a decimal number", r->path, r->line, token,
            what);
    if (!any && !isfinite(x))
        die(EXIT_BAD_INPUT, "%s:%zu: %s is %g, not finite; repeat or remove that line", r->path, r->line, what, x);
    return x;
}

size_t text_count(struct text_reader *r, const char *what, size_t max)
{
    double count = text_number(r, what, text_token(r), false);
    if (!(count >= 1 && count <= (double)max) || count != floor(count))
        die(EXIT_BAD_INPUT, "%s:%zu: %g %s, want a whole number from 1 to %zu", r->path, r->line, count, what, max);
    return (size_t)count;
}

void text_want(const struct text_reader *r, const char *token, const char *word)
{
    if (!token || strcmp(token, word))
        die(EXIT_BAD_INPUT, "%s:%zu: '%.40s' where %s is wanted; the file is truncated or damaged", r->path, r->line,
            token ? token : "", word);
}

void text_numbers(double *out, size_t count, size_t any_from, const struct text_reader *r, char *line)
{
    size_t n = 0;
    for (char *token = line + strspn(line, separators); *token;) {
        char *end = token + strcspn(token, separators), *next = end + strspn(end, separators);
        *end = 0;
        if (n < count)
            out[n] = text_number(r, "a number", token, n >= any_from);
        n++;
        token = next;
    }
    if (n != count)
        die(EXIT_BAD_INPUT, "%s:%zu: %zu numbers where %zu are wanted; complete the line", r->path, r->line, n, count);
}

bool text_begins(const uint8_t *data, size_t bytes, const char *word)
{
    size_t length = strlen(word), at = 0;
    for (int lines = 0; lines < 256 && at < bytes;) {
        while (at < bytes && (data[at] == ' ' || data[at] == '\t'))
            at++;
        const uint8_t *end = memchr(data + at, '\n', bytes - at);
        size_t n = end ? (size_t)(end - data) - at : bytes - at;
        if (n >= length && !memcmp(data + at, word, length) && (n == length || !isalnum(data[at + length])))
            return true;
        lines += n && data[at] != '#';
        at += n + 1;
    }
    return false;
}

void text_add(struct measurement *m, const struct text_reader *r, const double angle[4], const double rgb[3])
{
    double theta_in = angle[0], phi_in = angle[1], theta_out = angle[2], phi_out = angle[3];
    double unit = r->radians ? 3.14159265358979323846 / 180 : 1;
    phi_in += theta_in < 0 ? 180 : 0;
    phi_out += theta_out < 0 ? 180 : 0;
    theta_in = fabs(theta_in);
    theta_out = fabs(theta_out);
    if (!((float)theta_in < 90) || !(theta_out < 90 + 1e-4) || !(fabs(phi_in) <= 1e4) || !(fabs(phi_out) <= 1e4))
        die(EXIT_BAD_INPUT,
            "%s:%zu: theta %g in and %g out, phi %g in and %g out, in %s; theta must be below %s (reflection only)",
            r->path, r->line, theta_in * unit, theta_out * unit, phi_in * unit, phi_out * unit,
            r->radians ? "radians" : "degrees", r->radians ? "pi/2" : "90");
    if (m->count == MEASUREMENT_MAX_POINTS)
        die(EXIT_BAD_INPUT, "%s:%zu: more than %u samples; thin them out", r->path, r->line, MEASUREMENT_MAX_POINTS);
    double phi = fmod(phi_out - phi_in, 360);
    phi += phi < 0 ? 360 : 0;
    if (phi >= 360 - 5e-4)
        phi = 0;
    measurement_add(m, &(struct measurement_point){(float)theta_in,
                                                   (float)fmin(theta_out, 90),
                                                   (float)phi,
                                                   {(float)rgb[0], (float)rgb[1], (float)rgb[2]},
                                                   MEASURED});
}
