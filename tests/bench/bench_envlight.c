/*
 * How far directional lights made from an environment map are from the map: rows of results.csv on stdout.
 *
 *   bench_envlight
 *
 * The maps of the folder GONIOTILE_DATA (default ../shared/data), white Lambert and measured materials, K lights; `mean` is over
 * all of them. Without the folder only a comment line is printed. What is compared: tests/unit/envlight_fixture.h.
 */
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "common.h"
#include "tests/unit/envlight_fixture.h"

enum { MAPS = 3, MATERIALS = 7, COUNTS = 5 };
static const char *const maps[MAPS] = {"studio", "sunset", "warehouse"};
/* Names of results.csv, and files. */
static const char *const materials[MATERIALS][2] = {
    {"lambert", NULL},
    {"paper_white", "paper_white_rgb.bsdf"},
    {"colodur_napoli_4f", "colodur_napoli_4f_rgb.bsdf"},
    {"satin_rosaline", "satin_rosaline_rgb.bsdf"},
    {"cc_ibiza_sunset", "cc_ibiza_sunset_rgb.bsdf"},
    {"green_latex", "merl_sgd.csv:green-latex"},
    {"silver_paint", "merl_sgd.csv:silver-paint"},
};
static const unsigned counts[COUNTS] = {4, 8, 16, 32, 64};

static void print(const char *map, const char *material, unsigned count, double de)
{
    printf("envlight,x86-64,%s_%s,k_%u,de_mean,%.4g,CIE76\n", map, material, count, de);
    fflush(stdout);
}

int main(void)
{
    double sum[COUNTS] = {0};
    static struct envlight_picture picture;
    const char *folder = getenv("GONIOTILE_DATA");
    if (!folder)
        folder = "../shared/data";
    common_set_name("bench_envlight", NULL);
    if (access(folder, R_OK)) {
        printf("# environment light: no folder %s\n", folder);
        return 0;
    }
    for (int m = 0; m < MAPS; m++) {
        struct envmap_light lights[COUNTS][ENVMAP_MAX_LIGHTS];
        struct environment e;
        char *path = xasprintf("%s/envmaps/%s_256.exr", folder, maps[m]);
        environment_read(&e, path);
        free(path);
        for (int k = 0; k < COUNTS; k++)
            if (envmap_lights(lights[k], counts[k], &e) != counts[k])
                die(EXIT_INTERNAL, "%s: fewer than %u lights", maps[m], counts[k]);
        for (int i = 0; i < MATERIALS; i++) {
            struct brdf_source f = {.value = envlight_white};
            if (materials[i][1]) {
                path = xasprintf("%s/brdf/%s", folder, materials[i][1]);
                source_open(&f, path);
                free(path);
            }
            envlight_reference(&picture, &e, &f, 1);
            for (int k = 0; k < COUNTS; k++) {
                double de = envlight_difference(&picture, lights[k], counts[k], &f);
                print(maps[m], materials[i][0], counts[k], de);
                sum[k] += de / (MAPS * MATERIALS);
            }
            source_close(&f);
        }
        environment_free(&e);
    }
    for (int k = 0; k < COUNTS; k++)
        print("all", "mean", counts[k], sum[k]);
    return 0;
}
