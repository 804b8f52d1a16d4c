/*
 * Small scenes made by hand, rendered through the rasterizer's public interface. Background pixels are magenta, which no surface is.
 */
#ifndef SCENE_FIXTURE_H
#define SCENE_FIXTURE_H

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "raster.h"
#include "ref_blob.h"

static const uint8_t magenta[3] = {255, 0, 255};
static const double origin[3] = {0, 0, 0};
static uint64_t random_state = 1;

static inline double random_unit(void)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (double)(random_state >> 40) * 0x1p-24;
}

static inline double random_between(double lo, double hi)
{
    return lo + (hi - lo) * random_unit();
}

/* Lights from all sides, one grey material. */
static inline struct ref_blob new_scene(void)
{
    struct ref_blob b;
    ref_blob_init(&b);
    memcpy(b.background, magenta, 3);
    for (int i = 0; i < 6; i++) {
        double d[3] = {0, 0, 0};
        d[i / 2] = i & 1 ? 1 : -1;
        ref_blob_light(&b, d, 1);
    }
    ref_blob_material(&b, 1, 0, 0.5, "grey");
    return b;
}

struct opened {
    void *blob;
    struct scene scene;
    struct raster_frame frame;
};

static const struct lut_table *const no_tables[RASTER_MAX_SLOTS];

static inline void open_scene(struct opened *o, const struct ref_blob *b, uint16_t width, uint16_t height)
{
    size_t bytes;
    o->blob = ref_blob_finish(b, &bytes);
    assert_string_equal(scene_status_text(scene_open(&o->scene, o->blob, bytes)), scene_status_text(SCENE_OK));
    o->frame = (struct raster_frame){.parts = &raster_all_parts,
                                     .scene = &o->scene,
                                     .camera = &o->scene.header->camera,
                                     .output = &o->scene.header->output,
                                     .lights = o->scene.lights,
                                     .materials = o->scene.materials,
                                     .tables = no_tables,
                                     .width = width,
                                     .height = height,
                                     .light_count = (uint8_t)o->scene.header->lights.count,
                                     .format = RASTER_RGB888};
}

enum order { FORWARD, BACKWARD, SHUFFLED };

struct picture {
    unsigned width, height;
    uint8_t *rgb;
    uint32_t covered; /* as the statistics say */
};

/* Renders with exactly the arena that the frame asks for, in fresh memory each, the tile's filled with rubbish. */
static inline struct picture render_frame(const struct raster_frame *f, enum order order)
{
    struct picture p = {f->width, f->height, malloc(3u * f->width * f->height), 0};
    struct raster_tile *work = malloc(sizeof *work);
    struct raster r;
    size_t bytes = raster_arena_bytes(f);
    void *arena = malloc(bytes);
    assert_int_equal(raster_begin(&r, f, arena, bytes), RASTER_OK);
    uint32_t n = raster_tile_count(&r), stride = order == SHUFFLED ? 7919 : 1; /* a prime: visits all */
    for (uint32_t i = 0; i < n; i++) {
        struct raster_rect rect;
        struct raster_stats stats;
        memset(work, 0xa5, sizeof *work);
        raster_render_tile(&r, order == BACKWARD ? n - 1 - i : i * stride % n, work, &rect, &stats);
        p.covered += stats.covered;
        for (unsigned y = 0; y < rect.height; y++)
            memcpy(p.rgb + 3 * ((size_t)(rect.y + y) * p.width + rect.x),
                   raster_tile_pixels(work) + 3u * y * rect.width, 3u * rect.width);
    }
    free(arena);
    free(work);
    return p;
}

static inline struct picture render(const struct ref_blob *b, uint16_t width, uint16_t height)
{
    struct opened o;
    open_scene(&o, b, width, height);
    struct picture p = render_frame(&o.frame, FORWARD);
    free(o.blob);
    return p;
}

static inline bool is_background(const struct picture *p, unsigned x, unsigned y)
{
    return !memcmp(p->rgb + 3 * ((size_t)y * p->width + x), magenta, 3);
}

static inline unsigned count_surface(const struct picture *p)
{
    unsigned n = 0;
    for (unsigned i = 0; i < p->width * p->height; i++)
        n += !is_background(p, i % p->width, i / p->width);
    return n;
}

/* Renders, checks the number of pixels that show a surface, frees the scene. */
static inline void expect_surface(struct ref_blob *b, uint16_t width, uint16_t height, unsigned expected)
{
    struct picture p = render(b, width, height);
    assert_int_equal(count_surface(&p), expected);
    assert_int_equal(p.covered, expected);
    free(p.rgb);
    ref_blob_free(b);
}

/* Random orientation. */
static inline void turn_camera(struct ref_blob *b)
{
    double q[4], length = 0;
    for (int i = 0; i < 4; i++) {
        q[i] = random_between(-1, 1);
        length += q[i] * q[i];
    }
    for (int i = 0; i < 4; i++)
        q[i] /= sqrt(length);
    double w = q[0], x = q[1], y = q[2], z = q[3];
    const double m[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                         2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                         2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
    memcpy(b->rotation, m, sizeof m);
}

/* A cube of half edge `half`, each face a grid of n x n quads whose inner points move along the face; seen from
 * inside when `inside`. */
static inline unsigned add_cube(struct ref_blob *b, int half, int n, bool inside)
{
    int16_t(*v)[3] = malloc(6u * (n + 1) * (n + 1) * sizeof *v);
    uint16_t(*t)[3] = malloc(12u * n * n * sizeof *t);
    unsigned vertices = 0, triangles = 0;
    for (int face = 0; face < 6; face++) {
        int axis = face / 2, side = face & 1 ? 1 : -1;
        unsigned first = vertices;
        for (int i = 0; i <= n; i++)
            for (int j = 0; j <= n; j++, vertices++) {
                bool inner = i > 0 && j > 0 && i < n && j < n;
                double step = 2.0 * half / n, jitter = inner ? 0.24 * step : 0;
                v[vertices][axis] = (int16_t)(side * half);
                v[vertices][(axis + 1) % 3] = (int16_t)(i * step - half + random_between(-jitter, jitter));
                v[vertices][(axis + 2) % 3] = (int16_t)(j * step - half + random_between(-jitter, jitter));
            }
        for (int k = 0; k < 2 * n * n; k++, triangles++) {
            unsigned a = first + (k / 2 / n) * (n + 1) + k / 2 % n;
            unsigned c[3] = {a, k & 1 ? a + n + 2 : a + n + 1, k & 1 ? a + 1 : a + n + 2};
            bool turn = (side < 0) != inside; /* (a, a+row, a+row+1) turns around +axis */
            for (int i = 0; i < 3; i++)
                t[triangles][turn ? 2 - i : i] = (uint16_t)c[i];
        }
    }
    unsigned mesh = ref_blob_mesh(b, (const int16_t(*)[3])v, (const uint16_t(*)[3])t, triangles);
    free(v);
    free(t);
    return mesh;
}

/* A quad across the view at the object's distance: x0..x1, y0..y1 in vertex units. */
static inline unsigned add_wall(struct ref_blob *b, int x0, int y0, int x1, int y1)
{
    const int16_t v[4][3] = {{(int16_t)x0, (int16_t)y0, 0},
                             {(int16_t)x1, (int16_t)y0, 0},
                             {(int16_t)x1, (int16_t)y1, 0},
                             {(int16_t)x0, (int16_t)y1, 0}};
    const uint16_t t[2][3] = {{0, 1, 2}, {0, 2, 3}};
    return ref_blob_mesh(b, v, t, 2);
}

#endif
