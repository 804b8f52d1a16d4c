/* Readers of measurements: CSV, the measurement file, EPFL RGL .bsdf; and the grid a table needs. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "host_csv.h"
#include "host_measurement.h"
#include "host_rgl.h"
#include "host_source.h"
#include "importer_fixture.h"
#include "ref_rgl.h"

static void dies(void (*read)(const struct bytes *), const struct bytes *b, const char *message)
{
    int code = exit_code_of(read, b);
    if (code != EXIT_BAD_INPUT || !strstr(child_message, message))
        fail_msg("exit code %d, want %d and '%s'; said: %s", code, EXIT_BAD_INPUT, message, child_message);
}

/* A copy with exactly `count` bytes (and csv_parse's NUL), so that the sanitizer sees any access beyond. */
static void *copy_of(const struct bytes *b, bool with_nul)
{
    uint8_t *copy = xmalloc(b->count + with_nul);
    memcpy(copy, b->data, b->count);
    if (with_nul)
        copy[b->count] = 0;
    return copy;
}

/* --- CSV --- */

static void parse_text(struct measurement *m, const char *text)
{
    char *copy = xstrdup(text);
    csv_parse(m, "in.csv", copy, strlen(text), false);
    free(copy);
}

static void read_csv(const struct bytes *b)
{
    struct measurement m;
    csv_parse(&m, "in.csv", copy_of(b, true), b->count, false);
}

static void csv_dies(const char *text, const char *message)
{
    dies(read_csv, &(struct bytes){(uint8_t *)text, strlen(text)}, message);
}

static void csv_columns_come_in_any_order_with_comments_and_any_line_ends(void **state)
{
    (void)state;
    struct measurement m;
    parse_text(&m, "\xef\xbb\xbf# an instrument\r\n\r\n B , G,R,phi_out,theta_in,theta_out\r\n"
                   "3, 2.5 ,1e-3,359.5,20,75\n  # between\n\t\n6,5,4,0,0,0");
    assert_int_equal(m.count, 2);
    assert_string_equal(m.source, "in.csv");
    const struct measurement_point want[2] = {{20, 75, 359.5f, {1e-3f, 2.5f, 3}, MEASURED},
                                              {0, 0, 0, {4, 5, 6}, MEASURED}};
    assert_memory_equal(m.points, want, sizeof want);
    measurement_free(&m);
}

static void csv_brings_azimuths_into_one_turn(void **state)
{
    (void)state;
    struct measurement m;
    parse_text(&m,
               "theta_in,theta_out,phi_out,R,G,B\n0,0,-90,1,1,1\n0,0,360,2,2,2\n0,0,-360,1,1,1\n0,0,-1e-12,1,1,1\n");
    const double want[4] = {270, 0, 0, 0};
    for (int i = 0; i < 4; i++)
        assert_true((double)m.points[i].phi_out == want[i]);
    measurement_free(&m);
}

static void csv_counts_a_full_turn_once(void **state)
{
    (void)state;
    struct measurement m;
    parse_text(&m, "theta_in,theta_out,phi_out,R,G,B\n0,0,360,1,1,1\n0,5,360,2,2,2\n0,0,0,1,1,1\n0,5,0,2,2,3\n");
    assert_int_equal(m.count, 3); /* what differs stays, to be refused as two samples of one direction */
    assert_true((double)m.points[2].theta_out == 5 && (double)m.points[2].phi_out == 0);
    measurement_free(&m);
}

static void read_csv_counting(const struct bytes *b)
{
    struct measurement m;
    csv_parse(&m, "in.csv", copy_of(b, true), b->count, false);
    if (m.points[0].rgb[0] != 0 || m.points[1].rgb[2] != 0 || m.points[1].rgb[1] != 1)
        _exit(99);
}

static void csv_negative_values_become_zero_with_a_count(void **state)
{
    (void)state;
    const char *text = "theta_in,theta_out,phi_out,R,G,B\n0,0,0,-0.1,1,1\n0,1,0,1,1,-2\n";
    assert_int_equal(exit_code_of(read_csv_counting, &(struct bytes){(uint8_t *)text, strlen(text)}), 0);
    assert_non_null(strstr(child_message, "2 negative values set to 0, the first in line 2"));
}

