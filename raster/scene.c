/*
 * Validation of a scene blob. Nothing of a blob is trusted: every offset, count and index is checked against
 * the arrays' real extent before it is used, so that a scene that opens can be rendered without further
 * checks. The work is linear in the blob's size whatever it says: a mesh's levels and a level's meshlets
 * follow each other in array order without overlap, and a meshlet is at most 32 vertices and 32 triangles.
 */
#include "scene.h"

#define MAX_BRIGHTNESS (1u << 24) /* irradiance and exposure: 256.0 */
#define MAX_EXPONENT   (4096u << 16)
#define MAX_SLOT       15u
#define ONE_Q16        (1u << 16)

const char *scene_status_text(enum scene_status s)
{
    static const char *const text[SCENE_STATUS_COUNT] = {
        "the scene is valid",
        "shorter than its header or one of its arrays says",
        "not aligned to 4 bytes",
        "not a scene blob",
        "made for another version of the scene format",
        "header size or total size is wrong",
        "more bytes, objects, materials or lights than the limit",
        "camera out of range or its rotation not orthonormal",
        "exposure, tone curve or level-of-detail threshold out of range",
        "light of unknown kind, out of range, without radius or its direction not of unit length",
        "material of unknown kind, out of range or badly named",
        "object with a missing mesh or material, a bad rotation or a bad scale",
        "mesh with levels out of order or a box that does not hold it",
        "meshlet with vertices, triangles, frame or box out of range",
    };
    return (unsigned)s < SCENE_STATUS_COUNT ? text[s] : "unknown scene status";
}

/* Q60 dot product. In: |components| <= 2^30 + 2^20, so |sum| < 3 * 2^60.01 < 2^62. */
static int64_t dot_q60(const q2_30_t a[3], const q2_30_t b[3])
{
    return (int64_t)a[0] * b[0] + (int64_t)a[1] * b[1] + (int64_t)a[2] * b[2];
}

static bool within(int64_t x, int64_t middle, int64_t tolerance)
{
    return x >= middle - tolerance && x <= middle + tolerance;
}

/* Length within 2^-14 of 1: its square within 2^-13. */
static bool is_unit(const q2_30_t a[3])
{
    const int32_t largest = (1 << 30) + (1 << 20);
    for (int i = 0; i < 3; i++)
        if (a[i] < -largest || a[i] > largest)
            return false;
    return within(dot_q60(a, a), (int64_t)1 << 60, (int64_t)1 << 47);
}

/* Rows orthonormal within 2^-14 and right-handed: no mirror image, which would turn triangles inside out. */
static bool is_rotation(const q2_30_t m[9])
{
    const int64_t tolerance = (int64_t)1 << 46;
    if (!is_unit(m) || !is_unit(m + 3) || !is_unit(m + 6))
        return false;
    if (!within(dot_q60(m, m + 3), 0, tolerance) || !within(dot_q60(m, m + 6), 0, tolerance) ||
        !within(dot_q60(m + 3, m + 6), 0, tolerance))
        return false;
    /* Determinant of a matrix this close to orthonormal is near +1 or -1; Q9 entries decide which: |sum| <
     * 2^30. */
    int32_t r[9];
    for (int i = 0; i < 9; i++)
        r[i] = m[i] >> 21;
    return r[6] * (r[1] * r[5] - r[2] * r[4]) + r[7] * (r[2] * r[3] - r[0] * r[5]) +
               r[8] * (r[0] * r[4] - r[1] * r[3]) >
           0;
}

enum scene_status scene_check_camera(const struct scene_camera *c)
{
    if (c->focal < 1u << 8 || c->focal > 1u << 24 || c->near == 0 || !is_rotation(c->rotation))
        return SCENE_ERR_CAMERA;
    return SCENE_OK;
}

enum scene_status scene_check_output(const struct scene_output *o)
{
    return o->exposure <= MAX_BRIGHTNESS && o->tone_curve <= SCENE_TONE_LINEAR ? SCENE_OK : SCENE_ERR_OUTPUT;
}

