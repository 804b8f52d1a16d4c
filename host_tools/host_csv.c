#include "host_csv.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_text.h"

enum { THETA_IN, THETA_OUT, PHI_OUT, RED, GREEN, BLUE, FIELDS, IGNORED = FIELDS, MAX_COLUMNS = 64 };

static const char *const field_names[FIELDS] = {"theta_in", "theta_out", "phi_out", "R", "G", "B"};

struct csv {
    const char *path;
    size_t line;
    int columns;
    int field[MAX_COLUMNS]; /* of a column, or IGNORED */
    size_t negative, first_negative_line;
    float largest_theta, largest_phi;
    struct measurement turned; /* samples at phi_out 360 and -180, which may repeat those at 0 and 180 */
    bool raw;
};

/* Cuts the next cell off *rest at a comma and trims it; *rest becomes NULL after the last one. */
static char *next_cell(char **rest)
{
    char *cell = *rest, *comma = strchr(cell, ',');
    *rest = comma ? comma + 1 : NULL;
    char *end = comma ? comma : cell + strlen(cell);
    cell += strspn(cell, " \t");
    while (end > cell && (end[-1] == ' ' || end[-1] == '\t'))
        end--;
    *end = 0;
    return cell;
}

static void parse_header(struct csv *c, char *line)
{
    unsigned seen = 0;
    if (!strncmp(line, "material,rhoD_r,", 16))
        die(EXIT_BAD_INPUT, "%s: a table of shifted-gamma fits; name one of its materials: FILE.csv:NAME", c->path);
    bool is_foreign = !strchr(line, ',') && strpbrk(line, "; \t");
    for (char *rest = line; rest; c->columns++) {
        char *name = next_cell(&rest);
        if (c->columns == MAX_COLUMNS)
            die(EXIT_BAD_INPUT, "%s:%zu: more than %d columns; keep theta_in,theta_out,phi_out,R,G,B", c->path, c->line,
                MAX_COLUMNS);
        int f = 0;
        while (f < FIELDS && strcmp(name, field_names[f]))
            f++;
        c->field[c->columns] = f;
        if (f == IGNORED && is_foreign)
            continue; /* dies below */
        if (f == IGNORED) {
            warn("%s:%zu: column '%.40s' is not one of theta_in,theta_out,phi_out,R,G,B: ignored", c->path, c->line,
                 name);
            continue;
        }
        if (seen >> f & 1)
            die(EXIT_BAD_INPUT, "%s:%zu: column %s appears twice; name each once", c->path, c->line, field_names[f]);
        seen |= 1u << f;
    }
    for (int f = 0; f < FIELDS; f++)
        if (!(seen >> f & 1))
            die(EXIT_BAD_INPUT,
                "%s:%zu: no column %s; the first line must name theta_in,theta_out,phi_out,R,G,B (degrees, "
                "1/sr)%s",
                c->path, c->line, field_names[f],
                is_foreign ? "; separate columns by commas, with decimal points" : "");
}

static void check_angle(const struct csv *c, int f, double x)
{
    double lo = f == PHI_OUT ? -360 : 0, hi = f == PHI_OUT ? 360 : 90;
    if (!(x >= lo && x <= hi) || (f == THETA_IN && (float)x >= 90)) /* as it is kept */
        die(EXIT_BAD_INPUT, "%s:%zu: %s is %g, outside %g..%g%s; angles are in degrees", c->path, c->line,
            field_names[f], x, lo, hi, f == THETA_IN ? " (exclusive)" : "");
}

static double check_value(struct csv *c, int f, double x)
{
    if (c->raw)
        return x;
    if (!(fabs(x) <= FLT_MAX))
        die(EXIT_BAD_INPUT, "%s:%zu: %s is %g, not a finite number; repeat or remove that measurement", c->path,
            c->line, field_names[f], x);
    if (x >= 0)
        return x;
    if (!c->negative++)
        c->first_negative_line = c->line;
    return 0;
}

