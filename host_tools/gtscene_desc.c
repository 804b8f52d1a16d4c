#include "gtscene_desc.h"

#include "common.h"
#include "gtscene_json.h"
#include "host_model.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define KEYS(...)                                                                                                      \
    (const char *const[])                                                                                              \
    {                                                                                                                  \
        __VA_ARGS__, NULL                                                                                              \
    }
#define MAX_MESHES    4096
#define MAX_POSITION  32767
#define MAX_BRIGHT    256    /* irradiance and exposure */
#define MAX_POWER     800000 /* 4 pi times the largest intensity that the format has, 65536 */
#define MIN_ROUGHNESS (SCENE_MIN_ROUGHNESS / 65536.0)

static const double pi = 3.14159265358979323846;

static uq16_16_t to_q16(double x)
{
    return (uq16_16_t)llrint(x * 65536);
}

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static bool normalise(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3 && length > 1e-12; k++)
        v[k] /= length;
    return length > 1e-12;
}

static void unit_vector(double out[3], const struct node *n)
{
    json_vector(out, n, -1e6, 1e6);
    if (!normalise(out))
        json_die(n, "has no direction; give a vector of some length");
}

void desc_rotation(q2_30_t out[9], double rotation[3][3])
{
    for (int i = 0; i < 9; i++)
        out[i] = (q2_30_t)lrint(rotation[i / 3][i % 3] * (1 << 30));
}

/* A rotation by an angle about a unit axis (Rodrigues). */
static void axis_rotation(double out[3][3], const double axis[3], double degrees)
{
    double c = cos(degrees * pi / 180), s = sin(degrees * pi / 180);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            out[i][j] = axis[i] * axis[j] * (1 - c) + (i == j ? c : 0);
            if (i != j)
                out[i][j] += (j == (i + 1) % 3 ? -s : s) * axis[3 - i - j];
        }
}

/* {"axis": [x, y, z], "degrees": d}, or [x, y, z] in degrees: about x first, then y, then z. */
static void read_rotation(double out[3][3], const struct node *n)
{
    double axis[3] = {1, 0, 0}, angles[3] = {0, 0, 0};
    if (!n->json) {
        axis_rotation(out, axis, 0);
    } else if (cJSON_IsArray(n->json)) {
        json_vector(angles, n, -360, 360);
        axis_rotation(out, axis, angles[0]);
        for (int k = 1; k < 3; k++) {
            double about[3] = {0, k == 1, k == 2}, turn[3][3], product[3][3] = {{0}};
            axis_rotation(turn, about, angles[k]);
            for (int i = 0; i < 27; i++)
                product[i / 9][i / 3 % 3] += turn[i / 9][i % 3] * out[i % 3][i / 3 % 3];
            memcpy(out, product, sizeof product);
        }
    } else {
        json_check_keys(n, KEYS("axis", "degrees"));
        struct node about = json_need(n, "axis"), degrees = json_need(n, "degrees");
        unit_vector(axis, &about);
        axis_rotation(out, axis, json_number(&degrees, -360, 360));
    }
}

static double number_or(const struct node *n, const char *key, double otherwise, double lo, double hi)
{
    struct node member = json_get(n, key);
    return member.json ? json_number(&member, lo, hi) : otherwise;
}

/* Three values, each 0..hi; absent is `otherwise` for all. */
static void read_rgb(uq16_16_t out[3], const struct node *n, const char *key, double otherwise, double hi)
{
    struct node member = json_get(n, key);
    double rgb[3] = {otherwise, otherwise, otherwise};
    if (member.json)
        json_vector(rgb, &member, 0, hi);
    for (int k = 0; k < 3; k++)
        out[k] = to_q16(rgb[k]);
}

static void read_camera(struct scene_camera *out, const struct node *n)
{
    json_check_keys(n, KEYS("eye", "target", "up", "fov_y", "near"));
    struct node eye = json_need(n, "eye"), target = json_need(n, "target"), up = json_get(n, "up"),
                fov = json_need(n, "fov_y");
    double from[3], to[3], rotation[3][3], upward[3] = {0, 1, 0};
    json_vector(from, &eye, -MAX_POSITION, MAX_POSITION);
    json_vector(to, &target, -MAX_POSITION, MAX_POSITION);
    if (up.json)
        unit_vector(upward, &up);
    for (int k = 0; k < 3; k++) {
        out->eye[k] = (q16_16_t)lrint(from[k] * 65536);
        rotation[2][k] = from[k] - to[k];
    }
    if (!normalise(rotation[2]))
        json_die(&target, "is where the eye is; move one of them");
    cross(rotation[0], upward, rotation[2]);
    if (!normalise(rotation[0]))
        json_die(&up, "points along the view; give another direction");
    cross(rotation[1], rotation[2], rotation[0]);
    desc_rotation(out->rotation, rotation);
    out->focal = to_q16(1 / tan(json_number(&fov, 0.5, 179) * pi / 360));
    out->near = to_q16(number_or(n, "near", 0.1, 0.001, MAX_POSITION));
}