enum scene_status scene_check_light(const struct scene_light *l)
{
    if (l->reserved[0] || l->reserved[1] || l->reserved[2])
        return SCENE_ERR_LIGHT;
    if (l->kind == SCENE_LIGHT_POINT) /* any position and intensity */
        return l->radius && l->radius <= SCENE_MAX_RADIUS ? SCENE_OK : SCENE_ERR_LIGHT;
    if (l->kind != SCENE_LIGHT_DIRECTIONAL || l->radius)
        return SCENE_ERR_LIGHT;
    for (int i = 0; i < 3; i++)
        if (l->irradiance[i] > MAX_BRIGHTNESS)
            return SCENE_ERR_LIGHT;
    return is_unit(l->direction) ? SCENE_OK : SCENE_ERR_LIGHT;
}

enum scene_status scene_check_material(const struct scene_material *m)
{
    if (m->kind >= SCENE_MATERIAL_KIND_COUNT || m->slot > MAX_SLOT || m->reserved[0] || m->reserved[1] ||
        m->exponent > MAX_EXPONENT || m->metalness > ONE_Q16 || m->roughness > ONE_Q16)
        return SCENE_ERR_MATERIAL;
    if (m->kind == SCENE_MATERIAL_METALLIC_ROUGHNESS &&
        (m->roughness < SCENE_MIN_ROUGHNESS || (m->ks[0] | m->ks[1] | m->ks[2])))
        return SCENE_ERR_MATERIAL;
    for (int i = 0; i < 3; i++)
        if (m->kd[i] > ONE_Q16 || m->ks[i] > ONE_Q16)
            return SCENE_ERR_MATERIAL;
    bool ended = false;
    for (unsigned i = 0; i < sizeof m->name; i++) {
        ended = ended || m->name[i] == 0;
        if (ended ? m->name[i] != 0 : m->name[i] < ' ' || m->name[i] > '~')
            return SCENE_ERR_MATERIAL;
    }
    return ended ? SCENE_OK : SCENE_ERR_MATERIAL; /* at least one NUL, so that it is a C string */
}

static bool object_is_valid(const struct scene_object *o, uint32_t mesh_count, uint32_t material_count)
{
    return o->mesh < mesh_count && o->material < material_count && o->scale_mantissa >= 1u << 30 &&
           o->scale_mantissa < 1u << 31 && o->scale_shift >= 0 && o->scale_shift <= 40 && is_rotation(o->rotation);
}

/* Rows orthonormal within 2^-12. Bound: |entries| <= 2^14 + 64, so |sum| <= 3 * 2^28.02 < 2^30. */
static bool frame_is_valid(const int16_t f[9])
{
    for (int i = 0; i < 9; i++)
        if (f[i] < -(16384 + 64) || f[i] > 16384 + 64)
            return false;
    for (int i = 0; i < 9; i += 3)
        for (int j = i; j < 9; j += 3)
            if (!within(f[i] * f[j] + f[i + 1] * f[j + 1] + f[i + 2] * f[j + 2], i == j ? 1 << 28 : 0,
                        i == j ? 1 << 17 : 1 << 16))
                return false;
    return true;
}

/* Everything a meshlet refers to, and what it refers to. */
static bool meshlet_is_valid(const struct scene *s, const struct scene_meshlet *m)
{
    const struct scene_array *vertices = &s->header->vertices, *triangles = &s->header->triangles;
    if (m->vertex_count < 3 || m->vertex_count > SCENE_MESHLET_MAX_VERTICES || m->triangle_count < 1 ||
        m->triangle_count > SCENE_MESHLET_MAX_TRIANGLES)
        return false;
    if (m->vertex_first > vertices->count || m->vertex_count > vertices->count - m->vertex_first ||
        m->triangle_first > triangles->count || m->triangle_count > triangles->count - m->triangle_first)
        return false;
    if (m->cone_cutoff < 0 || m->cone_cutoff > 16384 || !frame_is_valid(m->frame))
        return false;
    for (unsigned i = 0; i < m->vertex_count; i++) {
        const struct scene_vertex *v = &s->vertices[m->vertex_first + i];
        if (v->x < m->lo[0] || v->y < m->lo[1] || v->z < m->lo[2] || v->x > m->hi[0] || v->y > m->hi[1] ||
            v->z > m->hi[2])
            return false;
        /* s <= 1 in Q28; the sum is at most 2^31, as unsigned */
        if ((uint32_t)(v->u * v->u) + (uint32_t)(v->v * v->v) > 1u << 28)
            return false;
    }
    for (unsigned i = 0; i < m->triangle_count; i++) {
        const uint8_t *t = s->triangles[m->triangle_first + i].v;
        if (t[0] >= m->vertex_count || t[1] >= m->vertex_count || t[2] >= m->vertex_count)
            return false;
    }
    return true;
}

