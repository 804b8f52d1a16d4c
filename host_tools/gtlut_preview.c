/* gtlut preview: pictures of a table or measurement. */
#include "gtlut_preview.h"

#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common.h"
#include "gtlut.h"
#include "gtlut_import.h"

static const char help[] =
    "Usage: gtlut preview INPUT -o FOLDER [options]\n"
    "  or:  gtlut preview INPUT --what NAME -o FILE.svg|FILE.png [options]\n"
    "\n"
    "Pictures of a table or of a measurement of any format (gtlut formats). Of a folder, or of a table of fits, a "
    "contact\n"
    "sheet of all its materials. Needs gnuplot. What a measurement or a specular-frame table lacks is hatched, or "
    "dotted\n"
    "in curves; a half-vector table does not hold what its measurement lacked.\n"
    "\n"
    "  lobe           the reflection of light from one direction, as a surface\n"
    "  plots          the plane of incidence, polar and Cartesian, for six directions of the light\n"
    "  slices         a table's texels, or a measurement's samples\n"
    "  image_slices   BRDF over theta_h and theta_d (Burley 2012); beside those of another and the difference\n"
    "  sphere         a sphere under an environment map, by numerical integration\n"
    "  sheet          the sphere of every material of a folder or of a table of fits\n"
    "\n"
    "  -o PATH             a folder, made when missing, gets lobe.png, plots.svg, ...; or the file of one picture\n"
    "  --what NAME,...     which; default all that there can be. sphere can also be an .exr: radiance, in floats\n"
    "  --against FILE      in image_slices: the table or measurement to compare with\n"
    "  --theta-in DEGREES  of the lobe, 0..89; default 45\n"
    "  --envmap FILE       equirectangular EXR or HDR, +z in its middle; default: a room with two lamps\n"
    "  --mesh FILE         an OBJ, PLY or glTF file instead of the sphere, without shadows\n"
    "  --turn DEGREES      of the mesh about the vertical axis, -360..360; default 30\n"
    "  --size N            pixels of the sphere or mesh, 8..2048; default 256, on a sheet 88\n"
    "  --exposure F        of sphere and sheet, 1e-3..1e3; default 1\n"
    "  --threads N         1..64; default: one per processor\n"
    "  --geometry NAME           minidiff or dense (default): where functions are evaluated and clouds resampled\n"
    "  --illuminant NAME, --axes WxHxN, --theta-max DEGREES   as for gtlut import\n"
    "\n"
    "Examples:\n"
    "  $ gtlut preview gold.ktx2 --against gold.csv -o gold_pictures\n"
    "  $ gtlut preview blue.bsdf --what sphere --envmap studio.exr -o blue.png\n"
    "  $ gtlut preview merl_sgd.csv --size 48 -o sheet.png\n";

enum { LOBE, PLOTS, SLICES, IMAGE_SLICES, SPHERE, SHEET, PICTURES };

static const struct {
    const char *name, *file;
} pictures[PICTURES] = {[LOBE] = {"lobe", "lobe.png"},       [PLOTS] = {"plots", "plots.svg"},
                        [SLICES] = {"slices", "slices.svg"}, [IMAGE_SLICES] = {"image_slices", "image_slices.svg"},
                        [SPHERE] = {"sphere", "sphere.png"}, [SHEET] = {"sheet", "sheet.png"}};

struct request {
    struct import_options import;
    const char *input, *output, *against, *envmap, *mesh;
    unsigned what; /* bits 1 << picture; 0: all */
    double theta_in;
    struct preview_view view;
};

static unsigned parse_what(const char *list)
{
    char *copy = xstrdup(list), *rest = copy;
    unsigned set = 0;
    for (char *name; (name = strsep(&rest, ","));) {
        int i = 0;
        while (i < PICTURES && strcmp(name, pictures[i].name))
            i++;
        if (i == PICTURES)
            die(EXIT_USAGE, "--what: '%s' is none of lobe, plots, slices, image_slices, sphere, sheet", name);
        set |= 1u << i;
    }
    free(copy);
    return set;
}

static bool is_radiance(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot && !strcmp(dot, ".exr");
}

/* The file of a picture, malloc'd: -o itself, or in the folder that it names. */
static char *file_of(const struct request *r, int picture)
{
    if (gnuplot_draws(r->output) || (picture == SPHERE && is_radiance(r->output))) {
        if (r->what & (r->what - 1))
            die(EXIT_USAGE, "-o: '%s' is one file, --what asks for several pictures; give a folder", r->output);
        return xstrdup(r->output);
    }
    /* A folder of such a name must be there: it is rather a file of another kind that is meant. */
    const char *slash = strrchr(r->output, '/'), *dot = strrchr(slash ? slash + 1 : r->output, '.');
    struct stat st;
    if (dot && strlen(dot) > 1 && strcmp(dot, "..") && !(!stat(r->output, &st) && S_ISDIR(st.st_mode)))
        die(EXIT_USAGE,
            "-o: '%s' is neither a folder nor .svg or .png (of a sphere alone also .exr); give one of these",
            r->output);
    if (mkdir(r->output, 0777) && errno != EEXIST)
        die(EXIT_FILE, "%s: %s; give a folder that can be written", r->output, strerror(errno));
    return xasprintf("%s/%s", r->output, pictures[picture].file);
}