static void csv_in_radians_is_said_to_be(void **state)
{
    (void)state;
    static const char head[] = "theta_in,theta_out,phi_out,R,G,B\n0,0,0,1,1,1\n";
    static const struct {
        const char *row;
        bool warns;
    } cases[] = {{"1,1.5,6.2,1,1,1\n", true}, {"1,1.6,6.2,1,1,1\n", false}, {"1,1.5,7,1,1,1\n", false}, {"", false}};
    for (int i = 0; i < 4; i++) {
        char *text = xasprintf("%s%s", head, cases[i].row);
        exit_code_of(read_csv_counting, &(struct bytes){(uint8_t *)text, strlen(text)});
        assert_int_equal(strstr(child_message, "look like radians") != NULL, cases[i].warns);
        free(text);
    }
}

static void csv_ignores_other_columns_and_says_so(void **state)
{
    (void)state;
    const char *text = "theta_in,theta_out,phi_out,note,R,G,B\n0,0,0,x,0,1,1\n0,1,0,,1,1,0\n";
    assert_int_equal(exit_code_of(read_csv_counting, &(struct bytes){(uint8_t *)text, strlen(text)}), 0);
    assert_non_null(strstr(child_message, "in.csv:1: column 'note'"));
}

#define HEADER "theta_in,theta_out,phi_out,R,G,B\n"

static void csv_names_the_line_of_what_is_wrong(void **state)
{
    (void)state;
    csv_dies("", "no samples");
    csv_dies("# only comments\n\n", "no samples");
    csv_dies(HEADER, "no samples");
    csv_dies("theta_in,theta_out,phi_out,R,G\n0,0,0,1,1\n", "in.csv:1: no column B");
    csv_dies("theta_in,theta_out,phi_out,R,G,B,R\n", "in.csv:1: column R appears twice");
    csv_dies(HEADER "0,0,0,1,1,1\n0,0,1,1,one,1\n", "in.csv:3: G is 'one', not a number");
    csv_dies(HEADER "0,0,0,1,,1\n", "in.csv:2: G is '', not a number");
    csv_dies(HEADER "0,0,0,1,1,\n5\n", "in.csv:2: B is ''");
    csv_dies(HEADER "0,0,0,1,1,1x\n", "in.csv:2: B is '1x'");
    csv_dies(HEADER "0,0,0,1,1,0x1p3\n", "in.csv:2: B is '0x1p3', not a number; write decimal");
    csv_dies("theta_in;theta_out;phi_out;R;G;B\n0;0;0;1;1;1\n", "separate columns by commas");
    csv_dies("theta_in\ttheta_out\tphi_out\tR\tG\tB\n", "separate columns by commas");
    csv_dies(HEADER "0,0,0,1,1\n", "in.csv:2: 5 columns where the header names 6");
    csv_dies(HEADER "0,0,0,1,1,1,1\n", "in.csv:2: 7 columns where the header names 6");
    csv_dies(HEADER "# c\n0,0,0,nan,1,1\n", "in.csv:3: R is nan");
    csv_dies(HEADER "0,0,0,1,inf,1\n", "in.csv:2: G is inf");
    csv_dies(HEADER "0,0,0,1,1,1e39\n", "in.csv:2: B is 1e+39, not a finite number");
    csv_dies(HEADER "90,0,0,1,1,1\n", "in.csv:2: theta_in is 90, outside 0..90 (exclusive)");
    csv_dies(HEADER "0,90.5,0,1,1,1\n", "in.csv:2: theta_out is 90.5, outside 0..90");
    csv_dies(HEADER "0,-1,0,1,1,1\n", "in.csv:2: theta_out is -1");
    csv_dies(HEADER "0,0,361,1,1,1\n", "in.csv:2: phi_out is 361, outside -360..360");
    csv_dies(HEADER "0,0,nan,1,1,1\n", "in.csv:2: phi_out is");
}

static void csv_refuses_binary_data(void **state)
{
    (void)state;
    uint8_t data[] = "theta_in\0theta_out";
    dies(read_csv, &(struct bytes){data, sizeof data}, "byte 8 is NUL");
}

/* --- the grid --- */

static void read_csv_grid(const struct bytes *b)
{
    struct measurement m;
    struct measurement_grid g;
    csv_parse(&m, "in.csv", copy_of(b, true), b->count, false);
    measurement_grid_make(&g, &m, "in.csv");
}

static void grid_dies(const char *rows, const char *message)
{
    char *text = xasprintf(HEADER "%s", rows);
    dies(read_csv_grid, &(struct bytes){(uint8_t *)text, strlen(text)}, message);
    free(text);
}

