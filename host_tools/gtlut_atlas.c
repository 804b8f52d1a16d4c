/* gtlut atlas: the tables of several materials in one texture or image, and out of it again. */
#include "gtlut.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "goniotile_version.h"
#include "gtlut_json.h"
#include "gtlut_slices.h"
#include "host_atlas.h"
#include "host_image.h"
#include "host_ktx2.h"
#include "host_measurement.h"
#include "host_rgb9e5.h"

static const char help[] =
    "Usage: gtlut atlas TABLE... -o out.ktx2|.exr|.png [--exposure F]\n"
    "  or:  gtlut atlas --extract I ATLAS -o table.ktx2 [--axes WxHxN --grid CxR]\n"
    "\n"
    "Puts tables of one kind and size into one texture, every slice of which is a grid of the tables' slices, and "
    "takes\n"
    "them out again. The place of a table, counted from 0, is all that a surface has to carry: a material's slot.\n"
    "Atlases given as TABLE bring all their tables. gtlut info lists what an atlas holds; gtsim --atlas and gtusb "
    "push\n"
    "fill the device's slots from one.\n"
    "\n"
    "  -o FILE              .ktx2: the atlas; .exr or .png: its slices in one image, in row-major order\n"
    "  --exposure F         factor on an image's values, 1e-6..1e6; default 1\n"
    "  --extract I          write table I, to the byte as it went in\n"
    "  --axes WxHxN         ATLAS is an image of specular-frame tables (EXR): N slices of W x H nodes (phi_d, "
    "theta_d)\n"
    "  --grid CxR           columns and rows of tables in each slice of that image\n"
    "  --theta-max DEGREES  theta_in of that image's last slice; default 60\n"
    "\n"
    "Examples:\n"
    "  $ gtlut measure matte_white -o white.csv\n"
    "  $ gtlut build white.csv -o white.ktx2 --size 91x46 --swap\n"
    "  $ gtlut atlas gold.ktx2 white.ktx2 -o atlas.ktx2\n"
    "  $ gtlut atlas atlas.ktx2 -o atlas.png\n"
    "  $ gtlut atlas --extract 1 atlas.ktx2 -o white.ktx2\n"
    "  $ gtlut atlas atlas.ktx2 -o atlas.exr\n"
    "  $ gtlut atlas --extract 0 atlas.exr --axes 91x46x4 --grid 2x1 -o gold.ktx2\n";

struct options {
    const char *output;
    double exposure, theta_max;
    long extract;                                 /* -1: none */
    uint32_t width, height, depth, columns, rows; /* of an image; 0: not given */
};

static bool ends_in(const char *path, const char *extension)
{
    const char *dot = strrchr(path, '.');
    return dot && !strcmp(dot, extension);
}

/* --- into an atlas --- */

struct members {
    struct atlas_member *list;
    uint32_t count;
};

static void members_add(struct members *m, const char *path, uint8_t *data, size_t bytes)
{
    if (m->count == ATLAS_MAX_TABLES)
        die(EXIT_USAGE, "more than %u tables; give fewer", ATLAS_MAX_TABLES);
    m->list = xrealloc(m->list, (m->count + 1) * sizeof *m->list);
    m->list[m->count++] = (struct atlas_member){path, data, bytes};
}

/* A table, or all tables of an atlas. */
static void members_read(struct members *m, const char *path)
{
    size_t bytes;
    uint8_t *data = read_file(path, ATLAS_MAX_BYTES, &bytes);
    if (!atlas_recognise(data, bytes)) {
        members_add(m, path, data, bytes);
        return;
    }
    struct atlas a;
    atlas_open(&a, path, data, bytes);
    for (uint32_t i = 0; i < a.tables; i++) {
        size_t length;
        uint8_t *table = atlas_table(&length, &a, i);
        members_add(m, path, table, length);
    }
    free(data);
}

static void write_image(const struct options *o, const uint8_t *file, size_t bytes)
{
    struct atlas a;
    struct slices image = {0};
    atlas_open(&a, o->output, file, bytes);
    for (uint32_t i = 0; i < a.tables; i++) {
        struct lut_table t;
        size_t length;
        uint8_t *table = atlas_table(&length, &a, i);
        if (lut_open(&t, table, length))
            die(EXIT_INTERNAL, "table %u of the atlas cannot be opened", i);
        if (!i)
            slices_make(&image, a.view.width, a.view.height, a.depth, t.kind == LUT_HALF_VECTOR);
        slices_put(&image, i % a.columns * a.width, i / a.columns * a.height, &t, o->exposure);
        free(table);
    }
    slices_write(o->output, &image);
    slices_free(&image);
}

