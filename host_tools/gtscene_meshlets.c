#include "gtscene_meshlets.h"

#include "common.h"

#include <math.h>
#include <meshoptimizer.h>
#include <stdlib.h>
#include <string.h>

/* Measured on Cortex-M: small meshlets with this cone weight cull best. */
#define MAX_VERTICES  24
#define MAX_TRIANGLES 32
#define CONE_WEIGHT   0.5f
#define MAX_JOINED    150 /* meshlets of a level that join_crumbs looks at, every pair of them */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* False, and v untouched, when v is too short to have a direction. */
static bool normalise(double v[3])
{
    double length = sqrt(dot(v, v));
    if (!(length > 1e-9))
        return false;
    for (int k = 0; k < 3; k++)
        v[k] /= length;
    return true;
}

/* Replaces positions by their quantised values, still as floats (exact: |q| <= 32767). */
static void quantise(struct packed_mesh *out, struct mesh *m, const char *name)
{
    double lo[3], hi[3], half = 0;
    for (int k = 0; k < 3; k++) {
        lo[k] = hi[k] = m->vertices[0].position[k];
        for (size_t i = 1; i < m->vertex_count; i++) {
            lo[k] = fmin(lo[k], m->vertices[i].position[k]);
            hi[k] = fmax(hi[k], m->vertices[i].position[k]);
        }
        out->center[k] = (lo[k] + hi[k]) / 2;
        half = fmax(half, (hi[k] - lo[k]) / 2);
    }
    if (!(half > 1e-9) || half > 1e9)
        die(EXIT_BAD_INPUT, "%s: the mesh is %g across; give one from 1e-9 to 1e9 units", name, 2 * half);
    out->scale = half / 32767;
    for (size_t i = 0; i < m->vertex_count; i++)
        for (int k = 0; k < 3; k++) {
            float *p = &m->vertices[i].position[k], *n = &m->vertices[i].normal[k];
            *p = (float)fmin(32767, fmax(-32767, nearbyint((*p - out->center[k]) / out->scale))) + 0.0f;
            *n += 0.0f; /* -0 to 0, so that equal vertices are equal bytes */
        }
}

static void weld(struct mesh *m)
{
    unsigned *remap = xmalloc(m->vertex_count * sizeof *remap);
    size_t count = meshopt_generateVertexRemap(remap, m->indices, m->index_count, m->vertices, m->vertex_count,
                                               sizeof *m->vertices);
    meshopt_remapIndexBuffer(m->indices, m->indices, m->index_count, remap);
    meshopt_remapVertexBuffer(m->vertices, m->vertices, m->vertex_count, sizeof *m->vertices, remap);
    m->vertex_count = count;
    free(remap);
}

/* Geometric normal of a triangle of quantised positions, twice its area long; exact: |components| < 2^35. */
static void triangle_normal(double out[3], const struct mesh *m, const unsigned t[3])
{
    const float *p[3];
    double e[2][3];
    for (int c = 0; c < 3; c++)
        p[c] = m->vertices[t[c]].position;
    for (int k = 0; k < 3; k++) {
        e[0][k] = (double)p[1][k] - p[0][k];
        e[1][k] = (double)p[2][k] - p[0][k];
    }
    cross(out, e[0], e[1]);
}

static void drop_degenerate(struct mesh *m)
{
    size_t kept = 0;
    for (size_t i = 0; i < m->index_count; i += 3) {
        double n[3];
        triangle_normal(n, m, &m->indices[i]);
        if (n[0] == 0 && n[1] == 0 && n[2] == 0)
            continue;
        memmove(&m->indices[kept], &m->indices[i], 3 * sizeof *m->indices);
        kept += 3;
    }
    m->index_count = kept;
}

/* The triangles of one meshlet being made, by index into the mesh. */
struct cluster {
    unsigned triangles[MAX_TRIANGLES][3];
    unsigned count;
};

