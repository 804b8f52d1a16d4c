/*
 * Point lights against double precision, over the whole range of cameras, depths, distances and radii.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>

#include "internal.h"
#include "point_light.h"

enum { CASES = 100000 };

static uint64_t state = 1;

static uint32_t random_u32(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(state >> 32);
}

/* 0..1 */
static double random_real(void)
{
    return random_u32() / 4294967296.0;
}

/* 2^lo .. 2^hi, every octave as likely as another. */
static double random_scale(double lo, double hi)
{
    return exp2(lo + (hi - lo) * random_real());
}

/* One unit with 16 fraction bits at least, as the format has them. */
static uint32_t random_fixed(double lo, double hi)
{
    return (uint32_t)llrint(random_scale(lo, hi) * 65536);
}

struct view {
    struct scene_camera camera;
    struct raster r;
};

static void random_view(struct view *v)
{
    v->camera.focal = random_fixed(-8, 8);
    v->camera.near = random_fixed(-16, 14);
    if (random_u32() % 2) { /* what pictures have */
        v->camera.focal = random_fixed(-1, 4);
        v->camera.near = random_fixed(-7, 1);
    }
    v->r.frame.camera = &v->camera;
    v->r.frame.width = (uint16_t)(1 + random_u32() % RASTER_MAX_WIDTH);
    v->r.frame.height = (uint16_t)(1 + random_u32() % RASTER_MAX_HEIGHT);
}

/* Every octave of depth. */
static uint32_t random_depth(void)
{
    return DEPTH_BIAS + 1 + (random_u32() % (1u << 23) >> random_u32() % 23);
}

static double saturated(double x)
{
    return fmin(fmax(x, -INT32_MAX / 65536.0), INT32_MAX / 65536.0);
}

/* The position that depth, D = 2^23 near2/w + bias, and the ray through the pixel's centre say. */
static void exact_point(double out[3], const struct view *v, uint32_t x, uint32_t y, uint32_t depth)
{
    const struct raster_frame *f = &v->r.frame;
    double near2 = exp2(floor(log2(v->camera.near / 65536.0)));
    double w = 0x1p23 * near2 / ((int32_t)depth - (int32_t)DEPTH_BIAS);
    double half_pixel = w / (f->height * (v->camera.focal / 65536.0));
    out[0] = (2 * (double)x + 1 - f->width) * half_pixel;
    out[1] = (f->height - 2 * (double)y - 1) * half_pixel;
    out[2] = -w;
}

static void surface_point_is_where_depth_and_pixel_say(void **unused)
{
    (void)unused;
    struct view v = {0};
    double worst = 0;
    for (int i = 0; i < CASES; i++) {
        double p[3];
        random_view(&v);
        uint32_t x = random_u32() % v.r.frame.width, y = random_u32() % v.r.frame.height, depth = random_depth();
        struct vec3 got = raster_surface_point(&v.r, x, y, depth);
        exact_point(p, &v, x, y, depth);
        double pixel = -p[2] * 2 / (v.r.frame.height * (v.camera.focal / 65536.0));
        const int32_t g[3] = {got.x, got.y, got.z};
        for (int k = 0; k < 3; k++) {
            double bound = 1 / 65536.0 + fabs(p[k]) * 0x1p-24 + (k < 2 ? pixel * 0x1p-17 : 0);
            double error = fabs(g[k] / 65536.0 - saturated(p[k])) / bound;
            worst = fmax(worst, error);
        }
    }
    print_message("# largest error %.2f of the bound\n", worst);
    assert_true(worst <= 1);
}

static void surface_point_of_no_depth_is_as_far_as_can_be(void **unused)
{
    (void)unused;
    struct view v = {.camera = {.focal = 1 << 17, .near = 1 << 15}, .r.frame = {.width = 320, .height = 240}};
    v.r.frame.camera = &v.camera;
    for (uint32_t depth = 0; depth <= DEPTH_BIAS + 1; depth += DEPTH_BIAS / 4) {
        struct vec3 p = raster_surface_point(&v.r, 0, 0, depth);
        assert_int_equal(p.x, -INT32_MAX);
        assert_int_equal(p.y, INT32_MAX);
        assert_int_equal(p.z, -INT32_MAX);
    }
}

