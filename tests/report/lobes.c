/*
 * Curves of Cezner and Havran 2024, figures 3 and 6, from the specular-frame tables of the product.
 *
 *   report_lobes interpolation THETA_IN     of the cosine lobe (r.v)^20, measured at 0, 20, 40, 60 degrees
 *   report_lobes extrapolation FILE P L     of a measurement, light at 40 degrees
 *   report_lobes bezier L                   the fade b(x, l) itself
 *
 * Stdout: CSV over the angle of the outgoing direction in the plane of incidence, degrees, the mirror direction's side positive.
 */
#include "common.h"
#include "host_rgb9e5.h"
#include "host_specular_frame.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEGREE (3.14159265358979323846 / 180)

static void in_plane(double d[3], double theta)
{
    d[0] = sin(theta * DEGREE);
    d[1] = 0;
    d[2] = cos(theta * DEGREE);
}

/* (r.v)^20, r the mirror direction of light from theta_in */
static double cosine_lobe(double theta_in, const double v[3])
{
    const double rv = -sin(theta_in * DEGREE) * v[0] + cos(theta_in * DEGREE) * v[2];
    return rv > 0 ? pow(rv, 20) : 0;
}

/* A table of a measurement, as encoded as on a device. */
static void table_make(struct specular_frame *frame, struct specular_frame_table *t, struct measurement *m, double p,
                       double l)
{
    struct measurement_grid grid;
    measurement_grid_make(&grid, m, "measurement");
    specular_frame_build(frame, &grid, &(struct specular_frame_options){361, 181, p, l}, "measurement");
    measurement_grid_free(&grid);
    const size_t count = (size_t)frame->width * frame->height * frame->depth;
    uint32_t *texels = xmalloc(count * sizeof *texels);
    for (size_t i = 0; i < count; i++)
        texels[i] = rgb9e5_encode(frame->rgb + 3 * i);
    *t = (struct specular_frame_table){texels, frame->width, frame->height, frame->depth, frame->theta_max, false};
}

/* Value in the plane of incidence; green. */
static double table_value(const struct specular_frame_table *t, double theta_in, double theta)
{
    double l[3], v[3], rgb[3];
    in_plane(l, theta_in);
    in_plane(v, -theta);
    specular_frame_value(rgb, t, l, v);
    return rgb[1];
}

static void interpolation(double theta_in)
{
    struct measurement m;
    struct specular_frame frame;
    struct specular_frame_table t;
    double low = floor(theta_in / 20) * 20, share = (theta_in - low) / 20, error[2] = {0}, total = 0;
    measurement_init(&m, "cosine lobe");
    for (int in = 0; in <= 60; in += 20)
        for (int out = 0; out <= 89; out++)
            for (int phi = 0; phi < 360; phi++) {
                const double v[3] = {sin(out * DEGREE) * cos(phi * DEGREE), sin(out * DEGREE) * sin(phi * DEGREE),
                                     cos(out * DEGREE)};
                const float f = (float)cosine_lobe(in, v);
                measurement_add(
                    &m, &(struct measurement_point){
                            .theta_in = (float)in, .theta_out = (float)out, .phi_out = (float)phi, .rgb = {f, f, f}});
            }
    table_make(&frame, &t, &m, 1, 0.3);
    puts("theta,truth,specular_frame,fixed_direction,slice_below,slice_above");
    for (int theta = -89; theta <= 89; theta++) {
        double v[3];
        in_plane(v, -theta);
        const double truth = cosine_lobe(theta_in, v), below = cosine_lobe(low, v), above = cosine_lobe(low + 20, v);
        const double ours = table_value(&t, theta_in, theta), fixed = (1 - share) * below + share * above;
        error[0] += (ours - truth) * (ours - truth);
        error[1] += (fixed - truth) * (fixed - truth);
        total += truth * truth;
        printf("%d,%.5f,%.5f,%.5f,%.5f,%.5f\n", theta, truth, ours, fixed, below, above);
    }
    fprintf(stderr, "%g,%.4f,%.4f\n", theta_in, sqrt(error[0] / total), sqrt(error[1] / total));
    free((void *)t.texels);
    specular_frame_free(&frame);
    measurement_free(&m);
}

static void extrapolation(const char *path, double p, double l)
{
    struct measurement m;
    struct specular_frame frame;
    struct specular_frame_table t;
    measurement_read(&m, path);
    table_make(&frame, &t, &m, p, l);
    puts("theta,value");
    for (double theta = 0; theta < 89.9; theta += 0.5)
        printf("%g,%.6f\n", theta, table_value(&t, 40, theta));
    free((void *)t.texels);
    specular_frame_free(&frame);
    measurement_free(&m);
}

/* From the table of a constant material that was measured up to 75 degrees: what is left of it is 1 - b where p is 0. */
static void bezier(double l)
{
    struct measurement m;
    struct specular_frame frame;
    struct specular_frame_table t;
    measurement_init(&m, "constant");
    for (int out = 0; out <= 75; out++)
        for (int phi = 0; phi < 360; phi += 10)
            measurement_add(
                &m, &(struct measurement_point){.theta_out = (float)out, .phi_out = (float)phi, .rgb = {1, 1, 1}});
    table_make(&frame, &t, &m, 0, l);
    puts("x,b");
    for (int theta = 75; theta < 90; theta++) /* whole degrees are nodes */
        printf("%.4f,%.4f\n", (theta - 75) / 15.0, 1 - table_value(&t, 0, theta));
    free((void *)t.texels);
    specular_frame_free(&frame);
    measurement_free(&m);
}

int main(int argc, char **argv)
{
    common_set_name("report_lobes", NULL);
    if (argc == 3 && !strcmp(argv[1], "interpolation"))
        interpolation(atof(argv[2]));
    else if (argc == 5 && !strcmp(argv[1], "extrapolation"))
        extrapolation(argv[2], atof(argv[3]), atof(argv[4]));
    else if (argc == 3 && !strcmp(argv[1], "bezier"))
        bezier(atof(argv[2]));
    else
        die(EXIT_USAGE, "usage: report_lobes interpolation THETA_IN | extrapolation FILE P L | bezier L");
    return EXIT_OK;
}