/* The mesh's vertices that a cluster uses, in order of first use; returns their number and, per corner, which. */
static unsigned cluster_vertices(unsigned vertices[3 * MAX_TRIANGLES], uint8_t corners[MAX_TRIANGLES][3],
                                 const struct cluster *c)
{
    unsigned count = 0;
    for (unsigned i = 0; i < c->count; i++)
        for (int k = 0; k < 3; k++) {
            unsigned j = 0;
            while (j < count && vertices[j] != c->triangles[i][k])
                j++;
            if (j == count)
                vertices[count++] = c->triangles[i][k];
            corners[i][k] = (uint8_t)j;
        }
    return count;
}

static void vertex_normal(double out[3], const struct mesh *m, unsigned vertex)
{
    for (int k = 0; k < 3; k++)
        out[k] = m->vertices[vertex].normal[k];
}

/* Cosine between z and the normal farthest from it. */
static double worst_normal(unsigned *worst, const struct mesh *m, const unsigned *vertices, unsigned count,
                           const double z[3])
{
    double least = 2;
    for (unsigned i = 0; i < count; i++) {
        double n[3];
        vertex_normal(n, m, vertices[i]);
        if (dot(n, z) < least) {
            least = dot(n, z);
            *worst = vertices[i];
        }
    }
    return least;
}

/* The frame's z: the mean normal, or, where a normal is more than 85 degrees off, the middle of the smallest cone (by
 * stepping towards the farthest normal, shorter each time). Returns the cosine of the farthest normal's angle to it. */
static double choose_axis(double z[3], const struct mesh *m, const unsigned *vertices, unsigned count)
{
    const double cos_85 = 0.0871557427;
    double n[3], best[3] = {0, 0, 1}, best_cosine = -2;
    unsigned worst = 0;
    memset(z, 0, 3 * sizeof *z);
    for (unsigned i = 0; i < count; i++) {
        vertex_normal(n, m, vertices[i]);
        for (int k = 0; k < 3; k++)
            z[k] += n[k];
    }
    for (unsigned step = 1; step <= 64; step++) {
        if (!normalise(z))
            vertex_normal(z, m, vertices[0]);
        double cosine = worst_normal(&worst, m, vertices, count, z);
        if (cosine > best_cosine) {
            best_cosine = cosine;
            memcpy(best, z, sizeof best);
        }
        if (cosine > cos_85)
            break;
        vertex_normal(n, m, worst);
        for (int k = 0; k < 3; k++)
            z[k] += (n[k] - z[k]) / (step + 1);
    }
    memcpy(z, best, sizeof best);
    return best_cosine;
}

/* Rows x, y, z in Q14; each entry within half a unit. */
static void make_frame(int16_t frame[9], const double z[3])
{
    double rows[3][3], helper[3] = {0, 0, 0};
    helper[fabs(z[0]) < 0.6 ? 0 : 1] = 1;
    cross(rows[0], helper, z);
    normalise(rows[0]);
    cross(rows[1], z, rows[0]);
    memcpy(rows[2], z, sizeof rows[2]);
    for (int i = 0; i < 9; i++)
        frame[i] = (int16_t)lrint(16384 * rows[i / 3][i % 3]);
}

/* Stereographic coordinates of a normal in the frame, Q14, u^2 + v^2 <= 1; a normal beyond 90 degrees becomes the
 * nearest at 90. */
static void encode_normal(int16_t uv[2], const int16_t frame[9], const double n[3])
{
    double local[3];
    for (int i = 0; i < 3; i++)
        local[i] = (frame[3 * i] * n[0] + frame[3 * i + 1] * n[1] + frame[3 * i + 2] * n[2]) / 16384;
    double across = hypot(local[0], local[1]);
    if (across == 0) { /* along z, either way */
        uv[0] = uv[1] = 0;
        return;
    }
    double radius = fmin(1, across / fmax(hypot(across, local[2]) + local[2], 1e-9)); /* tan of half the angle */
    double u = 16384 * radius * local[0] / across, v = 16384 * radius * local[1] / across;
    uv[0] = (int16_t)lrint(u);
    uv[1] = (int16_t)lrint(v);
    if (uv[0] * uv[0] + uv[1] * uv[1] > 1 << 28) { /* rounded out of the disc: round inwards */
        uv[0] = (int16_t)trunc(u);
        uv[1] = (int16_t)trunc(v);
    }
}

