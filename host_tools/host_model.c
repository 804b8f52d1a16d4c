#include "host_model.h"

#include <string.h>

#include "scene.h"

static const char *const names[SCENE_MATERIAL_KIND_COUNT] = {[SCENE_MATERIAL_MEASURED] = "measured",
                                                             [SCENE_MATERIAL_LAFORTUNE_PHONG] = "lafortune_phong",
                                                             [SCENE_MATERIAL_BLINN_PHONG] = "blinn_phong",
                                                             [SCENE_MATERIAL_METALLIC_ROUGHNESS] =
                                                                 "metallic_roughness"};

uint32_t model_find(const char *name)
{
    for (uint32_t kind = 0; kind < SCENE_MATERIAL_KIND_COUNT; kind++)
        if (!strcmp(name, names[kind]))
            return kind;
    return MODEL_OF_SCENE;
}

const char *model_name(uint32_t kind)
{
    return names[kind];
}
