/*
 * lut_eval against the double-precision reference, which evaluates from the same quantised vectors, on tables of several sizes and
 * contents.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>

#include "lut.h"
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

/* Nearest q17_15_t components of a direction of any length. */
static struct vec3 quantise(double x, double y, double z)
{
    double s = 32768 / sqrt(x * x + y * y + z * z);
    return (struct vec3){(int32_t)lrint(x * s), (int32_t)lrint(y * s), (int32_t)lrint(z * s)};
}

static struct vec3 random_direction(void)
{
    double z = uniform(-1, 1), a = uniform(0, 6.283185307179586), r = sqrt(1 - z * z);
    return quantise(r * cos(a), r * sin(a), z);
}

static struct vec3 near_to(struct vec3 a, double spread)
{
    struct vec3 d = random_direction();
    return quantise(a.x + spread * d.x, a.y + spread * d.y, a.z + spread * d.z);
}

struct table {
    uint32_t *texels;
    void *file;
    size_t bytes;
    struct lut_table lut;
    struct ref_table *ref;
};

static struct table file_open(uint32_t *texels, void *file, size_t bytes)
{
    struct table t = {.texels = texels, .file = file, .bytes = bytes};
    assert_int_equal(lut_open(&t.lut, t.file, t.bytes), LUT_OK);
    t.ref = ref_table_open(t.file, t.bytes);
    assert_non_null(t.ref);
    return t;
}

/* Takes over `texels`. */
static struct table table_open(unsigned width, unsigned height, unsigned depth, uint32_t *texels, unsigned theta_max)
{
    size_t bytes;
    void *file = ref_ktx2_make(width, height, depth, texels, theta_max, &bytes);
    return file_open(texels, file, bytes);
}

static void table_close(struct table *t)
{
    free(t->texels);
    free(t->file);
    ref_table_free(t->ref);
}

/* Noise with what every well-made table has: no dependence on phi_d in the first slice and at both poles, equal
 * first and last columns. One mantissa of each texel is at least 256. */
static uint32_t *noise_make(unsigned width, unsigned height, unsigned depth, unsigned exponent_low, unsigned exponents)
{
    uint32_t *texels = malloc(sizeof *texels * width * height * depth);
    for (unsigned z = 0, i = 0; z < depth; z++) {
        for (unsigned y = 0; y < height; y++) {
            unsigned row = i;
            for (unsigned x = 0; x < width; x++, i++) {
                bool constant = depth > 1 && (z == 0 || y == 0 || y == height - 1);
                texels[i] = (random32() & 0x7ffffff) | 0x100u << random32() % 3 * 9 |
                            (exponent_low + random32() % exponents) << 27;
                if (x > 0 && (constant || x == width - 1)) {
                    texels[i] = texels[row];
                }
            }
        }
    }
    return texels;
}

/* A lobe around the mirror direction on a diffuse base, narrower and stronger towards grazing incidence. */
static uint32_t *lobe_make(unsigned width, unsigned height, unsigned depth)
{
    uint32_t *texels = malloc(sizeof *texels * width * height * depth);
    for (unsigned z = 0, i = 0; z < depth; z++) {
        for (unsigned y = 0; y < height; y++) {
            for (unsigned x = 0; x < width; x++, i++) {
                double theta = 180.0 * y / (height - 1), phi = 6.283185307179586 * x / (width - 1);
                double width_degrees = 8 - z * (1 + 0.5 * cos(phi) * sin(theta / 57.3));
                double f = 0.3 + 40 * exp(-theta * theta / (width_degrees * width_degrees));
                int e;
                frexp(f, &e);
                uint32_t m = (uint32_t)lrint(ldexp(f, 9 - e) - 0.5);
                texels[i] = m | (m * 3 / 4) << 9 | (m / 2) << 18 | (uint32_t)(e + 15) << 27;
            }
        }
    }
    return texels;
}