static bool box_holds(const struct scene_mesh *mesh, const struct scene_meshlet *m)
{
    for (int i = 0; i < 3; i++)
        if (m->lo[i] < mesh->lo[i] || m->hi[i] > mesh->hi[i])
            return false;
    return true;
}

/* A range that starts at *next or later and ends within `count`; moves *next behind it. */
static bool range_follows(uint32_t *next, uint32_t first, uint32_t length, uint32_t count)
{
    if (length < 1 || first < *next || first > count || length > count - first)
        return false;
    *next = first + length;
    return true;
}

static enum scene_status check_meshes(const struct scene *s)
{
    const struct scene_header *h = s->header;
    uint32_t next_lod = 0, next_meshlet = 0;
    for (uint32_t i = 0; i < h->meshlets.count; i++)
        if (!meshlet_is_valid(s, &s->meshlets[i]))
            return SCENE_ERR_MESHLET;
    for (uint32_t i = 0; i < h->meshes.count; i++) {
        const struct scene_mesh *mesh = &s->meshes[i];
        if (!range_follows(&next_lod, mesh->lod_first, mesh->lod_count, h->lods.count))
            return SCENE_ERR_MESH;
        for (uint32_t j = mesh->lod_first; j < next_lod; j++) {
            const struct scene_lod *lod = &s->lods[j];
            if (!range_follows(&next_meshlet, lod->meshlet_first, lod->meshlet_count, h->meshlets.count))
                return SCENE_ERR_MESH;
            if (j > mesh->lod_first && lod->error < lod[-1].error)
                return SCENE_ERR_MESH;
            for (uint32_t k = lod->meshlet_first; k < next_meshlet; k++)
                if (!box_holds(mesh, &s->meshlets[k]))
                    return SCENE_ERR_MESH;
        }
    }
    return SCENE_OK;
}

static enum scene_status check_elements(const struct scene *s)
{
    const struct scene_header *h = s->header;
    enum scene_status status = scene_check_camera(&h->camera);
    if (status == SCENE_OK)
        status = h->lod_error > SCENE_MAX_LOD_ERROR ? SCENE_ERR_OUTPUT : scene_check_output(&h->output);
    for (uint32_t i = 0; status == SCENE_OK && i < h->lights.count; i++)
        status = scene_check_light(&s->lights[i]);
    if (status != SCENE_OK)
        return status;
    for (uint32_t i = 0; i < h->materials.count; i++)
        if (scene_check_material(&s->materials[i]) != SCENE_OK)
            return SCENE_ERR_MATERIAL;
    for (uint32_t i = 0; i < h->objects.count; i++)
        if (!object_is_valid(&s->objects[i], h->meshes.count, h->materials.count))
            return SCENE_ERR_OBJECT;
    return check_meshes(s);
}

/* In: a.count < 2^32 and size <= 60, so the product is below 2^38. */
static enum scene_status check_array(struct scene_array a, uint32_t size, uint32_t total)
{
    if (a.offset & 3)
        return SCENE_ERR_ALIGNMENT;
    if (a.offset < sizeof(struct scene_header))
        return SCENE_ERR_HEADER;
    if (a.offset > total || (uint64_t)a.count * size > total - a.offset)
        return SCENE_ERR_TRUNCATED;
    return SCENE_OK;
}

static enum scene_status check_arrays(const struct scene_header *h)
{
    const struct {
        struct scene_array array;
        uint32_t size;
    } arrays[] = {
        {h->lights, sizeof(struct scene_light)},    {h->materials, sizeof(struct scene_material)},
        {h->objects, sizeof(struct scene_object)},  {h->meshes, sizeof(struct scene_mesh)},
        {h->lods, sizeof(struct scene_lod)},        {h->meshlets, sizeof(struct scene_meshlet)},
        {h->vertices, sizeof(struct scene_vertex)}, {h->triangles, sizeof(struct scene_triangle)},
    };
    if (h->lights.count > SCENE_MAX_LIGHTS || h->materials.count > SCENE_MAX_MATERIALS ||
        h->objects.count > SCENE_MAX_OBJECTS)
        return SCENE_ERR_LIMIT;
    enum scene_status status = SCENE_OK;
    for (unsigned i = 0; status == SCENE_OK && i < sizeof arrays / sizeof *arrays; i++)
        status = check_array(arrays[i].array, arrays[i].size, h->total_bytes);
    return status;
}

