/*
 * Where vertices land on the screen, against double precision: raster_object_setup, raster_transform and raster_project of random objects
 * of sizes from a thousandth to a thousand, at all distances, in pictures up to 4096 x 4096.
 *
 * An object's transform holds X, Y and W in 31 bits and its matrix in as many: with all their roundings, X, Y and W err by less than 8 of
 * their units, 2^-26 of the larger of the object's extent and its distance. On the screen that is, with s pixels per unit of X and half a
 * sub-pixel of snapping,
 *   |error| <= 1/512 px + (8 s + |pixels from the centre| 8) / W.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>

#include "internal.h"

static uint64_t random_state = 1;

static double random_unit(void)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (double)(random_state >> 40) * 0x1p-24;
}

static double random_between(double lo, double hi)
{
    return lo + (hi - lo) * random_unit();
}

static void random_rotation(int32_t out[9])
{
    double q[4], length = 0;
    for (int i = 0; i < 4; i++) {
        q[i] = random_between(-1, 1);
        length += q[i] * q[i];
    }
    for (int i = 0; i < 4; i++)
        q[i] /= sqrt(length);
    double w = q[0], x = q[1], y = q[2], z = q[3];
    const double m[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                         2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                         2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
    for (int i = 0; i < 9; i++)
        out[i] = (int32_t)floor(ldexp(m[i], 30) + 0.5);
}

/* Pixels from the picture's centre, and w in world units. */
static void project_double(double xy[2], double *w, const struct scene_camera *c, const struct scene_object *o,
                           uint16_t height, const struct scene_vertex *v)
{
    double p[3] = {v->x, v->y, v->z}, world[3], eye[3];
    double scale = ldexp(o->scale_mantissa, -30 - o->scale_shift);
    for (int i = 0; i < 3; i++) {
        world[i] = (o->position[i] - (double)c->eye[i]) / 65536;
        for (int j = 0; j < 3; j++)
            world[i] += ldexp(o->rotation[3 * i + j], -30) * p[j] * scale;
    }
    for (int i = 0; i < 3; i++) {
        eye[i] = 0;
        for (int j = 0; j < 3; j++)
            eye[i] += ldexp(c->rotation[3 * i + j], -30) * world[j];
    }
    *w = -eye[2];
    double k = c->focal / 65536.0 * height / 2 / *w;
    xy[0] = eye[0] * k;
    xy[1] = -eye[1] * k;
}

static const uint16_t sizes[][2] = {{320, 240}, {4096, 4096}, {1280, 720}, {64, 64}, {4096, 16}};

static long count;
static double worst[2], worst_share, worst_depth_share; /* pixels at 320 x 240 and 4096 x 4096; of the bound */

/* An object of half extent `extent` somewhere in the view, `distance` away. */
static void random_object(struct scene_object *o, struct scene_camera *c, const uint16_t size[2], double extent,
                          double distance)
{
    int exponent;
    double mantissa = frexp(extent / 32768, &exponent), focal = exp2(random_between(-1, 4)), aspect = size[0] / size[1];
    const double eye[3] = {random_between(-1, 1) * distance * aspect / focal, random_between(-1, 1) * distance / focal,
                           -distance};
    *c = (struct scene_camera){.focal = (uint32_t)(65536 * focal), .near = (uint32_t)(1 + 65536 * extent / 100)};
    *o = (struct scene_object){.scale_mantissa = (uint32_t)ldexp(mantissa, 31), .scale_shift = 1 - exponent};
    random_rotation(c->rotation);
    random_rotation(o->rotation);
    for (int i = 0; i < 3; i++) {
        double p = 0;
        for (int j = 0; j < 3; j++)
            p += ldexp(c->rotation[3 * j + i], -30) * eye[j];
        c->eye[i] = (int32_t)random_between(-1000 * 65536, 1000 * 65536);
        o->position[i] = c->eye[i] + (int32_t)(fmax(-30000, fmin(30000, p)) * 65536);
    }
}

static void check_vertex(const struct raster_object *o, const struct scene_camera *c, const struct scene_object *so,
                         unsigned size, bool apart)
{
    struct scene_vertex v = {(int16_t)random_between(-32767, 32767), (int16_t)random_between(-32767, 32767),
                             (int16_t)random_between(-32767, 32767), 0, 0};
    struct raster_clip_vertex t;
    struct raster_vertex p;
    double xy[2], w;
    raster_transform(&t, o, &v);
    if (raster_clip_code(o, &t))
        return;
    raster_project(&p, o, &t, 1, 1);
    project_double(xy, &w, c, so, sizes[size][1], &v);
    double units = 8, x = ldexp(units / t.w, 29 - o->shift_xy) / 512;
    double relative = units / t.w;
    const int32_t got[2] = {p.x, p.y};
    count++;
    for (int i = 0; i < 2; i++) {
        double error = fabs(got[i] / 256.0 - xy[i]), bound = 1 / 512.0 + x + fabs(got[i] / 256.0) * relative;
        worst_share = fmax(worst_share, error / bound);
        if (apart && size < 2 && fabs(got[0] / 256.0) <= sizes[size][0] / 2 &&
            fabs(got[1] / 256.0) <= sizes[size][1] / 2)
            worst[size] = fmax(worst[size], error);
        if (error > bound)
            fail_msg("%.4f px from where it belongs, %.4f, bound %.4f; extent 2^%d", error, xy[i], bound,
                     15 - so->scale_shift);
    }
    double inv_w = ldexp(1, 23 + (int)floor(log2(c->near)) - 16) / w;
    double error = fabs(p.inv_w - fmin(inv_w, 1 << 23)), bound = 1 + inv_w * (relative + 0x1p-26);
    worst_depth_share = fmax(worst_depth_share, error / bound);
    assert_true(error <= bound);
}

static void vertices_land_within_the_stated_bound(void **state)
{
    (void)state;
    for (int n = 0; n < (getenv("GONIOTILE_LONG") ? 3000000 : 100000); n++) {
        struct scene_camera c;
        struct scene_object so;
        struct raster_object o;
        unsigned size = (unsigned)n % (sizeof sizes / sizeof *sizes);
        double extent = exp2(random_between(-10, 10));
        bool apart = n & 8; /* as seen from outside of the object's box */
        double distance = fmin(extent * exp2(apart ? random_between(1.6, 10) : random_between(-3, 10)), 30000);
        random_object(&so, &c, sizes[size], extent, distance);
        struct raster_frame f = {.camera = &c, .width = sizes[size][0], .height = sizes[size][1], .samples = 1};
        raster_object_setup(&o, &f, &so);
        for (int k = 0; k < 8; k++)
            check_vertex(&o, &c, &so, size, apart && distance > 3 * extent);
    }
    print_message("# %ld vertices, at most %.2f of the bound, depth %.2f\n", count, worst_share, worst_depth_share);
    print_message(
        "# objects 3 half extents away or farther, in view: 320 x 240 off by %.3f/256 px, 4096 x 4096 by %.3f/256 px\n",
        256 * worst[0], 256 * worst[1]);
    assert_true(count > 100000);
    assert_true(worst[0] <= 0.51 / 256);
    assert_true(worst[1] <= 0.51 / 256);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(vertices_land_within_the_stated_bound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