static void grid_says_which_direction_breaks_it(void **state)
{
    (void)state;
    grid_dies("0,0,0,1,1,1\n0,0,180,1,1,1\n0,5,0,1,1,1\n", "theta_out 5 has 1 azimuths where the first row has 2");
    grid_dies("0,0,0,1,1,1\n0,0,180,1,1,1\n0,5,180,1,1,1\n0,7,0,1,1,1\n0,7,180,1,1,1\n0,8,0,1,1,1\n", "theta_out 5");
    grid_dies("0,0,0,1,1,1\n0,0,90,1,1,1\n", "phi_out 90 stands where 2 equal steps of a full turn want 180");
    grid_dies("0,0,0,1,1,1\n0,0,360,1,1,2\n", "two samples at theta_in 0, theta_out 0, phi_out 0");
    grid_dies("0,0,0,1,1,1\n20,0,0,1,1,1\n30,0,0,1,1,1\n", "theta_in 20 stands where equal steps from 0 to 30 want 15");
    grid_dies("20,0,0,1,1,1\n", "theta_in 20 stands where");
    grid_dies("10,0,0,1,1,1\n20,0,0,1,1,1\n", "theta_in 10 stands where");
}

static void grid_interpolates_between_samples_and_around_the_turn(void **state)
{
    (void)state;
    struct measurement m;
    struct measurement_grid g;
    parse_text(&m, HEADER
               "0,10,350,1,0,0\n0,10,110,2,0,0\n0,10,230,4,0,0\n0,30,350,3,0,8\n0,30,110,3,0,8\n0,30,230,3,0,8\n");
    measurement_grid_make(&g, &m, "in.csv");
    assert_int_equal(g.count, 1);
    assert_int_equal(g.slices[0].theta_count, 2);
    assert_int_equal(g.slices[0].phi_count, 3);
    static const double cases[][4] = {
        /* theta_out, phi_out, red, blue */
        {10, 110, 2, 0},   {10, 170, 3, 0}, {10, 290, 2.5, 0}, {10, 350, 1, 0}, {10, 50, 1.5, 0}, {10, -10, 1, 0},
        {10, 410, 1.5, 0}, {0, 110, 2, 0},  {20, 110, 2.5, 4}, {30, 7, 3, 8},   {90, 7, 3, 8},    {15, 170, 3, 2},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double rgb[3];
        measurement_slice_value(rgb, &g.slices[0], cases[i][0], cases[i][1]);
        if (fabs(rgb[0] - cases[i][2]) > 1e-12 || rgb[1] != 0 || fabs(rgb[2] - cases[i][3]) > 1e-12)
            fail_msg("case %zu: %g %g", i, rgb[0], rgb[2]);
    }
    measurement_grid_free(&g);
    measurement_free(&m);
}

/* --- the measurement file --- */

static struct bytes make_gtm(struct measurement *m)
{
    char path[] = "/tmp/test_importers.XXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    close(fd);
    parse_text(m, HEADER "0,0,0,1e-30,2,65500\n0,0,180,1,3e38,1\n0,75,0,0,0,0\n0,75,180,1,2,3\n");
    m->points[2].mark = MEASUREMENT_FILLED;
    m->points[3].mark = MEASUREMENT_EXTRAPOLATED;
    measurement_write(m, path);
    struct bytes b;
    b.data = read_file(path, 1 << 20, &b.count);
    unlink(path);
    return b;
}

static void read_gtm(const struct bytes *b)
{
    struct measurement m;
    const uint8_t *data = copy_of(b, false);
    if (!measurement_recognise(data, b->count))
        die(EXIT_BAD_INPUT, "not recognised");
    measurement_parse(&m, "in.gtm", data, b->count);
}

static void measurement_file_keeps_every_value(void **state)
{
    (void)state;
    struct measurement m, back;
    struct bytes b = make_gtm(&m);
    measurement_parse(&back, "in.gtm", b.data, b.count);
    assert_int_equal(back.count, 4);
    assert_memory_equal(back.points, m.points, 4 * sizeof *m.points);
    assert_string_equal(back.source, "in.csv");
    measurement_free(&m);
    measurement_free(&back);
    free(b.data);
}

