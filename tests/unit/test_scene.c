/* The scene blob: what scene_open refuses, and what gtscene puts into the benchmark scene (GONIOTILE_SIX_MODELS). */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "ref_blob.h"
#include "ref_scene.h"
#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint32_t random_state = 1;

static uint32_t random_u32(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state;
}

static double random_signed(void)
{
    return random_u32() / 2147483648.0 - 1;
}

/* A tetrahedron in two objects, two materials, two lights: 144 + 64 + 112 + 120 + 20 + 12 + 176 + 120 + 12 bytes. */
static uint8_t *small_blob(size_t *bytes)
{
    static const int16_t vertices[4][3] = {{0, 0, 0}, {9000, 0, 0}, {0, 9000, 0}, {0, 0, 9000}};
    static const uint16_t triangles[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    struct ref_blob b;
    ref_blob_init(&b);
    ref_blob_light(&b, (const double[3]){0, 0, 1}, 3);
    ref_blob_light(&b, (const double[3]){1, 2, 3}, 1);
    ref_blob_material(&b, 0, 3, 0.5, "measured");
    ref_blob_material(&b, 1, 0, 0.5, "lambert");
    unsigned mesh = ref_blob_mesh(&b, vertices, triangles, 4);
    ref_blob_object(&b, mesh, 0, (const double[3]){0, 0, -3}, 1e-4);
    ref_blob_object(&b, mesh, 1, (const double[3]){1, 0, -3}, 1e-4);
    uint8_t *blob = ref_blob_finish(&b, bytes);
    ref_blob_free(&b);
    return blob;
}

/* Reads everything a renderer would. */
static uint64_t touch(const struct scene *s)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < s->header->objects.count; i++) {
        const struct scene_object *o = &s->objects[i];
        const struct scene_mesh *mesh = &s->meshes[o->mesh];
        sum += (uint64_t)s->materials[o->material].name[0] + mesh->hi[0];
        for (uint32_t j = 0; j < mesh->lod_count; j++) {
            const struct scene_lod *lod = &s->lods[mesh->lod_first + j];
            for (uint32_t k = 0; k < lod->meshlet_count; k++) {
                const struct scene_meshlet *m = &s->meshlets[lod->meshlet_first + k];
                for (unsigned t = 0; t < 3u * m->triangle_count; t++) {
                    unsigned v = s->triangles[m->triangle_first + t / 3].v[t % 3];
                    assert_true(v < m->vertex_count);
                    sum += (uint64_t)s->vertices[m->vertex_first + v].v;
                }
            }
        }
    }
    for (uint32_t i = 0; i < s->header->lights.count; i++)
        sum += (uint64_t)s->lights[i].irradiance[2];
    return sum;
}

static void open_accepts_a_small_scene(void **state)
{
    (void)state;
    size_t bytes;
    uint8_t *blob = small_blob(&bytes);
    struct scene s;
    assert_int_equal(scene_open(&s, blob, bytes), SCENE_OK);
    assert_ptr_equal(s.header, blob);
    assert_int_equal(s.header->triangles.count, 4);
    assert_ptr_equal(s.triangles, blob + s.header->triangles.offset);
    touch(&s);
    free(blob);
}

static void open_accepts_an_empty_scene(void **state)
{
    (void)state;
    struct ref_blob b;
    size_t bytes;
    struct scene s;
    ref_blob_init(&b);
    void *blob = ref_blob_finish(&b, &bytes);
    assert_int_equal(scene_open(&s, blob, bytes), SCENE_OK);
    assert_int_equal(s.header->objects.count, 0);
    free(blob);
    ref_blob_free(&b);
}

static void open_rejects_every_truncation(void **state)
{
    (void)state;
    size_t bytes;
    uint8_t *blob = small_blob(&bytes);
    struct scene s;
    for (size_t length = 0; length < bytes; length++) {
        uint8_t *cut = malloc(length + !length); /* exact size: the sanitizer sees any byte read beyond */
        memcpy(cut, blob, length);
        assert_int_equal(scene_open(&s, cut, length), SCENE_ERR_TRUNCATED);
        free(cut);
    }
    uint8_t *longer = calloc(1, bytes + 4);
    memcpy(longer, blob, bytes);
    assert_int_equal(scene_open(&s, longer, bytes + 4), SCENE_ERR_HEADER);
    assert_int_equal(scene_open(&s, longer + 1, bytes), SCENE_ERR_ALIGNMENT);
    free(longer);
    free(blob);
}

