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
    unsigned char start[3] = {0};
    if (!f || !fread(start, 1, sizeof start, f)) {
        if (!f || ferror(f))
            die(EXIT_FILE, "%s: %s; give a readable mesh file", path, strerror(errno));
        die(EXIT_BAD_INPUT, "%s: the mesh file is empty; is it the right file?", path);
    }
    if (!memcmp(start, "\xef\xbb\xbf", 3))
        die(EXIT_BAD_INPUT, "%s: begins with a byte order mark; save it without", path);
    long bytes = fseek(f, 0, SEEK_END) ? -1 : ftell(f);
    if (bytes > MAX_FILE_BYTES)
        die(EXIT_BAD_INPUT, "%s: %ld bytes, more than the limit of %ld; simplify the mesh", path, bytes,
            MAX_FILE_BYTES);
    fclose(f);
    input_remember(path);
}

/* A node's place in the file: positions by its matrix, normals by the matrix' cofactors. A mirror turns triangles inside out, so
 * their winding is turned back (glTF 2.0, 3.7.4). */
struct place {
    double m[3][4], normal[3][3];
    bool mirrored;
};

static void place_make(struct place *out, const struct aiMatrix4x4 *m)
{
    const double rows[3][4] = {
        {m->a1, m->a2, m->a3, m->a4}, {m->b1, m->b2, m->b3, m->b4}, {m->c1, m->c2, m->c3, m->c4}};
    double determinant = 0;
    memcpy(out->m, rows, sizeof rows);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            out->normal[i][j] = rows[i1][j1] * rows[i2][j2] - rows[i1][j2] * rows[i2][j1];
        }
    for (int j = 0; j < 3; j++)
        determinant += rows[0][j] * out->normal[0][j];
    out->mirrored = determinant < 0;
    for (int i = 0; i < 9 && out->mirrored; i++)
        out->normal[i / 3][i % 3] *= -1;
}

static void append_vertex(struct mesh *out, const struct aiMesh *part, unsigned i, const struct place *at,
                          const char *path)
{
    const struct aiVector3D *p = &part->mVertices[i], *n = part->mNormals ? &part->mNormals[i] : NULL;
    struct mesh_vertex *v = &out->vertices[out->vertex_count];
    double normal[3] = {0};
    for (int k = 0; k < 3; k++) {
        v->position[k] = (float)(at->m[k][0] * p->x + at->m[k][1] * p->y + at->m[k][2] * p->z + at->m[k][3]);
        normal[k] = n ? at->normal[k][0] * n->x + at->normal[k][1] * n->y + at->normal[k][2] * n->z : 0;
    }
    const float *q = v->position;
    if (!isfinite(q[0]) || !isfinite(q[1]) || !isfinite(q[2]))
        die(EXIT_BAD_INPUT, "%s: vertex %zu is at (%g, %g, %g); positions must be finite", path, out->vertex_count,
            q[0], q[1], q[2]);
    double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (int k = 0; k < 3; k++)
        v->normal[k] = length > 0 && isfinite(length) ? (float)(normal[k] / length) : 0;
    out->vertex_count++;
}

static int compare_positions(const void *a, const void *b)
{
    const struct mesh_vertex *const *v = a, *const *w = b;
    for (int k = 0; k < 3; k++)
        if ((*v)->position[k] != (*w)->position[k])
            return (*v)->position[k] < (*w)->position[k] ? -1 : 1;
    return 0;
}

static bool has_normal(const struct mesh_vertex *v)
{
    return v->normal[0] != 0 || v->normal[1] != 0 || v->normal[2] != 0;
}

static void set_normal(struct mesh_vertex *v, const double sum[3])
{
    double length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    for (int k = 0; k < 3 && length > 0 && isfinite(length); k++)
        v->normal[k] = (float)(sum[k] / length);
}

/* Vertices without a usable normal, of the part from (vertex, index) on, take the mean of the triangles that meet in their
 * position, whether these share the vertex or not; where these cancel, as on a sheet with two sides, that of their own. */
