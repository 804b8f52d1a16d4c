/*
 * How far tables are from a material.
 *
 *   report_errors SOURCE TABLE.ktx2...
 *
 * A line per table: `FILE de_mean A de_p99 B psnr C`, on host_metrics.h's pictures of a sphere, against the source's symmetric part, which is
 * what any table can hold.
 */
#include "common.h"
#include "host_metrics.h"

#include <stdio.h>

int main(int argc, char **argv)
{
    struct brdf_source source, truth;
    common_set_name("report_errors", NULL);
    if (argc < 3)
        die(EXIT_USAGE, "usage: report_errors SOURCE TABLE.ktx2...");
    source_open(&source, argv[1]);
    source_make_symmetric(&truth, &source);
    for (int i = 2; i < argc; i++) {
        struct brdf_source table;
        struct metrics m = {0};
        source_open(&table, argv[i]);
        metrics_pictures(&m, &table, &truth);
        printf("%s de_mean %.4f de_p99 %.4f psnr %.2f\n", argv[i], m.de_mean, m.de_p99, m.psnr);
        source_close(&table);
    }
    source_close(&source);
    return EXIT_OK;
}
