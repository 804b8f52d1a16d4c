/*
 * The analytic materials of the virtual instrument: a rough dielectric or conductor interface (GGX, Walter et al. 2007, with
 * height-correlated Smith masking, Heitz 2014, and exact Fresnel reflectance) over a diffuse base, and a sheen lobe.
 */
#ifndef HOST_TOOLS_GTLUT_MATERIALS_H
#define HOST_TOOLS_GTLUT_MATERIALS_H

#include <stddef.h>

struct material {
    const char *name, *description;
    double base[3];  /* diffuse reflectance under the interface; 0 for metals */
    double n[3];     /* refractive index at about 630, 532 and 465 nm; 1 is no interface */
    double k[3];     /* extinction coefficient; 0 for dielectrics */
    double alpha;    /* GGX roughness, 0.005..1 */
    double sheen[3]; /* weight of a broad grazing lobe (fibres), 0..1 */
};

extern const struct material materials[];
extern const size_t material_count;

/* Dies with EXIT_USAGE when there is none of that name. */
const struct material *material_find(const char *name);

/* A material ready for evaluation. */
struct material_surface {
    const struct material *m;
    double base[3]; /* BRDF of the diffuse base but for the transmission in and out */
};

void material_prepare(struct material_surface *out, const struct material *m);

/* BRDF in 1/sr for unit vectors with positive z, the normal. */
void material_value(double rgb[3], const struct material_surface *s, const double l[3], const double v[3]);

#endif
