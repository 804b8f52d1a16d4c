/*
 * Mean colour difference of two pictures.
 *
 *   report_difference A.rgb B.rgb
 *
 * Files of bytes, sRGB, three a pixel. Stdout: `de_frame D de_mean E psnr P`: over all pixels; over those of A that do not have its first pixel's
 * colour, the background's; of all pixels.
 */
#include "common.h"
#include "host_metrics.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static void linear(double out[3], const uint8_t rgb[3])
{
    for (int i = 0; i < 3; i++) {
        const double x = rgb[i] / 255.0;
        out[i] = x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4); /* IEC 61966-2-1 */
    }
}

int main(int argc, char **argv)
{
    size_t bytes, other;
    double sum = 0, squares = 0, shown = 0;
    common_set_name("report_difference", NULL);
    if (argc != 3)
        die(EXIT_USAGE, "usage: report_difference A.rgb B.rgb");
    const uint8_t *a = read_file(argv[1], 64u << 20, &bytes), *b = read_file(argv[2], 64u << 20, &other);
    if (bytes != other || !bytes || bytes % 3)
        die(EXIT_BAD_INPUT, "%s: not as large as %s", argv[2], argv[1]);
    for (size_t i = 0; i < bytes; i += 3) {
        double x[3], y[3];
        linear(x, a + i);
        linear(y, b + i);
        sum += metrics_difference(x, y);
        shown += memcmp(a, a + i, 3) != 0;
        for (size_t k = i; k < i + 3; k++)
            squares += (a[k] - b[k]) * (a[k] - b[k]);
    }
    printf("de_frame %.4f de_mean %.4f psnr %.2f\n", 3 * sum / (double)bytes, sum / fmax(shown, 1),
           10 * log10(255 * 255 * (double)bytes / fmax(squares, 1e-9)));
    return EXIT_OK;
}