static void draw(const struct request *r, const struct preview_input *in, int picture)
{
    char *file = file_of(r, picture);
    if (picture == LOBE) {
        preview_lobe(&in->preview, r->theta_in, file);
    } else if (picture == PLOTS) {
        preview_plots(&in->preview, file);
    } else if (picture == SLICES) {
        preview_slices(in, file);
    } else if (picture == IMAGE_SLICES) {
        struct preview_input other;
        if (r->against)
            preview_input_open(&other, r->against, &r->import);
        preview_image_slices(&in->preview, r->against ? &other.preview : NULL, file);
        if (r->against)
            preview_input_close(&other);
    } else {
        preview_sphere(&in->preview, &r->view, file);
    }
    free(file);
}

static void draw_one(struct request *r)
{
    struct preview_input in;
    if (r->what >> SHEET & 1)
        die(EXIT_USAGE, "--what: a sheet is of a folder or a table of fits, %s is neither", r->input);
    preview_input_open(&in, r->input, &r->import);
    if (!r->what) {
        r->what = is_radiance(r->output) ? 1u << SPHERE : (1u << SHEET) - 1;
        if (!in.is_table && !in.preview.samples.count)
            r->what &= ~(1u << SLICES);
    }
    for (int i = 0; i < SHEET; i++)
        if (r->what >> i & 1)
            draw(r, &in, i);
    preview_input_close(&in);
}

struct materials {
    char **paths;
    const struct import_options *import;
};

struct opening {
    const struct materials *materials;
    const char *path;
    struct preview_input in;
};

static void open_input(void *ctx)
{
    struct opening *o = ctx;
    preview_input_open(&o->in, o->path, o->materials->import);
}

/* One bad file among many is left out. */
static bool open_material(struct preview *out, const void *ctx, size_t i)
{
    const struct materials *m = ctx;
    struct opening o = {.materials = m, .path = m->paths[i]};
    if (!survives(open_input, &o)) {
        warn("%s: left out of the sheet", o.path);
        return false;
    }
    if (o.in.is_table)
        table_close(&o.in.table);
    *out = o.in.preview;
    return true;
}

static void draw_many(struct request *r, char **paths, size_t count)
{
    if (r->what & ~(1u << SHEET))
        die(EXIT_USAGE, "--what: of a folder or a table of fits there is only the sheet; give one material");
    r->what = 1u << SHEET;
    char *file = file_of(r, SHEET);
    struct materials materials = {paths, &r->import};
    preview_sheet(open_material, &materials, count, &r->view, file);
    for (size_t i = 0; i < count; i++)
        free(paths[i]);
    free(file);
}

static void take_option(struct request *r, int c)
{
    if (gtlut_import_option(&r->import, c))
        return;
    if (c == 'o')
        r->output = optarg;
    else if (c == 'w')
        r->what = parse_what(optarg);
    else if (c == 'a')
        r->against = optarg;
    else if (c == 'i')
        r->theta_in = parse_double("--theta-in", optarg, 0, 89);
    else if (c == 'e')
        r->envmap = optarg;
    else if (c == 'm')
        r->mesh = optarg;
    else if (c == 'u')
        r->view.turn = parse_double("--turn", optarg, -360, 360);
    else if (c == 's')
        r->view.size = (int)parse_long("--size", optarg, 8, 2048);
    else if (c == 'f')
        r->view.exposure = parse_double("--exposure", optarg, 1e-3, 1e3);
    else
        r->view.threads = (int)parse_long("--threads", optarg, 1, 64);
}

int gtlut_preview(int argc, char **argv)
{
    static const struct option options[] = {{"what", required_argument, 0, 'w'},
                                            {"against", required_argument, 0, 'a'},
                                            {"theta-in", required_argument, 0, 'i'},
                                            {"envmap", required_argument, 0, 'e'},
                                            {"mesh", required_argument, 0, 'm'},
                                            {"turn", required_argument, 0, 'u'},
                                            {"size", required_argument, 0, 's'},
                                            {"exposure", required_argument, 0, 'f'},
                                            {"threads", required_argument, 0, 'n'},
                                            GTLUT_IMPORT_OPTIONS,
                                            {0}};
    struct request r = {.import = {.theta_max = 60, .geometry = measurement_geometry_find("dense")},
                        .theta_in = 45,
                        .view = {.exposure = 1, .turn = 30}};
    struct environment environment;
    struct mesh mesh;
    for (int c; (c = gtlut_option(argc, argv, options, help)) != -1;)
        take_option(&r, c);
    r.input = gtlut_argument(argc, argv, "table or measurement");
    gtlut_need_output(r.output);

    char **paths;
    size_t count = preview_input_list(&paths, r.input);
    if (r.envmap)
        environment_read(&environment, r.envmap);
    else
        preview_studio(&environment);
    if (r.mesh) {
        mesh_load(&mesh, r.mesh);
        r.view.mesh = &mesh;
    }
    if (!r.view.size)
        r.view.size = count ? 88 : 256;
    r.view.environment = &environment;
    r.view.coarseness = is_radiance(r.output) ? 1 : 4; /* figures, pictures */
    if (count)
        draw_many(&r, paths, count);
    else
        draw_one(&r);
    free(paths);
    environment_free(&environment);
    if (r.mesh)
        mesh_free(&mesh);
    return EXIT_OK;
}