enum scene_status scene_open(struct scene *out, const void *blob, size_t bytes)
{
    const struct scene_header *h = blob;
    const uint8_t *base = blob;
    if ((uintptr_t)blob & 3)
        return SCENE_ERR_ALIGNMENT;
    if (bytes < offsetof(struct scene_header, camera))
        return SCENE_ERR_TRUNCATED;
    if (h->magic != SCENE_MAGIC)
        return SCENE_ERR_MAGIC;
    if (h->version != SCENE_VERSION)
        return SCENE_ERR_VERSION;
    if (h->header_bytes != sizeof(struct scene_header) || h->total_bytes < sizeof(struct scene_header))
        return SCENE_ERR_HEADER;
    if (h->total_bytes > SCENE_MAX_BYTES)
        return SCENE_ERR_LIMIT;
    if (bytes < h->total_bytes)
        return SCENE_ERR_TRUNCATED;
    if (bytes > h->total_bytes)
        return SCENE_ERR_HEADER;
    enum scene_status status = check_arrays(h);
    if (status != SCENE_OK)
        return status;

    struct scene s;
    s.header = h;
    s.lights = (const struct scene_light *)(base + h->lights.offset);
    s.materials = (const struct scene_material *)(base + h->materials.offset);
    s.objects = (const struct scene_object *)(base + h->objects.offset);
    s.meshes = (const struct scene_mesh *)(base + h->meshes.offset);
    s.lods = (const struct scene_lod *)(base + h->lods.offset);
    s.meshlets = (const struct scene_meshlet *)(base + h->meshlets.offset);
    s.vertices = (const struct scene_vertex *)(base + h->vertices.offset);
    s.triangles = (const struct scene_triangle *)(base + h->triangles.offset);
    status = check_elements(&s);
    if (status == SCENE_OK)
        *out = s;
    return status;
}

static uint8_t size_code(uint64_t size)
{
    unsigned shift = 0;
    while (size > 15ull << shift)
        shift++;
    const uint64_t m = (size + (1ull << shift) - 1) >> shift; /* <= 15; the shift is at most 31, see below */
    return (uint8_t)(8 * shift + (m > 8 ? m - 8 : 0));
}

void scene_measure(struct scene_meshlet *m, const struct scene_vertex *vertices, const struct scene_triangle *triangles)
{
    uint64_t area = 0, perimeter = 0; /* twice the area: 32 * 2 * 2^34 < 2^40; <= 96 * 2 * 2^16 */
    for (unsigned i = 0; i < m->triangle_count; i++) {
        const uint8_t *t = triangles[m->triangle_first + i].v;
        int64_t edge[3][3]; /* |.| < 2^16 */
        for (unsigned j = 0; j < 3; j++) {
            const struct scene_vertex *a = &vertices[m->vertex_first + t[j]];
            const struct scene_vertex *b = &vertices[m->vertex_first + t[j == 2 ? 0 : j + 1]];
            edge[j][0] = b->x - a->x;
            edge[j][1] = b->y - a->y;
            edge[j][2] = b->z - a->z;
            perimeter += scene_length(edge[j][0], edge[j][1], edge[j][2]);
        }
        const int64_t *e = edge[0], *f = edge[1];
        area += scene_length(e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]);
    }
    m->area = size_code((area + 127) >> 7);
    m->perimeter = size_code(perimeter);
}

enum scene_status scene_open_bounded(struct scene *out, const void *blob, size_t bytes)
{
    struct scene s;
    enum scene_status status = scene_open(&s, blob, bytes);
    for (uint32_t i = 0; status == SCENE_OK && i < s.header->meshlets.count; i++) {
        const struct scene_meshlet *m = &s.meshlets[i];
        struct scene_meshlet least = *m;
        scene_measure(&least, s.vertices, s.triangles);
        if (m->area < least.area || m->perimeter < least.perimeter)
            status = SCENE_ERR_MESHLET;
    }
    if (status == SCENE_OK)
        *out = s;
    return status;
}