/* Largest error of a channel, and the reference's largest channel; *around is the largest of the nodes around the cell. */
static double error_of(double *largest, double *around, const struct table *t, struct vec3 n, struct vec3 l,
                       struct vec3 v)
{
    struct lut_rgb out;
    double exact[3], worst = 0;
    double dn[3] = {n.x, n.y, n.z}, dl[3] = {l.x, l.y, l.z}, dv[3] = {v.x, v.y, v.z};
    *around = ref_table_eval(exact, t->ref, dn, dl, dv);
    *largest = fmax(exact[0], fmax(exact[1], exact[2]));
    assert_int_equal(lut_eval(&out, &t->lut, n, l, v), 8);
    for (int c = 0; c < 3; c++) {
        assert_true(out.c[c] < 1u << 21);
        worst = fmax(worst, fabs(ldexp(out.c[c], out.e) - exact[c]));
    }
    return worst;
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* A light and a viewer above the horizon: all over the sphere, and a third of them near the mirror direction. */
static void random_case(struct vec3 *n, struct vec3 *l, struct vec3 *v, int i)
{
    do {
        *n = random_direction(), *l = random_direction(), *v = random_direction();
        double nl = fx_dot(*n, *l) * 0x1p-30;
        if (i % 3 == 0) {
            *v = near_to(quantise(2 * nl * n->x - l->x, 2 * nl * n->y - l->y, 2 * nl * n->z - l->z), uniform(0, 0.2));
        }
    } while (fx_dot(*n, *l) <= 0 || fx_dot(*n, *v) <= 0);
}

enum { COUNT = 100000 };

static void check_distribution(const char *name, double *e, double p50, double p999, double max)
{
    qsort(e, COUNT, sizeof *e, compare_doubles);
    double a = e[COUNT / 2], b = e[COUNT - COUNT / 1000], c = e[COUNT - 1];
    print_message("# %s: error p50 %.6f, p99.9 %.6f, max %.6f\n", name, a, b, c);
    assert_true(a <= p50 && b <= p999 && c <= max);
}

/* Errors beyond the result's last place (2^-21 of the largest node around it), in units of that node. */
static void check_errors(const char *name, struct table t, double p50, double p999, double max)
{
    double *e = malloc(COUNT * sizeof *e);
    for (int i = 0; i < COUNT; i++) {
        struct vec3 n, l, v;
        double largest, around;
        random_case(&n, &l, &v, i);
        e[i] = error_of(&largest, &around, &t, n, l, v);
        e[i] = e[i] / around - 0x1p-21;
    }
    check_distribution(name, e, p50, p999, max);
    free(e);
    table_close(&t);
}

static void noise_361x181x4_agrees(void **state)
{
    (void)state;
    check_errors("noise 361x181x4", table_open(361, 181, 4, noise_make(361, 181, 4, 15, 1), 60000), 0.0004, 0.018,
                 0.04);
}

static void noise_91x46x4_agrees(void **state)
{
    (void)state;
    check_errors("noise 91x46x4", table_open(91, 46, 4, noise_make(91, 46, 4, 15, 1), 60000), 0.00015, 0.0016, 0.003);
}

static void noise_of_all_exponents_91x46x4_agrees(void **state)
{
    (void)state;
    check_errors("steep 91x46x4", table_open(91, 46, 4, noise_make(91, 46, 4, 0, 32), 60000), 0.00005, 0.0015, 0.003);
}

static void noise_2x2x1_agrees(void **state)
{
    (void)state;
    check_errors("noise 2x2x1", table_open(2, 2, 1, noise_make(2, 2, 1, 0, 32), 60000), 0.0002, 0.0004, 0.0005);
}

static void lobe_361x181x4_agrees(void **state)
{
    (void)state;
    check_errors("lobe 361x181x4", table_open(361, 181, 4, lobe_make(361, 181, 4), 60000), 0.00003, 0.0003, 0.0005);
}

static void lobe_181x91x7_agrees(void **state)
{
    (void)state;
    check_errors("lobe 181x91x7", table_open(181, 91, 7, lobe_make(181, 91, 7), 90000), 0.00003, 0.0004, 0.0008);
}

static void noise_181x91x7_with_swap_agrees(void **state)
{
    (void)state;
    struct ref_keys k = {.count = 0};
    size_t bytes;
    uint32_t *texels = noise_make(181, 91, 7, 15, 1);
    ref_key_set_text(&k, "goniotile.kind", "specular_frame");
    ref_key_set_text(&k, "goniotile.swap", "1");
    ref_key_set_text(&k, "goniotile.theta_max", "60000");
    ref_key_set_text(&k, "goniotile.version", "1");
    void *file = ref_ktx2_write(181, 91, 7, texels, &k, &bytes);
    ref_keys_free(&k);
    struct table t = file_open(texels, file, bytes);
    for (int i = 0; i < 1000; i++) { /* reciprocal now */
        struct vec3 n, l, v;
        struct lut_rgb a, b;
        random_case(&n, &l, &v, i);
        lut_eval(&a, &t.lut, n, l, v);
        lut_eval(&b, &t.lut, n, v, l);
        if (fx_dot(n, l) != fx_dot(n, v)) {
            assert_memory_equal(&a, &b, sizeof a);
        }
    }
    check_errors("noise 181x91x7 with swap", t, 0.0003, 0.008, 0.02);
}

/* --- half-vector tables --- */

static struct table half_open(const struct ref_half *f)
{
    size_t bytes;
    void *file = ref_half_make(f, &bytes);
    return file_open((uint32_t *)f->texels, file, bytes);
}

static struct table half_of_material(unsigned h, unsigned d, unsigned t, double alpha, double metalness, int scale)
{
    struct ref_material m = {
        .kind = REF_METALLIC_ROUGHNESS, .kd = {0.9, 0.5, 0.1}, .metalness = metalness, .roughness = sqrt(alpha)};
    struct ref_half f = {.t = t, .h = h, .d = d, .scale = scale};
    ref_half_warp(&f, alpha);
    ref_half_sample(&f, ref_brdf_of_material, &m);
    return half_open(&f);
}

/* Constant in t where the azimuth is undefined: at l = v and at h = n. */
static struct table half_noise(unsigned h, unsigned d, unsigned t, unsigned exponent_low, unsigned exponents)
{
    struct ref_half f = {.t = t, .h = h, .d = d};
    uint32_t *texels = malloc(sizeof *texels * t * h * d);
    for (unsigned i = 0; i < t * h * d; i++) {
        bool constant = i % t > 0 && (i / t < h || i / t % h == 0);
        texels[i] = constant ? texels[i - 1]
                             : (random32() & 0x7ffffff) | 0x100u << random32() % 3 * 9 |
                                   (exponent_low + random32() % exponents) << 27;
    }
    f.texels = texels;
    ref_half_warp(&f, 0.05);
    return half_open(&f);
}

/* What half-vector tables find hardest: besides random_case, light and viewer close together, and directions that graze. */
static void half_case(struct vec3 *n, struct vec3 *l, struct vec3 *v, int i)
{
    if (i % 4 < 2) {
        random_case(n, l, v, i / 4);
        return;
    }
    do {
        *n = random_direction(), *l = random_direction();
        *v = i % 4 == 2 ? near_to(*l, exp(uniform(-9, 0))) : random_direction();
        if (i % 4 == 3) { /* l or both within a degree of the horizon */
            double lift = uniform(0, 0.02) - fx_dot(*n, *l) * 0x1p-30;
            *l = quantise(l->x + lift * n->x, l->y + lift * n->y, l->z + lift * n->z);
            lift = uniform(0, 0.02) - fx_dot(*n, *v) * 0x1p-30;
            *v = i % 8 == 3 ? quantise(v->x + lift * n->x, v->y + lift * n->y, v->z + lift * n->z) : *v;
        }
    } while (fx_dot(*n, *l) <= 0 || fx_dot(*n, *v) <= 0);
}

/* Error over the value itself: of its largest channel. */
static void check_relative(const char *name, struct table t, double p50, double p999, double max)
{
    double *e = malloc(COUNT * sizeof *e);
    for (int i = 0; i < COUNT; i++) {
        struct vec3 n, l, v;
        double largest, around;
        half_case(&n, &l, &v, i);
        e[i] = error_of(&largest, &around, &t, n, l, v);
        e[i] = largest > 0 ? e[i] / largest : e[i] > 0;
    }
    check_distribution(name, e, p50, p999, max);
    free(e);
    table_close(&t);
}

static const double most = 1.0 / 128, almost_all = 1.0 / 512;

static void half_vector_rough_64x32x8_agrees(void **state)
{
    (void)state;
    check_relative("half-vector 64x32x8, alpha 0.3, dielectric", half_of_material(64, 32, 8, 0.3, 0, 0), 0.0001,
                   almost_all, most);
}

static void half_vector_glossy_64x32x8_agrees(void **state)
{
    (void)state;
    check_relative("half-vector 64x32x8, alpha 0.05, metal", half_of_material(64, 32, 8, 0.05, 1, -3), 0.0001,
                   almost_all, most);
}

static void half_vector_sharp_128x32x8_agrees(void **state)
{
    (void)state;
    check_relative("half-vector 128x32x8, alpha 0.003, metal", half_of_material(128, 32, 8, 0.003, 1, 0), 0.0002,
                   almost_all, most);
}

static void half_vector_21x16x3_agrees(void **state)
{
    (void)state;
    check_relative("half-vector 21x16x3, alpha 0.1", half_of_material(21, 16, 3, 0.1, 0, 0), 0.0001, almost_all, most);
}

static void half_vector_2x2x2_agrees(void **state)
{
    (void)state;
    check_relative("half-vector 2x2x2", half_of_material(2, 2, 2, 0.5, 0, 3), 0.0001, almost_all, most);
}

static void half_vector_noise_64x32x8_agrees(void **state)
{
    (void)state;
    check_relative("half-vector noise 64x32x8", half_noise(64, 32, 8, 15, 1), 0.0002, almost_all, most);
}

static void half_vector_noise_128x16x32_agrees(void **state)
{
    (void)state;
    check_relative("half-vector noise 128x16x32", half_noise(128, 16, 32, 15, 1), 0.0005, almost_all, most);
}

static void half_vector_noise_of_all_exponents_agrees(void **state)
{
    (void)state;
    struct table t = half_noise(64, 32, 8, 0, 32);
    double *e = malloc(COUNT * sizeof *e);
    for (int i = 0; i < COUNT; i++) {
        struct vec3 n, l, v;
        double largest, around;
        half_case(&n, &l, &v, i);
        e[i] = error_of(&largest, &around, &t, n, l, v) / around;
    }
    check_distribution("half-vector steep 64x32x8", e, 0.00005, almost_all, most);
    free(e);
    table_close(&t);
}

static void half_vector_is_exactly_reciprocal(void **state)
{
    (void)state;
    struct table t = half_noise(64, 32, 8, 0, 32);
    for (int i = 0; i < COUNT; i++) {
        struct vec3 n, l, v;
        struct lut_rgb a, b;
        half_case(&n, &l, &v, i);
        if (i % 16 == 0) { /* and of any length that is safe */
            n.x += (int32_t)(random32() % 61) - 30;
            l.y += (int32_t)(random32() % 61) - 30;
            v.z += (int32_t)(random32() % 61) - 30;
        }
        unsigned fetched = lut_eval(&a, &t.lut, n, l, v);
        assert_int_equal(lut_eval(&b, &t.lut, n, v, l), fetched);
        assert_memory_equal(&a, &b, sizeof a);
    }
    table_close(&t);
}

/* The re-packed copy is another form of the same table. */
static void half_vector_slabs_change_no_bit(void **state)
{
    (void)state;
    struct table t = half_noise(32, 24, 5, 8, 12);
    struct ref_half f = {.t = 5, .h = 32, .d = 24, .texels = t.texels, .slabs = 1};
    size_t bytes;
    struct lut_table packed;
    ref_half_warp(&f, 0.05);
    void *file = ref_half_make(&f, &bytes);
    assert_int_equal(lut_open(&packed, file, bytes), LUT_OK);
    assert_non_null(packed.slabs);
    assert_null(t.lut.slabs);
    for (int i = 0; i < COUNT; i++) {
        struct vec3 n, l, v;
        struct lut_rgb a, b;
        half_case(&n, &l, &v, i);
        assert_int_equal(lut_eval(&a, &t.lut, n, l, v), lut_eval(&b, &packed, n, l, v));
        assert_memory_equal(&a, &b, sizeof a);
    }
    free(file);
    table_close(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_361x181x4_agrees),
        cmocka_unit_test(noise_91x46x4_agrees),
        cmocka_unit_test(noise_of_all_exponents_91x46x4_agrees),
        cmocka_unit_test(noise_2x2x1_agrees),
        cmocka_unit_test(lobe_361x181x4_agrees),
        cmocka_unit_test(lobe_181x91x7_agrees),
        cmocka_unit_test(noise_181x91x7_with_swap_agrees),
        cmocka_unit_test(half_vector_rough_64x32x8_agrees),
        cmocka_unit_test(half_vector_glossy_64x32x8_agrees),
        cmocka_unit_test(half_vector_sharp_128x32x8_agrees),
        cmocka_unit_test(half_vector_21x16x3_agrees),
        cmocka_unit_test(half_vector_2x2x2_agrees),
        cmocka_unit_test(half_vector_noise_64x32x8_agrees),
        cmocka_unit_test(half_vector_noise_128x16x32_agrees),
        cmocka_unit_test(half_vector_noise_of_all_exponents_agrees),
        cmocka_unit_test(half_vector_is_exactly_reciprocal),
        cmocka_unit_test(half_vector_slabs_change_no_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