static uint32_t crc_of(const struct bytes *b)
{
    uint32_t crc = 0xffffffff; /* CRC-32, bit by bit */
    for (size_t i = 16; i < b->count; i++) {
        crc ^= b->data[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc & 1 ? crc >> 1 ^ 0xedb88320 : crc >> 1;
    }
    return ~crc;
}

static void measurement_file_is_what_the_specification_says(void **state)
{
    (void)state;
    struct measurement m;
    struct bytes b = make_gtm(&m);
    static const uint8_t head[] = {'G', 'T', 'M', 'E', 'A', 'S', '\r', '\n', 2, 0, 88, 0};
    static const uint8_t count_and_source[] = {4, 0, 0, 0, 0, 0, 0, 0, 'i', 'n', '.', 'c', 's', 'v', 0};
    static const uint8_t last[] = {0,    0,    0, 0, 0, 0,    0x96, 0x42, 0,    0,    0x34, 0x43, 0, 0,
                                   0x80, 0x3f, 0, 0, 0, 0x40, 0,    0,    0x40, 0x40, 1,    0,    0, 0};
    assert_int_equal(b.count, 88 + 4 * 28);
    assert_memory_equal(b.data, head, sizeof head);
    assert_memory_equal(b.data + 16, count_and_source, sizeof count_and_source);
    assert_memory_equal(b.data + 88 + 3 * 28, last, sizeof last);
    for (int i = 0; i < 4; i++)
        assert_int_equal(b.data[12 + i], crc_of(&b) >> 8 * i & 0xff);
    measurement_free(&m);
    free(b.data);
}

/* What version 1 wrote: samples without marks. */
static void measurement_file_of_version_1_is_read(void **state)
{
    (void)state;
    struct measurement m, back;
    struct bytes b = make_gtm(&m);
    for (size_t i = 1; i < 4; i++)
        memmove(b.data + 88 + 24 * i, b.data + 88 + 28 * i, 24);
    b.count = 88 + 4 * 24;
    b.data[8] = 1;
    uint32_t crc = crc_of(&b);
    for (int i = 0; i < 4; i++)
        b.data[12 + i] = (uint8_t)(crc >> 8 * i);
    measurement_parse(&back, "in.gtm", b.data, b.count);
    assert_int_equal(back.count, 4);
    m.points[2].mark = m.points[3].mark = MEASURED;
    assert_memory_equal(back.points, m.points, 4 * sizeof *m.points);
    measurement_free(&m);
    measurement_free(&back);
    free(b.data);
}

static void grid_keeps_what_was_measured(void **state)
{
    (void)state;
    struct measurement m;
    struct measurement_grid g;
    parse_text(&m, HEADER "0,0,0,1,1,1\n0,75,0,1,1,1\n0,80,0,1,1,1\n20,0,0,1,1,1\n20,10,0,1,1,1\n");
    m.points[1].mark = MEASUREMENT_FILLED;
    m.points[2].mark = m.points[3].mark = m.points[4].mark = MEASUREMENT_EXTRAPOLATED;
    measurement_grid_make(&g, &m, "in.csv");
    assert_true(g.slices[0].theta_measured == 75 && g.slices[1].theta_measured == -1);
    assert_int_equal(g.slices[0].mark[0], MEASURED);
    assert_int_equal(g.slices[0].mark[1], MEASUREMENT_FILLED);
    assert_int_equal(g.slices[0].mark[2], MEASUREMENT_EXTRAPOLATED);
    measurement_grid_free(&g);
    measurement_free(&m);
}

static void measurement_file_with_any_byte_changed_or_cut_is_refused(void **state)
{
    (void)state;
    struct measurement m;
    struct bytes b = make_gtm(&m);
    for (size_t i = 0; i < b.count; i++) {
        b.data[i] ^= 0x20;
        dies(read_gtm, &b, "");
        b.data[i] ^= 0x20;
        dies(read_gtm, &(struct bytes){b.data, i}, "");
    }
    b.data[8] = 3;
    dies(read_gtm, &b, "version 3");
    b.data[8] = 2;
    b.data[7] = '\r';
    dies(read_gtm, &b, "line ends");
    measurement_free(&m);
    free(b.data);
}

/* --- EPFL RGL --- */

static void put(struct bytes *b, uint64_t x, int bytes)
{
    b->data = xrealloc(b->data, b->count + (size_t)bytes);
    for (int i = 0; i < bytes; i++)
        b->data[b->count++] = (uint8_t)(x >> 8 * i);
}

struct field {
    const char *name;
    int type, dimensions, shape[5];
};

static double field_value(const struct field *f, size_t i, uint32_t *random)
{
    static const double theta_i[] = {0, 0.2, 0.55, 0.9, 1.4};
    *random = *random * 1664525 + 1013904223;
    double r = 0.05 + (*random >> 8) * 0x1p-24;
    if (!strcmp(f->name, "theta_i"))
        return theta_i[i];
    return !strcmp(f->name, "phi_i") ? 0 : !strcmp(f->name, "vndf") ? r * r * r * 8 : r;
}

static struct field rgl_fields[] = {
    {"description", 1, 1, {7}},
    {"phi_i", 10, 1, {1}},
    {"theta_i", 10, 1, {5}},
    {"ndf", 10, 2, {2, 16}},
    {"sigma", 10, 2, {2, 13}},
    {"vndf", 10, 4, {1, 5, 9, 11}},
    {"luminance", 10, 4, {1, 5, 6, 7}},
    {"rgb", 10, 5, {1, 5, 3, 6, 7}},
    {"jacobian", 1, 1, {1}},
};
enum { RGL_FIELDS = sizeof rgl_fields / sizeof *rgl_fields };

/* A small file with every extent different, so that mixed-up axes show. */
static struct bytes make_rgl(int jacobian)
{
    struct bytes b = {NULL, 0};
    uint32_t random = 7;
    size_t at[RGL_FIELDS];
    for (const char *c = "tensor_file"; c[0]; c++)
        put(&b, (uint8_t)*c, 1);
    put(&b, 0x0100 | 0, 2);
    put(&b, 0, 1);
    put(&b, RGL_FIELDS, 4);
    for (int i = 0; i < RGL_FIELDS; i++) {
        const struct field *f = &rgl_fields[i];
        put(&b, strlen(f->name), 2);
        for (const char *c = f->name; *c; c++)
            put(&b, (uint8_t)*c, 1);
        put(&b, (uint64_t)f->dimensions, 2);
        put(&b, (uint64_t)f->type, 1);
        at[i] = b.count;
        put(&b, 0, 8);
        for (int d = 0; d < f->dimensions; d++)
            put(&b, (uint64_t)f->shape[d], 8);
    }
    for (int i = 0; i < RGL_FIELDS; i++) {
        const struct field *f = &rgl_fields[i];
        size_t count = 1;
        for (int d = 0; d < f->dimensions; d++)
            count *= (size_t)f->shape[d];
        for (int k = 0; k < 8; k++)
            b.data[at[i] + k] = (uint8_t)(b.count >> 8 * k);
        for (size_t k = 0; k < count; k++) {
            float x = (float)field_value(f, k, &random);
            uint32_t u;
            memcpy(&u, &x, 4);
            if (f->type == 1)
                put(&b, (uint64_t)jacobian, 1);
            else
                put(&b, u, 4);
        }
    }
    return b;
}

static double random_unit(uint32_t *s)
{
    *s = *s * 1664525 + 1013904223;
    return (*s >> 8) * 0x1p-24;
}

/* Where the reference and the reader disagree by more than double rounding amplified through both warps. */
static void compare_rgl(const struct bytes *b, int directions)
{
    struct rgl *r = rgl_open("in.bsdf", b->data, b->count);
    struct ref_rgl *ref = ref_rgl_open(b->data, b->count);
    uint32_t s = 5;
    for (int i = 0; i < directions; i++) {
        double ti = 1.52 * random_unit(&s), to = 1.52 * random_unit(&s), phi = 6.2831853 * random_unit(&s), rgb[3],
               want[3];
        if (i % 16 == 0)
            ti = 0;
        if (i % 16 == 1)
            phi = 3.14159265358979;
        double wi[3] = {sin(ti), 0, cos(ti)}, wo[3] = {sin(to) * cos(phi), sin(to) * sin(phi), cos(to)};
        rgl_value(rgb, r, ti, to, phi);
        ref_rgl_value(want, ref, wi, wo);
        for (int c = 0; c < 3; c++)
            if (!(fabs(rgb[c] - want[c]) <= 1e-9 + 1e-7 * want[c]))
                fail_msg("theta_in %g theta_out %g phi %g channel %d: %.12g, want %.12g", ti, to, phi, c, rgb[c],
                         want[c]);
    }
    ref_rgl_close(ref);
    rgl_close(r);
}

static void rgl_value_equals_an_independent_evaluation(void **state)
{
    (void)state;
    for (int jacobian = 0; jacobian < 2; jacobian++) {
        struct bytes b = make_rgl(jacobian);
        compare_rgl(&b, 3000);
        free(b.data);
    }
}

static void rgl_value_equals_an_independent_evaluation_on_real_materials(void **state)
{
    (void)state;
    static const char *const names[] = {"paper_white", "cc_ibiza_sunset", "satin_rosaline", "colodur_napoli_4f"};
    const char *data = getenv("GONIOTILE_DATA");
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char *path = xasprintf("%s/brdf/%s_rgb.bsdf", data ? data : "../shared/data", names[i]);
        if (access(path, R_OK)) {
            free(path);
            skip();
        }
        struct bytes b;
        b.data = read_file(path, 1 << 24, &b.count);
        compare_rgl(&b, 150);
        free(b.data);
        free(path);
    }
}

