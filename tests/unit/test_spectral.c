/* Spectra to linear sRGB, against figures from outside the program. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "host_spectral.h"

static void a_constant_spectrum_is_neutral_under_every_illuminant(void **state)
{
    (void)state;
    static const double nm[2][4] = {{400, 500, 620, 700}, {550}};
    for (int illuminant = 0; illuminant < SPECTRAL_ILLUMINANTS; illuminant++)
        for (int k = 0; k < 2; k++) {
            struct spectral s;
            double rgb[3], values[4] = {0.3, 0.3, 0.3, 0.3};
            spectral_make(&s, nm[k], k ? 1 : 4, (enum spectral_illuminant)illuminant);
            spectral_rgb(rgb, &s, values);
            for (int c = 0; c < 3; c++)
                if (fabs(rgb[c] - 0.3) > 1e-6)
                    fail_msg("illuminant %d: %g %g %g", illuminant, rgb[0], rgb[1], rgb[2]);
            spectral_free(&s);
        }
}

/* Spectral lines of 5 nm at a table row: the chromaticity is that of the published tables. At 520 nm x = 0.0743, y = 0.8338; at 600
 * nm x = 0.6270, y = 0.3725 (CIE 015:2018, spectral chromaticities). */
static void a_spectral_line_has_its_published_chromaticity(void **state)
{
    (void)state;
    static const double want[2][3] = {{520, 0.0743, 0.8338}, {600, 0.6270, 0.3725}};
    for (int i = 0; i < 2; i++) {
        double nm[3] = {want[i][0] - 5, want[i][0], want[i][0] + 5}, values[3] = {0, 1, 0}, rgb[3];
        struct spectral s;
        spectral_make(&s, nm, 3, SPECTRAL_D65);
        spectral_rgb(rgb, &s, values);
        /* sRGB primaries (IEC 61966-2-1). */
        double x = 0.4124 * rgb[0] + 0.3576 * rgb[1] + 0.1805 * rgb[2];
        double y = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        double z = 0.0193 * rgb[0] + 0.1192 * rgb[1] + 0.9505 * rgb[2], sum = x + y + z;
        if (fabs(x / sum - want[i][1]) > 2e-3 || fabs(y / sum - want[i][2]) > 2e-3)
            fail_msg("%g nm: x %g y %g", want[i][0], x / sum, y / sum);
        spectral_free(&s);
    }
}

/* Luminance factors of a step from 0.05 to 0.8 at 590 nm, by a direct sum over the published tables. */
static void a_red_edge_is_red_and_redder_in_warm_light(void **state)
{
    (void)state;
    double nm[4] = {400, 589, 591, 700}, values[4] = {0.05, 0.05, 0.8, 0.8}, d65[3], a[3];
    struct spectral s;
    spectral_make(&s, nm, 4, SPECTRAL_D65);
    spectral_rgb(d65, &s, values);
    spectral_free(&s);
    spectral_make(&s, nm, 4, SPECTRAL_A);
    spectral_rgb(a, &s, values);
    spectral_free(&s);
    double luminance = 0.2126 * d65[0] + 0.7152 * d65[1] + 0.0722 * d65[2];
    double luminance_a = 0.2126 * a[0] + 0.7152 * a[1] + 0.0722 * a[2];
    assert_true(d65[0] > 0.5 && d65[1] < 0.15 && d65[2] < 0.1);
    assert_true(fabs(luminance - 0.2086) < 1e-3);
    assert_true(luminance_a > luminance + 0.04);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_constant_spectrum_is_neutral_under_every_illuminant),
        cmocka_unit_test(a_spectral_line_has_its_published_chromaticity),
        cmocka_unit_test(a_red_edge_is_red_and_redder_in_warm_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
