/* lut_open and lut_eval against the double-precision reference, on tables of several sizes and contents. */
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

/* Takes over `texels`. */
static struct table table_open(unsigned width, unsigned height, unsigned depth, uint32_t *texels, unsigned theta_max)
{
    struct table t = {.texels = texels};
    t.file = ref_ktx2_make(width, height, depth, texels, theta_max, &t.bytes);
    assert_int_equal(lut_open(&t.lut, t.file, t.bytes), LUT_OK);
    t.ref = ref_table_open(t.file, t.bytes);
    assert_non_null(t.ref);
    return t;
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

/* Error of one evaluation beyond the result's last place (2^-21 of the largest node around it), in units of that
 * node times n.l. */
static double error_of(const struct table *t, struct vec3 n, struct vec3 l, struct vec3 v)
{
    struct lut_rgb out;
    double exact[3], worst = 0;
    double dn[3] = {n.x, n.y, n.z}, dl[3] = {l.x, l.y, l.z}, dv[3] = {v.x, v.y, v.z};
    double largest = ref_table_eval(exact, t->ref, dn, dl, dv);
    assert_int_equal(lut_eval(&out, &t->lut, n, l, v), 8);
    for (int c = 0; c < 3; c++) {
        assert_true(out.c[c] < 1u << 21);
        worst = fmax(worst, fabs(ldexp(out.c[c], out.e) - exact[c]) - 0x1p-21 * largest);
    }
    return worst / (largest * fx_dot(n, l) * 0x1p-30);
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Directions all over the sphere, and a third of them near the mirror direction. */
static void check_errors(const char *name, struct table t, double p50, double p999, double max)
{
    enum { COUNT = 100000 };
    double *e = malloc(COUNT * sizeof *e);
    for (int i = 0; i < COUNT;) {
        struct vec3 n = random_direction(), l = random_direction(), v = random_direction();
        double nl = fx_dot(n, l) * 0x1p-30;
        if (i % 3 == 0) {
            v = near_to(quantise(2 * nl * n.x - l.x, 2 * nl * n.y - l.y, 2 * nl * n.z - l.z), uniform(0, 0.2));
        }
        if (fx_dot(n, l) > 0 && fx_dot(n, v) > 0) {
            e[i++] = error_of(&t, n, l, v);
        }
    }
    qsort(e, COUNT, sizeof *e, compare_doubles);
    double a = e[COUNT / 2], b = e[COUNT - COUNT / 1000], c = e[COUNT - 1];
    print_message("# %s: error p50 %.5f, p99.9 %.5f, max %.5f\n", name, a, b, c);
    free(e);
    table_close(&t);
    assert_true(a <= p50 && b <= p999 && c <= max);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_361x181x4_agrees),
        cmocka_unit_test(noise_91x46x4_agrees),
        cmocka_unit_test(noise_of_all_exponents_91x46x4_agrees),
        cmocka_unit_test(noise_2x2x1_agrees),
        cmocka_unit_test(lobe_361x181x4_agrees),
        cmocka_unit_test(lobe_181x91x7_agrees),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
