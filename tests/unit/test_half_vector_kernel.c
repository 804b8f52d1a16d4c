/*
 * The kernels of the half-vector table on batches made by hand: all give the same bits, whatever the table, the planes, the light and the
 * taps; and those are what lut_eval says, at one pixel whose planes are exact, and with fewer taps what double precision finds.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "half_vector.h"
#include "quality.h"
#include "ref_table.h"

static uint64_t seed = 1;

static uint32_t random32(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    uint32_t x = (uint32_t)(seed >> 33);
    return x * 2654435761u ^ x >> 15;
}

static double uniform(double low, double high)
{
    return low + (high - low) * random32() * 0x1p-32;
}

static void random_direction(double v[3])
{
    double z = uniform(-1, 1), a = uniform(0, 6.283185307179586), r = sqrt(1 - z * z);
    v[0] = r * cos(a), v[1] = r * sin(a), v[2] = z;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static struct vec3 quantise(const double v[3])
{
    int32_t q[3];
    for (int i = 0; i < 3; i++)
        q[i] = fx_clamp((int32_t)lrint(v[i] * 32768), -32767, 32767);
    return (struct vec3){q[0], q[1], q[2]};
}

struct table {
    uint32_t *texels;
    void *file;
    struct lut_table lut;
};

/* Random mantissas and exponents from `exponent` on, constant in t where the azimuth is undefined, or everywhere; with the re-packed copy. */
static struct table make_table(unsigned h, unsigned d, unsigned t, unsigned exponent, unsigned exponents, double width,
                               int scale, bool constant_in_t)
{
    struct ref_half f = {.t = t, .h = h, .d = d, .scale = scale, .slabs = 1};
    struct table out = {.texels = malloc(sizeof(uint32_t) * t * h * d)};
    size_t bytes;
    for (unsigned i = 0; i < t * h * d; i++) {
        bool constant = i % t > 0 && (constant_in_t || i / t < h || i / t % h == 0);
        const uint32_t mantissas = constant ? 0 : random32() & 0x7ffffff, largest = constant ? 0 : random32() % 3,
                       more = constant ? 0 : random32() % exponents;
        out.texels[i] = constant ? out.texels[i - 1] : mantissas | 0x100u << largest * 9 | (exponent + more) << 27;
    }
    f.texels = out.texels;
    ref_half_warp(&f, width);
    out.file = ref_half_make(&f, &bytes);
    assert_int_equal(lut_open(&out.lut, out.file, bytes), LUT_OK);
    assert_non_null(out.lut.slabs);
    return out;
}

static void free_table(struct table *t)
{
    free(t->texels);
    free(t->file);
}

/* A plane of two unit vectors' components in a block of 16 x 16, within 32767 everywhere. */
static struct raster_plane random_lanes(int32_t low, int32_t high)
{
    uint32_t lane[2][3];
    for (int k = 0; k < 2; k++) {
        int32_t base = k ? high : low, dx = (int32_t)(random32() % 401) - 200, dy = (int32_t)(random32() % 401) - 200;
        base -= 8 * (dx + dy);
        base =
            fx_clamp(base, -32767 - 15 * (fx_min(dx, 0) + fx_min(dy, 0)), 32767 - 15 * (fx_max(dx, 0) + fx_max(dy, 0)));
        lane[k][0] = (uint32_t)base, lane[k][1] = (uint32_t)dx, lane[k][2] = (uint32_t)dy;
    }
    return (struct raster_plane){lane[0][0] + (lane[1][0] << 16), lane[0][1] + (lane[1][1] << 16),
                                 lane[0][2] + (lane[1][2] << 16)};
}

