#include "scenes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene.h"

static const double pi = 3.14159265358979323846;

enum { ARRAYS = 8, UNITS = 30000 }; /* vertex units of a mesh of size 1 */

struct array {
    uint8_t *data;
    size_t bytes, room;
    uint32_t count;
};

struct maker {
    uint64_t random;
    struct scene_header header;
    struct array lights, materials, objects, meshes, lods, meshlets, vertices, triangles;
    bool broad; /* lobes of a power up to 1 */
};

/* --- random numbers --- */

static uint32_t draw(struct maker *k, uint32_t below)
{
    k->random = k->random * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)((k->random >> 32) * below >> 32);
}

static double between(struct maker *k, double lo, double hi)
{
    return lo + (hi - lo) * draw(k, 1u << 24) / (1u << 24);
}

/* --- vectors --- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Returns the length it had. */
static double normalize(double v[3])
{
    double length = sqrt(dot(v, v));
    for (int i = 0; i < 3 && length > 0; i++)
        v[i] /= length;
    return length;
}

static void any_axes(double x[3], double y[3], const double z[3])
{
    const double up[3] = {fabs(z[0]) < 0.7, fabs(z[0]) >= 0.7, 0};
    cross(x, up, z);
    normalize(x);
    cross(y, z, x);
}

static int32_t fixed(double x, int bits)
{
    return (int32_t)lrint(ldexp(x, bits));
}

/* --- arrays --- */

static void *append(struct array *a, size_t size)
{
    if (a->bytes + size > a->room) {
        a->room = 2 * a->room + size + 4096;
        a->data = realloc(a->data, a->room);
        if (!a->data)
            abort();
    }
    void *p = memset(a->data + a->bytes, 0, size);
    a->bytes += size;
    a->count++;
    return p;
}

static void *finish(struct maker *k, size_t *bytes)
{
    struct array *arrays[ARRAYS] = {&k->lights, &k->materials, &k->objects,  &k->meshes,
                                    &k->lods,   &k->meshlets,  &k->vertices, &k->triangles};
    struct scene_array *place = &k->header.lights;
    size_t at = sizeof k->header;
    for (int i = 0; i < ARRAYS; i++) {
        place[i] = (struct scene_array){(uint32_t)at, arrays[i]->count};
        at += (arrays[i]->bytes + 3) & ~(size_t)3;
    }
    k->header.magic = SCENE_MAGIC;
    k->header.version = SCENE_VERSION;
    k->header.header_bytes = sizeof k->header;
    k->header.total_bytes = (uint32_t)at;
    uint8_t *blob = calloc(1, at);
    if (!blob)
        abort();
    memcpy(blob, &k->header, sizeof k->header);
    for (int i = 0; i < ARRAYS; i++) {
        if (arrays[i]->bytes)
            memcpy(blob + place[i].offset, arrays[i]->data, arrays[i]->bytes);
        free(arrays[i]->data);
    }
    *bytes = at;
    return blob;
}

/* --- what a scene holds --- */

static void camera_set(struct maker *k, const double eye[3], const double target[3], double degrees, double near)
{
    struct scene_camera *c = &k->header.camera;
    double right[3], up[3], back[3];
    for (int i = 0; i < 3; i++)
        back[i] = eye[i] - target[i];
    normalize(back);
    cross(right, (const double[3]){0, 1, 0}, back);
    normalize(right);
    cross(up, back, right);
    for (int i = 0; i < 3; i++) {
        c->eye[i] = fixed(eye[i], 16);
        c->rotation[i] = fixed(right[i], 30);
        c->rotation[3 + i] = fixed(up[i], 30);
        c->rotation[6 + i] = fixed(back[i], 30);
    }
    c->focal = (uint32_t)fixed(1 / tan(degrees * pi / 360), 16);
    c->near = (uint32_t)fixed(near, 16);
}

