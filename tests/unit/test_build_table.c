/* The table builder against the double-precision reference, up to the rounding of RGB9_E5. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common.h"
#include "host_measurement.h"
#include "host_rgb9e5.h"
#include "host_rgl.h"
#include "host_specular_frame.h"
#include "lut.h"
#include "ref_build.h"

/* A measurement both as the product's point cloud and as the reference's grid. */
struct subject {
    struct measurement cloud;
    struct ref_measurement grid;
    double *theta_in, *theta_out, *rgb;
};

static void subject_fill_grid(struct subject *s, int slices, int rows, int columns)
{
    size_t count = (size_t)slices * rows * columns;
    assert_int_equal(s->cloud.count, count);
    s->theta_in = xmalloc(slices * sizeof(double));
    s->theta_out = xmalloc(rows * sizeof(double));
    s->rgb = xmalloc(3 * count * sizeof(double));
    for (size_t i = 0; i < count; i++) {
        const struct measurement_point *p = &s->cloud.points[i];
        s->theta_in[i / columns / rows] = (double)p->theta_in;
        s->theta_out[i / columns % rows] = (double)p->theta_out;
        for (int c = 0; c < 3; c++)
            s->rgb[3 * i + c] = (double)p->rgb[c];
    }
    s->grid = (struct ref_measurement){slices, rows, columns, s->theta_in, s->theta_out, s->rgb};
}

static void subject_free(struct subject *s)
{
    measurement_free(&s->cloud);
    free(s->theta_in);
    free(s->theta_out);
    free(s->rgb);
}

/* Rough in every direction, without symmetry in phi, so that a mirrored or rotated frame shows; spans 1e-3 to 1e4. */
static void make_synthetic(struct subject *s, int slices, double step, int rows, int columns)
{
    memset(s, 0, sizeof *s);
    measurement_init(&s->cloud, "folder/synthetic \xc3\xa9.csv");
    for (int i = 0; i < slices; i++)
        for (int j = 0; j < rows; j++)
            for (int k = 0; k < columns; k++) {
                float a = (float)(i * step), b = (float)(75.0 * j / (rows - 1)), phi = (float)(360.0 * k / columns);
                double r = 1 + sin(0.11 * (double)b + 0.05 * (double)phi + i),
                       g = 1 + cos(0.031 * (double)phi - (double)b);
                struct measurement_point p = {
                    a, b, phi, {(float)r, (float)(1e-3 + 1e3 * g * g * r), (float)exp(5 * r - 1)}, MEASURED};
                measurement_add(&s->cloud, &p);
            }
    subject_fill_grid(s, slices, rows, columns);
}

/* Every channel within half a step of its texel's exponent from the reference, and the exponent as small as it can be. */
static void compare(const uint32_t *texels, const struct subject *s, int width, int height, double p, double l)
{
    for (int z = 0; z < s->grid.slices; z++)
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++) {
                uint32_t w = *texels++;
                double want[3], step = ldexp(1, (int)(w >> 27) - 24), got[3] = {0}, max = 0;
                ref_build_node(want, &s->grid, z, x, y, width, height, p, l);
                for (int c = 0; c < 3; c++) {
                    got[c] = (w >> 9 * c & 511) * step;
                    max = fmax(max, got[c]);
                    if (!(fabs(got[c] - want[c]) <= step * (0.5 + 1e-6)))
                        fail_msg("slice %d, node %d %d, channel %d: %g, want %g", z, x, y, c, got[c], want[c]);
                }
                if (max < 256 * step && w >> 27)
                    fail_msg("slice %d, node %d %d: mantissa %g below 256", z, x, y, max / step);
            }
}

static uint32_t *build(const struct subject *s, const struct specular_frame_options *o)
{
    struct measurement_grid grid;
    struct specular_frame t;
    measurement_grid_make(&grid, &s->cloud, "test");
    specular_frame_build(&t, &grid, o, "test");
    assert_int_equal(t.depth, s->grid.slices);
    uint32_t *texels = xmalloc((size_t)t.width * t.height * t.depth * sizeof *texels);
    for (size_t i = 0; i < (size_t)t.width * t.height * t.depth; i++)
        texels[i] = rgb9e5_encode(t.rgb + 3 * i);
    specular_frame_free(&t);
    measurement_grid_free(&grid);
    return texels;
}

static void build_and_compare(const struct subject *s, uint32_t width, uint32_t height, double p, double l)
{
    struct specular_frame_options o = {width, height, p, l};
    uint32_t *texels = build(s, &o);
    compare(texels, s, (int)width, (int)height, p, l);
    free(texels);
}

static void table_equals_reference_when_clamped_and_when_faded(void **state)
{
    (void)state;
    struct subject s;
    make_synthetic(&s, 4, 20, 76, 360);
    build_and_compare(&s, 361, 181, 1, 0.3);
    build_and_compare(&s, 361, 181, 0.2, 0.3);
    subject_free(&s);
}