/* "#rrggbb" or [r, g, b] of 0..255. */
static void read_background(uint8_t out[3], const struct node *n)
{
    double rgb[3];
    if (cJSON_IsString(n->json)) {
        const char *s = json_string(n);
        unsigned value;
        if (strlen(s) != 7 || s[0] != '#' || strspn(s + 1, "0123456789abcdefABCDEF") != 6 ||
            sscanf(s + 1, "%x", &value) != 1)
            json_die(n, "'%s' is not a colour; write \"#rrggbb\"", s);
        for (int k = 0; k < 3; k++)
            out[k] = (uint8_t)(value >> (16 - 8 * k));
        return;
    }
    json_vector(rgb, n, 0, 255);
    for (int k = 0; k < 3; k++)
        out[k] = (uint8_t)lrint(rgb[k]);
}

static void read_output(struct scene_output *out, uq16_16_t *lod_error, const struct node *n)
{
    *lod_error = 1u << 15;
    *out = (struct scene_output){.exposure = 1u << 16, .tone_curve = SCENE_TONE_NONE};
    if (!n->json)
        return;
    json_check_keys(n, KEYS("exposure", "tone_curve", "background", "lod_error"));
    struct node curve = json_get(n, "tone_curve"), background = json_get(n, "background");
    out->exposure = to_q16(number_or(n, "exposure", 1, 0, MAX_BRIGHT));
    *lod_error = to_q16(number_or(n, "lod_error", 0.5, 0, SCENE_MAX_LOD_ERROR >> 16));
    if (curve.json) {
        const char *s = json_string(&curve);
        if (!strcmp(s, "aces"))
            out->tone_curve = SCENE_TONE_ACES;
        else if (!strcmp(s, "linear"))
            out->tone_curve = SCENE_TONE_LINEAR;
        else if (strcmp(s, "none"))
            json_die(&curve, "'%s' is no tone curve; give none, aces or linear", s);
    }
    if (background.json)
        read_background(out->background, &background);
}

/* Irradiance directly, or colour times intensity. */
static void read_directional(struct scene_light *out, const struct node *n)
{
    json_check_keys(n, KEYS("type", "direction", "irradiance", "color", "intensity"));
    struct node direction = json_need(n, "direction"), irradiance = json_get(n, "irradiance"),
                color = json_get(n, "color");
    double d[3], e[3] = {1, 1, 1}, intensity = 1;
    *out = (struct scene_light){.kind = SCENE_LIGHT_DIRECTIONAL};
    unit_vector(d, &direction);
    if (irradiance.json) {
        if (color.json || json_get(n, "intensity").json)
            json_die(&irradiance, "given beside color or intensity; give one or the other");
        json_vector(e, &irradiance, 0, MAX_BRIGHT);
    } else {
        struct node amount = json_need(n, "intensity");
        intensity = json_number(&amount, 0, MAX_BRIGHT);
        if (color.json)
            json_vector(e, &color, 0, 1);
    }
    for (int k = 0; k < 3; k++) {
        out->direction[k] = (q2_30_t)lrint(d[k] * (1 << 30));
        out->irradiance[k] = to_q16(e[k] * intensity);
    }
}

/* Power, one for all colours or three, spread over all directions. */
static void read_point(struct scene_light *out, const struct node *n)
{
    json_check_keys(n, KEYS("type", "position", "power", "radius"));
    struct node position = json_need(n, "position"), power = json_need(n, "power"), radius = json_need(n, "radius");
    double p[3], watts[3];
    *out = (struct scene_light){.kind = SCENE_LIGHT_POINT};
    json_vector(p, &position, -MAX_POSITION, MAX_POSITION);
    if (cJSON_IsNumber(power.json))
        watts[0] = watts[1] = watts[2] = json_number(&power, 0, MAX_POWER);
    else
        json_vector(watts, &power, 0, MAX_POWER);
    for (int k = 0; k < 3; k++) {
        out->position[k] = (q16_16_t)lrint(p[k] * 65536);
        out->irradiance[k] = to_q16(watts[k] / (4 * pi));
    }
    out->radius = to_q16(json_number(&radius, 0.001, SCENE_MAX_RADIUS >> 16));
}

