/* Mesh files through assimp: whatever a file holds becomes one indexed triangle mesh with normals. */
#include "host_mesh.h"

#include "common.h"

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define MAX_FILE_BYTES (512L << 20)

void mesh_free(struct mesh *m)
{
    free(m->vertices);
    free(m->indices);
}

static void check_file(const char *path)
{
    static const char *const known[] = {".obj", ".ply", ".gltf", ".glb"};
    const char *dot = strrchr(path, '.');
    bool is_known = false;
    for (size_t i = 0; dot && i < sizeof known / sizeof *known; i++)
        is_known = is_known || !strcasecmp(dot, known[i]);
    if (!is_known)
        die(EXIT_BAD_INPUT, "%s: not a mesh file this program reads; give an .obj, .ply, .gltf or .glb", path);
    FILE *f = fopen(path, "rb");
    if (!f || fgetc(f) == EOF) {
        if (!f || ferror(f))
            die(EXIT_FILE, "%s: %s; give a readable mesh file", path, strerror(errno));
        die(EXIT_BAD_INPUT, "%s: the mesh file is empty; is it the right file?", path);
    }
    long bytes = fseek(f, 0, SEEK_END) ? -1 : ftell(f);
    if (bytes > MAX_FILE_BYTES)
        die(EXIT_BAD_INPUT, "%s: %ld bytes, more than the limit of %ld; simplify the mesh", path, bytes,
            MAX_FILE_BYTES);
    fclose(f);
    input_remember(path);
}

static void append(struct mesh *out, const struct aiMesh *part, const char *path)
{
    unsigned first = (unsigned)out->vertex_count;
    for (unsigned i = 0; i < part->mNumVertices; i++) {
        const struct aiVector3D *p = &part->mVertices[i];
        struct mesh_vertex *v = &out->vertices[out->vertex_count++];
        *v = (struct mesh_vertex){{p->x, p->y, p->z}, {0, 0, 0}};
        if (!isfinite(p->x) || !isfinite(p->y) || !isfinite(p->z))
            die(EXIT_BAD_INPUT, "%s: vertex %u is at (%g, %g, %g); positions must be finite", path, first + i, p->x,
                p->y, p->z);
        const struct aiVector3D *n = part->mNormals ? &part->mNormals[i] : NULL;
        double length = n ? sqrt((double)n->x * n->x + (double)n->y * n->y + (double)n->z * n->z) : 0;
        if (length > 0 && isfinite(length)) {
            v->normal[0] = (float)(n->x / length);
            v->normal[1] = (float)(n->y / length);
            v->normal[2] = (float)(n->z / length);
        }
    }
    for (unsigned i = 0; i < part->mNumFaces; i++) {
        const struct aiFace *face = &part->mFaces[i];
        if (face->mNumIndices != 3)
            continue; /* points and lines */
        for (int k = 0; k < 3; k++) {
            if (face->mIndices[k] >= part->mNumVertices)
                die(EXIT_BAD_INPUT, "%s: triangle %u refers to vertex %u of %u; repair the mesh", path, i,
                    face->mIndices[k], part->mNumVertices);
            out->indices[out->index_count++] = first + face->mIndices[k];
        }
    }
}

/* A vertex without a usable normal takes the area-weighted mean of its triangles'. */
static void fill_normals(struct mesh *m)
{
    double(*sum)[3] = xcalloc(m->vertex_count, sizeof *sum);
    for (size_t i = 0; i < m->index_count; i += 3) {
        const float *p[3];
        double e[2][3];
        for (int k = 0; k < 3; k++)
            p[k] = m->vertices[m->indices[i + k]].position;
        for (int k = 0; k < 3; k++) {
            e[0][k] = (double)p[1][k] - p[0][k];
            e[1][k] = (double)p[2][k] - p[0][k];
        }
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < 3; k++)
                sum[m->indices[i + c]][k] +=
                    e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
    }
    for (size_t i = 0; i < m->vertex_count; i++) {
        float *n = m->vertices[i].normal;
        if (n[0] != 0 || n[1] != 0 || n[2] != 0)
            continue;
        double length = sqrt(sum[i][0] * sum[i][0] + sum[i][1] * sum[i][1] + sum[i][2] * sum[i][2]);
        if (length > 0 && isfinite(length))
            for (int k = 0; k < 3; k++)
                n[k] = (float)(sum[i][k] / length);
        else
            n[2] = 1; /* only triangles without area: never seen */
    }
    free(sum);
}

void mesh_load(struct mesh *out, const char *path)
{
    check_file(path);
    struct aiPropertyStore *store = aiCreatePropertyStore();
    aiSetImportPropertyInteger(store, AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    const struct aiScene *scene = aiImportFileExWithProperties(
        path,
        aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_GenSmoothNormals | aiProcess_PreTransformVertices,
        NULL, store);
    aiReleasePropertyStore(store);
    if (!scene)
        die(EXIT_BAD_INPUT, "%s: cannot be read as a mesh: %s; is it the right file?", path, aiGetErrorString());
    size_t vertices = 0, triangles = 0;
    for (unsigned i = 0; i < scene->mNumMeshes; i++) {
        vertices += scene->mMeshes[i]->mNumVertices;
        triangles += scene->mMeshes[i]->mNumFaces;
    }
    if (triangles > MESH_MAX_TRIANGLES || vertices > 3 * (size_t)MESH_MAX_TRIANGLES)
        die(EXIT_BAD_INPUT, "%s: %zu triangles, %zu vertices, more than the limit of %u triangles; simplify the mesh",
            path, triangles, vertices, MESH_MAX_TRIANGLES);
    *out = (struct mesh){.vertices = xmalloc(vertices * sizeof *out->vertices),
                         .indices = xmalloc(3 * triangles * sizeof *out->indices)};
    for (unsigned i = 0; i < scene->mNumMeshes; i++)
        append(out, scene->mMeshes[i], path);
    aiReleaseImport(scene);
    if (!out->index_count)
        die(EXIT_BAD_INPUT, "%s: holds no triangles; is it the right file?", path);
    fill_normals(out);
}