static void random_light(struct raster_block_light *light, const struct lut_table *t)
{
    double a[3], b[3], l[3];
    random_direction(a), random_direction(b), random_direction(l);
    struct vec3 qa = quantise(a), qb = quantise(b), ql = quantise(l);
    int32_t last = (int32_t)((t->depth - 1) << TERM_D_BITS) - 1, dx = (int32_t)(random32() % (unsigned)(last / 32)),
            dy = (int32_t)(random32() % (unsigned)(last / 32)),
            base = (int32_t)(random32() % (unsigned)(last - 15 * (dx + dy) + 1));
    memset(light, 0, sizeof *light);
    light->plane[PLANE_A_XY] = random_lanes(qa.x, qa.y);
    light->plane[PLANE_B_XY] = random_lanes(qb.x, qb.y);
    light->plane[PLANE_AB_Z] = random_lanes(qa.z, qb.z);
    light->plane[PLANE_TERM] = (struct raster_plane){(uint32_t)base, (uint32_t)dx, (uint32_t)dy};
    if (random32() % 2) /* falls towards the right */
        light->plane[PLANE_TERM] = (struct raster_plane){(uint32_t)(base + 15 * dx), -(uint32_t)dx, (uint32_t)dy};
    light->l_xy = lanes(ql.x, ql.y);
    light->l_z = ql.z;
    unsigned dark = random32() % 28;
    for (int k = 0; k < 3; k++)
        light->colour[k] = random32() % 5 ? random32() >> dark : 0;
}

static void random_batch(struct raster_batch *b)
{
    memset(b, 0, sizeof *b);
    b->count = RASTER_BATCH;
    for (uint32_t i = 0, at = 0; i < RASTER_BATCH; i++, at += 1 + random32() % 3) {
        double n[3];
        random_direction(n);
        struct vec3 q = quantise(n);
        int32_t nv = (int32_t)(random32() >> (2 + random32() % 8));
        b->pixel[i] =
            (struct raster_batch_pixel){lanes(q.x, q.y), q.z, fx_max(nv, 1 << 22), (at & 15) | (at >> 4 & 15) << 8};
        for (int k = 0; k < 3; k++)
            b->radiance[i][k] = random32() >> 1;
    }
}

/* By the batch's taps. */
static raster_half_vector *kernel(const struct raster_batch *b, raster_half_vector *eight, raster_half_vector *fewer)
{
    return b->taps == RASTER_TAPS_8 ? eight : fewer;
}

static void kernels_give_the_same_bits(void **state)
{
    static const struct {
        unsigned h, d, t, exponent, exponents;
        int scale;
    } size[] = {{64, 32, 8, 8, 12, 0}, {2, 2, 2, 0, 32, 0},    {128, 64, 8, 0, 32, -3}, {65, 3, 32, 20, 12, 2},
                {21, 16, 3, 12, 4, 0}, {32, 24, 5, 5, 20, 16}, {7, 128, 5, 0, 32, -16}};
    static struct raster_batch plain, chosen;
    uint32_t lit = 0, bright = 0;
    (void)state;
    for (unsigned i = 0; i < sizeof size / sizeof *size; i++) {
        struct table t = make_table(size[i].h, size[i].d, size[i].t, size[i].exponent, size[i].exponents,
                                    exp(uniform(-6, 0)), size[i].scale, false);
        for (int k = 0; k < 60 * RASTER_TAPS_COUNT; k++) {
            struct raster_block_light light;
            random_light(&light, &t.lut);
            random_batch(&plain);
            plain.taps = (uint32_t)k % RASTER_TAPS_COUNT;
            const struct raster_batch before = plain;
            const uint32_t first = random32() % 4, end = RASTER_BATCH - random32() % 4;
            raster_half_vector *const other[] = {
                kernel(&before, raster_half_vector_packed, raster_half_vector_fewer_packed),
                kernel(&before, HALF_VECTOR_PACKED, HALF_VECTOR_FEWER_PACKED),
                kernel(&before, HALF_VECTOR_PLAIN, HALF_VECTOR_FEWER_PLAIN),
            };
            const uint32_t count = kernel(&before, raster_half_vector_plain,
                                          raster_half_vector_fewer_plain)(&plain, first, end, &t.lut, &light);
            for (unsigned j = 0; j < sizeof other / sizeof *other; j++) {
                chosen = before;
                assert_int_equal(other[j](&chosen, first, end, &t.lut, &light), count);
                assert_memory_equal(&chosen, &plain, sizeof plain);
            }
            for (uint32_t p = 0; p < RASTER_BATCH; p++)
                for (int c = 0; c < 3; c++) {
                    uint32_t added = plain.radiance[p][c] - before.radiance[p][c];
                    assert_true(added <= RASTER_LIGHT_LIMIT && (added == 0 || (p >= first && p < end)));
                    bright += added == RASTER_LIGHT_LIMIT;
                }
            lit += count;
        }
        free_table(&t);
    }
    assert_true(lit > 7 * 180 * RASTER_BATCH / 4 && bright > 100);
}

