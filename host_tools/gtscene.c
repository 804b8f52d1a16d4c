/* gtscene: meshes and a scene description become the scene blob that the device renders. */
#include "common.h"
#include "goniotile_version.h"
#include "gtscene_blob.h"
#include "gtscene_envmap.h"
#include "host_model.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "Usage: gtscene COMMAND [options]\n"
    "\n"
    "From meshes and a description of a scene to the blob that the device renders.\n"
    "\n"
    "Commands:\n"
    "  build SCENE.json -o SCENE.blob   make a scene blob\n"
    "  info SCENE.blob                  check and describe one\n"
    "\n"
    "'gtscene COMMAND --help' explains one. Exit codes: 0 ok, 1 internal, 2 usage, 3 file cannot be read or written,\n"
    "4 bad input file.\n"
    "\n"
    "Examples:\n"
    "  $ gtscene build six_models.json -o six_models.blob\n"
    "  $ gtscene info six_models.blob\n";

static void print_build_help(void)
{
    printf("Usage: gtscene build SCENE.json -o SCENE.blob [options]\n"
           "\n"
           "Builds the scene blob: meshes become small meshlets with quantised positions and normals.\n"
           "\n"
           "Options:\n"
           "  -o, --output FILE       the blob; - is standard output\n"
           "      --data FOLDER       where mesh files are that do not lie relative to the scene file\n"
           "      --lod-error PIXELS  draw the coarsest level of detail whose error on the screen is at most this,\n"
           "                          0 to 64 (the scene file's, else 0.5); 0 draws the finest\n"
           "      --no-lod            store the finest level only\n"
           "      --normal-error DEGREES  split meshlets until interpolated normals stray by less (0.4; 0.01 to 90):\n"
           "                          less is truer on coarsely curved meshes, more makes a smaller blob\n"
           "      --envmap FILE       add the light of an environment map (equirectangular EXR or HDR; its centre\n"
           "                          lies at +z, 90 degrees to the left of it +x) as directional lights\n"
           "      --envmap-lights K   so many of them, 4 to 64 (16); each costs what any light costs\n"
           "      --envmap-scale X    factor on the map's radiance, 1e-6 to 1e6 (1); a radiance of 1 from\n"
           "                          everywhere shows white diffuse as display white\n"
           "      --envmap-rotate DEGREES  turn the map about +y, its centre from +z towards +x, -360 to 360 (0)\n"
           "      --help              this text\n"
           "\n"
           "Models of materials: " MODEL_NAMES ".\n"
           "Lights: directional (direction, irradiance) or of type point (position, power, radius).\n"
           "Mesh files: .obj .ply .gltf .glb.\n"
           "\n"
           "Built-in shapes and their parameters (default; range):\n");
    for (const struct shape *s = shapes; s->name; s++) {
        printf("  %-13s %s\n", s->name, s->what);
        for (int i = 0; i < SHAPE_MAX_PARAMETERS && s->parameters[i].name; i++) {
            const struct shape_parameter *p = &s->parameters[i];
            printf("      %-9s %g; %g to %g%s\n", p->name, p->value, p->lo, p->hi, p->whole ? ", whole" : "");
        }
    }
    puts("\nExamples:\n"
         "  $ gtscene build six_models.json -o six_models.blob\n"
         "  $ gtscene build spot.json --data meshes --lod-error 1 -o spot.blob\n"
         "  $ gtscene build spot.json --data meshes --envmap studio.exr --envmap-lights 32 -o spot.blob");
}

