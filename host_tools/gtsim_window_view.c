#define _GNU_SOURCE
#include "gtsim_window_view.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_model.h"

#define DEGREE       (3.14159265358979323846 / 180)
#define MAX_PITCH    (89 * DEGREE)
#define MAX_EXPOSURE (256.0 * 65536)
#define MIN_EXPOSURE (65536 / 256.0)

static const struct app_content *shown(const struct view *v)
{
    return &v->device->app.content;
}

static void request(struct view *v, uint8_t type, const void *payload, uint32_t bytes, const char *what)
{
    struct usb_header h;
    if (!sim_device_request(v->device, type, payload, bytes, &h, NULL, 0))
        die(EXIT_INTERNAL, "%s: the simulated device does not answer", what);
    if (h.status != USB_OK)
        warn("%s: refused by the device: status %u, detail %u", what, h.status, h.detail);
}

static void set(struct view *v, uint32_t setting, const void *value, size_t bytes, const char *what)
{
    uint8_t payload[128];
    memcpy(payload, &setting, sizeof setting);
    memcpy(payload + sizeof setting, value, bytes);
    request(v, USB_MSG_SET, payload, (uint32_t)(sizeof setting + bytes), what);
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static void normalize(double v[3])
{
    double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++)
        v[i] /= length;
}

/* v turned about the unit vector `axis` (Rodrigues). */
static void turn(double v[3], const double axis[3], double angle)
{
    double c = cos(angle), s = sin(angle), along = dot(v, axis), side[3];
    cross(side, axis, v);
    for (int i = 0; i < 3; i++)
        v[i] = c * v[i] + s * side[i] + (1 - c) * along * axis[i];
}

static const double vertical[3] = {0, 1, 0};

/* --- the camera --- */

struct eye {
    double at[3], row[3][3]; /* rows: right, up, back */
};

static void eye_read(struct eye *e, const struct scene_camera *c)
{
    for (int i = 0; i < 3; i++)
        e->at[i] = ldexp(c->eye[i], -16);
    for (int i = 0; i < 9; i++)
        e->row[i / 3][i % 3] = ldexp(c->rotation[i], -30);
}