static void parse_row(struct measurement *out, struct csv *c, char *line)
{
    double x[FIELDS + 1];
    int column = 0;
    for (char *rest = line; rest; column++) {
        char *cell = next_cell(&rest);
        int f = column < c->columns ? c->field[column] : IGNORED;
        if (f == IGNORED)
            continue;
        if (!decimal(cell, &x[f]))
            die(EXIT_BAD_INPUT, "%s:%zu: %s is '%.40s', not a number; write decimal numbers between commas", c->path,
                c->line, field_names[f], cell);
        if (f <= PHI_OUT)
            check_angle(c, f, x[f]);
        else
            x[f] = check_value(c, f, x[f]);
    }
    if (column != c->columns)
        die(EXIT_BAD_INPUT, "%s:%zu: %d columns where the header names %d; complete the line", c->path, c->line, column,
            c->columns);
    double phi = x[PHI_OUT] < 0 ? x[PHI_OUT] + 360 : x[PHI_OUT];
    struct measurement_point point = {(float)x[THETA_IN],
                                      (float)x[THETA_OUT],
                                      (float)phi < 360 ? (float)phi : 0,
                                      {(float)x[RED], (float)x[GREEN], (float)x[BLUE]},
                                      MEASURED};
    if (out->count + c->turned.count == MEASUREMENT_MAX_POINTS)
        die(EXIT_BAD_INPUT, "%s:%zu: more than %u samples; thin them out", c->path, c->line, MEASUREMENT_MAX_POINTS);
    c->largest_theta = fmaxf(c->largest_theta, fmaxf(point.theta_in, point.theta_out));
    c->largest_phi = fmaxf(c->largest_phi, point.phi_out);
    measurement_add(x[PHI_OUT] == 360 || x[PHI_OUT] == -180 ? &c->turned : out, &point);
}

static int compare_directions(const void *a, const void *b)
{
    const struct measurement_point *p = a, *q = b;
    int by_in = (p->theta_in > q->theta_in) - (p->theta_in < q->theta_in);
    int by_out = (p->theta_out > q->theta_out) - (p->theta_out < q->theta_out);
    return by_in ? by_in : by_out ? by_out : (p->phi_out > q->phi_out) - (p->phi_out < q->phi_out);
}

/* A full turn measured from 0 to 360, or from -180 to 180, has its first azimuth twice: what is the same there counts once. */
static void merge_turned(struct measurement *out, const struct measurement *turned)
{
    struct measurement first;
    if (!turned->count)
        return;
    measurement_init(&first, "");
    for (size_t i = 0; i < out->count; i++)
        if (out->points[i].phi_out == 0 || out->points[i].phi_out == 180)
            measurement_add(&first, &out->points[i]);
    qsort(first.points, first.count, sizeof *first.points, compare_directions);
    for (size_t i = 0; i < turned->count; i++) {
        const struct measurement_point *p = &turned->points[i], *same = NULL;
        if (first.count)
            same = bsearch(p, first.points, first.count, sizeof *p, compare_directions);
        if (!same || memcmp(same->rgb, p->rgb, sizeof p->rgb))
            measurement_add(out, p);
    }
    measurement_free(&first);
}

void csv_parse(struct measurement *out, const char *path, char *text, size_t bytes, bool raw)
{
    struct csv c = {.path = path, .raw = raw};
    const char *nul = memchr(text, 0, bytes);
    if (nul)
        die(EXIT_BAD_INPUT,
            "%s: byte %zu is NUL; neither CSV text nor of a format that gtlut formats lists; give another file", path,
            (size_t)(nul - text));
    text_check_line_ends(path, text);
    measurement_init(out, path);
    measurement_init(&c.turned, path);
    text += text_mark((const uint8_t *)text, bytes);
    for (char *line = text, *next; line; line = next) {
        next = strchr(line, '\n');
        char *end = next ? next++ : line + strlen(line);
        if (end > line && end[-1] == '\r')
            end--;
        *end = 0;
        c.line++;
        line += strspn(line, " \t");
        if (!*line || *line == '#')
            continue;
        if (c.columns)
            parse_row(out, &c, line);
        else
            parse_header(&c, line);
    }
    merge_turned(out, &c.turned);
    measurement_free(&c.turned);
    if (!out->count)
        die(EXIT_BAD_INPUT, "%s: no samples in %zu lines; give a header line and one line per direction", path, c.line);
    if (c.negative)
        warn("%s: %zu negative values set to 0, the first in line %zu", path, c.negative, c.first_negative_line);
    if (c.largest_theta > 0 && c.largest_theta <= 1.571f && c.largest_phi <= 6.2832f)
        warn("%s: no theta above 1.571, no phi_out above 6.283: the angles look like radians, they are read as degrees",
             path);
}
