/*
 * The names of reflectance models, as scene descriptions and command lines give them.
 */
#ifndef HOST_MODEL_H
#define HOST_MODEL_H

#include <stdint.h>

#define MODEL_NAMES    "measured, lafortune_phong, blinn_phong, metallic_roughness"
#define MODEL_OF_SCENE UINT32_MAX

/* enum scene_material_kind of a name; MODEL_OF_SCENE when it is none. */
uint32_t model_find(const char *name);

/* Constant storage. In: a valid enum scene_material_kind. */
const char *model_name(uint32_t kind);

#endif