/* One field overwritten. `array` < 0: at a byte of the header, else at a byte of an array's first element. */
struct damage {
    const char *what;
    int array;
    size_t at, size;
    uint32_t value;
    enum scene_status status;
};
enum { LIGHTS, MATERIALS, OBJECTS, MESHES, LODS, MESHLETS, VERTICES, TRIANGLES };
#define HEADER(field)          -1, offsetof(struct scene_header, field), sizeof((struct scene_header *)0)->field
#define IN(array, type, field) array, offsetof(struct type, field), sizeof((struct type *)0)->field

static const struct damage damages[] = {
    {"magic", HEADER(magic), 0x43535448, SCENE_ERR_MAGIC},
    {"version newer", HEADER(version), 4, SCENE_ERR_VERSION},
    {"version older", HEADER(version), 2, SCENE_ERR_VERSION},
    {"header_bytes", HEADER(header_bytes), 140, SCENE_ERR_HEADER},
    {"total_bytes tiny", HEADER(total_bytes), 143, SCENE_ERR_HEADER},
    {"total_bytes short", HEADER(total_bytes), 144, SCENE_ERR_HEADER},
    {"total_bytes long", HEADER(total_bytes), 100000, SCENE_ERR_TRUNCATED},
    {"total_bytes huge", HEADER(total_bytes), 0xffffffff, SCENE_ERR_LIMIT},
    {"camera rotation 2", HEADER(camera.rotation[0]), 0x7fffffff, SCENE_ERR_CAMERA},
    {"camera rotation -2", HEADER(camera.rotation[4]), 0x80000000, SCENE_ERR_CAMERA},
    {"camera rotation skewed", HEADER(camera.rotation[1]), 1 << 17, SCENE_ERR_CAMERA},
    {"camera mirrored", HEADER(camera.rotation[0]), (uint32_t) - (1 << 30), SCENE_ERR_CAMERA},
    {"camera focal small", HEADER(camera.focal), 255, SCENE_ERR_CAMERA},
    {"camera focal large", HEADER(camera.focal), (1 << 24) + 1, SCENE_ERR_CAMERA},
    {"camera near", HEADER(camera.near), 0, SCENE_ERR_CAMERA},
    {"exposure", HEADER(output.exposure), (1 << 24) + 1, SCENE_ERR_OUTPUT},
    {"tone curve", HEADER(output.tone_curve), 3, SCENE_ERR_OUTPUT},
    {"level-of-detail threshold", HEADER(lod_error), (64 << 16) + 1, SCENE_ERR_OUTPUT},
    {"lights count", HEADER(lights.count), 129, SCENE_ERR_LIMIT},
    {"materials count", HEADER(materials.count), 65, SCENE_ERR_LIMIT},
    {"objects count", HEADER(objects.count), 4097, SCENE_ERR_LIMIT},
    {"objects long", HEADER(objects.count), 4096, SCENE_ERR_TRUNCATED},
    {"meshes count wraps", HEADER(meshes.count), 0xffffffff, SCENE_ERR_TRUNCATED},
    {"meshlets count wraps", HEADER(meshlets.count), 0x80000001, SCENE_ERR_TRUNCATED},
    {"vertices count", HEADER(vertices.count), 11, SCENE_ERR_MESHLET},
    {"triangles count", HEADER(triangles.count), 3, SCENE_ERR_MESHLET},
    {"meshes none", HEADER(meshes.count), 0, SCENE_ERR_OBJECT},
    {"materials one", HEADER(materials.count), 1, SCENE_ERR_OBJECT},
    {"lods none", HEADER(lods.count), 0, SCENE_ERR_MESH},
    {"meshlets three", HEADER(meshlets.count), 3, SCENE_ERR_MESH},
    {"offset inside the header", HEADER(lights.offset), 136, SCENE_ERR_HEADER},
    {"offset odd", HEADER(vertices.offset), 142, SCENE_ERR_ALIGNMENT},
    {"offset outside", HEADER(triangles.offset), 0xfffffffc, SCENE_ERR_TRUNCATED},
    {"light kind", IN(LIGHTS, scene_light, kind), 2, SCENE_ERR_LIGHT},
    {"light a point without radius", IN(LIGHTS, scene_light, kind), 1, SCENE_ERR_LIGHT},
    {"light directional with a radius", IN(LIGHTS, scene_light, radius), 1, SCENE_ERR_LIGHT},
    {"light reserved", IN(LIGHTS, scene_light, reserved[2]), 1, SCENE_ERR_LIGHT},
    {"light direction short", IN(LIGHTS, scene_light, direction[2]), 1 << 29, SCENE_ERR_LIGHT},
    {"light direction long", IN(LIGHTS, scene_light, direction[2]), 0x80000000, SCENE_ERR_LIGHT},
    {"light irradiance", IN(LIGHTS, scene_light, irradiance[1]), (1 << 24) + 1, SCENE_ERR_LIGHT},
    {"material kind", IN(MATERIALS, scene_material, kind), 4, SCENE_ERR_MATERIAL},
    {"material metallic without roughness", IN(MATERIALS, scene_material, kind), 3, SCENE_ERR_MATERIAL},
    {"material metalness", IN(MATERIALS, scene_material, metalness), 65537, SCENE_ERR_MATERIAL},
    {"material roughness", IN(MATERIALS, scene_material, roughness), 65537, SCENE_ERR_MATERIAL},
    {"material slot", IN(MATERIALS, scene_material, slot), 16, SCENE_ERR_MATERIAL},
    {"material reserved", IN(MATERIALS, scene_material, reserved[0]), 1, SCENE_ERR_MATERIAL},
    {"material kd", IN(MATERIALS, scene_material, kd[2]), 65537, SCENE_ERR_MATERIAL},
    {"material ks", IN(MATERIALS, scene_material, ks[0]), 65537, SCENE_ERR_MATERIAL},
    {"material exponent", IN(MATERIALS, scene_material, exponent), (4096 << 16) + 1, SCENE_ERR_MATERIAL},
    {"material name control", IN(MATERIALS, scene_material, name[1]), '\n', SCENE_ERR_MATERIAL},
    {"material name beyond ASCII", IN(MATERIALS, scene_material, name[1]), 0xe4, SCENE_ERR_MATERIAL},
    {"material name after NUL", IN(MATERIALS, scene_material, name[15]), 'a', SCENE_ERR_MATERIAL},
    {"object mesh", IN(OBJECTS, scene_object, mesh), 1, SCENE_ERR_OBJECT},
    {"object material", IN(OBJECTS, scene_object, material), 2, SCENE_ERR_OBJECT},
    {"object rotation", IN(OBJECTS, scene_object, rotation[8]), 0, SCENE_ERR_OBJECT},
    {"object mirrored", IN(OBJECTS, scene_object, rotation[0]), (uint32_t) - (1 << 30), SCENE_ERR_OBJECT},
    {"object mantissa small", IN(OBJECTS, scene_object, scale_mantissa), (1 << 30) - 1, SCENE_ERR_OBJECT},
    {"object mantissa large", IN(OBJECTS, scene_object, scale_mantissa), 1u << 31, SCENE_ERR_OBJECT},
    {"object shift large", IN(OBJECTS, scene_object, scale_shift), 41, SCENE_ERR_OBJECT},
    {"object shift negative", IN(OBJECTS, scene_object, scale_shift), 0xffffffff, SCENE_ERR_OBJECT},
    {"mesh lod_first", IN(MESHES, scene_mesh, lod_first), 1, SCENE_ERR_MESH},
    {"mesh lod_count 0", IN(MESHES, scene_mesh, lod_count), 0, SCENE_ERR_MESH},
    {"mesh lod_count wraps", IN(MESHES, scene_mesh, lod_count), 0xffffffff, SCENE_ERR_MESH},
    {"mesh box", IN(MESHES, scene_mesh, hi[1]), 8999, SCENE_ERR_MESH},
    {"mesh box low", IN(MESHES, scene_mesh, lo[2]), 1, SCENE_ERR_MESH},
    {"lod first", IN(LODS, scene_lod, meshlet_first), 1, SCENE_ERR_MESH},
    {"lod count 0", IN(LODS, scene_lod, meshlet_count), 0, SCENE_ERR_MESH},
    {"lod count wraps", IN(LODS, scene_lod, meshlet_count), 0xffffffff, SCENE_ERR_MESH},
    {"meshlet box", IN(MESHLETS, scene_meshlet, hi[0]), 8999, SCENE_ERR_MESHLET},
    {"meshlet frame large", IN(MESHLETS, scene_meshlet, frame[0]), 0x8000, SCENE_ERR_MESHLET},
    {"meshlet frame skewed", IN(MESHLETS, scene_meshlet, frame[2]), 64, SCENE_ERR_MESHLET},
    {"meshlet cone negative", IN(MESHLETS, scene_meshlet, cone_cutoff), 0xffff, SCENE_ERR_MESHLET},
    {"meshlet cone large", IN(MESHLETS, scene_meshlet, cone_cutoff), 16385, SCENE_ERR_MESHLET},
    {"meshlet vertex_first", IN(MESHLETS, scene_meshlet, vertex_first), 10, SCENE_ERR_MESHLET},
    {"meshlet vertex_first wraps", IN(MESHLETS, scene_meshlet, vertex_first), 0xffffffff, SCENE_ERR_MESHLET},
    {"meshlet triangle_first", IN(MESHLETS, scene_meshlet, triangle_first), 4, SCENE_ERR_MESHLET},
    {"meshlet two vertices", IN(MESHLETS, scene_meshlet, vertex_count), 2, SCENE_ERR_MESHLET},
    {"meshlet many vertices", IN(MESHLETS, scene_meshlet, vertex_count), 33, SCENE_ERR_MESHLET},
    {"meshlet no triangle", IN(MESHLETS, scene_meshlet, triangle_count), 0, SCENE_ERR_MESHLET},
    {"meshlet many triangles", IN(MESHLETS, scene_meshlet, triangle_count), 33, SCENE_ERR_MESHLET},
    {"meshlet reserved", IN(MESHLETS, scene_meshlet, reserved), 1, SCENE_ERR_MESHLET},
    {"vertex outside its box", IN(VERTICES, scene_vertex, x), 0x8000, SCENE_ERR_MESHLET},
    {"vertex normal", IN(VERTICES, scene_vertex, u), 16385, SCENE_ERR_MESHLET},
    {"vertex normal lowest", IN(VERTICES, scene_vertex, v), 0x8000, SCENE_ERR_MESHLET},
    {"triangle index", IN(TRIANGLES, scene_triangle, v[2]), 3, SCENE_ERR_MESHLET},
};

