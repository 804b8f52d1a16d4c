/* gtlut build: how far a table is from its source. */
#include <math.h>
#include <stdio.h>

#include "common.h"
#include "gtlut_build.h"
#include "gtlut_json.h"
#include "gtlut_table.h"

/* Rounding to RGB9_E5 may raise every texel by up to 2^-9 of itself: that is not the source's doing. */
static const double albedo_limit = 1 + 1.0 / 512;

struct comparison {
    double reciprocity_source, reciprocity_table; /* NaN: unknown */
    bool made_reciprocal;                         /* the source, before the table was compared with it */
    double source[TABLE_ALBEDO_ANGLES][3], table[TABLE_ALBEDO_ANGLES][3]; /* albedo */
};

static void print_text(const struct build_result *r, const struct comparison *c, const struct brdf_source *source)
{
    const struct metrics *m = &r->metrics;
    bool half = r->kind == LUT_HALF_VECTOR;
    fprintf(stderr, "%s, %u x %u x %u nodes (%s): %zu bytes, %zu in the file", half ? "half_vector" : "specular_frame",
            r->nodes[0], r->nodes[1], r->nodes[2], half ? "h, d, t" : "phi_d, theta_d, theta_in", r->table_bytes,
            r->file_bytes);
    if (r->packed_bytes)
        fprintf(stderr, ", %zu of them the re-packed copy", r->packed_bytes);
    fprintf(stderr, "; built in %.2f s\n", r->seconds);
    fprintf(stderr, "mean dE %.3g, 99th percentile %.3g, PSNR %.1f dB, against the source%s\n", m->de_mean, m->de_p99,
            m->psnr, c->made_reciprocal ? " made reciprocal" : "");
    fputs("relative error", stderr);
    for (int i = 0; i < METRICS_BANDS; i++)
        fprintf(stderr, "%s theta_in %g..%g: %.3g", i ? "," : "", metrics_band[i][0], metrics_band[i][1], m->band[i]);
    if (isnan(c->reciprocity_source))
        fputs("\nreciprocity error: source unknown, it has no pair to compare", stderr);
    else
        fprintf(stderr, "\nreciprocity error: source %.3g", c->reciprocity_source);
    fprintf(stderr, ", table %.3g\n", c->reciprocity_table);
    for (int i = 0; i < TABLE_ALBEDO_ANGLES; i++) {
        const double *t = c->table[i], *s = c->source[i];
        fprintf(stderr, "albedo at theta_in %g: %.4f %.4f %.4f, of the source %.4f %.4f %.4f\n", table_albedo_angles[i],
                t[0], t[1], t[2], s[0], s[1], s[2]);
    }
    if (source->theta_in < 89.5 || source->theta_out < 89.5)
        fprintf(stderr, "measured up to theta_in %g, theta_out %g: beyond, the source is an extrapolation itself\n",
                source->theta_in, source->theta_out);
}

static void print_json(const struct build_result *r, const struct comparison *c, const struct brdf_source *source)
{
    const struct metrics *m = &r->metrics;
    const char *kind = r->kind == LUT_HALF_VECTOR ? "half_vector" : "specular_frame";
    double nodes[3] = {r->nodes[0], r->nodes[1], r->nodes[2]};
    json_open(NULL, '{');
    json_string("kind", kind, 64);
    json_string("source", source->name, sizeof source->name);
    json_numbers("nodes", nodes, 3);
    json_integer("table_bytes", r->table_bytes);
    json_integer("packed_bytes", r->packed_bytes);
    json_integer("file_bytes", r->file_bytes);
    json_number("seconds", r->seconds);
    json_number("de_mean", m->de_mean);
    json_number("de_p99", m->de_p99);
    json_number("psnr", m->psnr);
    json_number("e_0_60", m->band[0]);
    json_number("e_60_75", m->band[1]);
    json_number("e_75_87", m->band[2]);
    json_open("reciprocity", '{');
    json_number("source", c->reciprocity_source);
    json_number("table", c->reciprocity_table);
    json_close('}');
    json_open("albedo", '[');
    for (int i = 0; i < TABLE_ALBEDO_ANGLES; i++) {
        json_open(NULL, '{');
        json_number("theta_in", table_albedo_angles[i]);
        json_numbers("source", c->source[i], 3);
        json_numbers("table", c->table[i], 3);
        json_close('}');
    }
    json_close(']');
    json_open("measured", '{');
    json_number("theta_in", source->theta_in);
    json_number("theta_out", source->theta_out);
    json_close('}');
    json_close('}');
}

void build_judge(const struct build_result *r, size_t clipped, double largest, const char *path)
{
    /* 64 steps of 2^-24, the least that a texel holds */
    bool coarse = largest < 0x1p-18;
    if ((clipped || coarse) && !(r->metrics.band[0] < 0.9))
        die(EXIT_BAD_INPUT,
            "%s: its values do not fit into texels, which hold 6e-8 to %s 1/sr (%zu clipped, the largest stored %g); "
            "is "
            "the unit 1/sr?",
            path, r->kind == LUT_HALF_VECTOR ? "4e9" : "65408", clipped, largest);
    if (coarse && largest > 0)
        warn("the largest texel is %g, steps are 6e-8: values are rounded coarsely; is the unit 1/sr?", largest);
}

/* Rounding in double is none. */
static double reciprocity_error(const struct brdf_source *f)
{
    double error = metrics_reciprocity(f);
    return error < 1e-9 ? 0 : error;
}

void build_report(const struct build_result *r, const struct brdf_source *table, const struct build_input *in,
                  bool json)
{
    const struct brdf_source *source = &in->source;
    /* The BRDF that a measurement is read as is reciprocal already: its samples are what tells. */
    struct comparison c = {.reciprocity_source = in->is_measurement ? in->reciprocity : reciprocity_error(source),
                           .reciprocity_table = reciprocity_error(table)};
    c.made_reciprocal = c.reciprocity_source >= 0.001 && (r->kind == LUT_HALF_VECTOR || in->is_measurement);
    for (int i = 0; i < TABLE_ALBEDO_ANGLES; i++) {
        metrics_albedo(c.source[i], source, table_albedo_angles[i]);
        metrics_albedo(c.table[i], table, table_albedo_angles[i]);
        const double *a = c.table[i], *s = c.source[i];
        if (fmax(a[0], fmax(a[1], a[2])) > albedo_limit)
            warn("theta_in %g: albedo %.3f %.3f %.3f is above 1, the source's is %.3f %.3f %.3f: the table creates "
                 "energy; %s",
                 table_albedo_angles[i], a[0], a[1], a[2], c.source[i][0], c.source[i][1], c.source[i][2],
                 r->kind == LUT_HALF_VECTOR || fmax(s[0], fmax(s[1], s[2])) > albedo_limit
                     ? "check the source"
                     : "was the lobe sampled too coarsely, or is --p too high?");
    }
    print_text(r, &c, source);
    if (json)
        print_json(r, &c, source);
}
