/*
 * Blinn-Phong by runs of a row against the double-precision model, at random and at the model's extremes.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "internal.h"
#include "ref_render.h"

enum { WIDTH = 320, HEIGHT = 240, ROUNDS = 20000 };

static uint32_t random_state = 1;

static double random_signed(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state / 2147483648.0 - 1;
}

static void random_unit(double v[3])
{
    double square;
    do {
        for (int k = 0; k < 3; k++)
            v[k] = random_signed();
        square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    } while (square > 1 || square < 0.01);
    for (int k = 0; k < 3; k++)
        v[k] /= sqrt(square);
}

static struct vec3 to_q15(const double v[3])
{
    return (struct vec3){(int32_t)lrint(v[0] * 32768), (int32_t)lrint(v[1] * 32768), (int32_t)lrint(v[2] * 32768)};
}

static struct scene_material material(double kd, double ks, double exponent)
{
    uint32_t d = (uint32_t)lrint(kd * 65536), s = (uint32_t)lrint(ks * 65536);
    return (struct scene_material){.kind = SCENE_MATERIAL_BLINN_PHONG,
                                   .kd = {d, d / 2, 0},
                                   .ks = {s, 0, s / 2},
                                   .exponent = (uint32_t)lrint(exponent * 65536)};
}

static struct ref_material reference_of(const struct scene_material *m)
{
    struct ref_material r = {.exponent = m->exponent / 65536.0};
    for (int k = 0; k < 3; k++) {
        r.kd[k] = m->kd[k] / 65536.0;
        r.ks[k] = m->ks[k] / 65536.0;
    }
    return r;
}

static void assert_close(const double got[3], const double want[3], double tolerance)
{
    for (int k = 0; k < 3; k++)
        if (fabs(got[k] - want[k]) > tolerance)
            fail_msg("channel %d: %.6f instead of %.6f", k, got[k], want[k]);
}

static struct {
    struct raster r;
    struct raster_batch batch;
    struct raster_slot slot;
    struct raster_surface surface[RASTER_BATCH];
    struct raster_light lights[RASTER_RUN_LIGHTS];
    struct scene_material material;
    struct scene_output output;
    struct scene_camera camera;
} run;

static void run_setup(double kd, double ks, double exponent, unsigned lights)
{
    memset(&run, 0, sizeof run);
    run.material = material(kd, ks, exponent);
    run.output.exposure = 1 << 16;
    run.camera.focal = 158217; /* 45 degrees */
    run.r.frame = (struct raster_frame){.parts = &raster_all_parts,
                                        .output = &run.output,
                                        .camera = &run.camera,
                                        .materials = &run.material,
                                        .width = WIDTH,
                                        .height = HEIGHT,
                                        .light_count = (uint8_t)lights};
    run.r.lights = run.lights;
    run.slot.frame[0] = run.slot.frame[4] = run.slot.frame[8] = 1 << 14;
    raster_view_setup(&run.r.view, &run.camera, WIDTH, HEIGHT);
}

/* A normal as homogeneous coordinates U, V, D of a surface in slot 1. */
static struct raster_surface make_surface(int u, int v, int d)
{
    return (struct raster_surface){((uint32_t)d + DEPTH_BIAS) << 8 | 1, (uint32_t)(u & 0xffff) | (uint32_t)v << 16};
}

static void decode(double n[3], int u, int v, int d)
{
    double square = (double)d * d + (double)u * u + (double)v * v;
    n[0] = 2.0 * u * d / square;
    n[1] = 2.0 * v * d / square;
    n[2] = 2.0 * d * d / square - 1;
}

static void view_of(double v[3], unsigned x, unsigned y)
{
    double scale = HEIGHT * run.camera.focal / 65536.0;
    double px = (2.0 * x + 1 - WIDTH) / scale, py = (2.0 * y + 1 - HEIGHT) / scale,
           length = sqrt(px * px + py * py + 1);
    v[0] = -px / length;
    v[1] = py / length;
    v[2] = 1 / length;
}

