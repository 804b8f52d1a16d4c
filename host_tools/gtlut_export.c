/* gtlut export: the texels of a table as one image. */
#include "gtlut.h"

#include "common.h"
#include "gtlut_slices.h"
#include "gtlut_table.h"

static const char help[] = "Usage: gtlut export TABLE -o out.exr|out.png [options]\n"
                           "\n"
                           "Writes all texels of a table into one image, slice by slice in row-major order.\n"
                           "\n"
                           "  specular frame   a slice per theta_in, phi_d to the right, theta_d downwards, as square "
                           "an arrangement as fits (4\n"
                           "                   slices: 2 x 2); the BRDF in 1/sr\n"
                           "  half vector      a slice per node of the difference angle, its azimuth to the right, the "
                           "half angle downwards, as\n"
                           "                   square an image as fits; the BRDF times (n.l + n.v) in 1/sr\n"
                           "\n"
                           "EXR holds the values as linear floats; PNG clamps them to 0..1 and encodes sRGB.\n"
                           "\n"
                           "  -o FILE       the image; its extension chooses the format\n"
                           "  --exposure F  factor on all values, 1e-6..1e6; default 1\n"
                           "\n"
                           "Examples:\n"
                           "  $ gtlut export gold.ktx2 -o gold.exr\n"
                           "  $ gtlut export gold.ktx2 -o gold.png --exposure 0.2\n";

#define MAX_FILE_BYTES (((size_t)4 << 24) + (1 << 20))

int gtlut_export(int argc, char **argv)
{
    static const struct option options[] = {
        {"exposure", required_argument, 0, 'e'}, {"help", no_argument, 0, 'h'}, {0}};
    const char *output = NULL;
    double exposure = 1;
    for (int c; (c = gtlut_option(argc, argv, options, help)) != -1;) {
        if (c == 'o')
            output = optarg;
        else
            exposure = parse_double("--exposure", optarg, 1e-6, 1e6);
    }
    const char *input = gtlut_argument(argc, argv, "table");
    gtlut_need_output(output);
    slices_need_image(output);

    size_t bytes;
    void *data = read_file(input, MAX_FILE_BYTES, &bytes);
    struct table_file t;
    table_open(&t, input, data, bytes);
    struct slices slices; /* the half vector's are tall and narrow */
    slices_make(&slices, t.table.width, t.table.height, t.table.depth, t.table.kind == LUT_HALF_VECTOR);
    slices_put(&slices, 0, 0, &t.table, exposure);
    slices_write(output, &slices);
    slices_free(&slices);
    table_close(&t);
    return EXIT_OK;
}
