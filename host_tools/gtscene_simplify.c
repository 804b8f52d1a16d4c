#include "gtscene_simplify.h"

#include "common.h"
#include "gtscene_distance.h"

#include <math.h>
#include <meshoptimizer.h>
#include <stdlib.h>
#include <string.h>

#define FEWEST_TRIANGLES 64    /* about three meshlets: nothing is gained below */
#define STUCK            0.8   /* a level with more than this share of the one before is not worth its bytes */
#define FIT_POINTS       50000 /* of the original that a level is fitted to */
#define FIT_ROUNDS       3
#define SAMPLES          16000 /* points measured per surface */

/* Largest distance from a grid's surface among about SAMPLES points spread over some triangles: per triangle the
 * points of a regular subdivision, corners included; of more triangles than samples, every n-th. */
static double farthest(const struct distance_grid *from, const struct mesh_vertex *vertices, const unsigned *indices,
                       size_t index_count)
{
    size_t triangles = index_count / 3, stride = triangles / SAMPLES + 1;
    double most = 0;
    int parts = (int)sqrt(2.0 * SAMPLES / (double)triangles); /* n parts per edge: about n^2 / 2 points */
    parts = parts < 2 ? 2 : parts > 32 ? 32 : parts;
    for (size_t i = 0; i < triangles; i += stride)
        for (int u = 0; u <= parts; u++)
            for (int v = 0; u + v <= parts; v++) {
                double p[3];
                for (int k = 0; k < 3; k++) {
                    double a = vertices[indices[3 * i]].position[k];
                    double b = vertices[indices[3 * i + 1]].position[k];
                    double c = vertices[indices[3 * i + 2]].position[k];
                    p[k] = a + (u * (b - a) + v * (c - a)) / parts;
                }
                most = fmax(most, distance_to(from, p, NULL));
            }
    return most;
}

static void triangle_edges(double e[2][3], const struct mesh *m, const unsigned *t)
{
    for (int k = 0; k < 3; k++) {
        e[0][k] = (double)m->vertices[t[1]].position[k] - m->vertices[t[0]].position[k];
        e[1][k] = (double)m->vertices[t[2]].position[k] - m->vertices[t[0]].position[k];
    }
}

/* Triangles that lost their area. */
static size_t drop_flat(unsigned *indices, size_t count, const struct mesh *m)
{
    size_t kept = 0;
    for (size_t i = 0; i < count; i += 3) {
        double e[2][3];
        bool flat = true;
        triangle_edges(e, m, indices + i);
        for (int k = 0; k < 3; k++)
            flat = flat && e[0][(k + 1) % 3] * e[1][(k + 2) % 3] == e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
        if (!flat) {
            memmove(indices + kept, indices + i, 3 * sizeof *indices);
            kept += 3;
        }
    }
    return kept;
}

/* A number for each position, beyond all vertices for those of no triangle: vertices that differ by their normals only
 * must move as one. */
static unsigned *same_position(const struct mesh *m)
{
    unsigned *remap = xmalloc(m->vertex_count * sizeof *remap);
    const struct meshopt_Stream positions = {m->vertices, sizeof m->vertices->position, sizeof *m->vertices};
    meshopt_generateVertexRemapMulti(remap, m->indices, m->index_count, m->vertex_count, &positions, 1);
    return remap;
}

/* What the original's points say about a vertex of a level: how far along its normal they are. */
struct pull {
    double sum, weight, normal[3];
};

/* Adds how far p is from triangle t, along its normal, to its corners by their barycentric weights. */
static void pull_corners(struct pull *pulls, const struct mesh *level, const unsigned *t, const unsigned *group,
                         const float *p)
{
    double e[2][3], n[3], to[3], area2 = 0, height = 0, weight[3] = {0, 0, 0}, sum = 0;
    triangle_edges(e, level, t);
    for (int k = 0; k < 3; k++)
        to[k] = (double)p[k] - level->vertices[t[0]].position[k];
    for (int k = 0; k < 3; k++) {
        int a = (k + 1) % 3, b = (k + 2) % 3;
        n[k] = e[0][a] * e[1][b] - e[0][b] * e[1][a];
        area2 += n[k] * n[k];
        height += n[k] * to[k];
    }
    for (int k = 0; k < 3 && area2 > 0; k++) {
        int a = (k + 1) % 3, b = (k + 2) % 3;
        weight[1] += n[k] * (to[a] * e[1][b] - to[b] * e[1][a]) / area2;
        weight[2] += n[k] * (e[0][a] * to[b] - e[0][b] * to[a]) / area2;
    }
    weight[0] = 1 - weight[1] - weight[2];
    for (int c = 0; c < 3; c++)
        sum += weight[c] = fmax(0, weight[c]);
    for (int c = 0; c < 3 && area2 > 0; c++) {
        pulls[group[t[c]]].sum += weight[c] / sum * height / sqrt(area2);
        pulls[group[t[c]]].weight += weight[c] / sum;
    }
}