static void table_equals_reference_at_other_sizes_grids_and_fades(void **state)
{
    (void)state;
    struct subject s;
    make_synthetic(&s, 5, 21.25, 26, 40);
    build_and_compare(&s, 91, 46, 0.2, 0.5);
    build_and_compare(&s, 2, 2, 0, 0);
    build_and_compare(&s, 37, 200, 0.7, 1);
    subject_free(&s);
    make_synthetic(&s, 1, 0, 76, 1);
    build_and_compare(&s, 91, 46, 0.2, 0.3);
    subject_free(&s);
}

static void order_of_points_does_not_matter(void **state)
{
    (void)state;
    struct subject s;
    make_synthetic(&s, 3, 30, 16, 24);
    struct specular_frame_options o = {61, 31, 0.2, 0.3};
    uint32_t *sorted = build(&s, &o);
    uint32_t r = 1;
    for (size_t i = s.cloud.count - 1; i > 0; i--) {
        r = r * 1664525 + 1013904223;
        size_t j = (r >> 8) % (i + 1);
        struct measurement_point t = s.cloud.points[i];
        s.cloud.points[i] = s.cloud.points[j];
        s.cloud.points[j] = t;
    }
    uint32_t *shuffled = build(&s, &o);
    assert_memory_equal(sorted, shuffled, 61 * 31 * 3 * sizeof *sorted);
    free(sorted);
    free(shuffled);
    subject_free(&s);
}

static void last_column_repeats_the_first_and_first_slice_has_no_azimuth(void **state)
{
    (void)state;
    struct subject s;
    make_synthetic(&s, 4, 20, 76, 360);
    struct specular_frame_options o = {361, 181, 1, 0.3};
    uint32_t *t = build(&s, &o);
    for (int y = 0; y < 181 * 4; y++)
        assert_int_equal(t[361 * y], t[361 * y + 360]);
    for (int y = 0; y < 181; y++)
        for (int x = 1; x < 361; x++)
            assert_int_equal(t[361 * y + x], t[361 * y]);
    free(t);
    subject_free(&s);
}

/* The program itself: measurement file in, KTX 2.0 out, read back through the device's own reader. */
static void program_writes_the_table_the_reference_describes(void **state)
{
    (void)state;
    const char *b = getenv("B");
    char folder[] = "/tmp/test_build_table.XXXXXX";
    assert_non_null(mkdtemp(folder));
    char *in = xasprintf("%s/in.gtm", folder), *out = xasprintf("%s/out.ktx2", folder);
    char *command =
        xasprintf("%s/gtlut build %s -o %s --size 181x91 --p 0.2 --l 0.4 2>%s/err", b ? b : "build", in, out, folder);
    struct subject s;
    make_synthetic(&s, 4, 20, 76, 360);
    measurement_write(&s.cloud, in);
    assert_int_equal(system(command), 0);
    size_t bytes;
    void *file = read_file(out, 1 << 24, &bytes);
    struct lut_table t;
    struct ktx2_view v;
    assert_int_equal(lut_open(&t, file, bytes), LUT_OK);
    assert_int_equal(ktx2_open(&v, file, bytes), LUT_OK);
    assert_int_equal(t.width, 181);
    assert_int_equal(t.height, 91);
    assert_int_equal(t.depth, 4);
    compare(t.texels, &s, 181, 91, 0.2, 0.4);

    static const char *const pairs[][2] = {
        {"KTXwriter", "Goniotile gtlut 0.1.0"}, {"goniotile.extrapolation", "p=0.2,l=0.4,theta_b=75"},
        {"goniotile.kind", "specular_frame"},   {"goniotile.source", "synthetic___.csv"},
        {"goniotile.theta_max", "60000"},       {"goniotile.version", "1"}};
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        uint32_t n;
        const uint8_t *value = ktx2_find(&v, pairs[i][0], &n);
        assert_non_null(value);
        assert_string_equal((const char *)value, pairs[i][1]);
    }
    free(file);
    subject_free(&s);
    char *clean = xasprintf("rm -r %s", folder);
    assert_int_equal(system(clean), 0);
    free(clean);
    free(command);
    free(in);
    free(out);
}

static void table_of_a_real_material_equals_reference(void **state)
{
    (void)state;
    const char *data = getenv("GONIOTILE_DATA");
    char *path = xasprintf("%s/brdf/paper_white_rgb.bsdf", data ? data : "../shared/data");
    if (access(path, R_OK)) {
        free(path);
        skip();
    }
    size_t bytes;
    uint8_t *file = read_file(path, 1 << 24, &bytes);
    struct rgl *r = rgl_open(path, file, bytes);
    struct subject s = {0};
    rgl_sample(&s.cloud, r, path, measurement_geometry_find("minidiff"));
    rgl_close(r);
    subject_fill_grid(&s, 4, 76, 360);
    build_and_compare(&s, 361, 181, 1, 0.3);
    build_and_compare(&s, 91, 46, 0.2, 0.3);
    subject_free(&s);
    free(file);
    free(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(table_equals_reference_when_clamped_and_when_faded),
        cmocka_unit_test(table_equals_reference_at_other_sizes_grids_and_fades),
        cmocka_unit_test(order_of_points_does_not_matter),
        cmocka_unit_test(last_column_repeats_the_first_and_first_slice_has_no_azimuth),
        cmocka_unit_test(program_writes_the_table_the_reference_describes),
        cmocka_unit_test(table_of_a_real_material_equals_reference),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