static void run_kernel_equals_the_model(void **state)
{
    (void)state;
    double worst = 0;
    for (int i = 0; i < ROUNDS / 10; i++) {
        enum { COUNT = 7, LIGHTS = 3 };
        int coordinates[COUNT][3];
        double l[LIGHTS][3], e[LIGHTS][3];
        unsigned x = (unsigned)((random_signed() + 1) * (WIDTH - COUNT) / 2),
                 y = (unsigned)((random_signed() + 1) * HEIGHT / 2);
        run_setup(0.25, 0.25, 2 << i % 6, LIGHTS);
        double towards[3];
        view_of(towards, x, y);
        for (int j = 0; j < LIGHTS; j++) {
            do /* h loses its bits where l is opposite to v */
                random_unit(l[j]);
            while (l[j][0] * towards[0] + l[j][1] * towards[1] + l[j][2] * towards[2] < -0.97);
            run.r.lights[j].v = to_q15(l[j]);
            for (int k = 0; k < 3; k++) {
                run.r.lights[j].irradiance[k] = 100000u + (i % 2 ? (uint32_t)(k * 10000) : 0);
                e[j][k] = run.r.lights[j].irradiance[k] / 65536.0 / M_PI;
            }
        }
        for (int p = 0; p < COUNT; p++) {
            int d = coordinates[p][2] = 10000 + (int)(6000 * random_signed());
            coordinates[p][0] = (int)(d * 0.7 * random_signed());
            coordinates[p][1] = (int)(d * 0.7 * random_signed());
            run.surface[p] = make_surface(coordinates[p][0], coordinates[p][1], d);
        }
        assert_true(raster_blinn_phong_rows.takes(&run.r, &run.material));
        raster_blinn_phong_rows.shade(&run.batch, &run.r, &run.slot, run.surface, x, y, COUNT);
        struct ref_material reference = reference_of(&run.material);
        for (int p = 0; p < COUNT; p++) {
            double n[3], v[3], want[3], got[3];
            decode(n, coordinates[p][0], coordinates[p][1], coordinates[p][2]);
            view_of(v, x + (unsigned)p, y);
            for (int k = 0; k < 3; k++)
                want[k] = 0.02 * reference.kd[k];
            for (int j = 0; j < LIGHTS; j++) {
                double c[3];
                ref_blinn_phong(c, &reference, n, l[j], v);
                for (int k = 0; k < 3; k++)
                    want[k] += c[k] * e[j][k];
            }
            for (int k = 0; k < 3; k++) {
                want[k] = fmin(want[k], 1);
                got[k] = run.batch.radiance[p][k] / 1048576.0;
                worst = fmax(worst, fabs(got[k] - want[k]));
            }
            assert_close(got, want, 1.0 / 512);
        }
    }
    print_message("# largest error %.6f\n", worst);
}

static void run_kernel_keeps_the_extremes(void **state)
{
    (void)state;
    for (int exponent = 2; exponent <= 64; exponent *= 2) {
        double v[3];
        run_setup(0.5, 0.25, exponent, 1);
        view_of(v, 300, 20);
        run.r.lights[0] = (struct raster_light){to_q15(v), {205887, 205887, 205887}, 0};
        /* n = l = v: stereographic coordinates v.x / (1 + v.z) */
        int u = (int)lrint(16384 * v[0] / (1 + v[2])), w = (int)lrint(16384 * v[1] / (1 + v[2]));
        run.surface[0] = make_surface(u, w, 16384);
        raster_blinn_phong_rows.shade(&run.batch, &run.r, &run.slot, run.surface, 300, 20, 1);
        assert_true(abs((int)run.batch.radiance[0][0] - (int)(0.76 * 1048576)) < 1024);
        assert_true(abs((int)run.batch.radiance[0][2] - (int)(0.125 * 1048576)) < 512);
        /* l = -v: neither term, whatever the normal */
        struct vec3 l = to_q15(v);
        run.r.lights[0].v = (struct vec3){-l.x, -l.y, -l.z};
        for (int i = 0; i < RASTER_BATCH; i++)
            run.surface[i] = make_surface(u, w, 16384);
        raster_blinn_phong_rows.shade(&run.batch, &run.r, &run.slot, run.surface, 300, 20, 1);
        assert_true(abs((int)run.batch.radiance[0][0] - (int)(0.01 * 1048576)) < 64);
        assert_true(run.batch.radiance[0][2] < 64);
    }
    /* every light as bright as a scene can say */
    run_setup(1, 1, 32, RASTER_RUN_LIGHTS);
    run.output.exposure = 1 << 24;
    for (unsigned i = 0; i < RASTER_RUN_LIGHTS; i++)
        run.r.lights[i] = (struct raster_light){{0, 0, 32768}, {UINT32_MAX, UINT32_MAX, UINT32_MAX}, 0};
    run.surface[0] = make_surface(0, 0, 16384);
    raster_blinn_phong_rows.shade(&run.batch, &run.r, &run.slot, run.surface, WIDTH / 2, HEIGHT / 2, 1);
    assert_int_equal(run.batch.radiance[0][0], 1 << 20);
    assert_int_equal(run.batch.radiance[0][1], 1 << 20);
    assert_int_equal(run.batch.radiance[0][2], 1 << 20);
}

static void run_kernel_declines_what_it_cannot_do(void **state)
{
    (void)state;
    static const double no[] = {0, 0.5, 1, 3, 31, 48, 128, 4096};
    for (size_t i = 0; i < sizeof no / sizeof *no; i++) {
        run_setup(0.5, 0.5, no[i], 1);
        assert_false(raster_blinn_phong_rows.takes(&run.r, &run.material));
    }
    run_setup(0.5, 0.5, 32, 1);
    assert_true(raster_blinn_phong_rows.takes(&run.r, &run.material));
    run.camera.focal = 1 << 14; /* 152 degrees */
    raster_view_setup(&run.r.view, &run.camera, WIDTH, HEIGHT);
    assert_false(raster_blinn_phong_rows.takes(&run.r, &run.material));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(run_kernel_equals_the_model),
        cmocka_unit_test(run_kernel_keeps_the_extremes),
        cmocka_unit_test(run_kernel_declines_what_it_cannot_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
