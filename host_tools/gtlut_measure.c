/* gtlut measure: a virtual goniophotometer. */
#include "gtlut.h"

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "goniotile_version.h"
#include "gtlut_materials.h"
#include "host_measurement.h"

static const char help[] = "Usage: gtlut measure MATERIAL -o out.csv [options]\n"
                           "  or:  gtlut measure --list\n"
                           "\n"
                           "Samples an analytic material as a goniophotometer would and writes CSV: theta_in, "
                           "theta_out, phi_out in degrees, BRDF in\n"
                           "1/sr. Each value is the mean over a detector aperture of 1 x 1 degree.\n"
                           "\n"
                           "  -o FILE          the measurement, - for stdout\n"
                           "  --geometry NAME  minidiff: theta_in 0 20 40 60, theta_out 0..75 (default); dense: "
                           "theta_in 0 5 .. 85, theta_out 0..88;\n"
                           "                   both in steps of one degree over theta_out and phi_out 0..359\n"
                           "  --noise PERCENT  relative Gaussian noise, 0..50; default 0\n"
                           "  --seed N         of the noise; default 1\n"
                           "  --list           print the materials and exit\n"
                           "\n"
                           "Examples:\n"
                           "  $ gtlut measure --list\n"
                           "  $ gtlut measure gold -o gold.csv\n"
                           "  $ gtlut measure gold --geometry dense --noise 2 -o noisy.csv\n";

static const double pi = 3.14159265358979323846;

/* Below this roughness the lobe changes within the aperture and a single ray would misstate its energy. */
static const double smooth_alpha = 0.1;

struct text {
    char *data;
    size_t used, room;
};

/* Appends one line of at most 128 bytes. */
__attribute__((format(printf, 2, 3))) static void text_add(struct text *t, const char *format, ...)
{
    if (t->room - t->used < 129) {
        t->room = t->room ? 2 * t->room : 1 << 20;
        t->data = xrealloc(t->data, t->room);
    }
    va_list args;
    va_start(args, format);
    t->used += (size_t)vsnprintf(t->data + t->used, 129, format, args);
    va_end(args);
}

/* Mean over the aperture: a grid of rays in the plane perpendicular to the detector's direction. */
static void detector_value(double rgb[3], const struct material_surface *s, double theta_in, double theta_out,
                           double phi_out)
{
    const double degree = pi / 180;
    int rays = s->m->alpha < smooth_alpha ? 4 : 1;
    double st = sin(theta_out * degree), ct = cos(theta_out * degree), sp = sin(phi_out * degree),
           cp = cos(phi_out * degree);
    double l[3] = {sin(theta_in * degree), 0, cos(theta_in * degree)}, sum[3] = {0}, one[3];
    for (int i = 0; i < rays * rays; i++) {
        double a = ((i % rays + 0.5) / rays - 0.5) * degree, b = ((i / rays + 0.5) / rays - 0.5) * degree;
        double v[3] = {st * cp + a * ct * cp - b * sp, st * sp + a * ct * sp + b * cp, ct - a * st};
        double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        for (int c = 0; c < 3; c++)
            v[c] /= length;
        material_value(one, s, l, v);
        for (int c = 0; c < 3; c++)
            sum[c] += one[c];
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = sum[c] / (rays * rays);
}

/* splitmix64 (Steele et al. 2014) to (0, 1]. */
static double random_unit(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53 + 0x1p-54;
}

static double random_gaussian(uint64_t *state)
{
    double r = sqrt(-2 * log(random_unit(state)));
    return r * cos(2 * pi * random_unit(state));
}

static void sample_row(struct text *t, const struct material_surface *surface, double theta_in, int theta_out,
                       double noise, uint64_t *state)
{
    double row[181][3]; /* the materials are isotropic: phi and 360 - phi agree */
    for (int phi = 0; phi <= 180; phi++)
        detector_value(row[phi], surface, theta_in, theta_out, phi);
    for (int phi = 0; phi < 360; phi++) {
        const double *s = row[phi <= 180 ? phi : 360 - phi];
        double rgb[3];
        for (int c = 0; c < 3; c++)
            rgb[c] = noise > 0 ? s[c] * (1 + noise * random_gaussian(state)) : s[c];
        text_add(t, "%g,%d,%d,%.7g,%.7g,%.7g\n", theta_in, theta_out, phi, rgb[0], rgb[1], rgb[2]);
    }
}

static int list(void)
{
    for (size_t i = 0; i < material_count; i++)
        printf("%-20s %s\n", materials[i].name, materials[i].description);
    return EXIT_OK;
}

int gtlut_measure(int argc, char **argv)
{
    static const struct option options[] = {
        {"geometry", required_argument, 0, 'g'}, {"noise", required_argument, 0, 'n'},
        {"seed", required_argument, 0, 's'},     {"list", no_argument, 0, 'l'},
        {"help", no_argument, 0, 'h'},           {0}};
    const struct measurement_geometry *g = measurement_geometry_find("minidiff");
    const char *output = NULL;
    double noise = 0;
    uint64_t seed = 1;
    for (int c; (c = gtlut_option(argc, argv, options, help)) != -1;) {
        if (c == 'o')
            output = optarg;
        else if (c == 'g')
            g = measurement_geometry_find(optarg);
        else if (c == 'n')
            noise = parse_double("--noise", optarg, 0, 50) / 100;
        else if (c == 's')
            seed = (uint64_t)parse_long("--seed", optarg, 0, 0x7fffffff);
        else
            return list();
    }
    const struct material *m = material_find(gtlut_argument(argc, argv, "material"));
    gtlut_need_output(output);

    struct material_surface surface;
    material_prepare(&surface, m);
    struct text t = {0};
    text_add(&t, "# virtual goniophotometer, Goniotile gtlut " GONIOTILE_VERSION "\n");
    text_add(&t, "# material %s, geometry %s, noise %g %%, seed %llu\n", m->name, g->name, 100 * noise,
             (unsigned long long)seed);
    text_add(&t, "# angles in degrees (phi_out 180 is the mirror side), BRDF in 1/sr, linear sRGB\n");
    text_add(&t, "theta_in,theta_out,phi_out,R,G,B\n");
    for (int i = 0; i < g->theta_in_count; i++)
        for (int theta_out = 0; theta_out <= g->theta_out_max; theta_out++)
            sample_row(&t, &surface, i * g->theta_in_step, theta_out, noise, &seed);
    write_file(output, t.data, t.used);
    free(t.data);
    return EXIT_OK;
}
