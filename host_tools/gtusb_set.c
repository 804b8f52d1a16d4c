/* `select`, `set` and `reset`: what the device draws, from where and how bright, until it is reset. */
#define _GNU_SOURCE
#include "gtusb.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_model.h"
#include "raster.h"

#define MAX_COORDINATE 32767.0 /* of q16_16_t */
#define MAX_POWER      800000  /* 4 pi times the largest intensity */
#define MAX_BRIGHT     256     /* irradiance and exposure */

static const double pi = 3.14159265358979323846;

/* Sends one setting and ends the session. */
static void set_send(uint32_t setting, const void *value, size_t bytes, const char *what)
{
    uint8_t payload[128];
    struct usb_set head = {setting};
    struct usb_info info;
    struct reply r;
    memcpy(payload, &head, sizeof head);
    memcpy(payload + sizeof head, value, bytes);
    struct link *l = device_open(&info);
    link_request(l, &r, what, USB_MSG_SET, payload, sizeof head + bytes);
    device_close(l);
}

static int32_t fixed(double x, unsigned fraction_bits)
{
    return (int32_t)lrint(ldexp(x, (int)fraction_bits));
}

static double normalize(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return length;
}

static void cross(double out[3], const double a[3], const double b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* --- set camera --- */

struct camera_args {
    double eye[3], target[3], up[3], fov, near;
    unsigned given; /* bits: eye, target, fov, near */
};

static error_t parse_camera(int key, char *arg, struct argp_state *state)
{
    struct camera_args *a = state->input;
    switch (key) {
    case 'e':
        parse_triple(a->eye, "--eye", arg, -MAX_COORDINATE, MAX_COORDINATE);
        a->given |= 1;
        return 0;
    case 'g':
        parse_triple(a->target, "--target", arg, -MAX_COORDINATE, MAX_COORDINATE);
        a->given |= 2;
        return 0;
    case 'u':
        parse_triple(a->up, "--up", arg, -MAX_COORDINATE, MAX_COORDINATE);
        return 0;
    case 'f':
        a->fov = parse_double("--fov", arg, 1, 179);
        a->given |= 4;
        return 0;
    case 'n':
        a->near = parse_double("--near", arg, 1.0 / 65536, 32767);
        a->given |= 8;
        return 0;
    case ARGP_KEY_END:
        if (a->given != 15)
            die(EXIT_USAGE, "--eye, --target, --fov and --near are all needed; give the whole camera");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* Rows right, up, back of an eye at `eye` that looks at `target` (scene.h, "Conventions"). */
static void camera_look_at(struct scene_camera *c, const struct camera_args *a)
{
    double row[3][3];
    for (int i = 0; i < 3; i++)
        row[2][i] = a->eye[i] - a->target[i];
    if (!(normalize(row[2]) > 0))
        die(EXIT_USAGE, "--eye and --target are the same point; move one");
    cross(row[0], a->up, row[2]);
    if (!(normalize(row[0]) > 1e-6))
        die(EXIT_USAGE, "--up is parallel to the viewing direction; choose another");
    cross(row[1], row[2], row[0]);
    for (int i = 0; i < 9; i++)
        c->rotation[i] = fixed(row[i / 3][i % 3], 30);
    for (int i = 0; i < 3; i++)
        c->eye[i] = fixed(a->eye[i], 16);
    c->focal = (uint32_t)fixed(1 / tan(a->fov * (pi / 360)), 16);
    c->near = (uint32_t)fixed(a->near, 16);
}

static void set_camera(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"eye", 'e', "X,Y,Z", 0, "where the eye is, in world units", 0},
        {"target", 'g', "X,Y,Z", 0, "the point it looks at", 0},
        {"up", 'u', "X,Y,Z", 0, "what is up in the picture (0,1,0)", 0},
        {"fov", 'f', "DEGREES", 0, "vertical field of view, 1 to 179", 0},
        {"near", 'n', "DISTANCE", 0, "distance of the near plane, in world units", 0},
        {0}};
    static const struct argp argp = {options,
                                     parse_camera,
                                     NULL,
                                     "Moves the camera, until reset."
                                     "\vExamples:\n"
                                     "  $ gtusb set camera --eye 0,2,9 --target 0,0,0 --fov 35 --near 0.1",
                                     device_options,
                                     NULL,
                                     NULL};
    struct camera_args a = {.up = {0, 1, 0}};
    struct scene_camera camera;
    options_parse(&argp, argc, argv, &a);
    camera_look_at(&camera, &a);
    set_send(USB_SET_CAMERA, &camera, sizeof camera, "camera");
}

/* --- set light --- */

struct light_args {
    double direction[3], irradiance[3], position[3], power[3], radius;
    long index;
    unsigned given; /* bits as below */
};
enum { DIRECTION = 1, IRRADIANCE = 2, POSITION = 4, POWER = 8, RADIUS = 16 };

static error_t parse_light(int key, char *arg, struct argp_state *state)
{
    struct light_args *a = state->input;
    switch (key) {
    case 'd':
        parse_triple(a->direction, "--direction", arg, -1e6, 1e6);
        a->given |= DIRECTION;
        return 0;
    case 'i':
        parse_triple(a->irradiance, "--irradiance", arg, 0, MAX_BRIGHT);
        a->given |= IRRADIANCE;
        return 0;
    case 'x':
        parse_triple(a->position, "--position", arg, -MAX_COORDINATE, MAX_COORDINATE);
        a->given |= POSITION;
        return 0;
    case 'w':
        parse_triple(a->power, "--power", arg, 0, MAX_POWER);
        a->given |= POWER;
        return 0;
    case 'r':
        a->radius = parse_double("--radius", arg, 0.001, SCENE_MAX_RADIUS >> 16);
        a->given |= RADIUS;
        return 0;
    case ARGP_KEY_ARG:
        if (a->index >= 0)
            argp_usage(state);
        a->index = parse_long("INDEX", arg, 0, SCENE_MAX_LIGHTS - 1);
        return 0;
    case ARGP_KEY_END:
        if (a->index < 0 || (a->given != (DIRECTION | IRRADIANCE) && a->given != (POSITION | POWER | RADIUS)))
            die(EXIT_USAGE,
                "INDEX and either --direction and --irradiance, or --position, --power and --radius, are all "
                "needed; give the whole light");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static void directional_light(struct scene_light *light, struct light_args *a)
{
    if (!(normalize(a->direction) > 0))
        die(EXIT_USAGE, "--direction: 0,0,0 has none; say where the light is");
    light->kind = SCENE_LIGHT_DIRECTIONAL;
    for (int i = 0; i < 3; i++) {
        light->direction[i] = fixed(a->direction[i], 30);
        light->irradiance[i] = (uint32_t)fixed(a->irradiance[i], 16);
    }
}

static void point_light(struct scene_light *light, const struct light_args *a)
{
    light->kind = SCENE_LIGHT_POINT;
    light->radius = (uint32_t)llrint(a->radius * 65536);
    for (int i = 0; i < 3; i++) {
        light->position[i] = fixed(a->position[i], 16);
        light->irradiance[i] = (uint32_t)llrint(a->power[i] / (4 * pi) * 65536);
    }
}

static void set_light(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {0, 0, 0, 0, "A directional light:", 1},
        {"direction", 'd', "X,Y,Z", 0, "towards the light, in world space, of any length", 0},
        {"irradiance", 'i', "R,G,B", 0,
         "on a surface facing it, linear sRGB, 0 to 256; 3.14159 shows white diffuse as white", 0},
        {0, 0, 0, 0, "A point light:", 2},
        {"position", 'x', "X,Y,Z", 0, "where it is, in world units", 0},
        {"power", 'w', "R,G,B", 0,
         "into all directions, linear sRGB; 39.4784 shows white diffuse as white, one unit away", 0},
        {"radius", 'r', "DISTANCE", 0, "where its light ends", 0},
        {0}};
    static const struct argp argp = {options,
                                     parse_light,
                                     "INDEX",
                                     "Replaces light INDEX (the number of lights adds one), until reset."
                                     "\vExamples:\n"
                                     "  $ gtusb set light 0 --direction 1,1,2 --irradiance 3,3,3",
                                     device_options,
                                     NULL,
                                     NULL};
    struct light_args a = {.index = -1};
    struct {
        uint32_t index;
        struct scene_light light;
    } value = {.index = 0};
    options_parse(&argp, argc, argv, &a);
    value.index = (uint32_t)a.index;
    if (a.given & DIRECTION)
        directional_light(&value.light, &a);
    else
        point_light(&value.light, &a);
    set_send(USB_SET_LIGHT, &value, sizeof value, "light");
}

/* --- set output, set model --- */

struct output_args {
    double exposure;
    int tone;
    double background[3];
    unsigned given; /* bits: exposure, tone, background */
};

static error_t parse_output(int key, char *arg, struct argp_state *state)
{
    struct output_args *a = state->input;
    switch (key) {
    case 'x':
        a->exposure = parse_double("--exposure", arg, 0, MAX_BRIGHT);
        a->given |= 1;
        return 0;
    case 'c':
        if (strcmp(arg, "none") && strcmp(arg, "aces") && strcmp(arg, "linear"))
            die(EXIT_USAGE, "--tone: no curve '%s'; it is none, aces or linear", arg);
        a->tone = *arg == 'n' ? SCENE_TONE_NONE : *arg == 'a' ? SCENE_TONE_ACES : SCENE_TONE_LINEAR;
        a->given |= 2;
        return 0;
    case 'b':
        parse_triple(a->background, "--background", arg, 0, 255);
        a->given |= 4;
        return 0;
    case ARGP_KEY_END:
        if (a->given != 7)
            die(EXIT_USAGE, "--exposure, --tone and --background are all needed; give the whole output");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static void set_output(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"exposure", 'x', "FACTOR", 0, "multiplies every light, 0 to 256", 0},
        {"tone", 'c', "none|aces|linear", 0, "tone curve", 0},
        {"background", 'b', "R,G,B", 0, "sRGB, 0 to 255, where there is no surface", 0},
        {0}};
    static const struct argp argp = {options,
                                     parse_output,
                                     NULL,
                                     "Sets exposure, tone curve and background, until reset."
                                     "\vExamples:\n"
                                     "  $ gtusb set output --exposure 3 --tone aces --background 21,23,26",
                                     device_options,
                                     NULL,
                                     NULL};
    struct output_args a = {0};
    struct scene_output output;
    options_parse(&argp, argc, argv, &a);
    output.exposure = (uint32_t)fixed(a.exposure, 16);
    output.tone_curve = (uint8_t)a.tone;
    for (int i = 0; i < 3; i++)
        output.background[i] = (uint8_t)lrint(a.background[i]);
    set_send(USB_SET_OUTPUT, &output, sizeof output, "output");
}

static error_t parse_words(int key, char *arg, struct argp_state *state)
{
    const char **words = state->input; /* two of them */
    switch (key) {
    case ARGP_KEY_ARG:
        if (state->arg_num > 1)
            argp_usage(state);
        words[state->arg_num] = arg;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static void set_model(int argc, char **argv)
{
    static const struct argp argp = {NULL,
                                     parse_words,
                                     "measured|lafortune_phong|blinn_phong|metallic_roughness|scene",
                                     "Shades every material by one model, or each as the scene says, until reset."
                                     "\vExamples:\n"
                                     "  $ gtusb set model lafortune_phong\n"
                                     "  $ gtusb set model scene",
                                     device_options,
                                     NULL,
                                     NULL};
    const char *words[2] = {NULL, NULL};
    options_parse(&argp, argc, argv, words);
    uint32_t model = words[0] && !words[1] ? model_find(words[0]) : MODEL_OF_SCENE;
    if (model == MODEL_OF_SCENE && (!words[0] || words[1] || strcmp(words[0], "scene")))
        die(EXIT_USAGE, "no model '%s'; it is one of " MODEL_NAMES ", scene", words[0] ? words[0] : "");
    set_send(USB_SET_MODEL, &model, sizeof model, "model");
}

static void set_budget(int argc, char **argv)
{
    static const struct argp argp = {
        NULL,
        parse_words,
        "TICKS",
        "Limits a tile to TICKS of the device's clock on average (0: no limit), until reset: what "
        "does not fit is shaded at lower rates, where it is seen least. 'gtusb stats' says what "
        "tiles take and what it cost in error."
        "\vExamples:\n"
        "  $ gtusb set budget 800000",
        device_options,
        NULL,
        NULL};
    const char *words[2] = {NULL, NULL};
    options_parse(&argp, argc, argv, words);
    if (!words[0] || words[1])
        die(EXIT_USAGE, "TICKS are needed; see 'gtusb set budget --help'");
    uint32_t ticks = (uint32_t)parse_long("TICKS", words[0], 0, UINT32_MAX);
    set_send(USB_SET_BUDGET, &ticks, sizeof ticks, "budget");
}

void command_set(int argc, char **argv)
{
    static const struct {
        const char *name;
        void (*run)(int argc, char **argv);
    } settings[] = {{"camera", set_camera},
                    {"light", set_light},
                    {"output", set_output},
                    {"model", set_model},
                    {"budget", set_budget}};
    for (size_t i = 0; argc > 1 && i < sizeof settings / sizeof *settings; i++)
        if (!strcmp(argv[1], settings[i].name)) {
            argv[1] = xasprintf("gtusb set %s", settings[i].name);
            settings[i].run(argc - 1, argv + 1);
            return;
        }
    if (argc > 1 && !strcmp(argv[1], "--help")) {
        puts("Usage: gtusb set COMMAND [OPTION...]\nChanges what the device draws, until reset.\n\n"
             "Commands:\n"
             "  camera   move the camera\n"
             "  light    replace a light, or add one\n"
             "  output   set exposure, tone curve and background\n"
             "  model    shade every material by one model\n"
             "  budget   limit a tile's time\n\n"
             "'gtusb set COMMAND --help' explains one.\n\n"
             "Examples:\n"
             "  $ gtusb set model lafortune_phong\n"
             "  $ gtusb set light 0 --direction 1,1,2 --irradiance 3,3,3");
        return;
    }
    die(EXIT_USAGE, "no setting '%s'; it is one of camera, light, output, model, budget", argc > 1 ? argv[1] : "");
}

void command_select(int argc, char **argv)
{
    static const struct argp argp = {
        NULL,
        parse_words,
        "MATERIAL SLOT",
        "Lets material MATERIAL (its number in the scene) use the table in SLOT (0 to 15), until reset."
        "\vExamples:\n"
        "  $ gtusb select 0 2",
        device_options,
        NULL,
        NULL};
    const char *words[2] = {NULL, NULL};
    struct usb_select select;
    struct usb_info info;
    struct reply r;
    options_parse(&argp, argc, argv, words);
    if (!words[1])
        die(EXIT_USAGE, "MATERIAL and SLOT are needed; see 'gtusb select --help'");
    select.material = (uint16_t)parse_long("MATERIAL", words[0], 0, SCENE_MAX_MATERIALS - 1);
    select.table = (uint16_t)parse_long("SLOT", words[1], 0, RASTER_MAX_SLOTS - 1);
    struct link *l = device_open(&info);
    char *what = xasprintf("material %u, slot %u", select.material, select.table);
    link_request(l, &r, what, USB_MSG_SELECT, &select, sizeof select);
    device_close(l);
    free(what);
}

void command_reset(int argc, char **argv)
{
    static const struct argp argp = {NULL,
                                     NULL,
                                     NULL,
                                     "Lets the device forget what select and set changed; scene and tables stay."
                                     "\vExamples:\n"
                                     "  $ gtusb reset",
                                     device_options,
                                     NULL,
                                     NULL};
    struct usb_info info;
    struct reply r;
    options_parse(&argp, argc, argv, NULL);
    struct link *l = device_open(&info);
    link_request(l, &r, NULL, USB_MSG_RESET, NULL, 0);
    device_close(l);
}