/* sin of the widest angle between a triangle's geometric normal and the frame's z, Q14, rounded up. The rounded z is
 * up to 2^-14 longer than 1, which a test against it must make good for; one unit more covers the arithmetic here. */
static int16_t cone_cutoff(const struct mesh *m, const struct cluster *c, const int16_t frame[9])
{
    double z[3] = {frame[6], frame[7], frame[8]}, length = sqrt(dot(z, z)) / 16384, least = 1;
    normalise(z);
    for (unsigned i = 0; i < c->count; i++) {
        double g[3];
        triangle_normal(g, m, c->triangles[i]);
        least = fmin(least, dot(g, z) / sqrt(dot(g, g)));
    }
    if (least <= 0)
        return 16384;
    double cutoff = ceil(16384 * fmax(1, length) * sqrt(fmax(0, 1 - least * least))) + 1;
    return (int16_t)fmin(16384, cutoff);
}

static void grow_box(int16_t lo[3], int16_t hi[3], const int16_t p[3])
{
    for (int k = 0; k < 3; k++) {
        lo[k] = p[k] < lo[k] ? p[k] : lo[k];
        hi[k] = p[k] > hi[k] ? p[k] : hi[k];
    }
}

/* Room for one more cluster in the three arrays: they double whenever the count of meshlets is a power of two. */
static void reserve(struct meshlet_pool *pool)
{
    if (pool->meshlet_count & (pool->meshlet_count - 1))
        return;
    size_t room = 2 * (size_t)pool->meshlet_count + 1;
    pool->meshlets = xrealloc(pool->meshlets, room * sizeof *pool->meshlets);
    pool->vertices = xrealloc(pool->vertices, room * MAX_VERTICES * sizeof *pool->vertices);
    pool->triangles = xrealloc(pool->triangles, room * MAX_TRIANGLES * sizeof *pool->triangles);
}

/* The clusters of one level. */
struct clusters {
    struct cluster *items;
    unsigned count;
};

#define LEAST_COSINE 1e-3 /* of a normal's angle to its frame's z, which is rounded afterwards */

/* Cosine of the widest angle between a cluster's normals and the axis it would get; -2 when it has too many vertices. */
static double cluster_cosine(const struct mesh *m, const struct cluster *c)
{
    unsigned vertices[3 * MAX_TRIANGLES];
    uint8_t corners[MAX_TRIANGLES][3];
    unsigned count = cluster_vertices(vertices, corners, c);
    double z[3];
    return count > MAX_VERTICES ? -2 : choose_axis(z, m, vertices, count);
}

/* How far normals interpolated in stereographic coordinates stray: between two normals an angle d apart whose middle is an angle
 * a from the frame's z it is, at most, d^2/8 tan(a/2), for the coordinate tan(a/2) is not linear in a. */
static double cluster_error(const struct mesh *m, const struct cluster *c)
{
    unsigned vertices[3 * MAX_TRIANGLES];
    uint8_t corners[MAX_TRIANGLES][3];
    unsigned count = cluster_vertices(vertices, corners, c);
    double z[3], most = 0;
    choose_axis(z, m, vertices, count);
    for (unsigned i = 0; i < 3 * c->count; i++) {
        double a[3], b[3], middle[3];
        vertex_normal(a, m, c->triangles[i / 3][i % 3]);
        vertex_normal(b, m, c->triangles[i / 3][(i + 1) % 3]);
        for (int k = 0; k < 3; k++)
            middle[k] = a[k] + b[k];
        if (!normalise(middle))
            continue;
        double chord = 2 - 2 * dot(a, b), cosine = fmax(-0.9, dot(middle, z));
        most = fmax(most, chord / 8 * sqrt((1 - fmin(1, cosine)) / (1 + cosine)));
    }
    return most;
}

