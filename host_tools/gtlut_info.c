/* gtlut info: what a measurement or a table holds. */
#include "gtlut.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "gtlut_json.h"
#include "gtlut_table.h"
#include "host_atlas.h"
#include "host_import.h"
#include "host_measurement.h"
#include "host_metrics.h"

static const char help[] =
    "Usage: gtlut info FILE [--json]\n"
    "\n"
    "Describes a measurement (measurement file or CSV) or a table (KTX 2.0): size, axes, metadata, range of\n"
    "the values and, for a table, the albedo; or lists the tables of an atlas. One `name: value` per line on stdout.\n"
    "\n"
    "  --json  one JSON object instead\n"
    "\n"
    "Examples:\n"
    "  $ gtlut info gold.ktx2\n"
    "  $ gtlut info gold.ktx2 --json\n";

#define MAX_FILE_BYTES ((size_t)1 << 30)

struct range {
    double lo, hi;
};

static void range_add(struct range *r, double x)
{
    r->lo = fmin(r->lo, x);
    r->hi = fmax(r->hi, x);
}

/* --- tables --- */

enum { MAX_ANGLES = KTX2_MAX_EXTENT };

/* What both forms of output are made from. */
struct table_facts {
    const struct table_file *file;
    struct range values;          /* of the texels, scaled */
    double angles[2][MAX_ANGLES]; /* theta_in of the slices; or theta_h of the rows, theta_d of the planes */
    size_t albedo_count;
    double albedo_at[MAX_ANGLES], albedo[MAX_ANGLES][3];
};

static void table_facts_gather(struct table_facts *f, const struct table_file *file)
{
    const struct lut_table *t = &file->table;
    bool half = t->kind == LUT_HALF_VECTOR;
    *f = (struct table_facts){.file = file, .values = {INFINITY, 0}};
    for (size_t i = 0; i < (size_t)t->width * t->height * t->depth; i++) {
        struct lut_rgb x = lut_rgb9e5_decode(t->texels[i]);
        for (int c = 0; c < 3; c++)
            range_add(&f->values, ldexp(x.c[c], x.e + (half ? t->scale : 0)));
    }
    for (uint32_t i = 0; half && i < t->height; i++)
        f->angles[0][i] = table_theta_h(&file->half_vector, i);
    for (uint32_t i = 0; half && i < t->depth; i++)
        f->angles[1][i] = table_theta_d(&file->half_vector, i);
    for (uint32_t i = 0; !half && i < t->depth; i++)
        f->angles[0][i] = table_theta_in(&file->specular_frame, i);

    struct brdf_source source;
    table_source(&source, file);
    f->albedo_count = half ? TABLE_ALBEDO_ANGLES : t->depth;
    for (size_t i = 0; i < f->albedo_count; i++) {
        f->albedo_at[i] = half ? table_albedo_angles[i] : f->angles[0][i];
        metrics_albedo(f->albedo[i], &source, fmin(f->albedo_at[i], 89));
    }
}

/* Calls `add` for every entry of the key/value data, as ktx2_open has checked it: records of a length, a key, a NUL, a value
 * and padding to 4 bytes. */
static void metadata_visit(const struct ktx2_view *v,
                           void (*add)(const char *key, size_t key_bytes, const uint8_t *value, size_t bytes))
{
    for (uint32_t at = 0; at + 4 <= v->kvd_bytes;) {
        const uint8_t *p = v->kvd + at;
        uint32_t n = p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
        const uint8_t *key = p + 4, *nul = memchr(key, 0, n);
        if (nul)
            add((const char *)key, (size_t)(nul - key), nul + 1, (size_t)(key + n - nul - 1));
        at += (4 + n + 3) & ~3u;
    }
}

/* Printable, with at most a NUL at its end. */
static bool is_text(const uint8_t *value, size_t bytes)
{
    if (bytes && !value[bytes - 1])
        bytes--;
    for (size_t i = 0; i < bytes; i++)
        if (value[i] < ' ')
            return false;
    return true;
}

static void print_printable(const char *text, size_t bytes)
{
    for (size_t i = 0; i < bytes && text[i]; i++)
        putchar(text[i] >= ' ' && text[i] < 0x7f ? text[i] : '?');
}