static void read_light(struct scene_light *out, const struct node *n)
{
    struct node type = json_get(n, "type");
    const char *kind = type.json ? json_string(&type) : "directional";
    if (!strcmp(kind, "directional"))
        read_directional(out, n);
    else if (!strcmp(kind, "point"))
        read_point(out, n);
    else
        json_die(&type, "'%s' is no type of light; give directional or point", kind);
}

static void read_material(struct scene_material *out, const struct node *n)
{
    struct node name = json_need(n, "name"), model = json_need(n, "model"), slot = json_get(n, "slot");
    const char *text = json_string(&name), *kind = json_string(&model);
    *out = (struct scene_material){.kind = (uint8_t)model_find(kind)};
    if (model_find(kind) == MODEL_OF_SCENE)
        json_die(&model, "'%s' is no model; it is one of " MODEL_NAMES, kind);
    if (!*text || strlen(text) >= sizeof out->name)
        json_die(&name, "'%s' has %zu characters; give 1 to %zu", text, strlen(text), sizeof out->name - 1);
    for (const char *c = text; *c; c++)
        if (*c < ' ' || *c > '~')
            json_die(&name, "holds a character that is not printable ASCII; use letters, digits and _");
    memcpy(out->name, text, strlen(text));
    if (out->kind == SCENE_MATERIAL_MEASURED)
        slot = json_need(n, "slot");
    out->slot = slot.json ? (uint8_t)json_whole(&slot, 0, 15) : 0;
    if (out->kind == SCENE_MATERIAL_METALLIC_ROUGHNESS) {
        json_check_keys(n, KEYS("name", "model", "slot", "base_color", "metalness", "roughness"));
        read_rgb(out->kd, n, "base_color", 0.5, 1);
    } else {
        json_check_keys(n, KEYS("name", "model", "slot", "kd", "ks", "exponent", "metalness", "roughness"));
        read_rgb(out->kd, n, "kd", 0.5, 1);
        read_rgb(out->ks, n, "ks", 0, 1);
    }
    out->exponent = to_q16(number_or(n, "exponent", 1, 0, 4096));
    out->metalness = to_q16(number_or(n, "metalness", 0, 0, 1));
    out->roughness = to_q16(number_or(n, "roughness", 0.5, MIN_ROUGHNESS, 1));
}

static char *find_file(const char *scene_path, const char *name, const char *data_folder)
{
    const char *slash = strrchr(scene_path, '/');
    if (*name == '/')
        return xstrdup(name);
    char *beside = xasprintf("%.*s%s", slash ? (int)(slash - scene_path + 1) : 0, scene_path, name);
    if (!data_folder || !access(beside, R_OK))
        return beside;
    free(beside);
    return xasprintf("%s/%s", data_folder, name);
}

static void read_shape(struct mesh_desc *out, const struct node *n, const struct node *which)
{
    const char *keys[SHAPE_MAX_PARAMETERS + 3] = {"name", "shape"};
    out->shape = shape_find(json_string(which));
    if (!out->shape)
        json_die(which, "'%s' is no built-in shape; `gtscene build --help` lists them", json_string(which));
    for (int i = 0; i < SHAPE_MAX_PARAMETERS; i++)
        keys[2 + i] = out->shape->parameters[i].name;
    json_check_keys(n, keys);
    for (int i = 0; i < SHAPE_MAX_PARAMETERS && out->shape->parameters[i].name; i++) {
        const struct shape_parameter *p = &out->shape->parameters[i];
        struct node value = json_get(n, p->name);
        out->parameters[i] = !value.json ? p->value
                             : p->whole  ? json_whole(&value, p->lo, p->hi)
                                         : json_number(&value, p->lo, p->hi);
    }
}

static void read_mesh(struct mesh_desc *out, const struct node *n, const char *data_folder)
{
    struct node name = json_need(n, "name"), shape = json_get(n, "shape"), file = json_get(n, "file");
    *out = (struct mesh_desc){.name = json_string(&name)};
    if (shape.json && file.json)
        json_die(&file, "given beside a shape; give one or the other");
    if (shape.json) {
        read_shape(out, n, &shape);
        return;
    }
    json_check_keys(n, KEYS("name", "file"));
    file = json_need(n, "file");
    out->path = find_file(n->file, json_string(&file), data_folder);
}