static void light_position_is_turned_into_eye_space(void **unused)
{
    (void)unused;
    for (int i = 0; i < CASES / 10; i++) {
        struct scene_camera c = {.near = 1};
        double q[4], n = 0;
        for (int k = 0; k < 4; k++) {
            q[k] = random_real() - 0.5;
            n += q[k] * q[k];
        }
        if (n < 0.01)
            continue;
        n = sqrt(n);
        double w = q[0] / n, a = q[1] / n, b = q[2] / n, d = q[3] / n;
        double m[9] = {1 - 2 * (b * b + d * d), 2 * (a * b - d * w),     2 * (a * d + b * w),
                       2 * (a * b + d * w),     1 - 2 * (a * a + d * d), 2 * (b * d - a * w),
                       2 * (a * d - b * w),     2 * (b * d + a * w),     1 - 2 * (a * a + b * b)};
        q16_16_t position[3];
        unsigned down = i % 4 ? random_u32() % 31 : 0;
        for (int k = 0; k < 9; k++)
            c.rotation[k] = (q2_30_t)lrint(m[k] * (1 << 30));
        for (int k = 0; k < 3; k++) {
            c.eye[k] = (int32_t)random_u32() >> down;
            position[k] = (int32_t)random_u32() >> down;
        }
        struct vec3 e;
        raster_light_position(&e, &c, position);
        const int32_t got[3] = {e.x, e.y, e.z};
        for (int k = 0; k < 3; k++) {
            double sum = 0;
            for (int j = 0; j < 3; j++)
                sum += c.rotation[3 * k + j] * 0x1p-30 * ((double)position[j] - c.eye[j]);
            assert_true(fabs(got[k] - fmin(fmax(sum, -INT32_MAX), INT32_MAX)) <= 0.51);
        }
    }
}

static double attenuation_of(double d, double radius)
{
    double ratio = d / radius, window = 1 - ratio * ratio * ratio * ratio;
    return fmin(window * window / (fmax(d, 0.01) * fmax(d, 0.01)), 1);
}

struct errors {
    double component, length, attenuation;
};

static void check_light(struct errors *worst, struct vec3 position, uq16_16_t radius, struct vec3 point)
{
    struct vec3 l;
    uint32_t a;
    double d[3] = {(double)position.x - point.x, (double)position.y - point.y, (double)position.z - point.z};
    double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    bool lit = raster_point_light(&l, &a, &position, radius, point);
    if (fabs(length - radius) > 1e-6 * radius)
        assert_int_equal(lit, length < radius);
    if (!lit)
        return;
    assert_true(a <= 1u << 30);
    const int32_t got[3] = {l.x, l.y, l.z};
    double got_length = sqrt((double)l.x * l.x + (double)l.y * l.y + (double)l.z * l.z);
    for (int k = 0; k < 3 && length > 0; k++)
        worst->component = fmax(worst->component, fabs(got[k] - 32768 * d[k] / length));
    worst->length = fmax(worst->length, fabs(got_length - 32768));
    double distance = length / 65536, open = fmin(1 / (distance * distance + 1e-9), 1);
    double want = attenuation_of(distance, radius / 65536.0);
    worst->attenuation =
        fmax(worst->attenuation, fabs(a * 0x1p-30 - want) / (0x1p-30 + open * (distance < 0.1 ? 0x1p-15 : 0x1p-20)));
}

static void light_at_a_point_is_as_in_double_precision(void **unused)
{
    (void)unused;
    struct errors worst = {0, 0, 0};
    for (int i = 0; i < 3 * CASES; i++) {
        uq16_16_t radius = i % 7 ? random_fixed(-3, 10) : random_fixed(-16, 15);
        double reach = radius * (i % 3 ? 0.7 : random_scale(-12, 0.1)), middle = i % 5 ? 0x1p22 : 0x1p30;
        int32_t p[3], q[3];
        for (int k = 0; k < 3; k++) {
            double at = (2 * random_real() - 1) * middle;
            p[k] = (int32_t)at;
            q[k] = (int32_t)fmin(fmax(at + (2 * random_real() - 1) * reach, -INT32_MAX), INT32_MAX);
        }
        check_light(&worst, (struct vec3){p[0], p[1], p[2]}, radius, (struct vec3){q[0], q[1], q[2]});
    }
    print_message("# component %.3f LSB, length %.3f LSB, attenuation %.2f of its bound\n", worst.component,
                  worst.length, worst.attenuation);
    assert_true(worst.component <= 0.52);
    assert_true(worst.length <= 1);
    assert_true(worst.attenuation <= 1);
}