static void rgl_under_light_along_the_normal_depends_on_the_azimuth(void **state)
{
    (void)state;
    struct bytes b = make_rgl(1);
    char *path = xasprintf("/tmp/goniotile_%d.bsdf", (int)getpid());
    struct rgl *r = rgl_open("in.bsdf", b.data, b.count);
    struct brdf_source source;
    write_file(path, b.data, b.count);
    source_open(&source, path);
    const double l[3] = {0, 0, 1};
    double first[3], got[3], want[3];
    for (int i = 0; i < 6; i++) {
        const double phi = 0.5 + i, v[3] = {0.6 * cos(phi), 0.6 * sin(phi), 0.8};
        source.value(got, source.ctx, l, v);
        rgl_value(want, r, 0, acos(0.8), phi);
        for (int c = 0; c < 3; c++)
            assert_true(fabs(got[c] - want[c]) < 1e-9);
        if (!i)
            memcpy(first, got, sizeof first);
    }
    assert_true(fabs(got[0] - first[0]) > 1e-3 * first[0]);
    source_close(&source);
    unlink(path);
    free(path);
    rgl_close(r);
    free(b.data);
}

static void rgl_sample_visits_the_geometry(void **state)
{
    (void)state;
    struct bytes b = make_rgl(1);
    struct rgl *r = rgl_open("in.bsdf", b.data, b.count);
    struct measurement m;
    struct measurement_grid g;
    rgl_sample(&m, r, "a/b.bsdf", measurement_geometry_find("minidiff"));
    assert_int_equal(m.count, 4 * 76 * 360);
    assert_string_equal(m.source, "b.bsdf");
    measurement_grid_make(&g, &m, "b.bsdf");
    assert_int_equal(g.count, 4);
    assert_true(g.slices[3].theta_in == 60 && g.slices[3].theta_out[75] == 75 && g.slices[3].phi_count == 360);
    double want[3], got[3];
    rgl_value(want, r, 1.0471975511965976, 0.5235987755982988, 3.4906585039886591); /* 60, 30, 200 degrees */
    measurement_slice_value(got, &g.slices[3], 30, 200);
    for (int c = 0; c < 3; c++)
        assert_true(fabs(got[c] - want[c]) <= 1e-6 * want[c]);
    measurement_grid_free(&g);
    measurement_free(&m);
    rgl_sample(&m, r, "b", measurement_geometry_find("dense"));
    assert_int_equal(m.count, 18 * 89 * 360);
    for (size_t i = 0; i < m.count; i += 997) /* the file ends at 1.4 rad, 80.2 degrees */
        assert_int_equal(m.points[i].mark, m.points[i].theta_in > 80.3f ? MEASUREMENT_EXTRAPOLATED : MEASURED);
    measurement_free(&m);
    rgl_close(r);
    free(b.data);
}