static void open_rejects_each_damaged_field_by_its_status(void **state)
{
    (void)state;
    bool seen[SCENE_STATUS_COUNT] = {false};
    size_t bytes;
    uint8_t *blob = small_blob(&bytes);
    for (size_t i = 0; i < sizeof damages / sizeof *damages; i++) {
        const struct damage *d = &damages[i];
        uint8_t *copy = memcpy(malloc(bytes), blob, bytes);
        const struct scene_array *arrays = &((const struct scene_header *)(const void *)blob)->lights;
        struct scene s, untouched;
        memset(&s, 0x55, sizeof s);
        untouched = s;
        memcpy(copy + d->at + (d->array < 0 ? 0 : arrays[d->array].offset), &d->value, d->size);
        enum scene_status status = scene_open(&s, copy, bytes);
        if (status != d->status)
            fail_msg("%s: %s", d->what, scene_status_text(status));
        assert_memory_equal(&s, &untouched, sizeof s);
        seen[status] = true;
        free(copy);
    }
    for (int i = SCENE_ERR_MAGIC; i < SCENE_STATUS_COUNT; i++)
        assert_true(seen[i]);
    free(blob);
}

static void point_lights_are_checked(void **state)
{
    (void)state;
    const struct scene_light good = {.kind = SCENE_LIGHT_POINT,
                                     .position = {INT32_MIN, 0, INT32_MAX},
                                     .irradiance = {0, 1, UINT32_MAX},
                                     .radius = 1};
    struct scene_light l = good;
    assert_int_equal(scene_check_light(&l), SCENE_OK);
    l.radius = SCENE_MAX_RADIUS;
    assert_int_equal(scene_check_light(&l), SCENE_OK);
    l.radius = SCENE_MAX_RADIUS + 1;
    assert_int_equal(scene_check_light(&l), SCENE_ERR_LIGHT);
    l.radius = 0;
    assert_int_equal(scene_check_light(&l), SCENE_ERR_LIGHT);
    for (int i = 0; i < 3; i++) {
        l = good;
        l.reserved[i] = 1;
        assert_int_equal(scene_check_light(&l), SCENE_ERR_LIGHT);
    }
    l = good;
    l.kind = 2;
    assert_int_equal(scene_check_light(&l), SCENE_ERR_LIGHT);
    l.kind = SCENE_LIGHT_DIRECTIONAL; /* what is a position is no direction */
    assert_int_equal(scene_check_light(&l), SCENE_ERR_LIGHT);
}