static void fill_normals(struct mesh *m, size_t vertex, size_t index)
{
    size_t count = m->vertex_count - vertex, missing = 0;
    struct mesh_vertex *vertices = m->vertices + vertex;
    for (size_t i = 0; i < count; i++)
        missing += !has_normal(&vertices[i]);
    if (!missing)
        return;
    double(*sum)[3] = xcalloc(count, sizeof *sum);
    for (size_t i = index; i < m->index_count; i += 3) {
        const float *p[3];
        double e[2][3], face[3];
        for (int k = 0; k < 3; k++)
            p[k] = m->vertices[m->indices[i + k]].position;
        for (int k = 0; k < 3; k++) {
            e[0][k] = (double)p[1][k] - p[0][k];
            e[1][k] = (double)p[2][k] - p[0][k];
        }
        for (int k = 0; k < 3; k++)
            face[k] = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
        double area = sqrt(face[0] * face[0] + face[1] * face[1] + face[2] * face[2]);
        for (int c = 0; c < 3 && area > 0 && isfinite(area); c++)
            for (int k = 0; k < 3; k++)
                sum[m->indices[i + c] - vertex][k] += face[k] / area;
    }
    struct mesh_vertex **sorted = xmalloc(count * sizeof *sorted);
    for (size_t i = 0; i < count; i++)
        sorted[i] = &vertices[i];
    qsort(sorted, count, sizeof *sorted, compare_positions);
    for (size_t from = 0, to; from < count; from = to) {
        double all[3] = {0};
        for (to = from; to < count && !compare_positions(&sorted[from], &sorted[to]); to++)
            for (int k = 0; k < 3; k++)
                all[k] += sum[sorted[to] - vertices][k];
        for (size_t i = from; i < to; i++) {
            if (!has_normal(sorted[i]))
                set_normal(sorted[i], all);
            if (!has_normal(sorted[i]))
                set_normal(sorted[i], sum[sorted[i] - vertices]);
            if (!has_normal(sorted[i]))
                sorted[i]->normal[2] = 1; /* only triangles without area: never seen */
        }
    }
    free(sorted);
    free(sum);
}

static void append(struct mesh *out, const struct aiMesh *part, const struct place *at, const char *path)
{
    size_t first = out->vertex_count, first_index = out->index_count;
    for (unsigned i = 0; i < part->mNumVertices; i++)
        append_vertex(out, part, i, at, path);
    for (unsigned i = 0; i < part->mNumFaces; i++) {
        const struct aiFace *face = &part->mFaces[i];
        if (face->mNumIndices != 3)
            continue; /* points and lines */
        for (int k = 0; k < 3; k++) {
            unsigned vertex = face->mIndices[at->mirrored && k ? 3 - k : k];
            if (vertex >= part->mNumVertices)
                die(EXIT_BAD_INPUT, "%s: triangle %u refers to vertex %u of %u; repair the mesh", path, i, vertex,
                    part->mNumVertices);
            out->indices[out->index_count++] = (uint32_t)first + vertex;
        }
    }
    fill_normals(out, first, first_index);
}

/* What the nodes from here on hold, each mesh as often as nodes have it. */
static void count_nodes(size_t *vertices, size_t *triangles, const struct aiScene *scene, const struct aiNode *node)
{
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        *vertices += scene->mMeshes[node->mMeshes[i]]->mNumVertices;
        *triangles += scene->mMeshes[node->mMeshes[i]]->mNumFaces;
    }
    for (unsigned i = 0; i < node->mNumChildren; i++)
        count_nodes(vertices, triangles, scene, node->mChildren[i]);
}

static void append_nodes(struct mesh *out, const struct aiScene *scene, const struct aiNode *node,
                         struct aiMatrix4x4 matrix, const char *path)
{
    struct place at;
    aiMultiplyMatrix4(&matrix, &node->mTransformation);
    place_make(&at, &matrix);
    for (unsigned i = 0; i < node->mNumMeshes; i++)
        append(out, scene->mMeshes[node->mMeshes[i]], &at, path);
    for (unsigned i = 0; i < node->mNumChildren; i++)
        append_nodes(out, scene, node->mChildren[i], matrix, path);
}

void mesh_load(struct mesh *out, const char *path)
{
    check_file(path);
    struct aiPropertyStore *store = aiCreatePropertyStore();
    aiSetImportPropertyInteger(store, AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    const struct aiScene *scene =
        aiImportFileExWithProperties(path, aiProcess_Triangulate | aiProcess_SortByPType, NULL, store);
    aiReleasePropertyStore(store);
    if (!scene)
        die(EXIT_BAD_INPUT, "%s: cannot be read as a mesh: %s; is it the right file?", path, aiGetErrorString());
    size_t vertices = 0, triangles = 0;
    struct aiMatrix4x4 matrix;
    count_nodes(&vertices, &triangles, scene, scene->mRootNode);
    if (triangles > MESH_MAX_TRIANGLES || vertices > 3 * (size_t)MESH_MAX_TRIANGLES)
        die(EXIT_BAD_INPUT, "%s: %zu triangles, %zu vertices, more than the limit of %u triangles; simplify the mesh",
            path, triangles, vertices, MESH_MAX_TRIANGLES);
    *out = (struct mesh){.vertices = xmalloc(vertices * sizeof *out->vertices),
                         .indices = xmalloc(3 * triangles * sizeof *out->indices)};
    aiIdentityMatrix4(&matrix);
    append_nodes(out, scene, scene->mRootNode, matrix, path);
    aiReleaseImport(scene);
    if (!out->index_count)
        die(EXIT_BAD_INPUT, "%s: holds no triangles; is it the right file?", path);
}