static void light_is_right_at_the_ends_of_every_range(void **unused)
{
    (void)unused;
    static const int32_t places[] = {0, 1, -1, 654, 655, 656, 46341, 65535, 65536, INT32_MAX, -INT32_MAX, 1 << 30};
    static const uint32_t radii[] = {1, 2, 3, 655, 656, 657, 65536, 1u << 30, (1u << 31) - 1, 1u << 31};
    enum { PLACES = sizeof places / sizeof *places, RADII = sizeof radii / sizeof *radii };
    struct errors worst = {0, 0, 0};
    for (int i = 0; i < PLACES * PLACES * PLACES * 2; i++) {
        struct vec3 a = {places[i % PLACES], places[i / PLACES % PLACES], 0};
        struct vec3 b = {i % 2 ? 0 : -INT32_MAX, places[i / PLACES / PLACES % PLACES], 0};
        for (int k = 0; k < RADII; k++)
            check_light(&worst, a, radii[k], b);
    }
    assert_true(worst.component <= 0.52 && worst.length <= 1 && worst.attenuation <= 1);
}

static void light_at_the_light_itself_is_whole(void **unused)
{
    (void)unused;
    struct vec3 p = {77, -5, 1 << 20}, l;
    uint32_t a;
    assert_true(raster_point_light(&l, &a, &p, 1 << 16, p));
    assert_int_equal(a, 1 << 30);
    assert_int_equal(l.x * l.x + l.y * l.y + l.z / 32768 * l.z, 32768);
}

static void light_ends_at_its_radius(void **unused)
{
    (void)unused;
    const struct vec3 here = {0, 0, 0};
    struct vec3 l;
    uint32_t a = 5;
    const struct vec3 at = {3 << 16, 4 << 16, 0}; /* 5 away */
    assert_false(raster_point_light(&l, &a, &at, 5 << 16, here));
    assert_int_equal(a, 5);
    assert_true(raster_point_light(&l, &a, &at, (5 << 16) + 1, here));
    assert_true(a <= 1);
}

/* A light that lights some surface of a tile, by the product's arithmetic or by double precision, is never culled there. */
static void culling_keeps_every_light_that_reaches_a_pixel(void **unused)
{
    (void)unused;
    struct view v = {0};
    uint32_t lit = 0, culled = 0;
    for (int i = 0; i < CASES; i++) {
        random_view(&v);
        const struct raster_frame *f = &v.r.frame;
        struct raster_rect rect = {(uint16_t)(random_u32() % f->width), (uint16_t)(random_u32() % f->height), 1, 1};
        rect.width = (uint16_t)(1 + random_u32() % (f->width - rect.x) % 64);
        rect.height = (uint16_t)(1 + random_u32() % (f->height - rect.y) % 64);
        uint32_t a = random_depth(), b = i % 4 ? a + random_u32() % 4096 : random_depth();
        uint32_t nearest = a > b ? a : b, farthest = a > b ? b : a;
        struct raster_light_box box;
        raster_light_box_setup(&box, &v.r, &rect, nearest, farthest);
        for (int k = 0; k < 8; k++) {
            uint32_t x = rect.x + (k & 1 ? rect.width - 1u : random_u32() % rect.width),
                     y = rect.y + (k & 2 ? rect.height - 1u : random_u32() % rect.height);
            uint32_t depth = k & 4 ? nearest : farthest + random_u32() % (nearest - farthest + 1);
            struct vec3 p = raster_surface_point(&v.r, x, y, depth), l;
            uint32_t attenuation, radius = random_fixed(-10, 15);
            double d[3], n = 1e-9, exact[3], far = radius * (0.9 + (i % 2 ? 0.12 : 1) * random_real()), distance = 0;
            const double at[3] = {p.x, p.y, p.z};
            int32_t c[3];
            for (int j = 0; j < 3; j++) {
                d[j] = random_real() - 0.5;
                n += d[j] * d[j];
            }
            for (int j = 0; j < 3; j++)
                c[j] = (int32_t)lrint(fmin(fmax(at[j] + d[j] / sqrt(n) * far, -INT32_MAX), INT32_MAX));
            const struct vec3 light = {c[0], c[1], c[2]};
            exact_point(exact, &v, x, y, depth);
            for (int j = 0; j < 3; j++)
                distance += pow(saturated(exact[j]) - c[j] / 65536.0, 2);
            bool there = raster_point_light(&l, &attenuation, &light, radius, p) || sqrt(distance) < radius / 65536.0;
            lit += there;
            culled += !raster_light_box_reached(&box, &light, radius);
            assert_true(!there || raster_light_box_reached(&box, &light, radius));
        }
    }
    print_message("# %u lit, %u culled of %u\n", lit, culled, CASES * 8);
    assert_true(lit > CASES && culled > CASES / 2);
}