/* Moves a level's vertices between the original's points, to whole units as all positions are. */
static void fit(struct mesh *level, const struct mesh *m, const unsigned *group)
{
    struct pull *pulls = xmalloc(m->vertex_count * sizeof *pulls);
    size_t stride = m->vertex_count / FIT_POINTS + 1;
    for (int round = 0; round < FIT_ROUNDS; round++) {
        struct distance_grid grid;
        distance_grid_build(&grid, level->vertices, level->indices, level->index_count);
        memset(pulls, 0, m->vertex_count * sizeof *pulls);
        for (size_t i = 0; i < m->vertex_count; i++) {
            if (group[i] >= m->vertex_count)
                continue;
            for (int k = 0; k < 3; k++)
                pulls[group[i]].normal[k] += m->vertices[i].normal[k];
            const float *p = m->vertices[i].position;
            const double point[3] = {p[0], p[1], p[2]};
            unsigned nearest = 0;
            if (i % stride)
                continue;
            distance_to(&grid, point, &nearest);
            pull_corners(pulls, level, level->indices + 3 * nearest, group, p);
        }
        distance_grid_free(&grid);
        for (size_t i = 0; i < m->vertex_count; i++) {
            if (group[i] >= m->vertex_count)
                continue;
            const struct pull *pull = &pulls[group[i]];
            double length2 = 0;
            for (int k = 0; k < 3; k++)
                length2 += pull->normal[k] * pull->normal[k];
            for (int k = 0; k < 3 && pull->weight > 0 && length2 > 0; k++) {
                float *x = &level->vertices[i].position[k];
                double to = *x + pull->sum / pull->weight * pull->normal[k] / sqrt(length2);
                *x = (float)fmin(32767, fmax(-32767, nearbyint(to))) + 0.0f;
            }
        }
    }
    free(pulls);
}

/* Copies the vertices and halves the triangles of `finer`, a level of m. False when it is stuck. */
static bool halve(struct mesh *out, const struct mesh *finer, const struct mesh *m)
{
    *out = (struct mesh){.vertex_count = m->vertex_count};
    out->indices = xmalloc(finer->index_count * sizeof *out->indices);
    /* between the original's positions, where the finer level's vertices belong */
    out->index_count =
        meshopt_simplify(out->indices, finer->indices, finer->index_count, m->vertices[0].position, m->vertex_count,
                         sizeof *m->vertices, finer->index_count / 6 * 3, 1.0f, 0, NULL);
    out->index_count = drop_flat(out->indices, out->index_count, m);
    if (!out->index_count || (double)out->index_count > STUCK * (double)finer->index_count) {
        free(out->indices);
        return false;
    }
    out->vertices = xmalloc(m->vertex_count * sizeof *out->vertices);
    memcpy(out->vertices, m->vertices, m->vertex_count * sizeof *out->vertices);
    return true;
}

unsigned mesh_simplify(struct simplified out[SIMPLIFY_MAX_LEVELS], const struct mesh *m)
{
    const struct mesh *finer = m;
    double error = 0;
    unsigned levels = 0, *group = same_position(m);
    struct distance_grid original;
    distance_grid_build(&original, m->vertices, m->indices, m->index_count);
    for (; levels < SIMPLIFY_MAX_LEVELS && finer->index_count / 3 >= FEWEST_TRIANGLES; levels++) {
        struct mesh *level = &out[levels].mesh;
        struct distance_grid grid;
        if (!halve(level, finer, m))
            break;
        if (level->index_count / 3 <= FIT_POINTS / 4) /* about eight points to a vertex */
            fit(level, m, group);
        level->index_count = drop_flat(level->indices, level->index_count, level);
        distance_grid_build(&grid, level->vertices, level->indices, level->index_count);
        error = fmax(error, farthest(&grid, m->vertices, m->indices, m->index_count));
        error = fmax(error, farthest(&original, level->vertices, level->indices, level->index_count));
        distance_grid_free(&grid);
        out[levels].error = error;
        finer = level;
    }
    distance_grid_free(&original);
    free(group);
    return levels;
}
