/*
 * Reflectance models in double precision from their definitions, the exact terms that real-time models approximate, and the
 * albedo of any of them by numerical integration. Vectors are of unit length.
 */
#ifndef REF_MODELS_H
#define REF_MODELS_H

enum ref_model_kind {
    REF_LAMBERT,         /* kd/pi */
    REF_LAFORTUNE_PHONG, /* kd/pi + ks (n+2)/(2 pi) max(v.r, 0)^n: Lafortune and Willems 1994 */
    REF_PHONG, /* (kd + ks max(v.r, 0)^n / n.l)/pi: Phong 1975, reflected light per irradiance/pi divided by n.l */
    REF_BLINN_PHONG,        /* (kd + ks max(n.h, 0)^n / n.l)/pi: Blinn 1977, James 2022, eq. 1.6 */
    REF_METALLIC_ROUGHNESS, /* James 2022, listings 2 to 7: GGX, Schlick's Fresnel term, Hammon's masking approximation */
    REF_MICROFACET /* GGX, height-correlated Smith masking, Fresnel's equations: what the one above approximates */
};

struct ref_material {
    int measured; /* 1: table `slot`; 0: a model */
    enum ref_model_kind kind;
    unsigned slot;
    double kd[3], ks[3], exponent; /* kd is the base colour of the last two */
    double metalness;              /* of REF_METALLIC_ROUGHNESS */
    double roughness;              /* of the last two: alpha = roughness^2 */
    double eta[3], k[3];           /* of REF_MICROFACET; k of 0: a dielectric with a diffuse part kd/pi (1-F) */
    char name[17];
};

/* f(l,v); 0 where n.l <= 0. The last two take |n.v|. */
void ref_model_value(double rgb[3], const struct ref_material *m, const double n[3], const double l[3],
                     const double v[3]);

/* Blinn-Phong under one light: kd max(n.l, 0) + ks max(n.h, 0)^n, what multiplies irradiance/pi. 0 for l = -v; 0^0 = 0. */
void ref_blinn_phong(double rgb[3], const struct ref_material *m, const double n[3], const double l[3],
                     const double v[3]);

/* --- the terms; cosines of the angle to the facet's normal (Fresnel) or to the surface's (the others) --- */

double ref_fresnel_schlick(double f0, double cosine); /* Schlick 1994 */
double ref_fresnel_dielectric(double eta, double cosine);
double ref_fresnel_conductor(double eta, double k, double cosine);

/* eta of a dielectric with this reflectance at normal incidence. */
double ref_eta_of_f0(double f0);

double ref_ggx(double alpha, double nh); /* Walter et al. 2007, eq. 33 */

/* G / (4 n.l n.v): height-correlated Smith (Heitz 2014, eq. 99), and Hammon's approximation (2017; James 2022, listing 4). */
double ref_visibility_smith(double alpha, double nl, double nv);
double ref_visibility_hammon(double alpha, double nl, double nv);

/* --- lights --- */

/* Irradiance of a point light on a surface facing it, over its intensity: min(1/max(d, 0.01)^2 clamp(1-(d/radius)^4, 0, 1)^2, 1)
 * (James 2022, listing 10). */
double ref_attenuation(double distance, double radius);

/* --- albedo --- */

/* A BRDF for unit vectors above the horizon. */
typedef void ref_brdf_function(double rgb[3], const void *context, const double n[3], const double l[3],
                               const double v[3]);

/* One of a struct ref_material, and one of a struct ref_table. */
void ref_brdf_of_material(double rgb[3], const void *material, const double n[3], const double l[3], const double v[3]);
void ref_brdf_of_table(double rgb[3], const void *table, const double n[3], const double l[3], const double v[3]);

/* The share of the light from `theta` radians off the normal that is reflected: the integral of f n.v over all v, by
 * steps x steps half vectors, dense around the normal. 256 steps: within 0.1 % for lobes of 0.003 rad and wider. */
void ref_albedo(double rgb[3], ref_brdf_function *brdf, const void *context, double theta, int steps);

#endif
