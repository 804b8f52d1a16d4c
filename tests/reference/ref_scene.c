#include "ref_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Byte offsets in the header, and sizes of elements. */
enum {
    AT_TOTAL = 8,
    AT_CAMERA = 12,
    AT_OUTPUT = 68,
    AT_ARRAYS = 76,
    HEADER_SIZE = 144,
    LIGHT_SIZE = 32,
    MATERIAL_SIZE = 56,
    OBJECT_SIZE = 60,
    MESH_SIZE = 20,
    LOD_SIZE = 12,
    MESHLET_SIZE = 44,
    VERTEX_SIZE = 10,
    TRIANGLE_SIZE = 3
};

static uint32_t get_u32(const uint8_t *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static unsigned get_u16(const uint8_t *p)
{
    return p[0] | (unsigned)p[1] << 8;
}

static double get_i16(const uint8_t *p)
{
    unsigned x = get_u16(p);
    return x < 32768 ? x : x - 65536.0;
}

/* Signed fixed point. */
static double get_fixed(const uint8_t *p, int fraction_bits)
{
    uint32_t x = get_u32(p);
    return ldexp(x < 0x80000000u ? x : x - 4294967296.0, -fraction_bits);
}

static double get_ufixed(const uint8_t *p, int fraction_bits)
{
    return ldexp(get_u32(p), -fraction_bits);
}

static void get_matrix(double out[3][3], const uint8_t *p)
{
    for (int i = 0; i < 9; i++)
        out[i / 3][i % 3] = get_fixed(p + 4 * i, 30);
}

static void get_box(double lo[3], double hi[3], const uint8_t *p)
{
    for (int k = 0; k < 3; k++) {
        lo[k] = get_i16(p + 2 * k);
        hi[k] = get_i16(p + 6 + 2 * k);
    }
}

static void normalise(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++)
        v[k] /= length;
}

/* Where array number `which` is; 0 when it does not lie in the blob. */
static const uint8_t *array_find(unsigned *count, const uint8_t *blob, size_t bytes, int which, size_t size)
{
    const uint8_t *entry = blob + AT_ARRAYS + 8 * which;
    uint64_t offset = get_u32(entry);
    *count = get_u32(entry + 4);
    return offset % 4 == 0 && offset + (uint64_t)*count * size <= bytes ? blob + offset : NULL;
}

static void read_light(struct ref_light *out, const uint8_t *p)
{
    out->point = p[0] == 1;
    for (int k = 0; k < 3; k++) {
        out->direction[k] = get_fixed(p + 4 + 4 * k, 30);
        out->position[k] = get_fixed(p + 4 + 4 * k, 16);
        out->irradiance[k] = get_ufixed(p + 16 + 4 * k, 16);
    }
    out->radius = get_ufixed(p + 28, 16);
    if (!out->point)
        normalise(out->direction);
}

static void read_material(struct ref_material *out, const uint8_t *p)
{
    static const enum ref_model_kind kinds[4] = {REF_LAFORTUNE_PHONG, REF_LAFORTUNE_PHONG, REF_BLINN_PHONG,
                                                 REF_METALLIC_ROUGHNESS};
    out->measured = p[0] == 0;
    out->kind = kinds[p[0] & 3];
    out->slot = p[1];
    for (int k = 0; k < 3; k++) {
        out->kd[k] = get_ufixed(p + 4 + 4 * k, 16);
        out->ks[k] = get_ufixed(p + 16 + 4 * k, 16);
    }
    out->exponent = get_ufixed(p + 28, 16);
    out->metalness = get_ufixed(p + 32, 16);
    out->roughness = get_ufixed(p + 36, 16);
    memcpy(out->name, p + 40, 16);
    out->name[16] = 0;
}

static void read_object(struct ref_object *out, const uint8_t *p)
{
    out->mesh = get_u16(p);
    out->material = get_u16(p + 2);
    get_matrix(out->rotation, p + 16);
    double scale = ldexp(get_u32(p + 52), -30 - (int)get_u32(p + 56));
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            out->matrix[i][j] = scale * out->rotation[i][j];
        out->matrix[i][3] = get_fixed(p + 4 + 4 * i, 16);
    }
}

static void read_meshlet(struct ref_meshlet *out, const uint8_t *p)
{
    get_box(out->lo, out->hi, p);
    for (int i = 0; i < 9; i++)
        out->frame[i / 3][i % 3] = get_i16(p + 12 + 2 * i) / 16384;
    out->cone_cutoff = get_i16(p + 30) / 16384;
    out->vertex_first = get_u32(p + 32);
    out->triangle_first = get_u32(p + 36);
    out->vertex_count = p[40];
    out->triangle_count = p[41];
    out->area = 64 * ldexp(8 + p[42] % 8, p[42] / 8);
    out->perimeter = ldexp(8 + p[43] % 8, p[43] / 8);
}