static void print_entry(const char *key, size_t key_bytes, const uint8_t *value, size_t bytes)
{
    print_printable(key, key_bytes);
    fputs(": ", stdout);
    if (is_text(value, bytes))
        print_printable((const char *)value, bytes);
    else
        printf("(%zu bytes)", bytes);
    putchar('\n');
}

static void json_entry(const char *key, size_t key_bytes, const uint8_t *value, size_t bytes)
{
    json_open(NULL, '{');
    json_string("key", key, key_bytes);
    if (is_text(value, bytes))
        json_string("value", (const char *)value, bytes);
    else
        json_integer("bytes", bytes);
    json_close('}');
}

static void print_angles(const char *name, const double *angles, size_t count)
{
    printf("%s:", name);
    for (size_t i = 0; i < count; i++)
        printf(" %.4g", angles[i]);
    putchar('\n');
}

static void print_table(const struct table_facts *f)
{
    const struct lut_table *t = &f->file->table;
    bool half = t->kind == LUT_HALF_VECTOR;
    printf("kind: table, %s\n", half ? "half vector" : "specular frame");
    printf("bytes: %zu\n", f->file->bytes);
    printf("texels: %u x %u x %u (%s)\n", t->width, t->height, t->depth, half ? "t, h, d" : "phi_d, theta_d, theta_in");
    if (half) {
        print_angles("theta_h", f->angles[0], t->height);
        print_angles("theta_d", f->angles[1], t->depth);
        printf("t: 0..1 step %g\n", 1.0 / (t->width - 1));
        printf("scale: %d\n", t->scale);
        printf("re-packed copy: %u bytes\n", table_packed_bytes(f->file));
    } else {
        printf("phi_d: 0..360 step %g\ntheta_d: 0..180 step %g\n", 360.0 / (t->width - 1), 180.0 / (t->height - 1));
        print_angles("theta_in", f->angles[0], t->depth);
        printf("swap: %s\n", t->swap ? "yes" : "no");
    }
    metadata_visit(&f->file->view, print_entry);
    printf("values: %.5g..%.5g 1/sr%s\n", f->values.lo, f->values.hi, half ? ", of f (n.l + n.v)" : "");
    for (size_t i = 0; i < f->albedo_count; i++) {
        const double *a = f->albedo[i];
        printf("albedo at theta_in %g: %.4f %.4f %.4f\n", f->albedo_at[i], a[0], a[1], a[2]);
    }
}

static void json_table(const struct table_facts *f)
{
    const struct lut_table *t = &f->file->table;
    bool half = t->kind == LUT_HALF_VECTOR;
    double texels[3] = {t->width, t->height, t->depth}, values[2] = {f->values.lo, f->values.hi};
    json_open(NULL, '{');
    json_string("kind", half ? "half_vector" : "specular_frame", 64);
    json_integer("bytes", f->file->bytes);
    json_numbers("texels", texels, 3);
    if (half) {
        json_numbers("theta_h", f->angles[0], t->height);
        json_numbers("theta_d", f->angles[1], t->depth);
        json_number("scale", t->scale);
        json_integer("packed_bytes", table_packed_bytes(f->file));
    } else {
        json_numbers("theta_in", f->angles[0], t->depth);
        json_number("swap", t->swap);
    }
    json_open("metadata", '[');
    metadata_visit(&f->file->view, json_entry);
    json_close(']');
    json_numbers("values", values, 2);
    json_open("albedo", '[');
    for (size_t i = 0; i < f->albedo_count; i++) {
        json_open(NULL, '{');
        json_number("theta_in", f->albedo_at[i]);
        json_numbers("rgb", f->albedo[i], 3);
        json_close('}');
    }
    json_close(']');
    json_close('}');
}

/* --- measurements --- */

static struct range measurement_range(const struct measurement *m)
{
    struct range r = {INFINITY, 0};
    for (size_t i = 0; i < m->count; i++)
        for (int c = 0; c < 3; c++)
            range_add(&r, (double)m->points[i].rgb[c]);
    return r;
}