static void triangle_mean(double out[3], const struct mesh *m, const unsigned t[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = (double)m->vertices[t[0]].normal[k] + m->vertices[t[1]].normal[k] + m->vertices[t[2]].normal[k];
    normalise(out);
}

/* The triangle whose mean normal is farthest from n. */
static unsigned farthest_triangle(const struct mesh *m, const struct cluster *c, const double n[3])
{
    unsigned best = 0;
    double least = 2, t[3];
    for (unsigned i = 0; i < c->count; i++) {
        triangle_mean(t, m, c->triangles[i]);
        if (dot(t, n) < least) {
            least = dot(t, n);
            best = i;
        }
    }
    return best;
}

/* Splits a cluster of at least two triangles by their normals; in halves where these are all alike. */
static void split_cluster(struct cluster part[2], const struct mesh *m, const struct cluster *c)
{
    double p[3], q[3], t[3];
    triangle_mean(t, m, c->triangles[0]);
    triangle_mean(p, m, c->triangles[farthest_triangle(m, c, t)]);
    triangle_mean(q, m, c->triangles[farthest_triangle(m, c, p)]);
    part[0].count = part[1].count = 0;
    for (unsigned i = 0; i < c->count; i++) {
        triangle_mean(t, m, c->triangles[i]);
        struct cluster *to = &part[dot(t, p) < dot(t, q)];
        memcpy(to->triangles[to->count++], c->triangles[i], sizeof c->triangles[i]);
    }
    if (!part[0].count || !part[1].count) {
        part[0] = part[1] = *c;
        part[0].count = c->count / 2;
        part[1].count = c->count - part[0].count;
        memmove(part[1].triangles, part[1].triangles + part[0].count, part[1].count * sizeof *part[1].triangles);
    }
}

/* Adds a cluster, in parts if its normals do not fit one frame, or not well. */
static void add_cluster(struct clusters *out, const struct mesh *m, const struct cluster *c, double normal_error)
{
    if (c->count > 1 && (cluster_cosine(m, c) <= LEAST_COSINE || cluster_error(m, c) > normal_error)) {
        struct cluster part[2];
        split_cluster(part, m, c);
        add_cluster(out, m, &part[0], normal_error);
        add_cluster(out, m, &part[1], normal_error);
        return;
    }
    if (!(out->count & (out->count - 1)))
        out->items = xrealloc(out->items, (2 * (size_t)out->count + 1) * sizeof *out->items);
    out->items[out->count++] = *c;
}

/* Where thin parts turn within few triangles, splitting leaves crumbs: joins those whose normals are most alike. A level that
 * has them is drawn small, so that it does not matter how far apart they are. */
static void join_crumbs(struct clusters *all, const struct mesh *m, double normal_error)
{
    for (unsigned i = 0; i < all->count && all->count <= MAX_JOINED; i++) {
        unsigned best_j;
        do {
            double best = LEAST_COSINE;
            best_j = 0;
            for (unsigned j = i + 1; j < all->count; j++) {
                struct cluster both = all->items[i];
                if (both.count + all->items[j].count > MAX_TRIANGLES)
                    continue;
                memcpy(both.triangles + both.count, all->items[j].triangles,
                       all->items[j].count * sizeof *both.triangles);
                both.count += all->items[j].count;
                double cosine = cluster_cosine(m, &both);
                if (cosine > best && cluster_error(m, &both) <= normal_error) {
                    best = cosine;
                    best_j = j;
                }
            }
            if (best_j) {
                struct cluster *to = &all->items[i], *from = &all->items[best_j];
                memcpy(to->triangles + to->count, from->triangles, from->count * sizeof *from->triangles);
                to->count += from->count;
                *from = all->items[--all->count];
            }
        } while (best_j);
    }
}

/* Appends a cluster as one meshlet. */
static void emit(struct packed_mesh *out, struct meshlet_pool *pool, const struct mesh *m, const struct cluster *c)
{
    unsigned vertices[3 * MAX_TRIANGLES];
    uint8_t corners[MAX_TRIANGLES][3];
    unsigned count = cluster_vertices(vertices, corners, c);
    double z[3];
    choose_axis(z, m, vertices, count);
    reserve(pool);
    struct scene_meshlet *meshlet = &pool->meshlets[pool->meshlet_count++];
    *meshlet = (struct scene_meshlet){
        .lo = {32767, 32767, 32767},
        .hi = {-32767, -32767, -32767},
        .vertex_first = pool->vertex_count,
        .triangle_first = pool->triangle_count,
        .vertex_count = (uint8_t)count,
        .triangle_count = (uint8_t)c->count,
    };
    make_frame(meshlet->frame, z);
    meshlet->cone_cutoff = cone_cutoff(m, c, meshlet->frame);
    for (unsigned i = 0; i < count; i++) {
        const float *p = m->vertices[vertices[i]].position;
        const int16_t q[3] = {(int16_t)p[0], (int16_t)p[1], (int16_t)p[2]};
        double n[3];
        int16_t uv[2];
        vertex_normal(n, m, vertices[i]);
        encode_normal(uv, meshlet->frame, n);
        pool->vertices[pool->vertex_count++] = (struct scene_vertex){q[0], q[1], q[2], uv[0], uv[1]};
        grow_box(meshlet->lo, meshlet->hi, q);
    }
    for (unsigned i = 0; i < c->count; i++)
        memcpy(pool->triangles[pool->triangle_count++].v, corners[i], sizeof corners[i]);
    scene_measure(meshlet, pool->vertices, pool->triangles);
    grow_box(out->lo, out->hi, meshlet->lo);
    grow_box(out->lo, out->hi, meshlet->hi);
}

/* Appends the meshlets of one level. */
static void add_level(struct packed_mesh *out, struct meshlet_pool *pool, const struct mesh *m, double error,
                      double normal_error)
{
    size_t bound = meshopt_buildMeshletsBound(m->index_count, MAX_VERTICES, MAX_TRIANGLES);
    struct meshopt_Meshlet *meshlets = xmalloc(bound * sizeof *meshlets);
    unsigned *vertices = xmalloc(bound * MAX_VERTICES * sizeof *vertices);
    unsigned char *triangles = xmalloc(bound * MAX_TRIANGLES * 3);
    uint32_t first = pool->meshlet_count;
    struct clusters all = {NULL, 0};
    size_t count =
        meshopt_buildMeshlets(meshlets, vertices, triangles, m->indices, m->index_count, m->vertices[0].position,
                              m->vertex_count, sizeof *m->vertices, MAX_VERTICES, MAX_TRIANGLES, CONE_WEIGHT);
    for (size_t i = 0; i < count; i++) {
        struct cluster c = {.count = meshlets[i].triangle_count};
        for (unsigned j = 0; j < 3 * c.count; j++)
            c.triangles[j / 3][j % 3] =
                vertices[meshlets[i].vertex_offset + triangles[meshlets[i].triangle_offset + j]];
        add_cluster(&all, m, &c, normal_error);
    }
    join_crumbs(&all, m, normal_error);
    for (unsigned i = 0; i < all.count; i++)
        emit(out, pool, m, &all.items[i]);
    free(all.items);
    out->levels[out->level_count++] = (struct scene_lod){first, pool->meshlet_count - first, (uint32_t)ceil(error)};
    free(meshlets);
    free(vertices);
    free(triangles);
}

void mesh_pack(struct packed_mesh *out, struct meshlet_pool *pool, struct mesh *m, const struct pack_options *options,
               const char *name)
{
    struct simplified coarser[SIMPLIFY_MAX_LEVELS];
    *out = (struct packed_mesh){.lo = {32767, 32767, 32767}, .hi = {-32767, -32767, -32767}};
    quantise(out, m, name);
    weld(m);
    drop_degenerate(m);
    if (!m->index_count)
        die(EXIT_BAD_INPUT, "%s: no triangle has an area; is it the right mesh?", name);
    add_level(out, pool, m, 0, options->normal_error);
    unsigned count = options->with_levels ? mesh_simplify(coarser, m) : 0;
    for (unsigned i = 0; i < count; i++) {
        add_level(out, pool, &coarser[i].mesh, coarser[i].error, ldexp(options->normal_error, (int)i + 1));
        mesh_free(&coarser[i].mesh);
    }
    mesh_free(m);
}
