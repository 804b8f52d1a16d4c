#include "gtscene_blob.h"

#include "common.h"
#include "host_model.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* A growing byte array; each array of the blob starts 4-aligned. */
struct buffer {
    uint8_t *data;
    size_t used;
};

static void check_size(size_t bytes)
{
    if (bytes > SCENE_MAX_BYTES)
        die(EXIT_BAD_INPUT, "the scene takes more than the limit of %u bytes; use fewer triangles", SCENE_MAX_BYTES);
}

static struct scene_array append(struct buffer *b, const void *data, size_t count, size_t size)
{
    size_t end = (b->used + count * size + 3) & ~(size_t)3;
    check_size(end);
    struct scene_array a = {(uint32_t)b->used, (uint32_t)count};
    b->data = xrealloc(b->data, end);
    memset(b->data + b->used, 0, end - b->used);
    if (count)
        memcpy(b->data + b->used, data, count * size);
    b->used = end;
    return a;
}

/* The mesh's offset and scale go into the object's position and scale. */
static void place_object(struct scene_object *out, const struct object_desc *o, const struct packed_mesh *m,
                         unsigned index)
{
    double rotation[3][3], scale = o->scale * m->scale;
    memcpy(rotation, o->rotation, sizeof rotation);
    *out = (struct scene_object){.mesh = o->mesh, .material = o->material};
    desc_rotation(out->rotation, rotation);
    for (int i = 0; i < 3; i++) {
        double p = o->position[i];
        for (int j = 0; j < 3; j++)
            p += rotation[i][j] * m->center[j] * o->scale;
        if (!(fabs(p) < 32767))
            die(EXIT_BAD_INPUT, "objects[%u]: its middle is at %g, beyond 32767; move it or scale it down", index, p);
        out->position[i] = (q16_16_t)lrint(p * 65536);
    }
    int exponent; /* scale = f * 2^exponent, f in [0.5, 1) */
    double mantissa = nearbyint(ldexp(frexp(scale, &exponent), 31));
    if (mantissa == 0x1p31) {
        mantissa = 0x1p30;
        exponent++;
    }
    if (exponent > 1 || exponent < -39)
        die(EXIT_BAD_INPUT,
            "objects[%u]: %g world units across is out of range; give a mesh and scale from 1e-6 to 65534", index,
            2 * 32767 * scale);
    out->scale_mantissa = (uint32_t)mantissa;
    out->scale_shift = 1 - exponent;
}

static void load_file(struct mesh *out, const struct mesh_desc *desc, unsigned index)
{
    if (access(desc->path, R_OK))
        die(EXIT_FILE, "meshes[%u] '%s': %s: %s; put it beside the scene file or name its folder with --data", index,
            desc->name, desc->path, strerror(errno));
    mesh_load(out, desc->path);
}

static void build_mesh(struct packed_mesh *out, struct meshlet_pool *pool, const struct mesh_desc *desc, unsigned index,
                       const struct pack_options *options)
{
    struct mesh m;
    if (desc->shape)
        desc->shape->build(&m, desc->parameters);
    else
        load_file(&m, desc, index);
    mesh_pack(out, pool, &m, options, desc->shape ? desc->name : desc->path);
}

