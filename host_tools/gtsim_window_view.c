#define _GNU_SOURCE
#include "gtsim_window_view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "gtsim_device.h"
#include "gtsim_window_eye.h"
#include "gtsim_window_rate.h"
#include "host_model.h"

#define MAX_EXPOSURE (256.0 * 65536)
#define MIN_EXPOSURE (65536 / 256.0)

static const struct app_content *shown(const struct view *v)
{
    return &v->device->app.content;
}

static struct usb_header ask(struct view *v, uint8_t type, const void *payload, uint32_t bytes)
{
    struct usb_header h;
    if (!sim_device_request(v->device, type, payload, bytes, &h, NULL, 0))
        die(EXIT_INTERNAL, "the simulated device does not answer");
    return h;
}

static void request(struct view *v, uint8_t type, const void *payload, uint32_t bytes, const char *what)
{
    struct usb_header h = ask(v, type, payload, bytes);
    char *why = device_refusal(v->device, h.status, h.detail);
    if (why)
        warn("%s: %s", what, why);
    free(why);
}

static void set(struct view *v, uint32_t setting, const void *value, size_t bytes, const char *what)
{
    uint8_t payload[128];
    memcpy(payload, &setting, sizeof setting);
    memcpy(payload + sizeof setting, value, bytes);
    request(v, USB_MSG_SET, payload, (uint32_t)(sizeof setting + bytes), what);
}

/* --- the camera --- */

/* The nearest that the eye comes to what it turns around. */
static double least_distance(const struct view *v)
{
    return 2 * ldexp(shown(v)->camera.near, -16);
}

static void eye_get(struct view *v, struct eye *e)
{
    const struct app_content *c = shown(v);
    eye_read(e, &c->camera);
    if (memcmp(&v->camera, &c->camera, sizeof v->camera))
        eye_pivot(v->pivot, e, &c->scene, least_distance(v));
}

static void eye_set(struct view *v, const struct eye *e)
{
    v->camera = shown(v)->camera;
    if (eye_write(&v->camera, e))
        set(v, USB_SET_CAMERA, &v->camera, sizeof v->camera, "camera");
}

void view_orbit(struct view *v, double around, double up)
{
    struct eye e;
    if (!shown(v)->has_scene)
        return;
    eye_get(v, &e);
    if (eye_orbit(&e, v->pivot, around, up))
        eye_set(v, &e);
}

void view_distance(struct view *v, double factor)
{
    struct eye e;
    if (!shown(v)->has_scene)
        return;
    eye_get(v, &e);
    if (eye_approach(&e, v->pivot, factor, least_distance(v)))
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
        eye_scene_middle(middle, &shown(v)->scene);
    for (uint32_t l = 0; l < count; l++) {
        struct scene_light light = shown(v)->lights[l];
        bool point = light.kind == SCENE_LIGHT_POINT;
        double to[3];
        for (int i = 0; i < 3; i++)
            to[i] = point ? ldexp(light.position[i], -16) - middle[i] : ldexp(light.direction[i], -30);
        eye_turn_vertical(to, degrees);
        for (int i = 0; i < 3; i++)
            light.direction[i] = (int32_t)lrint(point ? ldexp(to[i] + middle[i], 16) : ldexp(to[i], 30));
        light_set(v, l, &light);
    }
}

/* --- budget --- */

void view_budget(struct view *v, int by, const struct usb_stats *stats)
{
    const uint32_t set_now = shown(v)->tile_budget, now = set_now == RATE_BUDGET ? 0 : set_now,
                   mean = stats->tile_count ? stats->total.ticks / stats->tile_count : 0;
    if (!shown(v)->has_scene || (by > 0 && !now))
        return;
    uint32_t next = by < 0 ? (now ? now : mean) / 5 * 4 : stats->tiles_reduced ? now / 4 * 5 : 0;
    uint32_t payload[2] = {USB_SET_BUDGET, next};
    struct usb_header h = ask(v, USB_MSG_SET, payload, sizeof payload);
    if (h.status == USB_ERR_BUDGET)
        next = h.detail;
    if (h.status != USB_OK)
        set(v, USB_SET_BUDGET, &next, sizeof next, "budget");
}

void view_rate(struct view *v, int by)
{
    const int now = shown(v)->tile_budget == RATE_BUDGET ? (int)rate_now() : RASTER_RATE_1X1, next = now + by;
    if (!shown(v)->has_scene || next < 0 || next >= RASTER_RATE_COUNT)
        return;
    const uint32_t budget = next == RASTER_RATE_1X1 ? 0 : RATE_BUDGET;
    rate_set((enum raster_rate)next);
    set(v, USB_SET_BUDGET, &budget, sizeof budget, "budget");
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