/* The middle of the box around all objects. */
static void scene_middle(double middle[3], const struct scene *s)
{
    double lo[3] = {DBL_MAX, DBL_MAX, DBL_MAX}, hi[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
    for (uint32_t o = 0; o < s->header->objects.count; o++) {
        const struct scene_object *object = &s->objects[o];
        const struct scene_mesh *m = &s->meshes[object->mesh];
        double scale = ldexp(object->scale_mantissa, -(30 + object->scale_shift));
        for (int corner = 0; corner < 8; corner++)
            for (int i = 0; i < 3; i++) {
                double x = ldexp(object->position[i], -16);
                for (int k = 0; k < 3; k++)
                    x += scale * ldexp(object->rotation[3 * i + k], -30) * (corner >> k & 1 ? m->hi[k] : m->lo[k]);
                lo[i] = fmin(lo[i], x);
                hi[i] = fmax(hi[i], x);
            }
    }
    for (int i = 0; i < 3; i++)
        middle[i] = s->header->objects.count ? (lo[i] + hi[i]) / 2 : 0;
}

/* What the eye turns around: the point that it looks at, as far away as the scene's middle, so that the picture's middle stays where it is. */
static void pivot_find(struct view *v, const struct eye *e)
{
    const struct app_content *c = shown(v);
    double middle[3], to[3];
    if (!memcmp(&v->camera, &c->camera, sizeof v->camera))
        return;
    scene_middle(middle, &c->scene);
    for (int i = 0; i < 3; i++)
        to[i] = middle[i] - e->at[i];
    double ahead = -dot(to, e->row[2]);
    if (ahead < 2 * ldexp(c->camera.near, -16))
        ahead = sqrt(dot(to, to)); /* the scene is behind or beside the eye */
    for (int i = 0; i < 3; i++)
        v->pivot[i] = e->at[i] - ahead * e->row[2][i];
}

static void eye_set(struct view *v, struct eye *e)
{
    struct scene_camera c = shown(v)->camera;
    normalize(e->row[2]);
    cross(e->row[0], e->row[1], e->row[2]);
    normalize(e->row[0]);
    cross(e->row[1], e->row[2], e->row[0]);
    for (int i = 0; i < 3; i++) {
        if (fabs(e->at[i]) > 32767)
            return; /* as far as the format goes */
        c.eye[i] = (int32_t)lrint(ldexp(e->at[i], 16));
    }
    for (int i = 0; i < 9; i++)
        c.rotation[i] = (int32_t)lrint(ldexp(e->row[i / 3][i % 3], 30));
    set(v, USB_SET_CAMERA, &c, sizeof c, "camera");
    v->camera = c;
}

void view_orbit(struct view *v, double around, double up)
{
    struct eye e;
    double from[3], right[3];
    if (!shown(v)->has_scene)
        return;
    eye_read(&e, &shown(v)->camera);
    pivot_find(v, &e);
    double pitch = asin(fmax(-1, fmin(1, e.row[2][1])));
    double raise = fmax(-MAX_PITCH, fmin(MAX_PITCH, pitch + up * DEGREE)) - pitch;
    if (fabs(raise) + fabs(around) < 1e-6)
        return; /* at the pole already */
    memcpy(right, e.row[0], sizeof right);
    for (int i = 0; i < 3; i++)
        from[i] = e.at[i] - v->pivot[i];
    double *turned[] = {from, e.row[0], e.row[1], e.row[2]};
    for (int i = 0; i < 4; i++) {
        turn(turned[i], right, -raise);
        turn(turned[i], vertical, around * DEGREE);
    }
    for (int i = 0; i < 3; i++)
        e.at[i] = v->pivot[i] + from[i];
    eye_set(v, &e);
}

void view_distance(struct view *v, double factor)
{
    struct eye e;
    if (!shown(v)->has_scene)
        return;
    eye_read(&e, &shown(v)->camera);
    pivot_find(v, &e);
    double distance = 0, least = 2 * ldexp(shown(v)->camera.near, -16);
    for (int i = 0; i < 3; i++)
        distance += (e.at[i] - v->pivot[i]) * (e.at[i] - v->pivot[i]);
    distance = sqrt(distance);
    if (distance * factor < least && factor < 1)
        return;
    for (int i = 0; i < 3; i++)
        e.at[i] = v->pivot[i] + factor * (e.at[i] - v->pivot[i]);
    eye_set(v, &e);
}

/* --- materials --- */

static uint32_t material_count(const struct view *v)
{
    return shown(v)->has_scene ? shown(v)->scene.header->materials.count : 0;
}

/* The selected material: a smaller scene may have come. */
static uint32_t selected(const struct view *v)
{
    return v->material < material_count(v) ? v->material : 0;
}

void view_material(struct view *v, int by)
{
    uint32_t count = material_count(v);
    if (count)
        v->material = (uint32_t)((int)(selected(v) + count) + by) % count;
}

void view_slot(struct view *v, int by)
{
    if (!material_count(v))
        return;
    uint32_t slot = shown(v)->materials[selected(v)].slot, next = slot;
    do
        next = (uint32_t)((int)(next + RASTER_MAX_SLOTS) + by) % RASTER_MAX_SLOTS;
    while (next != slot && !shown(v)->table_of_slot[next]);
    struct usb_select s = {(uint16_t)selected(v), (uint16_t)next};
    request(v, USB_MSG_SELECT, &s, sizeof s, "table slot");
}

/* The kind that material i gets from `model`. */
static uint8_t kind_of(const struct view *v, uint32_t model, uint32_t i)
{
    return model == MODEL_OF_SCENE ? shown(v)->scene.materials[i].kind : (uint8_t)model;
}

static bool model_is_shown(const struct view *v, uint32_t model)
{
    uint32_t i = 0;
    while (i < material_count(v) && shown(v)->materials[i].kind == kind_of(v, model, i))
        i++;
    return i == material_count(v);
}

void view_model(struct view *v, int by)
{
    static const uint32_t models[] = {MODEL_OF_SCENE, SCENE_MATERIAL_MEASURED, SCENE_MATERIAL_LAFORTUNE_PHONG,
                                      SCENE_MATERIAL_BLINN_PHONG, SCENE_MATERIAL_METALLIC_ROUGHNESS};
    const unsigned count = sizeof models / sizeof *models;
    unsigned now = 0, next;
    if (!material_count(v))
        return;
    while (now < count - 1 && !model_is_shown(v, models[now]))
        now++;
    next = now;
    do
        next = (unsigned)((int)(next + count) + by) % count;
    while (next != now && model_is_shown(v, models[next]));
    set(v, USB_SET_MODEL, &models[next], sizeof models[next], "model");
}

/* --- light --- */

void view_exposure(struct view *v, int by)
{
    struct scene_output o = shown(v)->output;
    if (!shown(v)->has_scene)
        return;
    o.exposure = (uint32_t)lrint(fmax(MIN_EXPOSURE, fmin(MAX_EXPOSURE, o.exposure * exp2(by / 3.0))));
    set(v, USB_SET_OUTPUT, &o, sizeof o, "exposure");
}

/* How many lights can be set; a scene with more keeps its own. */
static uint32_t light_count(const struct view *v)
{
    if (!shown(v)->has_scene)
        return 0;
    if (shown(v)->light_count > APP_MAX_SET_LIGHTS)
        warn("lights: the scene has %u, a device sets up to %d; they stay", shown(v)->light_count, APP_MAX_SET_LIGHTS);
    return shown(v)->light_count > APP_MAX_SET_LIGHTS ? 0 : shown(v)->light_count;
}

static bool is_dark(const uint32_t irradiance[3])
{
    return !(irradiance[0] | irradiance[1] | irradiance[2]);
}

static void light_set(struct view *v, uint32_t index, const struct scene_light *light)
{
    struct {
        uint32_t index;
        struct scene_light light;
    } value = {index, *light};
    set(v, USB_SET_LIGHT, &value, sizeof value, "light");
}

void view_light(struct view *v, uint32_t index)
{
    if (index >= light_count(v))
        return;
    struct scene_light light = shown(v)->lights[index];
    if (is_dark(light.irradiance)) {
        memcpy(light.irradiance, v->lit[index], sizeof light.irradiance);
    } else {
        memcpy(v->lit[index], light.irradiance, sizeof light.irradiance);
        memset(light.irradiance, 0, sizeof light.irradiance);
    }
    light_set(v, index, &light);
}

void view_turn_lights(struct view *v, double degrees)
{
    double middle[3];
    uint32_t count = light_count(v);
    if (count)
        scene_middle(middle, &shown(v)->scene);
    for (uint32_t l = 0; l < count; l++) {
        struct scene_light light = shown(v)->lights[l];
        bool point = light.kind == SCENE_LIGHT_POINT;
        double to[3];
        for (int i = 0; i < 3; i++)
            to[i] = point ? ldexp(light.position[i], -16) - middle[i] : ldexp(light.direction[i], -30);
        turn(to, vertical, degrees * DEGREE);
        if (!point)
            normalize(to);
        for (int i = 0; i < 3; i++)
            light.direction[i] = (int32_t)lrint(point ? ldexp(to[i] + middle[i], 16) : ldexp(to[i], 30));
        light_set(v, l, &light);
    }
}

void view_reset(struct view *v)
{
    request(v, USB_MSG_RESET, NULL, 0, "reset");
}

/* --- state --- */

char *view_text(const struct view *v)
{
    const struct app_content *c = shown(v);
    char lights[4 * APP_MAX_SET_LIGHTS + 8] = "";
    if (!c->has_scene)
        return xstrdup("no scene");
    const struct scene_material *m = &c->materials[selected(v)];
    if (c->light_count > APP_MAX_SET_LIGHTS)
        snprintf(lights, sizeof lights, " %u", c->light_count);
    for (uint32_t i = 0; i < c->light_count && c->light_count <= APP_MAX_SET_LIGHTS; i++)
        if (!is_dark(c->lights[i].irradiance))
            snprintf(lights + strlen(lights), sizeof lights - strlen(lights), " %u", i + 1);
    char *slot = m->kind == SCENE_MATERIAL_MEASURED ? xasprintf(", slot %u", m->slot) : xstrdup("");
    char *text = material_count(v)
                     ? xasprintf("%u %.16s: %s%s | exposure %.2f | lights%s", selected(v), m->name, model_name(m->kind),
                                 slot, ldexp(c->output.exposure, -16), *lights ? lights : " off")
                     : xstrdup("no materials");
    free(slot);
    return text;
}