static void reference_reader_agrees_on_point_lights(void **state)
{
    (void)state;
    size_t bytes;
    uint8_t *blob = small_blob(&bytes);
    const struct scene_light l = {.kind = SCENE_LIGHT_POINT,
                                  .position = {-98304, 1, INT32_MAX},
                                  .irradiance = {3 << 15, 0, UINT32_MAX},
                                  .radius = 5 << 14};
    memcpy(blob + ((const struct scene_header *)(const void *)blob)->lights.offset, &l, sizeof l);
    struct ref_scene *r = ref_scene_open(blob, bytes);
    assert_non_null(r);
    assert_true(r->lights[0].point && !r->lights[1].point && r->lights[0].radius == 1.25);
    for (int k = 0; k < 3; k++) {
        assert_true(r->lights[0].position[k] == l.position[k] / 65536.0);
        assert_true(r->lights[0].irradiance[k] == l.irradiance[k] / 65536.0);
    }
    ref_scene_close(r);
    free(blob);
}

static enum scene_status open_with_material(const struct scene_material *m)
{
    size_t bytes;
    struct scene s;
    uint8_t *blob = small_blob(&bytes);
    const struct scene_header *h = (const struct scene_header *)(const void *)blob;
    memcpy(blob + h->materials.offset + sizeof *m, m, sizeof *m); /* the second one */
    enum scene_status status = scene_open(&s, blob, bytes);
    free(blob);
    return status;
}

