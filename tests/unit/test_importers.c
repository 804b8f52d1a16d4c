/* Readers of measurements: CSV, the measurement file; and the grid a table needs. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "host_csv.h"
#include "host_measurement.h"
#include "importer_fixture.h"

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
    dies_reading(read_csv, &(struct bytes){(uint8_t *)text, strlen(text)}, message);
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

static void csv_counts_a_full_turn_about_the_mirror_side_once(void **state)
{
    (void)state;
    struct measurement m;
    parse_text(
        &m,
        "theta_in,theta_out,phi_out,R,G,B\n0,0,-180,1,1,1\n0,0,-90,1,1,1\n0,0,0,1,1,1\n0,0,90,1,1,1\n0,0,180,1,1,1\n");
    assert_int_equal(m.count, 4);
    assert_null(measurement_grid_problem(&m));
    measurement_free(&m);
    parse_text(
        &m,
        "theta_in,theta_out,phi_out,R,G,B\n0,0,-180,1,1,2\n0,0,-90,1,1,1\n0,0,0,1,1,1\n0,0,90,1,1,1\n0,0,180,1,1,1\n");
    char *problem = measurement_grid_problem(&m); /* not that steps are uneven */
    assert_string_equal(problem, "two samples at theta_in 0, theta_out 0, phi_out 180; keep one");
    free(problem);
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
    csv_dies("theta_in,theta_out,phi_out,R,G,B\n89.9999999,0,0,1,1,1\n", "theta_in is 90, outside 0..90 (exclusive)");
    csv_dies("theta_in theta_out phi_out R G B\n0 0 0 1 1 1\n", "separate columns by commas");
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
    dies_reading(read_csv, &(struct bytes){data, sizeof data}, "byte 8 is NUL");
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
    dies_reading(read_csv_grid, &(struct bytes){(uint8_t *)text, strlen(text)}, message);
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
        dies_reading(read_gtm, &b, "");
        b.data[i] ^= 0x20;
        dies_reading(read_gtm, &(struct bytes){b.data, i}, "");
    }
    b.data[8] = 3;
    dies_reading(read_gtm, &b, "version 3");
    b.data[8] = 2;
    b.data[7] = '\r';
    dies_reading(read_gtm, &b, "line ends");
    measurement_free(&m);
    free(b.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(csv_columns_come_in_any_order_with_comments_and_any_line_ends),
        cmocka_unit_test(csv_brings_azimuths_into_one_turn),
        cmocka_unit_test(csv_counts_a_full_turn_once),
        cmocka_unit_test(csv_counts_a_full_turn_about_the_mirror_side_once),
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
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
