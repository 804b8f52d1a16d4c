/*
 * Directions in no order, brought to an instrument's grid: what is between them is found, what is beyond them is marked.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "host_resample.h"
#include "importer_fixture.h"

/* A cloud of 900 directions at each of 5, 25, 45 and 65 degrees. */
static struct measurement make_cloud(void)
{
    struct measurement m;
    measurement_init(&m, "cloud");
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < SCATTERED; k++) {
            double theta, phi;
            fixture_spread(&theta, &phi, k, 80);
            const float f = (float)fixture_brdf(5 + 20 * i, theta, phi);
            measurement_add(
                &m, &(struct measurement_point){(float)(5 + 20 * i), (float)theta, (float)phi, {f, f, f}, MEASURED});
        }
    return m;
}

static void a_scattered_cloud_is_resampled_and_marked_where_it_ends(void **state)
{
    (void)state;
    struct measurement m = make_cloud(), grid;
    char *problem = measurement_grid_problem(&m);
    assert_non_null(problem);
    free(problem);
    assert_int_equal(measurement_slice_count(&m), 4);
    measurement_resample(&grid, &m, measurement_geometry_find("dense"));
    double worst = 0, sum = 0;
    size_t measured = 0;
    for (size_t i = 0; i < grid.count; i++) {
        const struct measurement_point *p = &grid.points[i];
        bool inside = p->theta_in > 4.9f && p->theta_in < 65.1f;
        if (!inside || p->theta_out > 86) {
            if (p->mark != MEASUREMENT_EXTRAPOLATED)
                fail_msg("%g %g %g is marked %u", p->theta_in, p->theta_out, p->phi_out, p->mark);
            assert_true(p->rgb[0] > 0 && p->rgb[0] < 1);
            continue;
        }
        if (p->theta_out > 56)
            continue; /* 20 degrees on is the end of the cloud of the next angle of incidence */
        if (p->mark != MEASURED)
            fail_msg("%g %g %g is marked %u", p->theta_in, p->theta_out, p->phi_out, p->mark);
        double want = fixture_brdf((double)p->theta_in, (double)p->theta_out, (double)p->phi_out);
        double error = fabs((double)p->rgb[0] - want) / want;
        worst = fmax(worst, error);
        sum += error;
        measured++;
    }
    print_message("# resampled: mean error %.4f, largest %.4f\n", sum / (double)measured, worst);
    assert_true(worst < 0.08 && sum / (double)measured < 0.01);
    measurement_free(&grid);
    measurement_free(&m);
}

static void resampling_meets_the_samples_and_keeps_constants(void **state)
{
    (void)state;
    struct measurement m = make_cloud(), grid;
    for (size_t i = 0; i < m.count; i++)
        m.points[i].rgb[0] = 0.25f;
    const struct measurement_geometry g = {"test", 5, 6, 20};
    /* one sample exactly at a grid direction of 25 degrees, far from the others in value */
    m.points[SCATTERED] = (struct measurement_point){25, 10, 90, {0.25f, 7, 1}, MEASURED};
    measurement_resample(&grid, &m, &g);
    bool met = false;
    for (size_t i = 0; i < grid.count; i++) {
        const struct measurement_point *p = &grid.points[i];
        assert_true(fabsf(p->rgb[0] - 0.25f) < 1e-6f);
        if (p->theta_in == 25 && p->theta_out == 10 && p->phi_out == 90) {
            met = true;
            assert_true(fabsf(p->rgb[1] - 7) < 0.01f);
        }
    }
    assert_true(met);
    measurement_free(&grid);
    measurement_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_scattered_cloud_is_resampled_and_marked_where_it_ends),
        cmocka_unit_test(resampling_meets_the_samples_and_keeps_constants),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
