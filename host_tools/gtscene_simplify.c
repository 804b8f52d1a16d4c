#include "gtscene_simplify.h"

#include "common.h"
#include "gtscene_distance.h"

#include <math.h>
#include <meshoptimizer.h>
#include <stdlib.h>
#include <string.h>

#define FEWEST_TRIANGLES 64    /* about three meshlets: nothing is gained below */
#define STUCK            0.8   /* a level with more than this share of the one before is not worth its bytes */
#define SAMPLES          16000 /* points measured per surface */

/* Largest distance from a grid's surface among about SAMPLES points spread over some triangles of its mesh: per triangle the
 * points of a regular subdivision, corners included; of more triangles than samples, every n-th. */
static double farthest(const struct distance_grid *from, const unsigned *indices, size_t index_count)
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
                    double a = from->vertices[indices[3 * i]].position[k];
                    double b = from->vertices[indices[3 * i + 1]].position[k];
                    double c = from->vertices[indices[3 * i + 2]].position[k];
                    p[k] = a + (u * (b - a) + v * (c - a)) / parts;
                }
                most = fmax(most, distance_to(from, p));
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

unsigned mesh_simplify(struct simplified out[SIMPLIFY_MAX_LEVELS], const struct mesh *m)
{
    const float *positions = m->vertices[0].position;
    const double unit = meshopt_simplifyScale(positions, m->vertex_count, sizeof *m->vertices);
    const unsigned *previous = m->indices;
    size_t previous_count = m->index_count;
    double least = 0;
    unsigned levels = 0;
    struct distance_grid original;
    distance_grid_build(&original, m->vertices, m->indices, m->index_count);
    while (levels < SIMPLIFY_MAX_LEVELS && previous_count / 3 >= FEWEST_TRIANGLES) {
        struct simplified *s = &out[levels];
        struct distance_grid grid;
        float relative = 0;
        s->indices = xmalloc(previous_count * sizeof *s->indices);
        s->index_count = meshopt_simplify(s->indices, previous, previous_count, positions, m->vertex_count,
                                          sizeof *m->vertices, previous_count / 6 * 3, 1.0f, 0, &relative);
        s->index_count = drop_flat(s->indices, s->index_count, m);
        if (!s->index_count || (double)s->index_count > STUCK * (double)previous_count) {
            free(s->indices);
            break;
        }
        distance_grid_build(&grid, m->vertices, s->indices, s->index_count);
        double there = farthest(&grid, m->indices, m->index_count),
               back = farthest(&original, s->indices, s->index_count);
        distance_grid_free(&grid);
        least = s->error = fmax(fmax(least, relative * unit), fmax(there, back));
        previous = s->indices;
        previous_count = s->index_count;
        levels++;
    }
    distance_grid_free(&original);
    return levels;
}