/* One pixel: planes that are exact, so that only the kernel's own fractions and sums err. */
static bool one_pixel(struct raster_batch *b, struct raster_block_light *light, const struct lut_table *t,
                      const double n[3], const double l[3], const double v[3])
{
    double h[3], d[3], c[3], h2 = 0, d2 = 0, nh;
    struct vec3 qn = quantise(n), ql = quantise(l);
    for (int i = 0; i < 3; i++) {
        h[i] = l[i] + v[i], d[i] = l[i] - v[i];
        c[i] = l[(i + 1) % 3] * v[(i + 2) % 3] - l[(i + 2) % 3] * v[(i + 1) % 3];
        h2 += h[i] * h[i], d2 += d[i] * d[i];
    }
    nh = dot(n, h);
    if (dot(n, v) < 1.0 / 128 || dot(n, l) < 1.0 / 128 || d2 < 0.01 || h2 < 0.01 || nh * nh > 0.999 * h2)
        return false; /* the last: t has no bits near the axis, where tables that are not noise do not depend on it */
    for (int i = 0; i < 3; i++)
        d[i] /= sqrt(d2), c[i] *= 2 / sqrt(h2 * d2);
    struct vec3 qa = quantise(d), qb = quantise(c);
    uint32_t term = lut_d_coordinate(t, (uint32_t)lrint(sqrt(d2) / 2 * 0x1p27), (uint32_t)lrint(sqrt(h2) / 2 * 0x1p27));
    memset(light, 0, sizeof *light);
    light->plane[PLANE_A_XY].base = lanes(qa.x, qa.y);
    light->plane[PLANE_B_XY].base = lanes(qb.x, qb.y);
    light->plane[PLANE_AB_Z].base = lanes(qa.z, qb.z);
    light->plane[PLANE_TERM].base = term >> (LUT_D_BITS - TERM_D_BITS);
    light->l_xy = lanes(ql.x, ql.y);
    light->l_z = ql.z;
    for (int k = 0; k < 3; k++)
        light->colour[k] = 65536;
    memset(b, 0, sizeof *b);
    b->count = 1;
    b->pixel[0] = (struct raster_batch_pixel){lanes(qn.x, qn.y), qn.z, (int32_t)lrint(dot(n, v) * 0x1p30), 0};
    return true;
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Fractions are cut to 6 bits (d) and 8 (t); neighbours are noise within a factor of 2. In units of the largest value around. */
static void kernel_agrees_with_lut_eval(void **state)
{
    enum { COUNT = 20000 };
    static double e[COUNT];
    static struct raster_batch b;
    struct raster_block_light light;
    struct table t = make_table(64, 32, 8, 15, 1, 0.3, 0, false);
    (void)state;
    for (unsigned i = 0; i < COUNT;) {
        double n[3], l[3], v[3];
        random_direction(n), random_direction(l), random_direction(v);
        if (!one_pixel(&b, &light, &t.lut, n, l, v))
            continue;
        struct lut_rgb f;
        lut_eval(&f, &t.lut, quantise(n), quantise(l), quantise(v));
        assert_int_equal(HALF_VECTOR_PACKED(&b, 0, 1, &t.lut, &light), 1);
        double share = dot(n, l) / (dot(n, l) + dot(n, v)); /* the largest is 511/512 */
        e[i] = 0;
        for (int c = 0; c < 3; c++)
            e[i] = fmax(e[i], fabs(b.radiance[0][c] * 0x1p-20 - ldexp(f.c[c], f.e) * dot(n, l)) / share);
        i++;
    }
    qsort(e, COUNT, sizeof *e, compare_doubles);
    print_message("# error median %.5f, p99 %.5f, p99.9 %.5f, max %.5f\n", e[COUNT / 2], e[COUNT - COUNT / 100],
                  e[COUNT - COUNT / 1000], e[COUNT - 1]);
    assert_true(e[COUNT / 2] < 0.006 && e[COUNT - COUNT / 100] < 0.015 && e[COUNT - 1] < 0.06);
    free_table(&t);
}

/* Where d has no more bits than 8 taps take. */
static void four_taps_are_eight_where_the_azimuth_does_not_matter(void **state)
{
    static struct raster_batch b, want;
    struct table t = make_table(64, 32, 8, 10, 8, 0.3, 0, true);
    (void)state;
    for (int k = 0; k < 200; k++) {
        struct raster_block_light light;
        random_light(&light, &t.lut);
        struct raster_plane *d = &light.plane[PLANE_TERM];
        d->base &= ~1023u, d->dx = (uint32_t)((int32_t)d->dx / 1024 * 1024), d->dy &= ~1023u;
        random_batch(&want);
        b = want;
        b.taps = RASTER_TAPS_4;
        const uint32_t count = HALF_VECTOR_PACKED(&want, 0, RASTER_BATCH, &t.lut, &light);
        assert_int_equal(HALF_VECTOR_FEWER_PACKED(&b, 0, RASTER_BATCH, &t.lut, &light), count);
        assert_memory_equal(b.radiance, want.radiance, sizeof b.radiance);
    }
    free_table(&t);
}

/* A plane's value at a pixel, its low and high half. */
static void plane_at(double value[2], const struct raster_plane *p, uint32_t at)
{
    const uint32_t x = p->base + (at & 255) * p->dx + (at >> 8) * p->dy;
    value[0] = lane_low(x) / 32768.0, value[1] = lane_high(x) / 32768.0;
}

/* Coordinates of a pixel on the table's axes, in nodes, and n.l / (n.l + n.v). False: the light does not reach it. */
static bool coordinates(double *h, double *d, double *t, double *ratio, const struct lut_table *table,
                        const struct raster_block_light *light, const struct raster_batch_pixel *p)
{
    double a_xy[2], b_xy[2], ab_z[2];
    const struct raster_plane *term = &light->plane[PLANE_TERM];
    const double n[3] = {lane_low(p->normal_xy) / 32768.0, lane_high(p->normal_xy) / 32768.0, p->normal_z / 32768.0},
                 l[3] = {lane_low(light->l_xy) / 32768.0, lane_high(light->l_xy) / 32768.0, light->l_z / 32768.0},
                 nl = dot(n, l), nv = ldexp(p->nv, -30), tilt = (nl - nv) / (nl + nv);
    plane_at(a_xy, &light->plane[PLANE_A_XY], p->at);
    plane_at(b_xy, &light->plane[PLANE_B_XY], p->at);
    plane_at(ab_z, &light->plane[PLANE_AB_Z], p->at);
    const double na = dot(n, (double[3]){a_xy[0], a_xy[1], ab_z[0]}),
                 nb = dot(n, (double[3]){b_xy[0], b_xy[1], ab_z[1]}), y = na * na + nb * nb + 0x1p-16;
    int octave;
    const double m = frexp(fmin(y, 1 - 0x1p-28), &octave), node = 8 * (octave + 15 + 2 * m - 1); /* 2^-16: node 0 */
    const uint16_t *w = table->warp_h + (int)node;
    *h = (w[0] + (node - floor(node)) * (w[1] - w[0])) / 512;
    *d = (term->base + (p->at & 255) * term->dx + (p->at >> 8) * term->dy) * 0x1p-16;
    *t = fmax(na * na / y, tilt * tilt) * (table->width - 1);
    *ratio = nl / (nl + nv);
    return nl > 0;
}

static double channel(const struct lut_table *t, unsigned h, unsigned d, unsigned at, int c)
{
    const uint32_t x = t->texels[(d * t->height + h) * t->width + at];
    return ldexp(x >> 9 * c & 511, (int)(x >> 27) - 24 + t->scale);
}

/* Whether rounding x to a whole number is sure, for an error of x. */
static bool rounds(double x, double error)
{
    return fabs(x - floor(x) - 0.5) > error;
}

static void fewer_taps_are_of_the_nearest_nodes(void **state)
{
    enum { FOUR, ONE, KINDS };
    static struct raster_batch b[KINDS];
    struct table t = make_table(40, 24, 8, 14, 3, 0.3, 0, false);
    uint32_t compared = 0;
    (void)state;
    for (int k = 0; k < 1500; k++) {
        struct raster_block_light light;
        random_light(&light, &t.lut);
        for (int c = 0; c < 3; c++)
            light.colour[c] = 65536;
        random_batch(&b[FOUR]);
        memset(b[FOUR].radiance, 0, sizeof b[FOUR].radiance);
        b[ONE] = b[FOUR];
        b[FOUR].taps = RASTER_TAPS_4, b[ONE].taps = RASTER_TAPS_1;
        for (int i = 0; i < KINDS; i++)
            HALF_VECTOR_FEWER_PACKED(&b[i], 0, RASTER_BATCH, &t.lut, &light);
        for (uint32_t i = 0; i < RASTER_BATCH; i++) {
            const struct raster_batch_pixel *p = &b[ONE].pixel[i];
            double h, d, azimuth, ratio;
            if (!coordinates(&h, &d, &azimuth, &ratio, &t.lut, &light, p) || ratio < 0.1 || ldexp(p->nv, -30) < 0.1)
                continue;
            if (!rounds(azimuth, 3 * 7 / 1024.0) || !rounds(h, 0.01) || !rounds(d, 1e-9))
                continue;
            const unsigned h0 = (unsigned)h, d0 = (unsigned)d, at = (unsigned)(azimuth + 0.5);
            const double fh = h - h0, fd = d - d0;
            for (int c = 0; c < 3; c++) {
                double node[4], largest = 0;
                for (unsigned j = 0; j < 4; j++) {
                    node[j] = channel(&t.lut, h0 + j % 2, d0 + j / 2, at, c);
                    largest = fmax(largest, node[j]);
                }
                const double four = (1 - fd) * ((1 - fh) * node[0] + fh * node[1]) +
                                    fd * ((1 - fh) * node[2] + fh * node[3]),
                             one = node[(fh > 0.5) + 2 * (fd > 0.5)];
                assert_true(fabs(b[ONE].radiance[i][c] * 0x1p-20 - one * ratio) <= 0.002 * one * ratio + 4e-6);
                assert_true(fabs(b[FOUR].radiance[i][c] * 0x1p-20 - four * ratio) <= 0.005 * largest * ratio + 4e-6);
            }
            compared += h0 + 2 < t.lut.height;
        }
    }
    assert_true(compared > 5000);
    free_table(&t);
}

/* Brighter than the loop takes: where a texel below 2^(E - 15 + scale) may reflect 128 of a light, rounded up to a power of two. */
static void tables_beyond_the_loops_range_say_so(void **state)
{
    struct lut_table t = {.kind = LUT_HALF_VECTOR, .height = 8};
    const struct lut_table *const tables[] = {&t};
    struct raster_light lights[3] = {{.radius = 0}};
    const struct scene_material m = {.kind = SCENE_MATERIAL_MEASURED};
    struct raster r = {.frame = {.tables = tables, .light_count = 3}, .lights = lights};
    unsigned seen[2] = {0};
    (void)state;
    for (unsigned n = 0; n < 200000; n++) {
        const uint32_t irradiance = 1 + (random32() >> random32() % 32);
        t.slabs = &irradiance; /* some */
        t.scale = (int32_t)(random32() % 33) - 16;
        t.brightest = random32() % 32;
        lights[n % 3].irradiance[n / 3 % 3] = irradiance;
        const bool bright = exp2((int)t.brightest - 15 + t.scale) * exp2(floor(log2(irradiance)) - 15) > 128;
        const uint32_t all = RASTER_SLOW(RASTER_SHADE_HALF_VECTOR) | RASTER_SLOW_BRIGHT;
        assert_int_equal(raster_half_vector_model.slow(&r, &m, NULL), bright ? all : 0);
        seen[bright]++;
        t.slabs = NULL; /* read from its texels whatever there is */
        assert_int_equal(raster_half_vector_model.slow(&r, &m, NULL), RASTER_SLOW(RASTER_SHADE_HALF_VECTOR));
        lights[n % 3].irradiance[n / 3 % 3] = 0;
    }
    assert_true(seen[0] > 10000 && seen[1] > 10000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kernels_give_the_same_bits),
        cmocka_unit_test(kernel_agrees_with_lut_eval),
        cmocka_unit_test(four_taps_are_eight_where_the_azimuth_does_not_matter),
        cmocka_unit_test(fewer_taps_are_of_the_nearest_nodes),
        cmocka_unit_test(tables_beyond_the_loops_range_say_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