static size_t count_marked(const struct measurement *m, enum measurement_mark mark)
{
    size_t count = 0;
    for (size_t i = 0; i < m->count; i++)
        count += m->points[i].mark == (uint32_t)mark;
    return count;
}

static void print_measurement(const struct measurement *m, const struct measurement_grid *g, size_t bytes)
{
    struct range r = measurement_range(m);
    printf("kind: measurement\n");
    printf("bytes: %zu\n", bytes);
    printf("source: %s\n", m->source);
    printf("points: %zu\n", m->count);
    printf("extrapolated: %zu\n", count_marked(m, MEASUREMENT_EXTRAPOLATED));
    printf("filled in: %zu\n", count_marked(m, MEASUREMENT_FILLED));
    for (size_t i = 0; i < g->count; i++) {
        const struct measurement_slice *s = &g->slices[i];
        printf("theta_in %g: theta_out %g..%g (%zu), phi_out %g..%g (%zu)\n", s->theta_in, s->theta_out[0],
               s->theta_out[s->theta_count - 1], s->theta_count, s->phi_first,
               s->phi_first + 360 - 360 / (double)s->phi_count, s->phi_count);
    }
    printf("values: %.5g..%.5g 1/sr\n", r.lo, r.hi);
}

static void json_measurement(const struct measurement *m, const struct measurement_grid *g, size_t bytes)
{
    struct range r = measurement_range(m);
    double values[2] = {r.lo, r.hi};
    json_open(NULL, '{');
    json_string("kind", "measurement", 64);
    json_integer("bytes", bytes);
    json_string("source", m->source, sizeof m->source);
    json_integer("points", m->count);
    json_integer("extrapolated", count_marked(m, MEASUREMENT_EXTRAPOLATED));
    json_integer("filled_in", count_marked(m, MEASUREMENT_FILLED));
    json_open("slices", '[');
    for (size_t i = 0; i < g->count; i++) {
        const struct measurement_slice *s = &g->slices[i];
        double theta_out[2] = {s->theta_out[0], s->theta_out[s->theta_count - 1]};
        json_open(NULL, '{');
        json_number("theta_in", s->theta_in);
        json_numbers("theta_out", theta_out, 2);
        json_integer("theta_out_count", s->theta_count);
        json_number("phi_out_first", s->phi_first);
        json_integer("phi_out_count", s->phi_count);
        json_close('}');
    }
    json_close(']');
    json_numbers("values", values, 2);
    json_close('}');
}

/* Takes `data` over. */
static void describe_table(const char *path, void *data, size_t bytes, bool json)
{
    struct table_file t;
    table_open(&t, path, data, bytes);
    struct table_facts *facts = xmalloc(sizeof *facts);
    table_facts_gather(facts, &t);
    (json ? json_table : print_table)(facts);
    free(facts);
    table_close(&t);
}

static void describe_measurement(const char *path, void *data, size_t bytes, bool json)
{
    struct measurement m;
    struct measurement_grid g;
    const char *format = import_format_of(data, bytes)->name;
    if (strcmp(format, "gtm") && strcmp(format, "csv") && strcmp(format, "rgl"))
        die(EXIT_BAD_INPUT, "%s: is %s; gtlut import it first", path, format);
    measurement_load(&m, path, data, bytes);
    measurement_grid_make(&g, &m, path);
    (json ? json_measurement : print_measurement)(&m, &g, bytes);
    measurement_grid_free(&g);
    measurement_free(&m);
    free(data);
}

int gtlut_info(int argc, char **argv)
{
    static const struct option options[] = {{"json", no_argument, 0, 'j'}, {"help", no_argument, 0, 'h'}, {0}};
    bool json = false;
    for (int c; (c = gtlut_option(argc, argv, options, help)) != -1;) {
        if (c == 'o')
            die(EXIT_USAGE, "-o: info prints to stdout; leave it out");
        json = true;
    }
    const char *path = gtlut_argument(argc, argv, "file");
    size_t bytes;
    void *data = read_file(path, MAX_FILE_BYTES, &bytes);
    (atlas_recognise(data, bytes)   ? gtlut_atlas_describe
     : table_recognise(data, bytes) ? describe_table
                                    : describe_measurement)(path, data, bytes, json);
    return EXIT_OK;
}