/* A floor of 20 x 20 units seen from above its edge and 100 lights of radius 2 above it: by tile, how many lights the box
 * keeps beside those that do reach one of the tile's surfaces. */
static void culling_keeps_few_lights_that_reach_nothing(void **unused)
{
    (void)unused;
    struct view v = {.camera = {.focal = 2 << 16, .near = 1 << 15}, .r.frame = {.width = 320, .height = 240}};
    v.r.frame.camera = &v.camera;
    const double eye[3] = {0, 4, 14}, s = 0.28, c = sqrt(1 - s * s); /* looks down by asin s */
    uint32_t pairs = 0, kept = 0, wanted = 0;
    struct vec3 light[100];
    for (int i = 0; i < 100; i++) {
        double p[3] = {i % 10 * 2 - 9 - eye[0], 0.5 - eye[1], i / 10 * 2 - 9 - eye[2]};
        light[i] = (struct vec3){(int32_t)(p[0] * 65536), (int32_t)((p[1] * c - p[2] * s) * 65536),
                                 (int32_t)((p[1] * s + p[2] * c) * 65536)};
    }
    for (uint32_t tile = 0; tile < 5 * 8; tile++) {
        const struct raster_rect rect = {(uint16_t)(tile % 5 * 64), (uint16_t)(tile / 5 * 32), 64,
                                         (uint16_t)(tile / 5 == 7 ? 16 : 32)};
        static struct vec3 point[64 * 32];
        uint32_t nearest = 0, farthest = UINT32_MAX, count = 0;
        for (uint32_t i = 0; i < (uint32_t)rect.width * rect.height; i++) {
            uint32_t x = rect.x + i % rect.width, y = rect.y + i / rect.width;
            double ry = (240 - 2 * (double)y - 1) / (240 * 2), rx = (2 * (double)x + 1 - 320) / (240 * 2);
            double w = -eye[1] / (ry * c - s), at[2] = {w * rx, eye[2] - w * (ry * s + c)};
            if (w <= 0 || fabs(at[0]) > 10 || fabs(at[1]) > 10)
                continue;
            uint32_t depth = (uint32_t)(0x1p23 * 0.5 / w) + DEPTH_BIAS;
            nearest = depth > nearest ? depth : nearest;
            farthest = depth < farthest ? depth : farthest;
            point[count++] = raster_surface_point(&v.r, x, y, depth);
        }
        if (!count)
            continue;
        struct raster_light_box box;
        raster_light_box_setup(&box, &v.r, &rect, nearest, farthest);
        for (int i = 0; i < 100; i++) {
            struct vec3 l;
            uint32_t a, any = 0;
            for (uint32_t k = 0; k < count && !any; k++)
                any = raster_point_light(&l, &a, &light[i], 2 << 16, point[k]);
            pairs++;
            wanted += any;
            kept += raster_light_box_reached(&box, &light[i], 2 << 16);
        }
    }
    print_message("# of %u pairs of tile and light %u are kept, %u light something\n", pairs, kept, wanted);
    assert_true(kept >= wanted && wanted > 0);
    assert_true(kept * 4 <= wanted * 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surface_point_is_where_depth_and_pixel_say),
        cmocka_unit_test(surface_point_of_no_depth_is_as_far_as_can_be),
        cmocka_unit_test(light_position_is_turned_into_eye_space),
        cmocka_unit_test(light_at_a_point_is_as_in_double_precision),
        cmocka_unit_test(light_is_right_at_the_ends_of_every_range),
        cmocka_unit_test(light_at_the_light_itself_is_whole),
        cmocka_unit_test(light_ends_at_its_radius),
        cmocka_unit_test(culling_keeps_every_light_that_reaches_a_pixel),
        cmocka_unit_test(culling_keeps_few_lights_that_reach_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
