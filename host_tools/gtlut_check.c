/* gtlut check: is a measurement complete, plausible, and a BRDF at all? */
#include "gtlut.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "gtlut_check.h"
#include "gtlut_import.h"
#include "gtlut_json.h"
#include "host_check.h"

static const char help[] =
    "Usage: gtlut check FILE [options]\n"
    "\n"
    "Looks for what is wrong or missing in a measurement of any format (gtlut formats): coverage of angles (phi_out "
    "at\n"
    "most 30 degrees apart, a fifth of the hemisphere), values that are negative or not finite, outliers, "
    "reciprocity,\n"
    "energy, a blind spot around the light, and whether the values are a BRDF or were multiplied or divided by the "
    "cosine\n"
    "once too often. Exit code 11 when something is wanting.\n"
    "\n"
    "  --json                    one object on stdout instead of lines\n"
    "  --plot PATH               also draw a page: PATH.svg, or check.svg in a folder; needs gnuplot\n"
    "  --max-reciprocity E       largest relative error between f(l,v) and f(v,l) that passes, 0..2; default 0.25\n"
    "  --repair -o FILE          also write a measurement file in which gaps, outliers and the blind spot are filled "
    "by\n"
    "                            interpolation and marked, negative values are 0, and a cosine is undone\n"
    "  --geometry NAME           minidiff or dense (default): where functions are evaluated and clouds resampled\n"
    "  --illuminant NAME, --axes WxHxN, --theta-max DEGREES   as for gtlut import\n"
    "\n"
    "Examples:\n"
    "  $ gtlut check gold.csv\n"
    "  $ gtlut check gold.csv --plot gold.svg --repair -o gold.gtm\n";

/* Whether each is wanting is decided here, once, for text, JSON and exit code. */
enum { COVERAGE, FINITE, NEGATIVE, OUTLIERS, BLIND, RECIPROCITY, ENERGY, QUANTITY, SUBJECTS };

static const char *const subject_names[SUBJECTS] = {"coverage",   "finite",      "negative", "outliers",
                                                    "blind_spot", "reciprocity", "energy",   "quantity"};

static const char *const quantity_texts[] = {
    [CHECK_BRDF] = "BRDF",
    [CHECK_TIMES_COSINE] = "BRDF times cos(theta_out): divide by the cosine once",
    [CHECK_OVER_COSINE] = "BRDF divided by cos(theta_out): the division was done once too often",
    [CHECK_UNCLEAR] = "unclear: neither reciprocity nor the trend towards grazing angles tells"};
static const char *const quantity_names[] = {"brdf", "times_cosine", "over_cosine", "unclear"};

/* Above 1, what the sum over one-degree cells of a lobe as narrow as those may overstate. */
static const double energy_limit = 1.02;

static unsigned wanting(const struct check *c, double max_reciprocity)
{
    bool is[SUBJECTS] = {
        [COVERAGE] = c->grid_problem || c->coverage_problem || c->missing || c->doubled,
        [FINITE] = c->nan + c->infinite > 0,
        [NEGATIVE] = c->negative > 0,
        [OUTLIERS] = c->outliers > 0,
        [BLIND] = c->blind > 0,
        [RECIPROCITY] = c->reciprocity[0] > max_reciprocity,
        [ENERGY] = check_albedo_max(c) > energy_limit,
        [QUANTITY] = c->quantity == CHECK_TIMES_COSINE || c->quantity == CHECK_OVER_COSINE,
    };
    unsigned set = 0;
    for (int i = 0; i < SUBJECTS; i++)
        set |= is[i] ? 1u << i : 0;
    return set;
}

static bool creates_energy(const struct check_slice *s)
{
    const double *a = s->albedo_carried;
    return fmax(a[0], fmax(a[1], a[2])) > energy_limit;
}

__attribute__((format(printf, 3, 4))) static void line(unsigned set, int subject, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    printf("%-8s %-12s ", set >> subject & 1 ? "WANTING" : "ok", subject_names[subject]);
    vprintf(format, args);
    putchar('\n');
    va_end(args);
}

static void print_text(const struct check *c, unsigned set)
{
    if (c->irregular)
        line(set, COVERAGE, "%zu scattered samples", c->irregular);
    for (size_t i = 0; i < c->count; i++) {
        const struct check_slice *s = &c->slices[i];
        line(0, COVERAGE,
             "theta_in %g: theta_out %g..%g (%zu), phi_out %g..%g (%zu), %.1f %% of the hemisphere measured",
             s->theta_in, s->theta_out[0], s->theta_out[s->theta_count - 1], s->theta_count, s->phi_out[0],
             s->phi_out[s->phi_count - 1], s->phi_count, 100 * s->covered);
    }
    if (c->grid_problem)
        line(set, COVERAGE, "%s", c->grid_problem);
    if (c->coverage_problem)
        line(set, COVERAGE, "%s", c->coverage_problem);
    line(c->missing || c->doubled ? set : 0, COVERAGE,
         "%zu samples missing, %zu twice, %zu extrapolated, %zu filled in before", c->missing, c->doubled,
         c->extrapolated, c->filled);
    line(set, FINITE, "%zu samples not a number, %zu infinite", c->nan, c->infinite);
    line(set, NEGATIVE, "%zu samples below 0", c->negative);
    line(set, OUTLIERS, "%zu samples far from their neighbours", c->outliers);
    if (c->blind)
        line(set, BLIND, "%.1f degrees around the light hold nothing: %zu samples", c->blind_radius, c->blind);
    else
        line(set, BLIND, "none");
    if (c->reciprocal_pairs)
        line(set, RECIPROCITY, "relative error %.3f over %zu pairs; divided by cos(theta_out) %.3f, multiplied %.3f",
             c->reciprocity[0], c->reciprocal_pairs, c->reciprocity[1], c->reciprocity[2]);
    else
        line(set, RECIPROCITY, "no pairs of directions to compare");
    for (size_t i = 0; i < c->count; i++) {
        const double *a = c->slices[i].albedo, *b = c->slices[i].albedo_carried;
        line(creates_energy(&c->slices[i]) ? 1u << ENERGY : 0, ENERGY,
             "theta_in %g: albedo %.3f %.3f %.3f measured, %.3f %.3f %.3f carried on to the horizon",
             c->slices[i].theta_in, a[0], a[1], a[2], b[0], b[1], b[2]);
    }
    char exponent[32] = "unknown", trend[32] = "unknown";
    if (isfinite(c->exponent))
        snprintf(exponent, sizeof exponent, "%.2f", c->exponent);
    if (isfinite(c->trend))
        snprintf(trend, sizeof trend, "%.2f", c->trend);
    line(set, QUANTITY, "%s (exponent of the cosine %s by reciprocity, %s by trend)", quantity_texts[c->quantity],
         exponent, trend);
}

