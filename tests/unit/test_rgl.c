/* The reader of EPFL RGL .bsdf files, and the BRDF they hold. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "host_measurement.h"
#include "host_rgl.h"
#include "host_source.h"
#include "importer_fixture.h"
#include "ref_rgl.h"

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
        dies_reading(read_rgl, &(struct bytes){b.data, n}, "");
    dies_reading(read_rgl, &(struct bytes){b.data, b.count - 1}, "truncated");
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
    dies_reading(read_rgl, &b, message);
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
    dies_reading(read_rgl, &b, "field 'rgb': value 629 is not finite");
    b.data[12] = 2;
    dies_reading(read_rgl, &b, "version 2");
    free(b.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
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