static void read_rgl(const struct bytes *b)
{
    const uint8_t *data = copy_of(b, false);
    if (!rgl_recognise(data, b->count))
        die(EXIT_BAD_INPUT, "not recognised");
    rgl_open("in.bsdf", data, b->count);
}

static void rgl_file_cut_anywhere_is_refused(void **state)
{
    (void)state;
    struct bytes b = make_rgl(1);
    assert_int_equal(exit_code_of(read_rgl, &b), 0);
    for (size_t n = 0; n < b.count; n += n < 460 ? 3 : 397)
        dies(read_rgl, &(struct bytes){b.data, n}, "");
    dies(read_rgl, &(struct bytes){b.data, b.count - 1}, "truncated");
    free(b.data);
}

/* Offsets, extents, counts and types of the field table: refused or read, never out of bounds. */
static void rgl_field_table_damage_never_reads_outside_the_file(void **state)
{
    (void)state;
    struct bytes b = make_rgl(1);
    for (size_t i = 12; i < 420; i++) {
        uint8_t was = b.data[i];
        b.data[i] = was ^ (i & 1 ? 0x80 : 0x03);
        int code = exit_code_of(read_rgl, &b);
        if (code != 0 && code != EXIT_BAD_INPUT)
            fail_msg("byte %zu: exit code %d, said: %s", i, code, child_message);
        b.data[i] = was;
    }
    free(b.data);
}

