/* gtlut fit: an analytic material that comes nearest to a measurement. */
#include "gtlut.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "common.h"
#include "gtlut_import.h"
#include "gtlut_json.h"
#include "host_fit.h"
#include "host_metrics.h"
#include "host_resample.h"

static const char help[] =
    "Usage: gtlut fit FILE --model lafortune_phong|blinn_phong|ggx [options]\n"
    "\n"
    "Finds the parameters of an analytic model that come nearest to a measurement or table of any format (gtlut "
    "formats):\n"
    "least squares of the cube root of the BRDF times cos(theta_out), nearly as bright as it looks, within the bounds "
    "of\n"
    "a scene file, from several starts. Prints the material as it stands in a scene file, then the error: relative, "
    "of\n"
    "these roots, over all measured samples; and the colour difference of three pictures of a sphere.\n"
    "\n"
    "  --model NAME    lafortune_phong, blinn_phong or ggx (metallic_roughness of a scene file)\n"
    "  --seed N        of the starts and of the choice of samples; default 1\n"
    "  --json          one object: material, error, mean_de, samples, agreed\n"
    "  --geometry NAME           minidiff or dense (default): where functions are evaluated and clouds resampled\n"
    "  --illuminant NAME, --axes WxHxN, --theta-max DEGREES   as for gtlut import\n"
    "\n"
    "Examples:\n"
    "  $ gtlut fit gold.csv --model ggx\n"
    "  $ gtlut fit gold.gtm --model lafortune_phong --json\n";

static void print_material(const char *key, const struct fit *fit, const char *source)
{
    static const char *const names[FIT_MODELS] = {"lafortune_phong", "blinn_phong", "metallic_roughness"};
    const char *colon = strrchr(source, ':'); /* FILE.csv:NAME */
    source = colon ? colon + 1 : source;
    const char *dot = strrchr(source, '.');
    size_t length = dot && dot > source ? (size_t)(dot - source) : strlen(source);
    json_open(key, '{');
    json_string("name", source, length < 15 ? length : 15); /* what a scene file takes */
    json_string("model", names[fit->model], strlen(names[fit->model]));
    if (fit->model == FIT_GGX) {
        json_numbers("base_color", fit->parameter, 3);
        json_number("metalness", fit->parameter[3]);
        json_number("roughness", fit->parameter[4]);
    } else {
        json_numbers("kd", fit->parameter, 3);
        json_numbers("ks", fit->parameter + 3, 3);
        json_number("exponent", fit->parameter[6]);
    }
    json_close('}');
}

int gtlut_fit(int argc, char **argv)
{
    static const struct option options[] = {{"model", required_argument, 0, 'm'},
                                            {"seed", required_argument, 0, 's'},
                                            {"json", no_argument, 0, 'j'},
                                            GTLUT_IMPORT_OPTIONS,
                                            {0}};
    struct import_options o = {.theta_max = 60, .geometry = measurement_geometry_find("dense")};
    const char *model = NULL;
    long seed = 1;
    bool json = false;
    for (int c; (c = gtlut_option(argc, argv, options, help)) != -1;) {
        if (gtlut_import_option(&o, c))
            continue;
        if (c == 'o')
            die(EXIT_USAGE, "-o: fit prints to stdout; leave it out");
        if (c == 'm')
            model = optarg;
        else if (c == 's')
            seed = parse_long("--seed", optarg, 0, 0x7fffffff);
        else
            json = true;
    }
    const char *input = gtlut_argument(argc, argv, "file");
    if (!model)
        die(EXIT_USAGE, "no model; give --model lafortune_phong, blinn_phong or ggx");
    enum fit_model which = fit_model_find(model);

    struct measurement m;
    struct measurement_grid grid;
    struct fit fit;
    struct brdf_source truth, fitted;
    struct metrics metrics;
    import_read(&m, input, &o);
    gtlut_import_grid(&m, &o, input);
    measurement_grid_make(&grid, &m, input);
    fit_make(&fit, which, &grid, (uint64_t)seed, input);
    source_from_grid(&truth, &grid, m.source);
    fit_source(&fitted, &fit);
    metrics_pictures(&metrics, &fitted, &truth);
    if (json)
        json_open(NULL, '{');
    print_material(json ? "material" : NULL, &fit, m.source);
    if (json) {
        json_number("error", fit.error);
        json_number("mean_de", metrics.de_mean);
        json_integer("samples", fit.samples);
        json_integer("starts", FIT_STARTS);
        json_integer("agreed", (size_t)fit.agreed);
        json_close('}');
    } else {
        printf("error: %.4f\nmean dE: %.2f\nsamples: %zu\nstarts: %d, %d ended there\n", fit.error, metrics.de_mean,
               fit.samples, FIT_STARTS, fit.agreed);
    }
    source_close(&truth);
    measurement_free(&m);
    return EXIT_OK;
}
