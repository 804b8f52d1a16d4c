#include "content.h"

#define MODEL_OF_SCENE 0xffffffffu

/* Triangles of all objects at their finest level, wrapping at 2^32. Visits what culling one frame does. */
static uint32_t triangle_count(const struct scene *scene)
{
    uint32_t n = 0;
    for (uint32_t o = 0; o < scene->header->objects.count; o++) {
        const struct scene_lod *lod = &scene->lods[scene->meshes[scene->objects[o].mesh].lod_first];
        for (uint32_t m = 0; m < lod->meshlet_count; m++)
            n += scene->meshlets[lod->meshlet_first + m].triangle_count;
    }
    return n;
}

void content_reset(struct app *app)
{
    struct app_content *c = &app->content;
    app->frame.refused = false;
    c->tile_budget = app->config.tile_budget;
    if (!c->has_scene)
        return;
    const struct scene_header *h = c->scene.header;
    c->camera = h->camera;
    c->output = h->output;
    c->light_count = (uint8_t)h->lights.count; /* scene_open: at most SCENE_MAX_LIGHTS */
    c->lights = c->scene.lights;
    c->materials = c->scene.materials;
    c->own = NULL;
}

size_t content_arena_bytes(const struct app *app)
{
    const struct scene_material *own = app->content.own;
    const size_t before = own ? (size_t)((const uint8_t *)own - (const uint8_t *)app->config.arena) : SIZE_MAX;
    return before < app->config.arena_bytes ? before : app->config.arena_bytes;
}

void content_load(struct app *app, uint32_t slot)
{
    struct app_content *c = &app->content;
    uint32_t bytes;
    const uint8_t *content = table_store_content(&app->store, slot, &bytes);
    app->frame.refused = false;
    if (slot == 0) {
        c->has_scene = content && scene_open_bounded(&c->scene, content, bytes) == SCENE_OK;
        c->triangle_count = c->has_scene ? triangle_count(&c->scene) : 0;
        content_reset(app);
        app->frame.budget = (struct budget){0}; /* what it learnt was of another scene */
        if (app->config.memory)
            *app->config.memory = (struct raster_memory){{0}};
    } else {
        struct lut_table *table = &c->tables[slot - 1];
        c->table_of_slot[slot - 1] = content && lut_open(table, content, bytes) == LUT_OK ? table : NULL;
    }
}

static const struct table_store_result accepted = {USB_OK, 0};

static struct table_store_result refused(uint32_t detail)
{
    return (struct table_store_result){USB_ERR_VALUE, detail};
}

/* Before a material or light changes: copies those of the scene into the arena, where a frame then has less. */
static struct table_store_result own_values(struct app *app)
{
    struct app_content *c = &app->content;
    const uint32_t materials = c->scene.header->materials.count,
                   lights = c->light_count <= APP_MAX_SET_LIGHTS ? APP_MAX_SET_LIGHTS : 0;
    const size_t bytes = materials * sizeof *c->own + lights * sizeof *c->lights;
    if (c->own)
        return accepted;
    if (bytes > app->config.arena_bytes)
        return (struct table_store_result){USB_ERR_MEMORY, (uint32_t)bytes};
    uint8_t *place = (uint8_t *)app->config.arena + ((app->config.arena_bytes - bytes) & ~(size_t)3);
    c->own = (struct scene_material *)(void *)place;
    __builtin_memcpy(c->own, c->materials, materials * sizeof *c->own);
    c->materials = c->own;
    if (lights) {
        __builtin_memcpy(c->own + materials, c->lights, c->light_count * sizeof *c->lights);
        c->lights = (struct scene_light *)(void *)(c->own + materials);
    }
    return accepted;
}

struct table_store_result content_select(struct app *app, const struct usb_select *select)
{
    struct app_content *c = &app->content;
    if (!c->has_scene)
        return (struct table_store_result){USB_ERR_STATE, 0};
    if (select->material >= c->scene.header->materials.count || select->table + 1u >= app->config.slot_count)
        return refused(0);
    struct table_store_result r = own_values(app);
    if (r.status != USB_OK)
        return r;
    c->own[select->material].slot = (uint8_t)select->table;
    app->frame.refused = false;
    return accepted;
}