/* The measured material of a table slot: the scene's first, or a new one. */
static uint16_t material_of_slot(struct scene_desc *desc, const struct node *n)
{
    const unsigned slot = (unsigned)json_whole(n, 0, 15);
    struct scene_material *m = desc->materials;
    while (m < desc->materials + desc->material_count && (m->kind != SCENE_MATERIAL_MEASURED || m->slot != slot))
        m++;
    if (m == desc->materials + desc->material_count) {
        if (desc->material_count++ == SCENE_MAX_MATERIALS)
            json_die(n, "needs one more material than the limit of %u", SCENE_MAX_MATERIALS);
        *m = (struct scene_material){.kind = SCENE_MATERIAL_MEASURED,
                                     .slot = (uint8_t)slot,
                                     .kd = {1u << 15, 1u << 15, 1u << 15},
                                     .exponent = 1u << 16,
                                     .roughness = 1u << 15};
        snprintf(m->name, sizeof m->name, "slot %u", slot);
    }
    return (uint16_t)(m - desc->materials);
}

static uint16_t material_of_name(const struct scene_desc *desc, const struct node *n)
{
    const char *name = json_string(n);
    uint16_t i = 0;
    while (i < desc->material_count && strcmp(desc->materials[i].name, name))
        i++;
    if (i == desc->material_count)
        json_die(n, "'%s' is not among the materials", name);
    return i;
}

static void read_object(struct object_desc *out, const struct node *n, struct scene_desc *desc)
{
    json_check_keys(n, KEYS("mesh", "material", "slot", "position", "rotation", "scale"));
    struct node mesh = json_need(n, "mesh"), slot = json_get(n, "slot"), position = json_get(n, "position"),
                rotation = json_get(n, "rotation"),
                material = slot.json ? json_get(n, "material") : json_need(n, "material");
    const char *mesh_name = json_string(&mesh);
    *out = (struct object_desc){.scale = number_or(n, "scale", 1, 1e-6, 1e6)};
    while (out->mesh < desc->mesh_count && strcmp(desc->meshes[out->mesh].name, mesh_name))
        out->mesh++;
    if (out->mesh == desc->mesh_count)
        json_die(&mesh, "'%s' is not among the meshes", mesh_name);
    if (slot.json && material.json)
        json_die(&slot, "given beside a material; give one or the other");
    out->material = slot.json ? material_of_slot(desc, &slot) : material_of_name(desc, &material);
    if (position.json)
        json_vector(out->position, &position, -MAX_POSITION, MAX_POSITION);
    read_rotation(out->rotation, &rotation);
}

static void need_other_name(const struct node *n, const char *name, const char *earlier, unsigned by)
{
    struct node member = json_get(n, "name");
    if (!strcmp(name, earlier))
        json_die(&member, "'%s' is taken by element %u; names must differ", name, by);
}

void desc_load(struct scene_desc *out, const char *path, const char *data_folder)
{
    struct node root = json_load(path);
    *out = (struct scene_desc){0};
    json_check_keys(&root, KEYS("meshes", "materials", "objects", "lights", "camera", "output"));
    struct node meshes = json_need(&root, "meshes"), materials = json_need(&root, "materials"),
                objects = json_need(&root, "objects"), lights = json_need(&root, "lights"),
                camera = json_need(&root, "camera"), output = json_get(&root, "output");
    out->mesh_count = (unsigned)json_count(&meshes, MAX_MESHES);
    out->material_count = (unsigned)json_count(&materials, SCENE_MAX_MATERIALS);
    out->object_count = (unsigned)json_count(&objects, SCENE_MAX_OBJECTS);
    out->light_count = (unsigned)json_count(&lights, SCENE_MAX_LIGHTS);
    out->meshes = xcalloc(out->mesh_count, sizeof *out->meshes);
    out->objects = xcalloc(out->object_count, sizeof *out->objects);
    read_camera(&out->camera, &camera);
    read_output(&out->output, &out->lod_error, &output);
    for (unsigned i = 0; i < out->light_count; i++) {
        struct node n = json_element(&lights, (int)i);
        read_light(&out->lights[i], &n);
    }
    for (unsigned i = 0; i < out->material_count; i++) {
        struct node n = json_element(&materials, (int)i);
        read_material(&out->materials[i], &n);
        for (unsigned j = 0; j < i; j++)
            need_other_name(&n, out->materials[i].name, out->materials[j].name, j);
    }
    for (unsigned i = 0; i < out->mesh_count; i++) {
        struct node n = json_element(&meshes, (int)i);
        read_mesh(&out->meshes[i], &n, data_folder);
        for (unsigned j = 0; j < i; j++)
            need_other_name(&n, out->meshes[i].name, out->meshes[j].name, j);
    }
    for (unsigned i = 0; i < out->object_count; i++) {
        struct node n = json_element(&objects, (int)i);
        read_object(&out->objects[i], &n, out);
    }
}
