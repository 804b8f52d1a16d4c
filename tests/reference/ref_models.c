#include "ref_models.h"

#include <complex.h>
#include <math.h>

#include "ref_table.h"

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* max(x, 0)^n, 0^0 = 0. */
static double lobe(double x, double n)
{
    return x > 0 ? pow(x, n) : 0;
}

static double mix(double a, double b, double share)
{
    return (1 - share) * a + share * b;
}

/* (l+v)/|l+v|; 0 for l = -v. */
static void half_vector(double h[3], const double l[3], const double v[3])
{
    for (int i = 0; i < 3; i++)
        h[i] = l[i] + v[i];
    double length = sqrt(dot(h, h));
    for (int i = 0; i < 3; i++)
        h[i] = length > 0 ? h[i] / length : 0;
}

double ref_fresnel_schlick(double f0, double cosine)
{
    return f0 + (1 - f0) * pow(1 - cosine, 5);
}

/* Unpolarised: the mean of both polarisations, |n_1 cos_1 - n_2 cos_2|^2 / |n_1 cos_1 + n_2 cos_2|^2 and the same with cosines
 * exchanged; n sin is the same on both sides. */
static double fresnel(double complex n, double cosine)
{
    double complex inside = csqrt(n * n - (1 - cosine * cosine)) / n;
    double across = cabs((cosine - n * inside) / (cosine + n * inside));
    double along = cabs((inside - n * cosine) / (inside + n * cosine));
    return (across * across + along * along) / 2;
}

double ref_fresnel_dielectric(double eta, double cosine)
{
    return fresnel(eta, cosine);
}

double ref_fresnel_conductor(double eta, double k, double cosine)
{
    return fresnel(eta + k * I, cosine);
}

double ref_eta_of_f0(double f0)
{
    return (1 + sqrt(f0)) / (1 - sqrt(f0));
}

double ref_ggx(double alpha, double nh)
{
    double theta = acos(fmin(nh, 1)), t = tan(theta) / alpha;
    return nh > 0 ? 1 / (M_PI * alpha * alpha * pow(cos(theta), 4) * (1 + t * t) * (1 + t * t)) : 0;
}

/* Walter et al. 2007, eq. 34 as 1/(1 + lambda). */
static double smith_lambda(double alpha, double cosine)
{
    double t = alpha * tan(acos(fmin(cosine, 1)));
    return (sqrt(1 + t * t) - 1) / 2;
}

double ref_visibility_smith(double alpha, double nl, double nv)
{
    return 1 / (1 + smith_lambda(alpha, nl) + smith_lambda(alpha, nv)) / (4 * nl * nv);
}

double ref_visibility_hammon(double alpha, double nl, double nv)
{
    return 0.5 / mix(2 * nl * nv, nl + nv, alpha);
}

static void metallic_roughness(double rgb[3], const struct ref_material *m, const double n[3], const double l[3],
                               const double v[3])
{
    double h[3], alpha = m->roughness * m->roughness;
    half_vector(h, l, v);
    double lobe_value = ref_ggx(alpha, dot(n, h)) * ref_visibility_hammon(alpha, dot(n, l), fabs(dot(n, v)));
    for (int c = 0; c < 3; c++) {
        double f = ref_fresnel_schlick(mix(0.04, m->kd[c], m->metalness), fmax(dot(h, l), 0));
        rgb[c] = f * lobe_value + (1 - f) * (1 - m->metalness) * m->kd[c] / M_PI;
    }
}

static void microfacet(double rgb[3], const struct ref_material *m, const double n[3], const double l[3],
                       const double v[3])
{
    double h[3], alpha = m->roughness * m->roughness;
    half_vector(h, l, v);
    double lobe_value = ref_ggx(alpha, dot(n, h)) * ref_visibility_smith(alpha, dot(n, l), fabs(dot(n, v)));
    for (int c = 0; c < 3; c++) {
        double f = ref_fresnel_conductor(m->eta[c], m->k[c], fmax(dot(h, l), 0));
        rgb[c] = f * lobe_value + (m->k[c] > 0 ? 0 : (1 - f) * m->kd[c] / M_PI);
    }
}

