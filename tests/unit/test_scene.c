/* The scene blob: what scene_open accepts and what it refuses. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "ref_blob.h"
#include "ref_scene.h"
#include "scene.h"

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
    {"version newer", HEADER(version), 5, SCENE_ERR_VERSION},
    {"version older", HEADER(version), 3, SCENE_ERR_VERSION},
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
    {"meshlet area small", IN(MESHLETS, scene_meshlet, area), 0, SCENE_ERR_MESHLET},
    {"meshlet perimeter small", IN(MESHLETS, scene_meshlet, perimeter), 0, SCENE_ERR_MESHLET},
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
        enum scene_status status = scene_open_bounded(&s, copy, bytes);
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

/* Nothing is drawn by them: a program without budgets does not pay for measuring. */
static void sizes_of_meshlets_are_asked_of_bounded_scenes_alone(void **state)
{
    (void)state;
    size_t bytes;
    uint8_t *blob = small_blob(&bytes);
    struct scene_meshlet *m =
        (struct scene_meshlet *)(void *)(blob + ((const struct scene_header *)(const void *)blob)->meshlets.offset);
    struct scene s;
    assert_int_equal(scene_open_bounded(&s, blob, bytes), SCENE_OK);
    assert_ptr_equal(s.meshlets, m);
    m->perimeter--;
    assert_int_equal(scene_open_bounded(&s, blob, bytes), SCENE_ERR_MESHLET);
    assert_int_equal(scene_open(&s, blob, bytes), SCENE_OK);
    touch(&s);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(open_accepts_a_small_scene),
        cmocka_unit_test(open_accepts_an_empty_scene),
        cmocka_unit_test(open_rejects_every_truncation),
        cmocka_unit_test(open_rejects_each_damaged_field_by_its_status),
        cmocka_unit_test(sizes_of_meshlets_are_asked_of_bounded_scenes_alone),
        cmocka_unit_test(point_lights_are_checked),
        cmocka_unit_test(reference_reader_agrees_on_point_lights),
        cmocka_unit_test(metallic_roughness_materials_are_checked),
        cmocka_unit_test(open_survives_random_damage),
        cmocka_unit_test(open_is_linear_in_hostile_blobs),
        cmocka_unit_test(every_status_has_its_own_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