static void metallic_roughness_materials_are_checked(void **state)
{
    (void)state;
    const struct scene_material good = {.kind = SCENE_MATERIAL_METALLIC_ROUGHNESS,
                                        .kd = {65536, 0, 1},
                                        .metalness = 65536,
                                        .roughness = SCENE_MIN_ROUGHNESS,
                                        .name = "gold"};
    struct scene_material m = good;
    assert_int_equal(open_with_material(&m), SCENE_OK);
    m.roughness = 65536;
    m.metalness = 0;
    assert_int_equal(open_with_material(&m), SCENE_OK);
    m.roughness = SCENE_MIN_ROUGHNESS - 1;
    assert_int_equal(open_with_material(&m), SCENE_ERR_MATERIAL);
    m = good;
    m.metalness = 65537;
    assert_int_equal(open_with_material(&m), SCENE_ERR_MATERIAL);
    for (int k = 0; k < 3; k++) {
        m = good;
        m.ks[k] = 1;
        assert_int_equal(open_with_material(&m), SCENE_ERR_MATERIAL);
        m.kind = SCENE_MATERIAL_BLINN_PHONG; /* which may say what it is as the other */
        assert_int_equal(open_with_material(&m), SCENE_OK);
    }
}

static void open_survives_random_damage(void **state)
{
    (void)state;
    size_t bytes, accepted = 0;
    uint8_t *blob = small_blob(&bytes), *copy = malloc(bytes);
    for (int i = 0; i < 100000; i++) {
        memcpy(copy, blob, bytes);
        for (unsigned n = 1 + random_u32() % 4; n; n--)
            copy[random_u32() % bytes] = (uint8_t)(random_u32() >> 24);
        struct scene s;
        enum scene_status status = scene_open(&s, copy, bytes);
        assert_true((unsigned)status < SCENE_STATUS_COUNT);
        if (status == SCENE_OK) {
            touch(&s);
            accepted++;
        }
    }
    assert_in_range(accepted, 1000, 60000); /* names, colours and positions may change, structure may not */
    free(copy);
    free(blob);
}

static void open_is_linear_in_hostile_blobs(void **state)
{
    (void)state;
    /* 20,000 meshes that all claim the same 20,000 levels: checked one by one this would be 4e8 steps. */
    enum { COUNT = 20000 };
    size_t bytes, extra = COUNT * (sizeof(struct scene_mesh) + sizeof(struct scene_lod));
    uint8_t *small = small_blob(&bytes), *blob = calloc(1, bytes + extra);
    memcpy(blob, small, bytes);
    struct scene_header *h = (struct scene_header *)(void *)blob;
    struct scene_mesh *meshes = (struct scene_mesh *)(void *)(blob + bytes);
    struct scene_lod *lods = (struct scene_lod *)(void *)(meshes + COUNT);
    for (int i = 0; i < COUNT; i++) {
        meshes[i] = (struct scene_mesh){0, COUNT, {0, 0, 0}, {9000, 9000, 9000}};
        lods[i] = (struct scene_lod){0, 1, 0};
    }
    h->total_bytes = (uint32_t)(bytes + extra);
    h->meshes = (struct scene_array){(uint32_t)bytes, COUNT};
    h->lods = (struct scene_array){(uint32_t)(bytes + COUNT * sizeof *meshes), COUNT};
    struct scene s;
    assert_int_equal(scene_open(&s, blob, bytes + extra), SCENE_ERR_MESH);
    free(blob);
    free(small);
}

static void every_status_has_its_own_text(void **state)
{
    (void)state;
    for (int i = 0; i <= SCENE_STATUS_COUNT; i++) {
        assert_true(strlen(scene_status_text((enum scene_status)i)) > 5);
        for (int j = 0; j < i; j++)
            assert_string_not_equal(scene_status_text((enum scene_status)i), scene_status_text((enum scene_status)j));
    }
}

/* The benchmark scene, both ways. */
static uint8_t *six_blob;
static size_t six_bytes;
static struct scene six;
static struct ref_scene *ref;

