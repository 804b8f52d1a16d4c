/*
 * Tiles of hand-made surfaces, each pixel with a normal of its own, shaded by one light; and what double precision makes of the same
 * stored normals, the same light and each pixel's own view ray.
 */
#ifndef TILE_FIXTURE_H
#define TILE_FIXTURE_H

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "internal.h"
#include "ref_blob.h"
#include "ref_render.h"

static const uint32_t pi_16 = 205887;
enum { PIXELS = RASTER_TILE_WIDTH * RASTER_TILE_HEIGHT };

static uint64_t seed = 1;

static inline uint32_t random32(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    uint32_t x = (uint32_t)(seed >> 33);
    return x * 2654435761u ^ x >> 15;
}

static inline double uniform(double low, double high)
{
    return low + (high - low) * random32() * 0x1p-32;
}

static inline double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void normalise(double v[3])
{
    double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++)
        v[i] /= length;
}

static inline void random_direction(double v[3])
{
    double z = uniform(-1, 1), a = uniform(0, 6.283185307179586), r = sqrt(1 - z * z);
    v[0] = r * cos(a), v[1] = r * sin(a), v[2] = z;
}

/* Nearest q17_15_t components, no larger than 32767 as in a batch, of a direction of unit length. */
static inline struct vec3 quantise(const double v[3])
{
    int32_t q[3];
    for (int i = 0; i < 3; i++)
        q[i] = fx_clamp((int32_t)lrint(v[i] * 32768), -32767, 32767);
    return (struct vec3){q[0], q[1], q[2]};
}

static inline void direction_of(double out[3], struct vec3 v)
{
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
    normalise(out);
}

static struct {
    struct raster r;
    struct raster_tile tile;
    struct scene scene; /* one object that does not show */
    void *blob;
    struct scene_light light;
    struct scene_material material;
    const struct lut_table *tables[RASTER_MAX_SLOTS];
    struct scene_camera camera;
    uint64_t arena[1 << 16];
} k;

static inline int make_scene(void **state)
{
    struct ref_blob b;
    size_t bytes;
    (void)state;
    ref_blob_init(&b);
    ref_blob_light(&b, (const double[3]){0, 0, 1}, 3);
    ref_blob_material(&b, 1, 0, 0.5, "grey");
    const int16_t v[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const uint16_t t[1][3] = {{0, 1, 2}};
    ref_blob_object(&b, ref_blob_mesh(&b, v, t, 1), 0, (const double[3]){0, 0, 9}, 1);
    k.blob = ref_blob_finish(&b, &bytes);
    ref_blob_free(&b);
    return scene_open(&k.scene, k.blob, bytes) != SCENE_OK;
}

static inline int free_scene(void **state)
{
    (void)state;
    free(k.blob);
    return 0;
}

struct subject {
    struct scene_material material;
    struct ref_material model;
    struct lut_table lut;
    struct ref_table *ref; /* NULL: the model */
    void *file;
};

/* A frame of the subject's material under one light; a vertical field of view of 45 degrees. */
static inline void frame_begin(const struct subject *s, unsigned width, unsigned height, struct vec3 light,
                               uint32_t irradiance)
{
    k.material = s->material;
    k.tables[0] = s->ref ? &s->lut : NULL;
    k.camera = k.scene.header->camera;
    k.camera.focal = 158217;
    k.light = (struct scene_light){.kind = SCENE_LIGHT_DIRECTIONAL,
                                   .direction = {light.x * 32768, light.y * 32768, light.z * 32768},
                                   .irradiance = {irradiance, irradiance, irradiance}};
    struct raster_frame f = {.parts = &raster_all_parts,
                             .scene = &k.scene,
                             .camera = &k.camera,
                             .output = &k.scene.header->output,
                             .lights = &k.light,
                             .materials = &k.material,
                             .tables = k.tables,
                             .width = (uint16_t)width,
                             .height = (uint16_t)height,
                             .light_count = 1,
                             .format = RASTER_RGB888};
    assert_int_equal(raster_begin(&k.r, &f, k.arena, sizeof k.arena), RASTER_OK);
    memset(&k.tile, 0, sizeof k.tile);
    k.tile.slots[1] = (struct raster_slot){.frame = {1 << 14, 0, 0, 0, 1 << 14, 0, 0, 0, 1 << 14}};
    k.tile.slot_count = 1;
}

static inline void view_of(double v[3], unsigned x, unsigned y)
{
    double scale = k.r.frame.height * (k.camera.focal / 65536.0);
    v[0] = -(2.0 * x + 1 - k.r.frame.width) / scale, v[1] = (2.0 * y + 1 - k.r.frame.height) / scale, v[2] = 1;
    normalise(v);
}

/* Under the irradiance that frame_begin was given, with ambient light. */
static inline void reference(double radiance[3], const struct subject *s, const double n[3], const double l[3],
                             const double v[3])
{
    double f[3];
    if (s->ref)
        ref_table_eval(f, s->ref, n, l, v);
    else if (s->model.kind == REF_BLINN_PHONG)
        ref_blinn_phong(f, &s->model, n, l, v);
    else
        ref_model_value(f, &s->model, n, l, v);
    const double pi = 3.14159265358979323846, kind = s->model.kind;
    double scale = k.light.irradiance[0] / 65536.0, ambient = 0;
    scale *= kind == REF_BLINN_PHONG ? 1 / pi : fmax(dot(n, l), 0);
    if (!s->ref)
        ambient = kind == REF_BLINN_PHONG ? 0.02 : kind == REF_METALLIC_ROUGHNESS ? 0.05 : 0;
    for (int c = 0; c < 3; c++)
        radiance[c] = f[c] * scale + ambient * s->model.kd[c];
}

/* A unit normal as a surface in slot 1 stores it, and then exactly what is stored. In: n[2] > -0.5. */
static inline struct raster_surface store_normal(double n[3])
{
    const int32_t d = 16383;
    int32_t u = (int32_t)lrint(d * n[0] / (1 + n[2])), w = (int32_t)lrint(d * n[1] / (1 + n[2]));
    double square = (double)u * u + (double)w * w + (double)d * d;
    n[0] = 2.0 * u * d / square, n[1] = 2.0 * w * d / square, n[2] = 2.0 * d * d / square - 1;
    return (struct raster_surface){((uint32_t)d + DEPTH_BIAS) << 8 | 1, (uint32_t)(u & 0xffff) | (uint32_t)w << 16};
}

/* Opens a table file, malloc'd and taken over: see subject_free. */
static inline struct subject table_subject(void *file, size_t bytes)
{
    struct subject s = {.material = {.kind = SCENE_MATERIAL_MEASURED}, .file = file};
    assert_string_equal(lut_status_text(lut_open(&s.lut, file, bytes)), lut_status_text(LUT_OK));
    s.ref = ref_table_open(file, bytes);
    assert_non_null(s.ref);
    return s;
}

static inline void subject_free(struct subject *s)
{
    free(s->file);
    ref_table_free(s->ref);
}

#endif
