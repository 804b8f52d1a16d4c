#include "gtlut_materials.h"

#include <math.h>
#include <string.h>

#include "common.h"

static const double pi = 3.14159265358979323846;

#define GREY(x)                                                                                                        \
    {                                                                                                                  \
        x, x, x                                                                                                        \
    }
#define PLASTIC GREY(1.5)
#define GOLD_N                                                                                                         \
    {                                                                                                                  \
        0.183, 0.421, 1.373                                                                                            \
    }
#define GOLD_K                                                                                                         \
    {                                                                                                                  \
        3.424, 2.346, 1.770                                                                                            \
    }
#define COPPER_N                                                                                                       \
    {                                                                                                                  \
        0.18, 1.10, 1.25                                                                                               \
    }
#define COPPER_K                                                                                                       \
    {                                                                                                                  \
        3.60, 2.78, 2.39                                                                                               \
    }
#define CHROME_N                                                                                                       \
    {                                                                                                                  \
        3.107, 3.181, 2.323                                                                                            \
    }
#define CHROME_K                                                                                                       \
    {                                                                                                                  \
        3.331, 3.329, 3.135                                                                                            \
    }

const struct material materials[] = {
    {"matte_white", "Lambertian, reflectance 0.8", GREY(0.8), GREY(1), GREY(0), 1, GREY(0)},
    {"matte_red", "Lambertian, red", {0.55, 0.05, 0.04}, GREY(1), GREY(0), 1, GREY(0)},
    {"plastic_red", "red plastic, polished", {0.60, 0.03, 0.03}, PLASTIC, GREY(0), 0.06, GREY(0)},
    {"plastic_yellow", "yellow plastic, moulded", {0.75, 0.52, 0.04}, PLASTIC, GREY(0), 0.18, GREY(0)},
    {"plastic_blue_rough", "blue plastic, sand-blasted", {0.05, 0.14, 0.65}, PLASTIC, GREY(0), 0.40, GREY(0)},
    {"ceramic_white", "glazed white ceramic", GREY(0.78), GREY(1.55), GREY(0), 0.03, GREY(0)},
    {"paint_orange", "semi-gloss orange paint", {0.75, 0.20, 0.02}, PLASTIC, GREY(0), 0.12, GREY(0)},
    {"rubber_black", "black rubber", GREY(0.02), GREY(1.5), GREY(0), 0.50, GREY(0)},
    {"satin_green",
     "green satin: coloured broad lobe and sheen",
     {0.02, 0.10, 0.03},
     {1.9, 3.2, 2.1},
     GREY(0),
     0.32,
     {0.05, 0.25, 0.08}},
    {"velvet_purple",
     "purple velvet: sheen over a dark base",
     {0.06, 0.01, 0.09},
     GREY(1),
     GREY(0),
     1,
     {0.45, 0.12, 0.60}},
    {"gold", "gold, brushed evenly", GREY(0), GOLD_N, GOLD_K, 0.20, GREY(0)},
    {"copper_satin", "copper, satin finish", GREY(0), COPPER_N, COPPER_K, 0.33, GREY(0)},
    {"chrome_satin", "chrome, satin finish", GREY(0), CHROME_N, CHROME_K, 0.12, GREY(0)},
    {"chrome_polished", "chrome with a lobe narrower than the instrument's aperture", GREY(0), CHROME_N, CHROME_K, 0.01,
     GREY(0)},
};
const size_t material_count = sizeof materials / sizeof *materials;

const struct material *material_find(const char *name)
{
    for (size_t i = 0; i < material_count; i++)
        if (!strcmp(name, materials[i].name))
            return &materials[i];
    die(EXIT_USAGE, "'%s': no such material; see gtlut measure --list", name);
}

/* Fresnel reflectance of unpolarised light, complex index n + ik against air. */
static double fresnel(double cosine, double n, double k)
{
    double c2 = cosine * cosine, s2 = 1 - c2, t = n * n - k * k - s2;
    double ab = hypot(t, 2 * n * k); /* a^2 + b^2, a + ib the refracted wave's normal component */
    double a = sqrt(fmax((ab + t) / 2, 0)), twice = 2 * a * cosine;
    double perpendicular = (ab + c2 - twice) / (ab + c2 + twice);
    double parallel = (c2 * ab + s2 * s2 - twice * s2) / (c2 * ab + s2 * s2 + twice * s2);
    return perpendicular * (1 + parallel) / 2;
}

/* Light that enters the interface, is scattered by the base, and leaves after any number of internal reflections. */
void material_prepare(struct material_surface *out, const struct material *m)
{
    out->m = m;
    for (int c = 0; c < 3; c++) {
        double n2 = m->n[c] * m->n[c], external = 0; /* hemispherical reflectance from outside */
        for (int i = 0; i < 64 && m->n[c] != 1; i++)
            external += fresnel(sqrt((i + 0.5) / 64), m->n[c], 0) / 64;
        double internal = 1 - (1 - external) / n2;
        out->base[c] = m->base[c] / (pi * n2 * (1 - m->base[c] * internal));
    }
}

void material_value(double rgb[3], const struct material_surface *s, const double l[3], const double v[3])
{
    const struct material *m = s->m;
    double h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]}, length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    double nl = l[2], nv = v[2], nh = h[2] / length, lh = fmin(length / 2, 1);
    /* Not 1 - nh^2, which cancels at the lobe's centre. */
    double sine2 = (h[0] * h[0] + h[1] * h[1]) / (length * length);
    double a2 = m->alpha * m->alpha, d = nh * nh * a2 + sine2;
    double lobe = a2 / (pi * d * d) / 2 / (nl * sqrt(a2 + (1 - a2) * nv * nv) + nv * sqrt(a2 + (1 - a2) * nl * nl));
    /* Sheen: Estevez and Kulla 2017's distribution at roughness 0.5, D = 2 sin^2 / pi, with Neubelt's visibility. */
    double sheen = 2 * sine2 / pi / (4 * (nl + nv - nl * nv));
    for (int c = 0; c < 3; c++) {
        double base = s->base[c], n = m->n[c], k = m->k[c];
        rgb[c] = m->sheen[c] * sheen;
        if (n == 1) { /* no interface */
            rgb[c] += base;
            continue;
        }
        rgb[c] += fresnel(lh, n, k) * lobe;
        if (base > 0)
            rgb[c] += base * (1 - fresnel(nl, n, k)) * (1 - fresnel(nv, n, k));
    }
}