static int open_six(void **state)
{
    (void)state;
    const char *path = getenv("GONIOTILE_SIX_MODELS");
    FILE *f = path ? fopen(path, "rb") : NULL;
    if (!f)
        return 1;
    six_blob = malloc(4 << 20);
    six_bytes = fread(six_blob, 1, 4 << 20, f);
    fclose(f);
    ref = ref_scene_open(six_blob, six_bytes);
    return !ref || scene_open(&six, six_blob, six_bytes) != SCENE_OK;
}

static int close_six(void **state)
{
    (void)state;
    ref_scene_close(ref);
    free(six_blob);
    return 0;
}

static void benchmark_scene_is_what_it_says(void **state)
{
    (void)state;
    unsigned total = 0;
    assert_int_equal(ref->object_count, 6);
    assert_int_equal(ref->light_count, 3);
    assert_int_equal(ref->material_count, 6);
    for (unsigned i = 0; i < 6; i++) {
        assert_int_equal(ref->materials[i].slot, i);
        assert_true(ref->materials[i].measured);
        unsigned triangles = 0;
        const struct ref_mesh *m = &ref->meshes[i];
        for (unsigned j = 0; j < m->meshlet_count; j++)
            triangles += ref->meshlets[m->meshlet_first + j].triangle_count;
        assert_in_range(triangles, 4600, 5400);
        total += triangles;
    }
    assert_in_range(total, 29000, 31000);
}