void *blob_build(size_t *bytes, const struct scene_desc *desc, const struct pack_options *options)
{
    struct meshlet_pool pool = {.meshlet_count = 0};
    struct packed_mesh *packed = xcalloc(desc->mesh_count, sizeof *packed);
    struct scene_mesh *meshes = xcalloc(desc->mesh_count, sizeof *meshes);
    struct scene_lod *lods = xcalloc(desc->mesh_count, sizeof packed->levels);
    uint32_t lod_count = 0;
    struct scene_object *objects = xcalloc(desc->object_count, sizeof *objects);
    for (unsigned i = 0; i < desc->mesh_count; i++) {
        build_mesh(&packed[i], &pool, &desc->meshes[i], i, options);
        check_size(pool.meshlet_count * sizeof *pool.meshlets + pool.vertex_count * sizeof *pool.vertices +
                   pool.triangle_count * sizeof *pool.triangles);
        meshes[i] = (struct scene_mesh){.lod_first = lod_count, .lod_count = packed[i].level_count};
        memcpy(meshes[i].lo, packed[i].lo, sizeof meshes[i].lo);
        memcpy(meshes[i].hi, packed[i].hi, sizeof meshes[i].hi);
        memcpy(&lods[lod_count], packed[i].levels, packed[i].level_count * sizeof *lods);
        lod_count += packed[i].level_count;
    }
    for (unsigned i = 0; i < desc->object_count; i++)
        place_object(&objects[i], &desc->objects[i], &packed[desc->objects[i].mesh], i);

    struct scene_header header = {.magic = SCENE_MAGIC,
                                  .version = SCENE_VERSION,
                                  .header_bytes = sizeof header,
                                  .camera = desc->camera,
                                  .output = desc->output,
                                  .lod_error = desc->lod_error};
    struct buffer b = {.used = 0};
    append(&b, &header, 1, sizeof header);
    header.lights = append(&b, desc->lights, desc->light_count, sizeof *desc->lights);
    header.materials = append(&b, desc->materials, desc->material_count, sizeof *desc->materials);
    header.objects = append(&b, objects, desc->object_count, sizeof *objects);
    header.meshes = append(&b, meshes, desc->mesh_count, sizeof *meshes);
    header.lods = append(&b, lods, lod_count, sizeof *lods);
    header.meshlets = append(&b, pool.meshlets, pool.meshlet_count, sizeof *pool.meshlets);
    header.vertices = append(&b, pool.vertices, pool.vertex_count, sizeof *pool.vertices);
    header.triangles = append(&b, pool.triangles, pool.triangle_count, sizeof *pool.triangles);
    header.total_bytes = (uint32_t)b.used;
    memcpy(b.data, &header, sizeof header);
    free(packed);
    free(meshes);
    free(lods);
    free(objects);
    free(pool.meshlets);
    free(pool.vertices);
    free(pool.triangles);

    struct scene s;
    enum scene_status status = scene_open_bounded(&s, b.data, b.used);
    if (status != SCENE_OK)
        die(EXIT_INTERNAL, "the scene built is refused: %s; please report this", scene_status_text(status));
    *bytes = b.used;
    return b.data;
}

static void print_array(const char *name, struct scene_array a, size_t size)
{
    printf("%-10s %8u x %3zu bytes = %8zu\n", name, a.count, size, a.count * size);
}

static uint32_t triangle_count(const struct scene *s, const struct scene_lod *lod)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < lod->meshlet_count; i++)
        count += s->meshlets[lod->meshlet_first + i].triangle_count;
    return count;
}

void blob_print(const struct scene *s)
{
    const struct scene_header *h = s->header;
    uint32_t finest = 0, cones = 0;
    for (uint32_t i = 0; i < h->objects.count; i++)
        finest += triangle_count(s, &s->lods[s->meshes[s->objects[i].mesh].lod_first]);
    for (uint32_t i = 0; i < h->meshlets.count; i++)
        cones += s->meshlets[i].cone_cutoff < 16384;
    printf("version    %8u\n", h->version);
    printf("bytes      %8u\n", h->total_bytes);
    printf("drawn      %8u triangles of all objects, finest levels\n", finest);
    printf("lod error  %8.3f pixels, the coarsest level within it is drawn\n", h->lod_error / 65536.0);
    printf("cones      %8u meshlets that can be culled by their normals\n", cones);
    print_array("lights", h->lights, sizeof *s->lights);
    print_array("materials", h->materials, sizeof *s->materials);
    print_array("objects", h->objects, sizeof *s->objects);
    print_array("meshes", h->meshes, sizeof *s->meshes);
    print_array("lods", h->lods, sizeof *s->lods);
    print_array("meshlets", h->meshlets, sizeof *s->meshlets);
    print_array("vertices", h->vertices, sizeof *s->vertices);
    print_array("triangles", h->triangles, sizeof *s->triangles);
    for (uint32_t i = 0; i < h->meshes.count; i++) {
        printf("mesh %4u  triangles (error in vertex units):", i);
        for (uint32_t j = s->meshes[i].lod_first; j < s->meshes[i].lod_first + s->meshes[i].lod_count; j++)
            printf(" %u (%u)", triangle_count(s, &s->lods[j]), s->lods[j].error);
        printf("\n");
    }
    for (uint32_t i = 0; i < h->lights.count; i++) {
        const struct scene_light *l = &s->lights[i];
        if (l->kind == SCENE_LIGHT_POINT)
            printf("light     %3u point at %g, %g, %g, ends at %g\n", i, l->position[0] / 65536.0,
                   l->position[1] / 65536.0, l->position[2] / 65536.0, l->radius / 65536.0);
        else
            printf("light     %3u directional from %.4f, %.4f, %.4f, irradiance %.4f, %.4f, %.4f\n", i,
                   ldexp(l->direction[0], -30), ldexp(l->direction[1], -30), ldexp(l->direction[2], -30),
                   l->irradiance[0] / 65536.0, l->irradiance[1] / 65536.0, l->irradiance[2] / 65536.0);
    }
    for (uint32_t i = 0; i < h->materials.count; i++)
        printf("material   %2u %-15s slot %2u %s\n", i, s->materials[i].name, s->materials[i].slot,
               model_name(s->materials[i].kind));
}
