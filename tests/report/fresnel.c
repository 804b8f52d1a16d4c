/*
 * How much of a floor's picture is gloss, by the angle from which it is seen (James 2022, 3.2).
 *
 *   report_fresnel TABLE.ktx2 R G B KS EXPONENT ROUGHNESS
 *
 * The floor is the plane y = 0 within 6 units of the origin, a point light stands one unit above the origin, the eye circles around it 7
 * units away. Stdout: CSV, a row per degree from the normal; for Blinn-Phong (kd = R G B, ks, exponent), GGX (base colour R G B,
 * roughness) and the table 1 - matte/whole: both are sums of luminance over the floor as the eye sees it, matte that of a Lambertian
 * floor of R G B. In double precision, without ambient light, from the reference models.
 */
#include "common.h"
#include "host_source.h"
#include "ref_models.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { STEPS = 400, LAST = 85 };

static double luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

/* Unit vector from p, on the floor, to q; returns the distance. z is up. */
static double direction(double d[3], const double p[2], const double q[3])
{
    d[0] = q[0] - p[0];
    d[1] = q[1] - p[1];
    d[2] = q[2];
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int k = 0; k < 3; k++)
        d[k] /= length;
    return length;
}

int main(int argc, char **argv)
{
    static const double n[3] = {0, 0, 1}, lamp[3] = {0, 0, 1};
    struct brdf_source table;
    struct ref_material models[3] = {
        {.kind = REF_LAMBERT}, {.kind = REF_BLINN_PHONG}, {.kind = REF_METALLIC_ROUGHNESS}};
    common_set_name("report_fresnel", NULL);
    if (argc != 8)
        die(EXIT_USAGE, "usage: report_fresnel TABLE.ktx2 R G B KS EXPONENT ROUGHNESS");
    source_open(&table, argv[1]);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            models[i].kd[k] = atof(argv[2 + k]);
            models[i].ks[k] = atof(argv[5]);
        }
    models[1].exponent = atof(argv[6]);
    models[2].roughness = atof(argv[7]);
    puts("angle,blinn_phong,ggx,measured");
    for (int angle = 0; angle <= LAST; angle++) {
        const double a = angle * 3.14159265358979323846 / 180, eye[3] = {7 * sin(a), 0, 7 * cos(a)};
        double sum[4] = {0};
        for (int i = 0; i < STEPS; i++)
            for (int j = 0; j < STEPS; j++) {
                const double p[2] = {6 * ((2 * i + 1.0) / STEPS - 1), 6 * ((2 * j + 1.0) / STEPS - 1)};
                double l[3], v[3], f[3];
                if (p[0] * p[0] + p[1] * p[1] > 36)
                    continue;
                const double far = direction(l, p, lamp), eye_far = direction(v, p, eye);
                /* irradiance, times the solid angle in which the eye sees the place */
                const double weight = l[2] / (far * far) * v[2] / (eye_far * eye_far);
                for (int m = 0; m < 3; m++) {
                    ref_model_value(f, &models[m], n, l, v);
                    sum[m] += weight * luminance(f);
                }
                table.value(f, table.ctx, l, v);
                sum[3] += weight * luminance(f);
            }
        printf("%d,%.4f,%.4f,%.4f\n", angle, 1 - sum[0] / sum[1], 1 - sum[0] / sum[2], 1 - sum[0] / sum[3]);
    }
    source_close(&table);
    return EXIT_OK;
}