static struct table_store_result set_camera(struct app_content *c, const struct scene_camera *camera)
{
    enum scene_status status = scene_check_camera(camera);
    if (status != SCENE_OK)
        return refused((uint32_t)status);
    c->camera = *camera;
    return accepted;
}

static struct table_store_result set_output(struct app_content *c, const struct scene_output *output)
{
    enum scene_status status = scene_check_output(output);
    if (status != SCENE_OK)
        return refused((uint32_t)status);
    c->output = *output;
    return accepted;
}

static struct table_store_result set_light(struct app *app, uint32_t index, const struct scene_light *light)
{
    struct app_content *c = &app->content;
    enum scene_status status = scene_check_light(light);
    if (status != SCENE_OK || index > c->light_count || index >= APP_MAX_SET_LIGHTS ||
        c->light_count > APP_MAX_SET_LIGHTS)
        return refused((uint32_t)status);
    struct table_store_result r = own_values(app);
    if (r.status != USB_OK)
        return r;
    struct scene_light *own = (struct scene_light *)(void *)(c->own + c->scene.header->materials.count);
    own[index] = *light;
    if (index == c->light_count)
        c->light_count++;
    return accepted;
}

static struct table_store_result set_model(struct app *app, uint32_t model)
{
    struct app_content *c = &app->content;
    if (model >= SCENE_MATERIAL_KIND_COUNT && model != MODEL_OF_SCENE)
        return refused(0);
    struct table_store_result r = own_values(app);
    for (uint32_t i = 0; r.status == USB_OK && i < c->scene.header->materials.count; i++) {
        struct scene_material *m = &c->own[i];
        m->kind = model == MODEL_OF_SCENE ? c->scene.materials[i].kind : (uint8_t)model;
        if (m->kind == SCENE_MATERIAL_METALLIC_ROUGHNESS && m->roughness < SCENE_MIN_ROUGHNESS)
            m->roughness = SCENE_MIN_ROUGHNESS;
    }
    return r;
}

static struct table_store_result set_budget(struct app *app, uint32_t tile_budget)
{
    if (tile_budget && !app->config.budgets)
        return refused(0);
    struct table_store_result r = app_check_budget(app, tile_budget);
    if (r.status == USB_OK)
        app->content.tile_budget = tile_budget;
    return r;
}

/* Bytes of a setting's value; 0: no such setting. */
static uint32_t value_bytes(uint32_t setting)
{
    switch (setting) {
    case USB_SET_CAMERA:
        return sizeof(struct scene_camera);
    case USB_SET_LIGHT:
        return sizeof(uint32_t) + sizeof(struct scene_light);
    case USB_SET_OUTPUT:
        return sizeof(struct scene_output);
    case USB_SET_MODEL:
    case USB_SET_BUDGET:
        return sizeof(uint32_t);
    default:
        return 0;
    }
}

struct table_store_result content_set(struct app *app, uint32_t setting, const void *value, uint32_t bytes)
{
    struct app_content *c = &app->content;
    const uint32_t *words = value;
    uint32_t wanted = value_bytes(setting);
    if (!wanted)
        return refused(0);
    if (bytes != wanted)
        return (struct table_store_result){USB_ERR_LENGTH, (uint32_t)sizeof(struct usb_set) + wanted};
    if (!c->has_scene)
        return (struct table_store_result){USB_ERR_STATE, 0};
    app->frame.refused = false;
    switch (setting) {
    case USB_SET_CAMERA:
        return set_camera(c, value);
    case USB_SET_LIGHT:
        return set_light(app, words[0], (const struct scene_light *)(words + 1));
    case USB_SET_OUTPUT:
        return set_output(c, value);
    case USB_SET_BUDGET:
        return set_budget(app, words[0]);
    default:
        return set_model(app, words[0]);
    }
}