static void light_directional(struct maker *k, const double direction[3], double irradiance)
{
    struct scene_light *l = append(&k->lights, sizeof *l);
    double d[3] = {direction[0], direction[1], direction[2]};
    normalize(d);
    l->kind = SCENE_LIGHT_DIRECTIONAL;
    for (int i = 0; i < 3; i++) {
        l->direction[i] = fixed(d[i], 30);
        l->irradiance[i] = (uint32_t)fixed(irradiance * (1 - 0.1 * i), 16);
    }
}

static void light_point(struct maker *k, const double position[3], double intensity, double radius)
{
    struct scene_light *l = append(&k->lights, sizeof *l);
    l->kind = SCENE_LIGHT_POINT;
    l->radius = (uint32_t)fixed(radius, 16);
    for (int i = 0; i < 3; i++) {
        l->position[i] = fixed(position[i], 16);
        l->irradiance[i] = (uint32_t)fixed(intensity * (1 - 0.1 * i), 16);
    }
}

/* The n-th of the ways in which a material can be shaded: two half-vector tables, the other table, four models, two of them in rows. */
enum { SHADINGS = 8 };
static void material_add(struct maker *k, unsigned n)
{
    static const uint8_t kinds[SHADINGS] = {SCENE_MATERIAL_MEASURED,    SCENE_MATERIAL_LAFORTUNE_PHONG,
                                            SCENE_MATERIAL_MEASURED,    SCENE_MATERIAL_BLINN_PHONG,
                                            SCENE_MATERIAL_MEASURED,    SCENE_MATERIAL_METALLIC_ROUGHNESS,
                                            SCENE_MATERIAL_BLINN_PHONG, SCENE_MATERIAL_LAFORTUNE_PHONG};
    struct scene_material *m = append(&k->materials, sizeof *m);
    n %= SHADINGS;
    m->kind = kinds[n];
    m->slot = n == 0 ? 0 : n == 2 ? 1 : SCENES_SPECULAR_FRAME_SLOT;
    for (int i = 0; i < 3; i++) {
        m->kd[i] = (uint32_t)fixed(between(k, 0.1, 0.6), 16);
        m->ks[i] = m->kind == SCENE_MATERIAL_METALLIC_ROUGHNESS || n == 7 ? 0 : (uint32_t)fixed(0.3, 16);
    }
    m->exponent = (uint32_t)fixed(k->broad ? between(k, 0.2, 1) : n == 6 ? 32 : between(k, 5, 200), 16);
    m->metalness = (uint32_t)fixed(draw(k, 2), 16);
    m->roughness = (uint32_t)fixed(between(k, 0.1, 0.9), 16);
    memcpy(m->name, "material", 8);
}

static void object_add(struct maker *k, uint32_t mesh, uint32_t material, const double position[3], double size,
                       double turn)
{
    struct scene_object *o = append(&k->objects, sizeof *o);
    double scale = size / UNITS;
    const double rotation[9] = {cos(turn), 0, sin(turn), 0, 1, 0, -sin(turn), 0, cos(turn)};
    o->mesh = (uint16_t)mesh;
    o->material = (uint16_t)material;
    for (int i = 0; i < 3; i++)
        o->position[i] = fixed(position[i], 16);
    for (int i = 0; i < 9; i++)
        o->rotation[i] = fixed(rotation[i], 30);
    while (scale < 1) {
        scale *= 2;
        o->scale_shift++;
    }
    o->scale_mantissa = (uint32_t)fixed(scale, 30);
}

/* --- meshes --- */

struct corner {
    double p[3], n[3]; /* in units of UNITS; unit normal */
};

struct triangle {
    uint8_t v[3];
};

static uint32_t mesh_begin(struct maker *k)
{
    struct scene_mesh *m = append(&k->meshes, sizeof *m);
    m->lod_first = k->lods.count;
    for (int i = 0; i < 3; i++) {
        m->lo[i] = INT16_MAX;
        m->hi[i] = INT16_MIN;
    }
    return k->meshes.count - 1;
}

static struct scene_mesh *last_mesh(struct maker *k)
{
    return &((struct scene_mesh *)(void *)k->meshes.data)[k->meshes.count - 1];
}

