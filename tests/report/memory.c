/*
 * How far every representation of a material is from it.
 *
 *   report_memory SOURCE INSTRUMENT.gtm [quick]
 *
 * Half-vector tables and errors are of SOURCE, by its symmetric part, which is what any table can hold; specular-frame tables and fitted models
 * of INSTRUMENT, the same material as the instrument of Cezner and Havran 2024 sees it. CSV: `representation,size,bytes,de_mean,de_p99,psnr`,
 * bytes of texels or of a material in a scene file, errors on host_metrics.h's pictures of a sphere. quick: the smallest sizes alone.
 */
#include "common.h"
#include "host_fit.h"
#include "host_half_vector.h"
#include "host_metrics.h"
#include "host_rgb9e5.h"
#include "host_specular_frame.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MATERIAL_BYTES = 56 };

static struct brdf_source truth;

static void print(const char *representation, const char *size, size_t bytes, const struct brdf_source *f)
{
    struct metrics m = {0};
    metrics_pictures(&m, f, &truth);
    printf("%s,%s,%zu,%.4f,%.4f,%.2f\n", representation, size, bytes, m.de_mean, m.de_p99, m.psnr);
}

static void half_vectors(const struct brdf_source *source, bool quick)
{
    for (uint32_t k = quick ? 1 : 256; k; k /= 4) {
        struct half_vector table;
        struct half_vector_report report;
        struct brdf_source f;
        char *size = xasprintf("%uK", k);
        half_vector_build(&table, &report, source, &(struct half_vector_options){.texels = 256 * k});
        half_vector_source(&f, &table, size);
        print("half_vector", size, 4 * (size_t)table.h * table.d * table.t, &f);
        half_vector_free(&table);
        free(size);
    }
}

static void specular_frames(struct measurement_grid *grid, bool quick)
{
    static const uint32_t sizes[][2] = {{12, 6}, {23, 12}, {46, 23}, {91, 46}, {181, 91}, {361, 181}};
    for (int i = quick ? 0 : 5; i >= 0; i--) {
        struct specular_frame frame;
        struct brdf_source f;
        specular_frame_build(&frame, grid, &(struct specular_frame_options){sizes[i][0], sizes[i][1], 1, 0.3},
                             "instrument");
        const size_t count = (size_t)frame.width * frame.height * frame.depth;
        uint32_t *texels = xmalloc(count * sizeof *texels);
        for (size_t k = 0; k < count; k++)
            texels[k] = rgb9e5_encode(frame.rgb + 3 * k);
        char *size = xasprintf("%ux%u", frame.width, frame.height);
        for (int swap = 0; swap < 2; swap++) {
            specular_frame_source(
                &f,
                &(struct specular_frame_table){texels, frame.width, frame.height, frame.depth, frame.theta_max, swap},
                size);
            print(swap ? "specular_frame_swap" : "specular_frame", size, 4 * count, &f);
        }
        free(size);
        free(texels);
        specular_frame_free(&frame);
    }
}

static void models(const struct measurement_grid *grid)
{
    static const char *const names[] = {"lafortune_phong", "blinn_phong", "ggx"};
    for (int i = 0; i < 3; i++) {
        struct fit fit;
        struct brdf_source f;
        fit_make(&fit, fit_model_find(names[i]), grid, 1, "instrument");
        fit_source(&f, &fit);
        print(names[i], "fit", MATERIAL_BYTES, &f);
    }
}

int main(int argc, char **argv)
{
    struct brdf_source source;
    struct measurement m;
    struct measurement_grid grid;
    common_set_name("report_memory", NULL);
    if (argc != 3 && !(argc == 4 && !strcmp(argv[3], "quick")))
        die(EXIT_USAGE, "usage: report_memory SOURCE INSTRUMENT.gtm [quick]");
    source_open(&source, argv[1]);
    source_make_symmetric(&truth, &source);
    measurement_read(&m, argv[2]);
    measurement_grid_make(&grid, &m, argv[2]);
    half_vectors(&source, argc == 4);
    models(&grid); /* before a frame averages the grid's first slice */
    specular_frames(&grid, argc == 4);
    measurement_grid_free(&grid);
    measurement_free(&m);
    source_close(&source);
    return EXIT_OK;
}
