/*
 * Counts pixels of pictures.
 *
 *   report_pixels FILE...
 *
 * A line per picture: `FILE pixels N white W mean L`. White: all channels at their largest value. Mean: of the linear luminance,
 * 0..1, Rec. 709.
 */
#include "common.h"
#include "host_image.h"

#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
    common_set_name("report_pixels", NULL);
    if (argc < 2)
        die(EXIT_USAGE, "usage: report_pixels FILE...");
    for (int i = 1; i < argc; i++) {
        int width, height, white = 0;
        float *rgb = image_read_rgb(&width, &height, argv[i], false);
        const int count = width * height;
        double sum = 0;
        for (const float *p = rgb; p < rgb + 3 * count; p += 3) {
            white += p[0] > 0.9999f && p[1] > 0.9999f && p[2] > 0.9999f;
            sum += 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
        }
        printf("%s pixels %d white %d mean %.6f\n", argv[i], count, white, sum / count);
        free(rgb);
    }
    return EXIT_OK;
}