static void make_atlas(const struct options *o, char **paths, int count)
{
    struct members m = {0};
    size_t bytes;
    if (!ends_in(o->output, ".ktx2") && !ends_in(o->output, ".exr") && !ends_in(o->output, ".png"))
        die(EXIT_USAGE, "-o: '%s' does not end in .ktx2, .exr or .png", o->output);
    if (!count)
        die(EXIT_USAGE, "no table given; see gtlut atlas --help");
    for (int i = 0; i < count; i++)
        members_read(&m, paths[i]);
    uint8_t *file = atlas_compose(&bytes, m.list, m.count);
    if (ends_in(o->output, ".ktx2"))
        write_file(o->output, file, bytes);
    else
        write_image(o, file, bytes);
    for (uint32_t i = 0; i < m.count; i++)
        free((void *)m.list[i].data);
    free(m.list);
    free(file);
}

/* --- out of an atlas --- */

/* The texels of a cell of the image. */
static uint32_t *image_texels(const struct options *o, const char *path)
{
    int w, h;
    float *pixels = image_read_rgb(&w, &h, path, true);
    const size_t slice_width = (size_t)o->columns * o->width, slice_height = (size_t)o->rows * o->height;
    const size_t columns = (size_t)w / slice_width, rows = (size_t)h / slice_height;
    if (columns * slice_width != (size_t)w || rows * slice_height != (size_t)h || columns * rows < o->depth ||
        columns * rows - o->depth >= columns)
        die(EXIT_BAD_INPUT,
            "%s: %d x %d pixels do not hold %u slices of %zu x %zu in full rows; correct --axes, --grid", path, w, h,
            o->depth, slice_width, slice_height);
    uint32_t *texels = xmalloc((size_t)o->width * o->height * o->depth * sizeof *texels), *t = texels;
    const size_t x0 = (size_t)o->extract % o->columns * o->width, y0 = (size_t)o->extract / o->columns * o->height;
    for (size_t z = 0; z < o->depth; z++)
        for (size_t y = 0; y < o->height; y++) {
            const float *p =
                pixels + 3 * ((z / columns * slice_height + y0 + y) * (size_t)w + z % columns * slice_width + x0);
            for (size_t x = 0; x < o->width; x++, p += 3) {
                if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]))
                    die(EXIT_BAD_INPUT, "%s: table %ld holds a value that is not finite; repair the image", path,
                        o->extract);
                *t++ = rgb9e5_encode((double[3]){(double)p[0], (double)p[1], (double)p[2]});
            }
        }
    free(pixels);
    return texels;
}

static uint8_t *image_table(size_t *bytes, const struct options *o, const char *path)
{
    struct measurement m;
    measurement_init(&m, path); /* reduces the path to what a file may carry */
    char *theta_max = xasprintf("%ld", lround(1e3 * (o->depth > 1 ? o->theta_max : 90)));
    const struct ktx2_pair pairs[] = {{"KTXwriter", "Goniotile gtlut " GONIOTILE_VERSION, 0},
                                      {"goniotile.kind", "specular_frame", 0},
                                      {"goniotile.source", m.source, 0},
                                      {"goniotile.theta_max", theta_max, 0},
                                      {"goniotile.version", "1", 0}};
    uint32_t *texels = image_texels(o, path);
    uint8_t *file = ktx2_compose(bytes, texels, o->width, o->height, o->depth, pairs, sizeof pairs / sizeof *pairs);
    free(texels);
    free(theta_max);
    measurement_free(&m);
    return file;
}

static void check_index(const struct options *o, const char *path, uint32_t tables)
{
    if (o->extract >= (long)tables)
        die(EXIT_USAGE, "--extract %ld: %s has tables 0 to %u", o->extract, path, tables - 1);
}

static void extract_table(const struct options *o, const char *path)
{
    struct atlas a;
    size_t bytes, length;
    uint8_t *table;
    if (o->width && o->columns) {
        check_index(o, path, o->columns * o->rows);
        table = image_table(&length, o, path);
    } else {
        uint8_t *data = read_file(path, ATLAS_MAX_BYTES, &bytes);
        atlas_open(&a, path, data, bytes);
        check_index(o, path, a.tables);
        table = atlas_table(&length, &a, (uint32_t)o->extract);
        free(data);
    }
    write_file(o->output, table, length);
    free(table);
}

/* --- description --- */