static void rgl_dies_with(int field, struct field changed, const char *message)
{
    struct field was = rgl_fields[field];
    rgl_fields[field] = changed;
    struct bytes b = make_rgl(1);
    rgl_fields[field] = was;
    dies(read_rgl, &b, message);
    free(b.data);
}

static void rgl_says_what_it_cannot_use(void **state)
{
    (void)state;
    rgl_dies_with(1, (struct field){"phi_i", 10, 1, {8}}, "anisotropic, 8 azimuths");
    rgl_dies_with(7, (struct field){"spectra", 10, 5, {1, 5, 3, 6, 7}}, "no field 'rgb'");
    rgl_dies_with(7, (struct field){"rgb", 10, 5, {1, 5, 2, 6, 7}}, "field 'rgb' has a shape");
    rgl_dies_with(7, (struct field){"rgb", 10, 4, {1, 5, 3, 6}}, "field 'rgb' has 4 dimensions");
    rgl_dies_with(5, (struct field){"vndf", 10, 4, {1, 4, 9, 11}}, "field 'vndf' has a shape");
    rgl_dies_with(3, (struct field){"ndf", 10, 2, {1, 16}}, "field 'ndf' has a shape");
    rgl_dies_with(5, (struct field){"vndf", 10, 4, {65536, 65536, 65536, 65536}}, "'vndf' has extent 65536");
    rgl_dies_with(8, (struct field){"jacobian", 1, 1, {0}}, "'jacobian' has extent 0");
    struct bytes b = make_rgl(1);
    b.data[b.count - 2] = 0x7f; /* the last rgb value becomes NaN */
    b.data[b.count - 3] = 0xff;
    dies(read_rgl, &b, "field 'rgb': value 629 is not finite");
    b.data[12] = 2;
    dies(read_rgl, &b, "version 2");
    free(b.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(csv_columns_come_in_any_order_with_comments_and_any_line_ends),
        cmocka_unit_test(csv_brings_azimuths_into_one_turn),
        cmocka_unit_test(csv_counts_a_full_turn_once),
        cmocka_unit_test(csv_in_radians_is_said_to_be),
        cmocka_unit_test(csv_negative_values_become_zero_with_a_count),
        cmocka_unit_test(csv_ignores_other_columns_and_says_so),
        cmocka_unit_test(csv_names_the_line_of_what_is_wrong),
        cmocka_unit_test(csv_refuses_binary_data),
        cmocka_unit_test(grid_says_which_direction_breaks_it),
        cmocka_unit_test(grid_interpolates_between_samples_and_around_the_turn),
        cmocka_unit_test(measurement_file_keeps_every_value),
        cmocka_unit_test(measurement_file_is_what_the_specification_says),
        cmocka_unit_test(measurement_file_of_version_1_is_read),
        cmocka_unit_test(grid_keeps_what_was_measured),
        cmocka_unit_test(measurement_file_with_any_byte_changed_or_cut_is_refused),
        cmocka_unit_test(rgl_value_equals_an_independent_evaluation),
        cmocka_unit_test(rgl_value_equals_an_independent_evaluation_on_real_materials),
        cmocka_unit_test(rgl_under_light_along_the_normal_depends_on_the_azimuth),
        cmocka_unit_test(rgl_sample_visits_the_geometry),
        cmocka_unit_test(rgl_file_cut_anywhere_is_refused),
        cmocka_unit_test(rgl_field_table_damage_never_reads_outside_the_file),
        cmocka_unit_test(rgl_says_what_it_cannot_use),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