/* The last mesh's next level; `error` in units of UNITS. */
static void level_begin(struct maker *k, double error)
{
    struct scene_lod *l = append(&k->lods, sizeof *l);
    l->meshlet_first = k->meshlets.count;
    l->error = (uint32_t)ceil(error * UNITS);
    last_mesh(k)->lod_count++;
}

static void normal_of(double n[3], const struct corner *c, const struct triangle *t)
{
    double e[3], f[3];
    for (int i = 0; i < 3; i++) {
        e[i] = c[t->v[1]].p[i] - c[t->v[0]].p[i];
        f[i] = c[t->v[2]].p[i] - c[t->v[0]].p[i];
    }
    cross(n, e, f);
    normalize(n);
}

static void frame_find(struct scene_meshlet *m, double axis[3][3], const struct corner *c, unsigned corners,
                       const struct triangle *t, unsigned triangles)
{
    double least = 1;
    memset(axis, 0, 9 * sizeof axis[0][0]);
    for (unsigned i = 0; i < corners; i++)
        for (int j = 0; j < 3; j++)
            axis[2][j] += c[i].n[j];
    normalize(axis[2]);
    any_axes(axis[0], axis[1], axis[2]);
    for (int i = 0; i < 9; i++)
        m->frame[i] = (int16_t)fixed(axis[i / 3][i % 3], 14);
    for (unsigned i = 0; i < triangles; i++) {
        double g[3];
        normal_of(g, c, &t[i]);
        least = fmin(least, dot(g, axis[2]));
    }
    m->cone_cutoff = least > 0.05 ? (int16_t)fmin(16384, ceil(16384 * sqrt(1 - least * least) * 1.001 + 8)) : 16384;
}

/* A meshlet of the last mesh's last level. */
static void meshlet_add(struct maker *k, const struct corner *c, unsigned corners, const struct triangle *t,
                        unsigned triangles)
{
    struct scene_mesh *mesh = last_mesh(k);
    struct scene_meshlet m = {.vertex_first = k->vertices.count,
                              .triangle_first = k->triangles.count,
                              .vertex_count = (uint8_t)corners,
                              .triangle_count = (uint8_t)triangles};
    double axis[3][3];
    frame_find(&m, axis, c, corners, t, triangles);
    for (int i = 0; i < 3; i++) {
        m.lo[i] = INT16_MAX;
        m.hi[i] = INT16_MIN;
    }
    for (unsigned i = 0; i < corners; i++) {
        struct scene_vertex *v = append(&k->vertices, sizeof *v);
        const double z = 1 + fmax(dot(c[i].n, axis[2]), 0.01);
        int16_t p[3];
        for (int j = 0; j < 3; j++) {
            p[j] = (int16_t)lrint(c[i].p[j] * UNITS);
            m.lo[j] = p[j] < m.lo[j] ? p[j] : m.lo[j];
            m.hi[j] = p[j] > m.hi[j] ? p[j] : m.hi[j];
            mesh->lo[j] = p[j] < mesh->lo[j] ? p[j] : mesh->lo[j];
            mesh->hi[j] = p[j] > mesh->hi[j] ? p[j] : mesh->hi[j];
        }
        *v = (struct scene_vertex){p[0], p[1], p[2], (int16_t)fixed(dot(c[i].n, axis[0]) / z * 0.999, 14),
                                   (int16_t)fixed(dot(c[i].n, axis[1]) / z * 0.999, 14)};
    }
    for (unsigned i = 0; i < triangles; i++)
        memcpy(append(&k->triangles, sizeof *t), &t[i], sizeof *t);
    scene_measure(&m, (const struct scene_vertex *)(const void *)k->vertices.data,
                  (const struct scene_triangle *)(const void *)k->triangles.data);
    memcpy(append(&k->meshlets, sizeof m), &m, sizeof m);
    ((struct scene_lod *)(void *)k->lods.data)[k->lods.count - 1].meshlet_count++;
}

/* A surface over 0..1 x 0..1; corners' order is counter-clockwise where (d/du x d/dv) is its normal. */
typedef void surface(struct corner *c, double u, double v);