/* Metadata of a table file that lut_open has accepted. */
static const char *source_of(const uint8_t *table, size_t bytes, uint32_t *length)
{
    struct ktx2_view view;
    const uint8_t *source = ktx2_open(&view, table, bytes) ? NULL : ktx2_find(&view, "goniotile.source", length);
    if (!source)
        *length = 0;
    return source ? (const char *)source : "";
}

static void print_atlas(const struct atlas *a, enum lut_kind kind, size_t bytes)
{
    printf("kind: atlas, %s\nbytes: %zu\ntables: %u in %u columns\ntexels of a table: %u x %u x %u\n",
           kind == LUT_HALF_VECTOR ? "half vector" : "specular frame", bytes, a->tables, a->columns, a->width,
           a->height, a->depth);
}

static void json_atlas(const struct atlas *a, enum lut_kind kind, size_t bytes)
{
    const double texels[3] = {a->width, a->height, a->depth};
    json_open(NULL, '{');
    json_string("kind", "atlas", 5);
    json_string("table_kind", kind == LUT_HALF_VECTOR ? "half_vector" : "specular_frame", 16);
    json_integer("bytes", bytes);
    json_integer("columns", a->columns);
    json_numbers("texels", texels, 3);
    json_open("sources", '[');
}

void gtlut_atlas_describe(const char *path, void *data, size_t bytes, bool json)
{
    struct atlas a;
    atlas_open(&a, path, data, bytes);
    for (uint32_t i = 0; i < a.tables; i++) {
        struct lut_table t = {0};
        size_t table_bytes;
        uint32_t length;
        uint8_t *table = atlas_table(&table_bytes, &a, i);
        lut_open(&t, table, table_bytes);
        if (!i)
            (json ? json_atlas : print_atlas)(&a, t.kind, bytes);
        const char *source = source_of(table, table_bytes, &length);
        if (json)
            json_string(NULL, source, length);
        else
            printf("table %u: %.*s\n", i, (int)length, source);
        free(table);
    }
    if (json) {
        json_close(']');
        json_close('}');
    }
    free(data);
}

static void parse_grid(struct options *o, const char *text)
{
    char tail;
    if (sscanf(text, "%3ux%3u%c", &o->columns, &o->rows, &tail) != 2 || !o->columns || !o->rows)
        die(EXIT_USAGE, "--grid: '%s' is not COLUMNSxROWS with 1 to 999 of each", text);
}

static void parse_axes(struct options *o, const char *text)
{
    char tail;
    if (sscanf(text, "%4ux%4ux%4u%c", &o->width, &o->height, &o->depth, &tail) != 3 || o->width < 2 || o->height < 2 ||
        !o->depth || o->width > KTX2_MAX_EXTENT || o->height > KTX2_MAX_EXTENT || o->depth > KTX2_MAX_EXTENT ||
        (size_t)o->width * o->height * o->depth > KTX2_MAX_TEXELS)
        die(EXIT_USAGE, "--axes: '%s' is not WIDTHxHEIGHTxSLICES with 2 to %u nodes and at most %u in all", text,
            KTX2_MAX_EXTENT, KTX2_MAX_TEXELS);
}

int gtlut_atlas(int argc, char **argv)
{
    static const struct option options[] = {{"exposure", required_argument, 0, 'e'},
                                            {"extract", required_argument, 0, 'i'},
                                            {"axes", required_argument, 0, 'x'},
                                            {"grid", required_argument, 0, 'g'},
                                            {"theta-max", required_argument, 0, 't'},
                                            {"help", no_argument, 0, 'h'},
                                            {0}};
    struct options o = {.exposure = 1, .theta_max = 60, .extract = -1};
    for (int c; (c = gtlut_option(argc, argv, options, help)) != -1;) {
        if (c == 'o')
            o.output = optarg;
        else if (c == 'e')
            o.exposure = parse_double("--exposure", optarg, 1e-6, 1e6);
        else if (c == 'i')
            o.extract = parse_long("--extract", optarg, 0, ATLAS_MAX_TABLES - 1);
        else if (c == 'x')
            parse_axes(&o, optarg);
        else if (c == 'g')
            parse_grid(&o, optarg);
        else
            o.theta_max = parse_double("--theta-max", optarg, 0.1, 90);
    }
    gtlut_need_output(o.output);
    if (o.extract < 0) {
        make_atlas(&o, argv + optind, argc - optind);
        return EXIT_OK;
    }
    if (!o.width != !o.columns)
        die(EXIT_USAGE, "--axes and --grid go together; an image needs both, a .ktx2 atlas neither");
    extract_table(&o, gtlut_argument(argc, argv, "atlas"));
    return EXIT_OK;
}