static void read_vertex(struct ref_vertex *out, const uint8_t *p, const struct ref_meshlet *m)
{
    for (int k = 0; k < 3; k++)
        out->position[k] = get_i16(p + 2 * k);
    for (int k = 0; k < 2; k++)
        out->uv[k] = get_i16(p + 6 + 2 * k) / 16384;
    double s = out->uv[0] * out->uv[0] + out->uv[1] * out->uv[1];
    const double local[3] = {2 * out->uv[0] / (1 + s), 2 * out->uv[1] / (1 + s), (1 - s) / (1 + s)};
    for (int k = 0; k < 3; k++)
        out->normal[k] = local[0] * m->frame[0][k] + local[1] * m->frame[1][k] + local[2] * m->frame[2][k];
    normalise(out->normal);
}

/* 0 on success. */
static int read_arrays(struct ref_scene *s, const uint8_t *blob, size_t bytes)
{
    static const size_t sizes[8] = {LIGHT_SIZE, MATERIAL_SIZE, OBJECT_SIZE, MESH_SIZE,
                                    LOD_SIZE,   MESHLET_SIZE,  VERTEX_SIZE, TRIANGLE_SIZE};
    const uint8_t *at[8];
    unsigned n[8];
    for (int i = 0; i < 8; i++)
        if (!(at[i] = array_find(&n[i], blob, bytes, i, sizes[i])))
            return 1;
    s->light_count = n[0], s->material_count = n[1], s->object_count = n[2], s->mesh_count = n[3];
    s->meshlet_count = n[5], s->vertex_count = n[6], s->triangle_count = n[7];
    s->lights = calloc(n[0] + 1, sizeof *s->lights);
    s->materials = calloc(n[1] + 1, sizeof *s->materials);
    s->objects = calloc(n[2] + 1, sizeof *s->objects);
    s->meshes = calloc(n[3] + 1, sizeof *s->meshes);
    s->meshlets = calloc(n[5] + 1, sizeof *s->meshlets);
    s->vertices = calloc(n[6] + 1, sizeof *s->vertices);
    s->triangles = calloc(n[7] + 1, sizeof *s->triangles);
    if (!s->lights || !s->materials || !s->objects || !s->meshes || !s->meshlets || !s->vertices || !s->triangles)
        return 1;
    for (unsigned i = 0; i < n[0]; i++)
        read_light(&s->lights[i], at[0] + LIGHT_SIZE * i);
    for (unsigned i = 0; i < n[1]; i++)
        read_material(&s->materials[i], at[1] + MATERIAL_SIZE * i);
    for (unsigned i = 0; i < n[2]; i++)
        read_object(&s->objects[i], at[2] + OBJECT_SIZE * i);
    for (unsigned i = 0; i < n[3]; i++) {
        const uint8_t *p = at[3] + MESH_SIZE * i;
        if (get_u32(p) >= n[4])
            return 1;
        get_box(s->meshes[i].lo, s->meshes[i].hi, p + 8);
        s->meshes[i].meshlet_first = get_u32(at[4] + (size_t)LOD_SIZE * get_u32(p));
        s->meshes[i].meshlet_count = get_u32(at[4] + (size_t)LOD_SIZE * get_u32(p) + 4);
        if ((uint64_t)s->meshes[i].meshlet_first + s->meshes[i].meshlet_count > n[5])
            return 1;
    }
    for (unsigned i = 0; i < n[7]; i++)
        for (int k = 0; k < 3; k++)
            s->triangles[i][k] = at[7][(size_t)TRIANGLE_SIZE * i + k];
    for (unsigned i = 0; i < n[5]; i++) {
        struct ref_meshlet *m = &s->meshlets[i];
        read_meshlet(m, at[5] + (size_t)MESHLET_SIZE * i);
        if ((uint64_t)m->vertex_first + m->vertex_count > n[6] ||
            (uint64_t)m->triangle_first + m->triangle_count > n[7])
            return 1;
        for (unsigned j = m->vertex_first; j < m->vertex_first + m->vertex_count; j++)
            read_vertex(&s->vertices[j], at[6] + (size_t)VERTEX_SIZE * j, m);
    }
    return 0;
}

struct ref_scene *ref_scene_open(const void *blob, size_t bytes)
{
    const uint8_t *b = blob;
    if (bytes < HEADER_SIZE || memcmp(b, "GTSC\4\0\220\0", 8) || get_u32(b + AT_TOTAL) != bytes)
        return NULL;
    struct ref_scene *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    for (int k = 0; k < 3; k++)
        s->camera.eye[k] = get_fixed(b + AT_CAMERA + 4 * k, 16);
    get_matrix(s->camera.rotation, b + AT_CAMERA + 12);
    s->camera.focal = get_ufixed(b + AT_CAMERA + 48, 16);
    s->camera.near = get_ufixed(b + AT_CAMERA + 52, 16);
    s->exposure = get_ufixed(b + AT_OUTPUT, 16);
    s->aces = b[AT_OUTPUT + 4] == 1;
    memcpy(s->background, b + AT_OUTPUT + 5, 3);
    if (read_arrays(s, b, bytes)) {
        ref_scene_close(s);
        return NULL;
    }
    return s;
}

void ref_scene_close(struct ref_scene *s)
{
    if (!s)
        return;
    free(s->lights);
    free(s->materials);
    free(s->objects);
    free(s->meshes);
    free(s->meshlets);
    free(s->vertices);
    free(s->triangles);
    free(s);
}
