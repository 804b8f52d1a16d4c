#include "host_astm.h"

#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_text.h"

enum { MAX_COLUMNS = 1024, ANGLES = 4, IGNORED = -1 };

struct layout {
    size_t columns, values;
    int place[MAX_COLUMNS]; /* of a column: angle 0..3, value 4.. or IGNORED */
    double nm[MAX_COLUMNS]; /* of a value, when they are wavelengths */
    enum { SPECTRAL, RGB, XYZ } kind;
    unsigned seen;   /* bits: angles, then the three of RGB or XYZ */
    bool is_muddled; /* a name twice, or values of several kinds */
};

bool astm_recognise(const uint8_t *data, size_t bytes)
{
    return text_begins(data, bytes, "VARS") || text_begins(data, bytes, "NUM_POINTS");
}

static int index_of(const char *name, const char *const *names, int count)
{
    for (int i = 0; i < count; i++)
        if (!strcmp(name, names[i]))
            return i;
    return -1;
}

/* Of an angle or one of three values. */
static void take_place(struct layout *l, int place)
{
    l->is_muddled |= l->seen >> place & 1;
    l->seen |= 1u << place;
    l->place[l->columns] = place;
}

static void value_column(struct layout *l, const struct text_reader *r, const char *name)
{
    static const char *const tristimulus[] = {"R", "G", "B", "X", "Y", "Z"};
    int t = index_of(name, tristimulus, 6);
    if (t >= 0) {
        l->is_muddled |= l->values && l->kind != (t < 3 ? RGB : XYZ);
        l->kind = t < 3 ? RGB : XYZ;
        take_place(l, ANGLES + t % 3);
        l->values++;
        return;
    }
    char *end;
    double nm = strtod(name, &end);
    if (end == name || (*end && strcmp(end, "nm")) || !(nm > 0 && nm < 1e5)) {
        warn("%s:%zu: variable '%.40s' is neither an angle, a wavelength (450nm) nor one of R,G,B,X,Y,Z: ignored",
             r->path, r->line, name);
        l->place[l->columns] = IGNORED;
        return;
    }
    l->is_muddled |= l->kind != SPECTRAL;
    if (l->values && nm <= l->nm[l->values - 1])
        die(EXIT_BAD_INPUT, "%s:%zu: wavelength %g after %g; they must ascend", r->path, r->line, nm,
            l->nm[l->values - 1]);
    l->nm[l->values] = nm;
    l->place[l->columns] = ANGLES + (int)l->values++;
}

static void parse_vars(struct layout *l, const struct text_reader *r, char *names)
{
    static const char *const angles[ANGLES] = {"theta_i", "phi_i", "theta_s", "phi_s"};
    for (char *name = strtok(names, " \t,"); name; name = strtok(NULL, " \t,"), l->columns++) {
        if (l->columns == MAX_COLUMNS)
            die(EXIT_BAD_INPUT, "%s:%zu: more than %d variables", r->path, r->line, MAX_COLUMNS);
        int angle = index_of(name, angles, ANGLES);
        if (angle >= 0)
            take_place(l, angle);
        else
            value_column(l, r, name);
    }
    if ((l->seen & 15) != 15 || !l->values || (l->kind != SPECTRAL && l->values != 3) || l->is_muddled)
        die(EXIT_BAD_INPUT,
            "%s:%zu: VARS must name theta_i,phi_i,theta_s,phi_s and R,G,B or X,Y,Z or wavelengths (450nm), each once",
            r->path, r->line);
    if (l->kind == SPECTRAL)
        spectral_look_at(r->path, r->line, l->nm, l->values);
}

static void add_row(struct measurement *out, const struct text_reader *r, const struct layout *l,
                    const struct spectral *s, char *line)
{
    const double degree = 3.14159265358979323846 / 180;
    double cells[MAX_COLUMNS], angle[ANGLES] = {0}, value[MAX_COLUMNS] = {0}, rgb[3];
    text_numbers(cells, l->columns, 0, r, line);
    for (size_t i = 0; i < l->columns; i++) {
        if (l->place[i] >= ANGLES)
            value[l->place[i] - ANGLES] = cells[i];
        else if (l->place[i] != IGNORED)
            angle[l->place[i]] = cells[i] / degree;
    }
    if (l->kind == SPECTRAL)
        spectral_rgb(rgb, s, value);
    else if (l->kind == XYZ)
        spectral_xyz_to_rgb(rgb, value);
    else
        memcpy(rgb, value, sizeof rgb);
    text_add(out, r, angle, rgb);
}

void astm_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes,
               const struct import_options *options)
{
    struct text_reader r;
    struct layout l = {0};
    struct spectral s = {0};
    double want = -1;
    text_open(&r, path, data, bytes);
    r.radians = true;
    measurement_init(out, path);
    for (char *line; (line = text_line(&r));) {
        if (!strncmp(line, "NUM_POINTS", 10)) {
            want = text_number(&r, "a number of points", line + 10 + strspn(line + 10, " \t"), false);
        } else if (!strncmp(line, "VARS", 4) && !l.columns) {
            parse_vars(&l, &r, line + 4);
            spectral_make(&s, l.nm, l.kind == SPECTRAL ? l.values : 1, options->illuminant);
        } else if (l.columns) {
            add_row(out, &r, &l, &s, line);
        } /* else another key of the header */
    }
    if (!l.columns)
        die(EXIT_BAD_INPUT, "%s: no VARS line; the file is truncated or of another kind", path);
    if (want >= 0 && want != (double)out->count)
        die(EXIT_BAD_INPUT, "%s: %zu samples where NUM_POINTS says %g; the file is truncated", path, out->count, want);
    spectral_free(&s);
}