static void sphere(struct corner *c, double u, double v)
{
    const double a = 2 * pi * u, b = pi * (v - 0.5);
    c->n[0] = cos(b) * cos(a);
    c->n[1] = sin(b);
    c->n[2] = -cos(b) * sin(a);
    memcpy(c->p, c->n, sizeof c->p);
}

/* Seen from within. */
static void cave(struct corner *c, double u, double v)
{
    sphere(c, 1 - u, v);
    for (int i = 0; i < 3; i++)
        c->n[i] = -c->n[i];
}

static void torus(struct corner *c, double u, double v)
{
    const double a = 2 * pi * u, b = 2 * pi * v;
    c->n[0] = cos(b) * cos(a);
    c->n[1] = sin(b);
    c->n[2] = -cos(b) * sin(a);
    c->p[0] = 0.7 * cos(a) + 0.3 * c->n[0];
    c->p[1] = 0.3 * c->n[1];
    c->p[2] = -0.7 * sin(a) + 0.3 * c->n[2];
}

/* A level of across x down patches of 4 x 4 quads each. */
static void patches_add(struct maker *k, surface *s, unsigned across, unsigned down)
{
    for (unsigned y = 0; y < down; y++)
        for (unsigned x = 0; x < across; x++) {
            struct corner c[25];
            struct triangle t[32];
            unsigned n = 0;
            for (unsigned i = 0; i < 25; i++)
                s(&c[i], (x + i % 5 / 4.0) / across, (y + i / 5 / 4.0) / down);
            for (uint8_t i = 0; i < 20; i++) {
                if (i % 5 == 4)
                    continue;
                t[n++] = (struct triangle){{i, (uint8_t)(i + 1), (uint8_t)(i + 6)}};
                t[n++] = (struct triangle){{i, (uint8_t)(i + 6), (uint8_t)(i + 5)}};
            }
            meshlet_add(k, c, 25, t, 32);
        }
}

/* Levels that halve the patches along each side; the finest has `across` x `down`. */
static uint32_t surface_mesh(struct maker *k, surface *s, unsigned across, unsigned down, unsigned levels)
{
    uint32_t mesh = mesh_begin(k);
    for (unsigned l = 0; l < levels && across >> l && down >> l; l++) {
        const double angle = pi / (4 * (across >> l));
        level_begin(k, l ? 1 - cos(angle) + 0.0001 : 0);
        patches_add(k, s, across >> l, down >> l);
    }
    return mesh;
}

/* Strips along y of the plane z = 0, `count` over -1..1 in x, those that are `which` modulo `of`; as high as they are
 * said to be, leaning by `lean`. */
static uint32_t strips_mesh(struct maker *k, unsigned count, unsigned which, unsigned of, double height, double lean)
{
    uint32_t mesh = mesh_begin(k);
    struct corner c[32];
    struct triangle t[16];
    unsigned n = 0;
    level_begin(k, 0);
    for (unsigned i = which; i < count; i += of) {
        const double x0 = 2.0 * i / count - 1, x1 = x0 + 2.0 / count;
        const double at[4][2] = {{x0, -height}, {x1, -height}, {x1 + lean, height}, {x0 + lean, height}};
        for (int j = 0; j < 4; j++)
            c[4 * n + j] = (struct corner){{at[j][0], at[j][1], 0}, {0.3 * sin(x0 * 40), 0.2, 1}};
        for (int j = 0; j < 4; j++)
            normalize(c[4 * n + j].n);
        const uint8_t v = (uint8_t)(4 * n);
        t[2 * n] = (struct triangle){{v, (uint8_t)(v + 1), (uint8_t)(v + 2)}};
        t[2 * n + 1] = (struct triangle){{v, (uint8_t)(v + 2), (uint8_t)(v + 3)}};
        if (++n == 8 || i + of >= count) {
            meshlet_add(k, c, 4 * n, t, 2 * n);
            n = 0;
        }
    }
    return mesh;
}