static void reference_reader_agrees_with_the_structures(void **state)
{
    (void)state;
    const struct scene_header *h = six.header;
    assert_true(ref->camera.focal == h->camera.focal / 65536.0 && ref->camera.near == h->camera.near / 65536.0);
    assert_true(ref->camera.rotation[1][2] == ldexp(h->camera.rotation[5], -30));
    assert_true(ref->exposure == h->output.exposure / 65536.0 && ref->aces == h->output.tone_curve);
    assert_memory_equal(ref->background, h->output.background, 3);
    for (unsigned i = 0; i < 3; i++) {
        assert_true(fabs(ref->lights[i].direction[1] - ldexp(six.lights[i].direction[1], -30)) < 1e-8);
        assert_true(ref->lights[i].irradiance[2] == six.lights[i].irradiance[2] / 65536.0);
    }
    for (unsigned i = 0; i < 6; i++) {
        const struct scene_object *o = &six.objects[i];
        const struct scene_material *m = &six.materials[i];
        assert_string_equal(ref->materials[i].name, m->name);
        assert_true(ref->materials[i].ks[1] == m->ks[1] / 65536.0 && ref->materials[i].kd[0] == m->kd[0] / 65536.0);
        assert_true(ref->materials[i].exponent == m->exponent / 65536.0);
        assert_true(ref->materials[i].roughness == m->roughness / 65536.0);
        assert_true(ref->objects[i].matrix[2][3] == o->position[2] / 65536.0);
        assert_true(ref->objects[i].matrix[1][0] ==
                    ldexp(o->scale_mantissa, -30 - o->scale_shift) * ldexp(o->rotation[3], -30));
    }
    for (unsigned i = 0; i < ref->meshlet_count; i++) {
        const struct scene_meshlet *m = &six.meshlets[i];
        assert_int_equal(ref->meshlets[i].vertex_first, m->vertex_first);
        assert_true(ref->meshlets[i].frame[2][1] == m->frame[7] / 16384.0);
        assert_true(ref->meshlets[i].cone_cutoff == m->cone_cutoff / 16384.0 && ref->meshlets[i].hi[2] == m->hi[2]);
        assert_true(ref->vertices[m->vertex_first].position[2] == six.vertices[m->vertex_first].z);
        assert_int_equal(ref->triangles[m->triangle_first][1], six.triangles[m->triangle_first].v[1]);
    }
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Corners of triangle t of meshlet m, and its geometric normal (any length). */
static void triangle_get(const double *corner[3], double normal[3], const struct ref_meshlet *m, unsigned t)
{
    double e[2][3];
    for (int k = 0; k < 3; k++)
        corner[k] = ref->vertices[m->vertex_first + ref->triangles[m->triangle_first + t][k]].position;
    for (int k = 0; k < 3; k++) {
        e[0][k] = corner[1][k] - corner[0][k];
        e[1][k] = corner[2][k] - corner[0][k];
    }
    for (int k = 0; k < 3; k++)
        normal[k] = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
}

static void boxes_are_tight(void **state)
{
    (void)state;
    for (unsigned i = 0; i < ref->mesh_count; i++) {
        double lo[3] = {1e9, 1e9, 1e9}, hi[3] = {-1e9, -1e9, -1e9};
        const struct scene_lod *first = &six.lods[six.meshes[i].lod_first], *last = first + six.meshes[i].lod_count - 1;
        for (unsigned j = first->meshlet_first; j < last->meshlet_first + last->meshlet_count;
             j++) { /* of all levels */
            const struct ref_meshlet *m = &ref->meshlets[j];
            for (int k = 0; k < 3; k++) {
                double least = 1e9, most = -1e9;
                for (unsigned v = m->vertex_first; v < m->vertex_first + m->vertex_count; v++) {
                    least = fmin(least, ref->vertices[v].position[k]);
                    most = fmax(most, ref->vertices[v].position[k]);
                }
                assert_true(m->lo[k] == least && m->hi[k] == most);
                lo[k] = fmin(lo[k], least);
                hi[k] = fmax(hi[k], most);
            }
        }
        double largest = 0;
        for (int k = 0; k < 3; k++) {
            assert_true(ref->meshes[i].lo[k] == lo[k] && ref->meshes[i].hi[k] == hi[k]);
            largest = fmax(largest, fmax(-lo[k], hi[k]));
        }
        assert_true(largest == 32767); /* the whole range is used */
    }
}

static bool is_finest(unsigned meshlet)
{
    for (unsigned i = 0; i < ref->mesh_count; i++)
        if (meshlet - ref->meshes[i].meshlet_first < ref->meshes[i].meshlet_count)
            return true;
    return false;
}

/* Is the whole box in the (convex) region where the cone test culls? */
static bool cone_culls(const struct ref_meshlet *m, const double eye[3])
{
    for (int i = 0; i < 8; i++) {
        double d[3];
        for (int k = 0; k < 3; k++)
            d[k] = (i >> k & 1 ? m->hi[k] : m->lo[k]) - eye[k];
        if (!(dot(d, m->frame[2]) >= m->cone_cutoff * sqrt(dot(d, d))))
            return false;
    }
    return m->cone_cutoff < 1;
}

static void cones_never_cull_a_triangle_that_faces_the_eye(void **state)
{
    (void)state;
    unsigned culled[2] = {0, 0}, hidden[2] = {0, 0}; /* of coarser levels, of the finest */
    for (unsigned i = 0; i < ref->meshlet_count; i++) {
        const struct ref_meshlet *m = &ref->meshlets[i];
        for (int n = 0; n < 200; n++) {
            double eye[3], reach = n % 2 ? 2e5 : 4e4;
            bool faces = false;
            for (int k = 0; k < 3; k++)
                eye[k] = reach * random_signed();
            for (unsigned t = 0; t < m->triangle_count && !faces; t++) {
                const double *corner[3];
                double normal[3], d[3];
                triangle_get(corner, normal, m, t);
                for (int k = 0; k < 3; k++)
                    d[k] = eye[k] - corner[0][k];
                faces = dot(d, normal) > 0;
            }
            hidden[is_finest(i)] += !faces;
            if (cone_culls(m, eye)) {
                culled[is_finest(i)]++;
                assert_false(faces);
            }
        }
    }
    /* not by disabling the test: it finds most of what can be found */
    print_message("# cones cull %.1f %% of the finest meshlets that face away, %.1f %% of coarser ones\n",
                  100.0 * culled[1] / hidden[1], 100.0 * culled[0] / hidden[0]);
    assert_true(culled[1] > 0.7 * hidden[1] && culled[0] > 0.3 * hidden[0]);
}

static void cone_cutoffs_are_the_sine_of_the_widest_normal_rounded_up(void **state)
{
    (void)state;
    for (unsigned i = 0; i < ref->meshlet_count; i++) {
        const struct ref_meshlet *m = &ref->meshlets[i];
        double z_length = sqrt(dot(m->frame[2], m->frame[2])), sine = 0;
        for (unsigned t = 0; t < m->triangle_count; t++) {
            const double *corner[3];
            double g[3], across = 0;
            triangle_get(corner, g, m, t);
            double along = dot(g, m->frame[2]) / z_length;
            for (int k = 0; k < 3; k++)
                across += pow(g[k] - along * m->frame[2][k] / z_length, 2);
            sine = along <= 0 ? 2 : fmax(sine, sqrt(across / dot(g, g)));
        }
        /* the test multiplies by the rounded axis, whose length differs from 1: the cutoff makes good for it */
        assert_true(m->cone_cutoff >= fmin(1, sine * z_length));
        assert_true(m->cone_cutoff <= sine + 4.0 / 16384 || m->cone_cutoff == 1);
    }
}

static void meshes_are_closed_and_face_outwards(void **state)
{
    (void)state;
    for (unsigned i = 0; i < ref->mesh_count; i++) {
        const struct ref_mesh *mesh = &ref->meshes[i];
        enum { SLOTS = 1 << 16 };
        /* Edges by their end points: +1 in one direction, -1 in the other; equal hashes share a slot. */
        int *balance = calloc(SLOTS, sizeof *balance);
        double volume = 0;
        for (unsigned j = 0; j < mesh->meshlet_count; j++) {
            const struct ref_meshlet *m = &ref->meshlets[mesh->meshlet_first + j];
            for (unsigned t = 0; t < m->triangle_count; t++) {
                const double *corner[3];
                double normal[3];
                triangle_get(corner, normal, m, t);
                volume += dot(normal, corner[0]);
                for (int k = 0; k < 3; k++) {
                    const double *a = corner[k], *b = corner[(k + 1) % 3];
                    int order = memcmp(a, b, 3 * sizeof *a);
                    const double *first = order < 0 ? a : b, *second = order < 0 ? b : a;
                    uint32_t hash = 0;
                    for (int c = 0; c < 6; c++)
                        hash = (hash ^ (uint32_t)((c < 3 ? first[c] : second[c - 3]) + 40000)) * 2654435761u;
                    balance[hash >> 16] += order < 0 ? 1 : -1;
                }
            }
        }
        for (int j = 0; j < SLOTS; j++)
            assert_int_equal(balance[j], 0);
        assert_true(volume > 0);
        free(balance);
    }
}

/* The sphere (mesh 0) has its normals and radius by definition, whatever gtscene did. Positions are rounded to half a
 * unit of 32767 per axis; normals by 2^-15 in u and v, which doubles, and by the frame's own rounding. */
static void sphere_is_within_the_quantisation_bounds(void **state)
{
    (void)state;
    double worst_angle = 0, worst_radius = 0;
    for (unsigned j = 0; j < ref->meshes[0].meshlet_count; j++) {
        const struct ref_meshlet *m = &ref->meshlets[ref->meshes[0].meshlet_first + j];
        for (unsigned v = m->vertex_first; v < m->vertex_first + m->vertex_count; v++) {
            const double *p = ref->vertices[v].position, *n = ref->vertices[v].normal;
            double length = sqrt(dot(p, p)), across = 0;
            for (int k = 0; k < 3; k++)
                across += pow(n[k] - p[k] / length, 2);
            worst_angle = fmax(worst_angle, sqrt(across));
            worst_radius = fmax(worst_radius, fabs(length - 32767));
        }
    }
    print_message("# sphere: normals within %.2e rad, radius within %.2f units\n", worst_angle, worst_radius);
    assert_true(worst_radius <= 0.8661); /* sqrt(3)/2 */
    assert_true(worst_angle <= 2e-4);
}

static void normals_agree_with_the_triangles(void **state)
{
    (void)state;
    /* Every vertex normal of a finest level is within 60 degrees of its triangles': no flipped or garbled one. */
    for (unsigned i = 0; i < ref->meshlet_count; i++)
        for (unsigned t = 0; t < ref->meshlets[i].triangle_count && is_finest(i); t++) {
            const struct ref_meshlet *m = &ref->meshlets[i];
            const double *corner[3];
            double g[3];
            triangle_get(corner, g, m, t);
            for (int k = 0; k < 3; k++) {
                const double *n = ref->vertices[m->vertex_first + ref->triangles[m->triangle_first + t][k]].normal;
                assert_true(dot(n, g) > 0.5 * sqrt(dot(g, g)));
            }
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(open_accepts_a_small_scene),
        cmocka_unit_test(open_accepts_an_empty_scene),
        cmocka_unit_test(open_rejects_every_truncation),
        cmocka_unit_test(open_rejects_each_damaged_field_by_its_status),
        cmocka_unit_test(point_lights_are_checked),
        cmocka_unit_test(reference_reader_agrees_on_point_lights),
        cmocka_unit_test(metallic_roughness_materials_are_checked),
        cmocka_unit_test(open_survives_random_damage),
        cmocka_unit_test(open_is_linear_in_hostile_blobs),
        cmocka_unit_test(every_status_has_its_own_text),
    };
    const struct CMUnitTest built[] = {
        cmocka_unit_test(benchmark_scene_is_what_it_says),
        cmocka_unit_test(reference_reader_agrees_with_the_structures),
        cmocka_unit_test(boxes_are_tight),
        cmocka_unit_test(cones_never_cull_a_triangle_that_faces_the_eye),
        cmocka_unit_test(cone_cutoffs_are_the_sine_of_the_widest_normal_rounded_up),
        cmocka_unit_test(meshes_are_closed_and_face_outwards),
        cmocka_unit_test(sphere_is_within_the_quantisation_bounds),
        cmocka_unit_test(normals_agree_with_the_triangles),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    return cmocka_run_group_tests(built, open_six, close_six) + failed;
}