static void print_json_slice(const struct check_slice *s)
{
    json_open(NULL, '{');
    json_number("theta_in", s->theta_in);
    json_number("theta_out_first", s->theta_out[0]);
    json_number("theta_out_last", s->theta_out[s->theta_count - 1]);
    json_number("covered", s->covered);
    json_numbers("albedo", s->albedo, 3);
    json_numbers("albedo_carried", s->albedo_carried, 3);
    json_close('}');
}

static void print_json(const struct check *c, unsigned set, const char *source)
{
    json_open(NULL, '{');
    json_string("source", source, strlen(source));
    json_open("wanting", '[');
    for (int i = 0; i < SUBJECTS; i++)
        if (set >> i & 1)
            json_string(NULL, subject_names[i], strlen(subject_names[i]));
    json_close(']');
    json_integer("points", c->points);
    json_integer("scattered", c->irregular);
    json_integer("not_a_number", c->nan);
    json_integer("infinite", c->infinite);
    json_integer("negative", c->negative);
    json_integer("doubled", c->doubled);
    json_integer("missing", c->missing);
    json_integer("outliers", c->outliers);
    json_integer("extrapolated", c->extrapolated);
    json_integer("filled", c->filled);
    json_integer("blind", c->blind);
    json_number("covered_least", c->covered_least);
    json_number("phi_gap", c->phi_gap);
    json_number("blind_radius", c->blind_radius);
    json_integer("reciprocal_pairs", c->reciprocal_pairs);
    json_number("reciprocity", c->reciprocity[0]);
    json_number("reciprocity_divided", c->reciprocity[1]);
    json_number("reciprocity_multiplied", c->reciprocity[2]);
    json_number("exponent", c->exponent);
    json_number("trend", c->trend);
    json_string("quantity", quantity_names[c->quantity], strlen(quantity_names[c->quantity]));
    json_open("slices", '[');
    for (size_t i = 0; i < c->count; i++)
        print_json_slice(&c->slices[i]);
    json_close(']');
    json_close('}');
}

static void repair(struct check *c, const char *source, const char *output)
{
    struct measurement m;
    size_t filled = check_repair(c, false);
    if (filled)
        warn("%zu samples filled by interpolation and marked", filled);
    if (c->quantity == CHECK_TIMES_COSINE || c->quantity == CHECK_OVER_COSINE)
        warn("values %s by cos(theta_out)", c->quantity == CHECK_TIMES_COSINE ? "divided" : "multiplied");
    check_measurement(&m, c, source);
    char *problem = measurement_grid_problem(&m);
    if (problem)
        die(EXIT_BAD_INPUT, "%s: %s; this cannot be repaired: gtlut import --geometry resamples", source, problem);
    measurement_write(&m, output);
    measurement_free(&m);
}

int gtlut_check(int argc, char **argv)
{
    static const struct option options[] = {{"json", no_argument, 0, 'j'},
                                            {"plot", required_argument, 0, 'p'},
                                            {"max-reciprocity", required_argument, 0, 'm'},
                                            {"repair", no_argument, 0, 'r'},
                                            GTLUT_IMPORT_OPTIONS,
                                            {0}};
    struct import_options o = {.theta_max = 60, .geometry = measurement_geometry_find("dense"), .raw = true};
    const char *output = NULL, *plot = NULL;
    bool json = false, repairs = false;
    double max_reciprocity = 0.25;
    for (int c; (c = gtlut_option(argc, argv, options, help)) != -1;) {
        if (gtlut_import_option(&o, c))
            continue;
        if (c == 'o')
            output = optarg;
        else if (c == 'p')
            plot = optarg;
        else if (c == 'm')
            max_reciprocity = parse_double("--max-reciprocity", optarg, 0, 2);
        else
            *(c == 'j' ? &json : &repairs) = true;
    }
    const char *input = gtlut_argument(argc, argv, "file");
    if (repairs)
        gtlut_need_output(output);
    else if (output)
        die(EXIT_USAGE, "-o: only with --repair");
    if (json && repairs && !strcmp(output, "-"))
        die(EXIT_USAGE, "-o: stdout holds the JSON; give a file");

    struct measurement m;
    struct check c;
    import_read(&m, input, &o);
    check_make(&c, &m, o.geometry);
    unsigned set = wanting(&c, max_reciprocity);
    if (json)
        print_json(&c, set, m.source);
    else if (!output || strcmp(output, "-"))
        print_text(&c, set);
    if (plot)
        check_plot(&c, m.source, plot);
    if (repairs)
        repair(&c, m.source, output);
    check_free(&c);
    measurement_free(&m);
    return set ? EXIT_WANTING : EXIT_OK;
}