/* A fan from the lower left corner to the right edge of -1..1 x -1..1: thin everywhere, across the whole. */
static uint32_t fan_mesh(struct maker *k, unsigned triangles)
{
    uint32_t mesh = mesh_begin(k);
    level_begin(k, 0);
    for (unsigned first = 0; first < triangles; first += 30) {
        struct corner c[32];
        struct triangle t[30];
        c[0] = (struct corner){{-1, -1, 0}, {0, 0, 1}};
        for (unsigned i = 0; i <= 30; i++)
            c[i + 1] = (struct corner){{1, 2.0 * (first + i) / (triangles + 29) - 1, 0}, {0, 0, 1}};
        for (uint8_t i = 0; i < 30; i++)
            t[i] = (struct triangle){{0, (uint8_t)(i + 1), (uint8_t)(i + 2)}};
        meshlet_add(k, c, 32, t, 30);
    }
    return mesh;
}

/* --- scenes --- */

static void begin(struct maker *k, uint32_t seed)
{
    static const double eye[3] = {0, 0, 6}, target[3] = {0, 0, 0};
    memset(k, 0, sizeof *k);
    k->random = (seed + 1) * 0x9e3779b97f4a7c15u; /* neighbours are to differ in all bits: splitmix64's finish */
    k->random = (k->random ^ k->random >> 30) * 0xbf58476d1ce4e5b9u;
    k->random = (k->random ^ k->random >> 27) * 0x94d049bb133111ebu;
    k->header.output = (struct scene_output){.exposure = 1u << 16, .background = {20, 30, 40}};
    k->header.lod_error = 1u << 15;
    camera_set(k, eye, target, 37.85, 0.0625); /* 4.11 x 5.49 units at the centre's depth */
}

static void three_lights(struct maker *k)
{
    light_directional(k, (const double[3]){1, 1, 2}, 1.6);
    light_directional(k, (const double[3]){-2, 1, 1}, 1.0);
    light_directional(k, (const double[3]){0, -1, 1}, 0.5);
}

static void make_random(struct maker *k)
{
    const unsigned materials = 1 + draw(k, 6), objects = 1 + draw(k, 10), first = draw(k, SHADINGS);
    const uint32_t meshes[4] = {surface_mesh(k, sphere, 8, 4, 3), surface_mesh(k, torus, 12, 6, 3),
                                surface_mesh(k, torus, 24, 10, 4),
                                strips_mesh(k, 20 + draw(k, 300), 0, 2, 0.3, between(k, -0.3, 0.3))};
    for (unsigned i = 0; i < materials; i++)
        material_add(k, first + i);
    for (unsigned i = 0; i < objects; i++) {
        const double depth = between(k, -8, 4), spread = (6 - depth) * 0.4;
        const double position[3] = {between(k, -spread, spread), between(k, -spread, spread) * 0.7, depth};
        object_add(k, meshes[draw(k, 4)], draw(k, materials), position, between(k, 0.2, 2), between(k, 0, 6));
    }
    const unsigned directional = draw(k, 4), points = draw(k, 3) ? 0 : 1 + draw(k, 20);
    for (unsigned i = 0; i < directional || i + points == 0; i++)
        light_directional(k, (const double[3]){between(k, -2, 2), between(k, -1, 2), between(k, 0, 2) + 0.1},
                          between(k, 0.2, 3));
    for (unsigned i = 0; i < points; i++)
        light_point(k, (const double[3]){between(k, -3, 3), between(k, -2, 2), between(k, -3, 5)}, between(k, 0.2, 5),
                    between(k, 0.5, 6));
    k->header.output.tone_curve = (uint8_t)draw(k, 3);
    k->header.output.exposure = (uint32_t)fixed(between(k, 0.3, 2), 16);
    const double eye[3] = {between(k, -3, 3), between(k, -2, 2), between(k, 4, 8)}, target[3] = {0, 0, 0};
    camera_set(k, eye, target, between(k, 20, 80), 0.0625);
}