static int run_build(int argc, char **argv)
{
    static const struct option options[] = {{"output", required_argument, NULL, 'o'},
                                            {"data", required_argument, NULL, 'd'},
                                            {"lod-error", required_argument, NULL, 'e'},
                                            {"no-lod", no_argument, NULL, 'n'},
                                            {"normal-error", required_argument, NULL, 'r'},
                                            {"envmap", required_argument, NULL, 'E'},
                                            {"envmap-lights", required_argument, NULL, 'K'},
                                            {"envmap-scale", required_argument, NULL, 'S'},
                                            {"envmap-rotate", required_argument, NULL, 'R'},
                                            {"help", no_argument, NULL, 'h'},
                                            {NULL, 0, NULL, 0}};
    const char *output = NULL, *data = NULL, *envmap_option = NULL;
    struct envmap_options envmap = {.lights = 16, .scale = 1};
    double lod_error = -1; /* as the scene file says */
    struct pack_options pack = {.with_levels = true, .normal_error = 0.4};
    for (int c; (c = getopt_long(argc, argv, "o:h", options, NULL)) != -1;) {
        if (c == 'h') {
            print_build_help();
            return EXIT_OK;
        }
        if (c == 'o')
            output = optarg;
        else if (c == 'd')
            data = optarg;
        else if (c == 'e')
            lod_error = parse_double("--lod-error", optarg, 0, 64);
        else if (c == 'n')
            pack.with_levels = false;
        else if (c == 'r')
            pack.normal_error = parse_double("--normal-error", optarg, 0.01, 90);
        else if (c == 'E')
            envmap.path = optarg;
        else if (c == 'K')
            envmap.lights =
                (unsigned)parse_long(envmap_option = "--envmap-lights", optarg, ENVMAP_MIN_LIGHTS, ENVMAP_MAX_LIGHTS);
        else if (c == 'S')
            envmap.scale = parse_double(envmap_option = "--envmap-scale", optarg, 1e-6, 1e6);
        else if (c == 'R')
            envmap.degrees = parse_double(envmap_option = "--envmap-rotate", optarg, -360, 360);
        else
            return EXIT_USAGE;
    }
    pack.normal_error *= 3.14159265358979323846 / 180;
    if (optind != argc - 1)
        die(EXIT_USAGE, "%d scene files given, 1 wanted; see gtscene build --help", argc - optind);
    if (!output)
        die(EXIT_USAGE, "no output file; give one with -o");
    if (envmap_option && !envmap.path)
        die(EXIT_USAGE, "%s: is for an environment map; give --envmap FILE", envmap_option);
    struct scene_desc desc;
    size_t bytes;
    desc_load(&desc, argv[optind], data);
    if (envmap.path)
        envmap_add(&desc, &envmap);
    if (lod_error >= 0)
        desc.lod_error = (uq16_16_t)lrint(lod_error * 65536);
    void *blob = blob_build(&bytes, &desc, &pack);
    write_file(output, blob, bytes);
    free(blob);
    return EXIT_OK;
}

static int run_info(int argc, char **argv)
{
    static const struct option options[] = {{"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};
    for (int c; (c = getopt_long(argc, argv, "h", options, NULL)) != -1;) {
        if (c != 'h')
            return EXIT_USAGE;
        printf("Usage: gtscene info SCENE.blob\n"
               "\n"
               "Checks a scene blob as the device does and prints what it holds.\n"
               "\n"
               "Examples:\n"
               "  $ gtscene info six_models.blob\n");
        return EXIT_OK;
    }
    if (optind != argc - 1)
        die(EXIT_USAGE, "%d scene blobs given, 1 wanted; see gtscene info --help", argc - optind);
    size_t bytes;
    struct scene s;
    void *blob = read_file(argv[optind], SCENE_MAX_BYTES, &bytes);
    enum scene_status status = scene_open_bounded(&s, blob, bytes);
    if (status != SCENE_OK)
        die(EXIT_BAD_INPUT, "%s: %s (%zu bytes); build it again", argv[optind], scene_status_text(status), bytes);
    blob_print(&s);
    free(blob);
    return EXIT_OK;
}

int main(int argc, char **argv)
{
    const char *command = argc > 1 ? argv[1] : "";
    common_set_name("gtscene", NULL);
    if (!strcmp(command, "--help") || !strcmp(command, "-h")) {
        fputs(help, stdout);
        return EXIT_OK;
    }
    if (!strcmp(command, "--version")) {
        printf("gtscene " GONIOTILE_VERSION "\n");
        return EXIT_OK;
    }
    common_set_name("gtscene", command);
    if (!strcmp(command, "build"))
        return run_build(argc - 1, argv + 1);
    if (!strcmp(command, "info"))
        return run_info(argc - 1, argv + 1);
    common_set_name("gtscene", NULL);
    die(EXIT_USAGE, "'%s' is not a command; see gtscene --help", command);
}
