/*
 * Rows of results.csv on what real-time terms lose against the exact ones, from the reference alone:
 *   schlick      against Fresnel's equations; angles 0, 1 .. 89 degrees
 *   hammon       against height-correlated Smith masking; both directions at 1, 3 .. 89 degrees
 *   albedo       of all of metallic-roughness against the exact model; light at 0, 15 .. 75 degrees
 * Errors are relative: the largest, and the mean over the angles. Columns: suite, target, case, variant, metric, value, unit.
 */
#include <math.h>
#include <stdio.h>

#include "ref_models.h"

static const double degree = 3.14159265358979323846 / 180;

struct errors {
    double largest, sum;
    int count;
};

static void add(struct errors *e, double got, double want)
{
    double error = fabs(got / want - 1);
    e->largest = fmax(e->largest, error);
    e->sum += error;
    e->count++;
}

static void print(const char *name, const char *variant, const struct errors *e)
{
    printf("shade,host,%s,%s,relative_error_max,%.4f,ratio\n", name, variant, e->largest);
    printf("shade,host,%s,%s,relative_error_mean,%.4f,ratio\n", name, variant, e->sum / e->count);
}

static void print_dielectrics(void)
{
    static const double f0[] = {0.02, 0.04, 0.08, 0.17};
    for (int i = 0; i < 4; i++) {
        char name[64];
        struct errors e = {0, 0, 0};
        for (int angle = 0; angle < 90; angle++) {
            double c = cos(angle * degree);
            add(&e, ref_fresnel_schlick(f0[i], c), ref_fresnel_dielectric(ref_eta_of_f0(f0[i]), c));
        }
        snprintf(name, sizeof name, "fresnel_f0_%g", f0[i]);
        print(name, "schlick", &e);
    }
}

/* Red, green, blue at about 650, 540 and 440 nm: Hagemann, Gudat and Kunz 1974 (DESY SR-74/7, tables 3 and 5). */
static const struct {
    const char *name;
    double eta[3], k[3];
} metals[] = {{"copper", {0.214, 1.037, 1.169}, {3.67, 2.59, 2.36}},
              {"gold", {0.487, 0.613, 1.826}, {3.31, 2.64, 1.81}},
              {"aluminium", {1.292, 0.771, 0.548}, {7.28, 5.91, 5.00}}};

static void print_metals(void)
{
    for (size_t i = 0; i < sizeof metals / sizeof *metals; i++) {
        char name[64];
        struct errors e = {0, 0, 0};
        for (int angle = 0; angle < 90; angle++)
            for (int k = 0; k < 3; k++) {
                double c = cos(angle * degree), f0 = ref_fresnel_conductor(metals[i].eta[k], metals[i].k[k], 1);
                add(&e, ref_fresnel_schlick(f0, c), ref_fresnel_conductor(metals[i].eta[k], metals[i].k[k], c));
            }
        snprintf(name, sizeof name, "fresnel_%s", metals[i].name);
        print(name, "schlick", &e);
    }
}

static const double roughness[] = {0.1, 0.3, 0.5, 0.7, 1};

static void print_masking(void)
{
    for (size_t i = 0; i < sizeof roughness / sizeof *roughness; i++) {
        char name[64];
        struct errors e = {0, 0, 0};
        double alpha = roughness[i] * roughness[i];
        for (int a = 1; a < 90; a += 2)
            for (int b = 1; b < 90; b += 2)
                add(&e, ref_visibility_hammon(alpha, cos(a * degree), cos(b * degree)),
                    ref_visibility_smith(alpha, cos(a * degree), cos(b * degree)));
        snprintf(name, sizeof name, "masking_roughness_%g", roughness[i]);
        print(name, "hammon", &e);
    }
}

static void print_albedo(void)
{
    for (size_t i = 0; i < 2 * sizeof roughness / sizeof *roughness; i++) {
        char name[64];
        struct errors e = {0, 0, 0};
        int metal = i % 2;
        double eta = ref_eta_of_f0(0.04);
        struct ref_material approximate = {.kind = REF_METALLIC_ROUGHNESS,
                                           .kd = {0.5, 0.5, 0.5},
                                           .metalness = metal,
                                           .roughness = roughness[i / 2]},
                            exact = approximate;
        exact.kind = REF_MICROFACET;
        for (int k = 0; k < 3; k++) {
            exact.eta[k] = metal ? metals[1].eta[k] : eta;
            exact.k[k] = metal ? metals[1].k[k] : 0;
            if (metal)
                approximate.kd[k] = ref_fresnel_conductor(metals[1].eta[k], metals[1].k[k], 1);
        }
        for (int angle = 0; angle < 90; angle += 15) {
            double a[3], b[3];
            ref_albedo(a, ref_brdf_of_material, &approximate, angle * degree, 192);
            ref_albedo(b, ref_brdf_of_material, &exact, angle * degree, 192);
            for (int k = 0; k < 3; k++)
                add(&e, a[k], b[k]);
        }
        snprintf(name, sizeof name, "albedo_%s_roughness_%g", metal ? "gold" : "dielectric", roughness[i / 2]);
        print(name, "metallic_roughness", &e);
    }
}

int main(void)
{
    print_dielectrics();
    print_metals();
    print_masking();
    print_albedo();
    return 0;
}