static void make_one_tile(struct maker *k)
{
    /* the centre of the tile below and right of the picture's */
    const double pixel = 4.11 / 240, x = 32 * pixel, y = -8 * pixel;
    const uint32_t mesh = surface_mesh(k, sphere, 16, 12, 3);
    three_lights(k);
    for (unsigned i = 0; i < 4; i++)
        material_add(k, i);
    for (unsigned i = 0; i < 12; i++)
        object_add(k, mesh, i % 4, (const double[3]){x + ((int)i - 6) * 4 * pixel, y, -0.05 * i}, 7 * pixel, 0.3 * i);
    k->header.lod_error = 0;
}

static void make_slivers(struct maker *k)
{
    const uint32_t fan = fan_mesh(k, 600), strips = strips_mesh(k, 900, 0, 2, 0.8, 0.4);
    three_lights(k);
    material_add(k, 0);
    material_add(k, 3);
    object_add(k, fan, 0, (const double[3]){0, 0, 0}, 2.7, 0);
    object_add(k, strips, 1, (const double[3]){0, 0, 0.1}, 2.7, 0);
}

static void make_lights(struct maker *k)
{
    const uint32_t ball = surface_mesh(k, sphere, 8, 4, 2), room = surface_mesh(k, cave, 12, 6, 2);
    for (unsigned i = 0; i < 6; i++)
        material_add(k, i);
    for (unsigned i = 0; i < 6; i++)
        object_add(k, ball, i, (const double[3]){1.6 * (i % 3) - 1.6, i / 3 * 1.6 - 0.8, 0}, 0.7, 0);
    object_add(k, room, 1, (const double[3]){0, 0, 0}, 8, 0);
    light_directional(k, (const double[3]){1, 1, 1}, 0.5);
    for (unsigned i = 0; i < 100; i++)
        light_point(k, (const double[3]){between(k, -3, 3), between(k, -2, 2), between(k, -1, 3)}, between(k, 0.05, 1),
                    between(k, 0.5, 4));
}

static void make_interleaved(struct maker *k)
{
    three_lights(k);
    for (unsigned i = 0; i < 6; i++)
        material_add(k, i);
    for (unsigned i = 0; i < 6; i++)
        object_add(k, strips_mesh(k, 320, i, 6, 0.75, 0.05), i, (const double[3]){0, 0, 0}, 2.75, 0);
}

static void make_inside(struct maker *k)
{
    const uint32_t room = surface_mesh(k, cave, 12, 6, 3), ring = surface_mesh(k, torus, 12, 6, 3);
    three_lights(k);
    light_point(k, (const double[3]){0, 0, 1}, 2, 5);
    for (unsigned i = 0; i < 4; i++)
        material_add(k, i + draw(k, SHADINGS));
    object_add(k, room, 0, (const double[3]){0, 0, 0}, 3, 0);
    object_add(k, ring, 1, (const double[3]){0.9, 0, 0}, 1.2, 0);
    object_add(k, ring, 2, (const double[3]){0, 0.1, -0.8}, 1.1, 1);
    object_add(k, room, 3, (const double[3]){0.2, 0, 0}, 2.5, 0);
    const double eye[3] = {between(k, -0.2, 0.2), between(k, -0.1, 0.1), between(k, -0.2, 0.2)};
    camera_set(k, eye, (const double[3]){1, between(k, -0.5, 0.5), 0.3}, 70, 0.02);
}

void *scenes_make(enum scenes_kind kind, uint32_t seed, size_t *bytes)
{
    static void (*const make[SCENES_KIND_COUNT])(struct maker *) = {
        make_random, make_one_tile, make_slivers, make_lights, make_interleaved, make_inside, make_random, make_random};
    struct maker k;
    begin(&k, seed);
    k.broad = kind == SCENES_BROAD;
    make[kind](&k);
    if (kind == SCENES_BRIGHT)
        k.header.output.exposure = 256u << 16;
    return finish(&k, bytes);
}

const char *scenes_name(enum scenes_kind kind)
{
    static const char *const names[SCENES_KIND_COUNT] = {"random",      "one_tile", "slivers", "lights",
                                                         "interleaved", "inside",   "broad",   "bright"};
    return names[kind];
}
