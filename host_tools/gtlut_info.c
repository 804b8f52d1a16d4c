/* gtlut info: what a measurement or a table holds. */
#include "gtlut.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "gtlut_table.h"
#include "host_measurement.h"
#include "host_specular_frame.h"

static const char help[] =
    "usage: gtlut info FILE\n"
    "\n"
    "Describes a measurement (measurement file or CSV) or a table (KTX 2.0): size, axes, metadata, range of\n"
    "the values and, for a table, the albedo per slice. One `name: value` per line on stdout.\n";

#define MAX_FILE_BYTES ((size_t)1 << 30)

struct range {
    double lo, hi;
};

static void range_add(struct range *r, double x)
{
    r->lo = fmin(r->lo, x);
    r->hi = fmax(r->hi, x);
}

static void print_printable(const uint8_t *text, size_t bytes)
{
    for (size_t i = 0; i < bytes && text[i]; i++)
        putchar(text[i] >= ' ' && text[i] < 0x7f ? text[i] : '?');
}

/* Key/value data as ktx2_open has checked it: records of a length, a key, a NUL, a value and padding to 4 bytes. */
static void print_metadata(const struct ktx2_view *v)
{
    for (uint32_t at = 0; at + 4 <= v->kvd_bytes;) {
        const uint8_t *p = v->kvd + at;
        uint32_t n = p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
        const uint8_t *key = p + 4, *nul = memchr(key, 0, n);
        if (nul) {
            print_printable(key, n);
            fputs(": ", stdout);
            print_printable(nul + 1, (size_t)(key + n - nul - 1));
            putchar('\n');
        }
        at += (4 + n + 3) & ~3u;
    }
}

static void print_table(const struct table_file *t)
{
    const struct lut_table *table = &t->table;
    uint32_t w = table->width, h = table->height;
    printf("kind: table, specular frame\n");
    printf("bytes: %zu\n", t->bytes);
    printf("texels: %u x %u x %u (phi_d, theta_d, theta_in)\n", w, h, table->depth);
    printf("phi_d: 0..360 step %g\ntheta_d: 0..180 step %g\n", 360.0 / (w - 1), 180.0 / (h - 1));
    printf("theta_in:");
    for (uint32_t z = 0; z < table->depth; z++)
        printf(" %g", table_theta_in(t, z));
    putchar('\n');
    print_metadata(&t->view);
    struct range r = {INFINITY, 0};
    for (size_t i = 0; i < (size_t)w * h * table->depth; i++) {
        struct lut_rgb x = lut_rgb9e5_decode(table->texels[i]);
        for (int c = 0; c < 3; c++)
            range_add(&r, ldexp(x.c[c], x.e));
    }
    printf("values: %.5g..%.5g 1/sr\n", r.lo, r.hi);
    for (uint32_t z = 0; z < table->depth; z++) {
        double albedo[3];
        specular_frame_albedo(albedo, table->texels + (size_t)z * w * h, w, h, table_theta_in(t, z));
        printf("albedo at theta_in %g: %.4f %.4f %.4f\n", table_theta_in(t, z), albedo[0], albedo[1], albedo[2]);
    }
}

static void print_measurement(const struct measurement *m, size_t bytes, const char *path)
{
    struct measurement_grid g;
    measurement_grid_make(&g, m, path);
    printf("kind: measurement\n");
    printf("bytes: %zu\n", bytes);
    printf("source: %s\n", m->source);
    printf("points: %zu\n", m->count);
    for (size_t i = 0; i < g.count; i++) {
        const struct measurement_slice *s = &g.slices[i];
        printf("theta_in %g: theta_out %g..%g (%zu), phi_out %g..%g (%zu)\n", s->theta_in, s->theta_out[0],
               s->theta_out[s->theta_count - 1], s->theta_count, s->phi_first,
               s->phi_first + 360 - 360 / (double)s->phi_count, s->phi_count);
    }
    struct range r = {INFINITY, 0};
    for (size_t i = 0; i < m->count; i++)
        for (int c = 0; c < 3; c++)
            range_add(&r, (double)m->points[i].rgb[c]);
    printf("values: %.5g..%.5g 1/sr\n", r.lo, r.hi);
    measurement_grid_free(&g);
}

int gtlut_info(int argc, char **argv)
{
    static const struct option options[] = {{"help", no_argument, 0, 'h'}, {0}};
    if (gtlut_option(argc, argv, options, help) != -1)
        die(EXIT_USAGE, "-o: info prints to stdout; leave it out");
    const char *path = gtlut_argument(argc, argv, "file");
    size_t bytes;
    void *data = read_file(path, MAX_FILE_BYTES, &bytes);
    if (table_recognise(data, bytes)) {
        struct table_file t;
        table_open(&t, path, data, bytes);
        print_table(&t);
        table_close(&t);
        return EXIT_OK;
    }
    struct measurement m;
    measurement_load(&m, path, data, bytes);
    print_measurement(&m, bytes, path);
    measurement_free(&m);
    free(data);
    return EXIT_OK;
}