void ref_blinn_phong(double rgb[3], const struct ref_material *m, const double n[3], const double l[3],
                     const double v[3])
{
    double h[3];
    half_vector(h, l, v);
    for (int c = 0; c < 3; c++)
        rgb[c] = m->kd[c] * fmax(dot(n, l), 0) + m->ks[c] * lobe(dot(n, h), m->exponent);
}

void ref_model_value(double rgb[3], const struct ref_material *m, const double n[3], const double l[3],
                     const double v[3])
{
    double nl = dot(n, l), r[3];
    rgb[0] = rgb[1] = rgb[2] = 0;
    if (nl <= 0)
        return;
    for (int i = 0; i < 3; i++)
        r[i] = 2 * nl * n[i] - l[i];
    double phong = lobe(dot(v, r), m->exponent);
    switch (m->kind) {
    case REF_LAMBERT:
    case REF_LAFORTUNE_PHONG:
        phong *= m->kind == REF_LAMBERT ? 0 : (m->exponent + 2) / (2 * M_PI);
        for (int c = 0; c < 3; c++)
            rgb[c] = m->kd[c] / M_PI + m->ks[c] * phong;
        break;
    case REF_PHONG:
        for (int c = 0; c < 3; c++)
            rgb[c] = (m->kd[c] + m->ks[c] * phong / nl) / M_PI;
        break;
    case REF_BLINN_PHONG:
        ref_blinn_phong(rgb, m, n, l, v);
        for (int c = 0; c < 3; c++)
            rgb[c] /= nl * M_PI;
        break;
    case REF_METALLIC_ROUGHNESS:
        metallic_roughness(rgb, m, n, l, v);
        break;
    case REF_MICROFACET:
        microfacet(rgb, m, n, l, v);
        break;
    }
}

double ref_attenuation(double distance, double radius)
{
    double near = fmax(distance, 0.01), window = fmin(fmax(1 - pow(distance / radius, 4), 0), 1);
    return fmin(window * window / (near * near), 1);
}

void ref_brdf_of_material(double rgb[3], const void *material, const double n[3], const double l[3], const double v[3])
{
    ref_model_value(rgb, material, n, l, v);
}

void ref_brdf_of_table(double rgb[3], const void *table, const double n[3], const double l[3], const double v[3])
{
    ref_table_eval(rgb, table, n, l, v);
}

/* With v the reflection of l at h, dv = 4 (l.h) dh. theta_h = width sinh(u ...) spreads the steps evenly below the width and in
 * equal ratios above it. */
void ref_albedo(double rgb[3], ref_brdf_function *brdf, const void *context, double theta, int steps)
{
    const double n[3] = {0, 0, 1}, l[3] = {sin(theta), 0, cos(theta)}, width = 1e-3;
    double range = asinh(M_PI / 2 / width);
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int i = 0; i < steps; i++) {
        double u = (i + 0.5) / steps * range, theta_h = width * sinh(u);
        double ring = width * cosh(u) * range / steps * sin(theta_h) * 2 * M_PI / steps;
        for (int j = 0; j < steps; j++) {
            double phi = (j + 0.5) / steps * 2 * M_PI, v[3], f[3];
            double h[3] = {sin(theta_h) * cos(phi), sin(theta_h) * sin(phi), cos(theta_h)};
            double lh = dot(l, h);
            for (int c = 0; c < 3; c++)
                v[c] = 2 * lh * h[c] - l[c];
            if (lh <= 0 || v[2] <= 0)
                continue;
            brdf(f, context, n, l, v);
            for (int c = 0; c < 3; c++)
                rgb[c] += f[c] * v[2] * 4 * lh * ring;
        }
    }
}
