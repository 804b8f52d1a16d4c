/*
 * The rasterizer through its public interface, on small scenes made by hand: near plane, guard band, extreme depths,
 * crowded tiles, odd pictures, refusals. Background pixels are magenta, which no surface here is.
 */
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
static uint64_t random_state;

static double random_unit(void)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (double)(random_state >> 40) * 0x1p-24;
}

static double random_between(double lo, double hi)
{
    return lo + (hi - lo) * random_unit();
}

/* Lights from all sides, one grey material. */
static struct ref_blob new_scene(void)
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

static void open_scene(struct opened *o, const struct ref_blob *b, uint16_t width, uint16_t height)
{
    size_t bytes;
    o->blob = ref_blob_finish(b, &bytes);
    assert_string_equal(scene_status_text(scene_open(&o->scene, o->blob, bytes)), scene_status_text(SCENE_OK));
    o->frame = (struct raster_frame){.scene = &o->scene,
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
static struct picture render_frame(const struct raster_frame *f, enum order order)
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

static struct picture render(const struct ref_blob *b, uint16_t width, uint16_t height)
{
    struct opened o;
    open_scene(&o, b, width, height);
    struct picture p = render_frame(&o.frame, FORWARD);
    free(o.blob);
    return p;
}

static bool is_background(const struct picture *p, unsigned x, unsigned y)
{
    return !memcmp(p->rgb + 3 * ((size_t)y * p->width + x), magenta, 3);
}

static unsigned count_surface(const struct picture *p)
{
    unsigned n = 0;
    for (unsigned i = 0; i < p->width * p->height; i++)
        n += !is_background(p, i % p->width, i / p->width);
    return n;
}

/* Renders, checks the number of pixels that show a surface, frees the scene. */
static void expect_surface(struct ref_blob *b, uint16_t width, uint16_t height, unsigned expected)
{
    struct picture p = render(b, width, height);
    assert_int_equal(count_surface(&p), expected);
    assert_int_equal(p.covered, expected);
    free(p.rgb);
    ref_blob_free(b);
}

/* Random orientation. */
static void turn_camera(struct ref_blob *b)
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
static unsigned add_cube(struct ref_blob *b, int half, int n, bool inside)
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
static unsigned add_wall(struct ref_blob *b, int x0, int y0, int x1, int y1)
{
    const int16_t v[4][3] = {{(int16_t)x0, (int16_t)y0, 0},
                             {(int16_t)x1, (int16_t)y0, 0},
                             {(int16_t)x1, (int16_t)y1, 0},
                             {(int16_t)x0, (int16_t)y1, 0}};
    const uint16_t t[2][3] = {{0, 1, 2}, {0, 2, 3}};
    return ref_blob_mesh(b, v, t, 2);
}

static void room_around_the_eye_leaves_no_background(void **state)
{
    (void)state;
    random_state = 1;
    for (int n = 0; n < 60; n++) {
        struct ref_blob b = new_scene();
        double half = exp2(random_between(-4, 10)); /* world units; the vertices reach 32000 */
        unsigned mesh = add_cube(&b, 32000, n % 3 == 0 ? 1 : n % 3 == 1 ? 3 : 8, true);
        ref_blob_object(&b, mesh, 0, origin, half / 32000);
        b.near = fmax(half * exp2(random_between(-12, -3)), 0x1p-16);
        b.focal = exp2(random_between(-1, 3));
        /* The near plane's corner must stay inside of the room, whichever way the eye looks, and although a vertex's
         * place is rounded to a part of the object's size, and eye and near plane to 2^-16. */
        double margin = half - 1.01 * b.near * sqrt(1 + 4 / b.focal / b.focal) - half * 0x1p-13 - 0x1p-14;
        for (int i = 0; i < 3; i++)
            b.eye[i] = n & 1 ? random_between(-margin, margin) : random_unit() < 0.5 ? -margin : margin;
        if (margin > 0) {
            turn_camera(&b);
            expect_surface(&b, 150, 90, 150 * 90);
        } else {
            ref_blob_free(&b);
        }
    }
}

static void eye_inside_a_solid_sees_only_back_faces(void **state)
{
    (void)state;
    random_state = 2;
    for (int n = 0; n < 10; n++) {
        struct ref_blob b = new_scene();
        ref_blob_object(&b, add_cube(&b, 30000, 4, false), 0, origin, 1 / 3000.0);
        for (int i = 0; i < 3; i++)
            b.eye[i] = random_between(-9, 9);
        turn_camera(&b);
        expect_surface(&b, 150, 90, 0);
    }
}

static void solid_in_front_covers_its_silhouette(void **state)
{
    (void)state;
    /* Front face at distance 4 with half edge 2: tan 1/2, so 25 of 50 pixels to each side, to the pixel. */
    struct ref_blob b = new_scene();
    ref_blob_object(&b, add_cube(&b, 32000, 4, false), 0, (const double[3]){0, 0, -6}, 2 / 32000.0);
    struct picture p = render(&b, 140, 100);
    for (unsigned y = 0; y < 100; y++)
        for (unsigned x = 0; x < 140; x++)
            assert_int_equal(!is_background(&p, x, y), x >= 45 && x < 95 && y >= 25 && y < 75);
    free(p.rgb);
    ref_blob_free(&b);
    b = new_scene();
    ref_blob_object(&b, add_cube(&b, 32000, 4, true), 0, (const double[3]){0, 0, -6}, 2 / 32000.0);
    p = render(&b, 140, 100);
    /* Inside out: the back wall shows through the front; the side walls frame it up to the same silhouette. */
    for (unsigned y = 0; y < 100; y++)
        for (unsigned x = 0; x < 140; x++)
            assert_int_equal(!is_background(&p, x, y), x >= 45 && x < 95 && y >= 25 && y < 75);
    free(p.rgb);
    ref_blob_free(&b);
}

static void walls_seen_from_behind_are_culled(void **state)
{
    (void)state;
    struct ref_blob b = new_scene();
    unsigned wall = add_wall(&b, 1000, -1000, -1000, 1000); /* turned over */
    ref_blob_object(&b, wall, 0, (const double[3]){0, 0, -4}, 1 / 1000.0);
    expect_surface(&b, 64, 64, 0);
}

static void objects_behind_the_eye_draw_nothing(void **state)
{
    (void)state;
    struct ref_blob b = new_scene();
    unsigned wall = add_wall(&b, -1000, -1000, 1000, 1000), cube = add_cube(&b, 1000, 2, true);
    ref_blob_object(&b, wall, 0, (const double[3]){0, 0, 4}, 1 / 1000.0);
    ref_blob_object(&b, wall, 0, (const double[3]){0, 0, -1 / 32.0}, 1); /* nearer than the near plane */
    ref_blob_object(&b, cube, 0, (const double[3]){3, 2, 1.5}, 1 / 1000.0);
    expect_surface(&b, 64, 64, 0);
}

/* A floor below a level eye, through the near plane and to the horizon: tan of the last row seen is depth / reach. */
static void check_floor(double depth, double reach, double near, int quads)
{
    struct ref_blob b = new_scene();
    int n = quads + 1, half = 32000;
    int16_t(*v)[3] = malloc((size_t)n * n * sizeof *v);
    uint16_t(*t)[3] = malloc(2u * quads * quads * sizeof *t);
    for (int i = 0; i < n * n; i++) {
        v[i][0] = (int16_t)(i % n * (2 * half) / quads - half);
        v[i][1] = 0;
        v[i][2] = (int16_t)(i / n * (2 * half) / quads - half);
    }
    for (int k = 0; k < 2 * quads * quads; k++) {
        unsigned a = (unsigned)(k / 2 / quads * n + k / 2 % quads);
        const unsigned c[2][3] = {{a, a + n, a + n + 1}, {a, a + n + 1, a + 1}};
        for (int i = 0; i < 3; i++)
            t[k][i] = (uint16_t)c[k & 1][i];
    }
    unsigned mesh = ref_blob_mesh(&b, (const int16_t(*)[3])v, (const uint16_t(*)[3])t, 2u * quads * quads);
    ref_blob_object(&b, mesh, 0, (const double[3]){0, -depth, 0}, reach / half);
    b.near = near;
    free(v);
    free(t);
    struct picture p = render(&b, 120, 80);
    for (unsigned y = 0; y < 80; y++) {
        double tangent = (y + 0.5 - 40) / 40; /* downwards */
        for (unsigned x = 0; x < 120; x++) {
            /* Away from the horizon by a pixel, and not cut off by the near plane (w < near) or the side. */
            if (tangent < depth / reach - 1 / 40.0)
                assert_true(is_background(&p, x, y));
            else if (tangent > depth / reach + 1 / 40.0 && tangent < depth / near)
                assert_false(is_background(&p, x, y));
        }
    }
    free(p.rgb);
    ref_blob_free(&b);
}

static void floors_through_the_near_plane_reach_the_horizon(void **state)
{
    (void)state;
    for (int quads = 1; quads <= 16; quads *= 4) {
        check_floor(1, 100, 0.25, quads);
        check_floor(0.5, 8000, 1 / 64.0, quads);
        check_floor(1 / 100.0, 16000, 1 / 128.0, quads); /* w from 1/128 to 16000: 2 million to 1 */
        check_floor(1 / 1024.0, 4, 1 / 2048.0, quads);
    }
}

static void far_objects_keep_their_place(void **state)
{
    (void)state;
    /* 30000 away, half edge 3000: a tenth, so 4 of 40 pixels to each side. */
    struct ref_blob b = new_scene();
    ref_blob_object(&b, add_wall(&b, -30000, -30000, 30000, 30000), 0, (const double[3]){0, 0, -30000}, 0.1);
    b.near = 1 / 256.0;
    struct picture p = render(&b, 80, 80);
    for (unsigned y = 0; y < 80; y++)
        for (unsigned x = 0; x < 80; x++)
            assert_int_equal(!is_background(&p, x, y), x >= 36 && x < 44 && y >= 36 && y < 44);
    free(p.rgb);
    ref_blob_free(&b);
}

static void depth_orders_a_million_to_one(void **state)
{
    (void)state;
    /* Full-screen walls at every factor of two from 2^-9 to 2^13, given farthest first and nearest first; the eye must
     * see the nearest that is left. Walls differ in material. */
    for (int reverse = 0; reverse < 2; reverse++)
        for (int nearest = 0; nearest < 22; nearest++) {
            struct ref_blob b = new_scene();
            unsigned wall = add_wall(&b, -32000, -32000, 32000, 32000);
            for (int i = 1; i < 23; i++)
                ref_blob_material(&b, 1, 0, i / 24.0, "wall");
            b.near = 1 / 1024.0;
            for (int k = nearest; k < 22; k++) {
                int i = reverse ? 21 + nearest - k : k;
                double distance = ldexp(1, i - 9);
                ref_blob_object(&b, wall, (unsigned)i + 1, (const double[3]){0, 0, -distance},
                                fmin(4 * distance / 32000, 1));
            }
            struct picture p = render(&b, 40, 40);
            struct ref_blob alone = b; /* the nearest only: shares all arrays but the objects */
            size_t object = b.array[2].bytes / b.array[2].count;
            size_t at = reverse ? b.array[2].bytes - object : 0;
            alone.array[2].data = b.array[2].data + at;
            alone.array[2].bytes = object;
            alone.array[2].count = 1;
            struct picture q = render(&alone, 40, 40);
            assert_int_equal(count_surface(&p), 1600);
            assert_memory_equal(p.rgb, q.rgb, 3 * 1600);
            free(p.rgb);
            free(q.rgb);
            ref_blob_free(&b);
        }
}

static void walls_beyond_the_guard_band_fill_the_picture(void **state)
{
    (void)state;
    random_state = 3;
    for (int n = 0; n < 40; n++) {
        /* Up to 65534 world units wide at an arm's length: a million pixels. */
        struct ref_blob b = new_scene();
        double distance = exp2(random_between(-3, 3));
        int x = (int)random_between(-20000, 20000), y = (int)random_between(-20000, 20000);
        ref_blob_object(&b, add_wall(&b, x - 12000, y - 12000, x + 12000, y + 12000), 0,
                        (const double[3]){n % 4 ? -x : -x + 11990.0, -y, -distance}, 1);
        if (n % 2 == 0)
            ref_blob_object(&b, add_wall(&b, -32000, -32000, 32000, 32000), 0, (const double[3]){0, 0, -9}, 1);
        expect_surface(&b, 150, 90, 150 * 90);
    }
}

static void scene_without_objects_is_background(void **state)
{
    (void)state;
    struct ref_blob b = new_scene();
    expect_surface(&b, 100, 50, 0);
    ref_blob_init(&b); /* nothing at all */
    memcpy(b.background, magenta, 3);
    expect_surface(&b, 100, 50, 0);
}

static void scene_without_lights_is_black(void **state)
{
    (void)state;
    struct ref_blob b;
    ref_blob_init(&b);
    memcpy(b.background, magenta, 3);
    ref_blob_material(&b, 1, 0, 1, "white");
    ref_blob_object(&b, add_wall(&b, -100, -100, 100, 100), 0, (const double[3]){0, 0, -1}, 1);
    struct picture p = render(&b, 70, 40);
    for (unsigned i = 0; i < 3 * 70 * 40; i++)
        assert_int_equal(p.rgb[i], 0);
    free(p.rgb);
    ref_blob_free(&b);
}

static void pictures_of_extreme_shape_are_complete(void **state)
{
    (void)state;
    static const uint16_t sizes[][2] = {{1, 1}, {4096, 1}, {1, 4096}, {65, 33}, {63, 31}, {4095, 3}, {2, 2}};
    random_state = 4;
    for (unsigned i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        struct ref_blob b = new_scene();
        ref_blob_object(&b, add_cube(&b, 32000, 3, true), 0, origin, 1);
        b.focal = sizes[i][0] > 1000 ? 256 : 1;
        turn_camera(&b);
        expect_surface(&b, sizes[i][0], sizes[i][1], (unsigned)sizes[i][0] * sizes[i][1]);
    }
}

static void sizes_out_of_range_are_refused(void **state)
{
    (void)state;
    static const uint16_t sizes[][2] = {{0, 1}, {1, 0}, {4097, 1}, {1, 4097}, {0, 0}, {65535, 65535}};
    struct ref_blob b = new_scene();
    struct opened o;
    struct raster r;
    open_scene(&o, &b, 1, 1);
    for (unsigned i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        o.frame.width = sizes[i][0];
        o.frame.height = sizes[i][1];
        assert_int_equal(raster_begin(&r, &o.frame, NULL, 0), RASTER_ERR_SIZE);
        assert_int_equal(raster_arena_bytes(&o.frame), 0);
    }
    free(o.blob);
    ref_blob_free(&b);
}

static void small_arena_says_what_is_needed(void **state)
{
    (void)state;
    struct ref_blob b = new_scene();
    struct opened o;
    ref_blob_object(&b, add_cube(&b, 32000, 5, true), 0, origin, 1);
    open_scene(&o, &b, 320, 240);
    size_t needed = raster_arena_bytes(&o.frame);
    assert_true(needed > 0);
    for (size_t bytes = 0; bytes < needed; bytes += bytes + 64 < needed ? 61 : 1) {
        struct raster r;
        void *arena = malloc(bytes);
        assert_int_equal(raster_begin(&r, &o.frame, arena, bytes), RASTER_ERR_ARENA);
        assert_int_equal(r.arena_needed, needed);
        free(arena);
    }
    struct picture p = render_frame(&o.frame, FORWARD); /* with just that */
    assert_int_equal(count_surface(&p), 320 * 240);
    free(p.rgb);
    free(o.blob);
    ref_blob_free(&b);
}

static void missing_table_is_refused_with_its_material(void **state)
{
    (void)state;
    struct ref_blob b = new_scene();
    struct opened o;
    struct raster r;
    unsigned wall = add_wall(&b, -100, -100, 100, 100);
    ref_blob_material(&b, 1, 3, 0.5, "another");
    unsigned measured = ref_blob_material(&b, 0, 7, 0, "measured");
    ref_blob_object(&b, wall, 0, (const double[3]){0, 0, -1}, 1);
    open_scene(&o, &b, 32, 32);
    assert_true(raster_arena_bytes(&o.frame) > 0); /* the material exists, but nothing is made of it */
    free(o.blob);
    ref_blob_object(&b, wall, measured, (const double[3]){0, 0, 9}, 1);
    open_scene(&o, &b, 32, 32);
    memset(&r, 0xa5, sizeof r);
    assert_int_equal(raster_begin(&r, &o.frame, NULL, 0), RASTER_ERR_TABLE);
    assert_int_equal(r.bad_material, measured);
    assert_int_equal(raster_arena_bytes(&o.frame), 0);
    free(o.blob);
    ref_blob_free(&b);
}

static void too_many_meshlets_are_refused(void **state)
{
    (void)state;
    enum { PER_MESH = 1000 };
    static uint16_t t[PER_MESH][3];
    const int16_t v[3][3] = {{-100, -100, 0}, {100, -100, 0}, {0, 100, 0}};
    for (int i = 0; i < PER_MESH; i++)
        memcpy(t[i], (const uint16_t[3]){0, 1, 2}, sizeof t[i]);
    struct ref_blob b = new_scene();
    unsigned mesh = ref_blob_mesh(&b, v, (const uint16_t(*)[3])t, PER_MESH);
    for (int objects = 1; objects <= 66; objects++) {
        ref_blob_object(&b, mesh, 0, (const double[3]){0, 0, -4}, 0.01);
        if (objects != 65 && objects != 66)
            continue;
        struct opened o; /* one tile: as many entries as meshlets, 65000 or 66000 */
        struct raster r;
        open_scene(&o, &b, 32, 32);
        assert_int_equal(raster_begin(&r, &o.frame, NULL, 0), objects == 65 ? RASTER_ERR_ARENA : RASTER_ERR_LIMIT);
        assert_int_equal(raster_arena_bytes(&o.frame) > 0, objects == 65);
        o.frame.width = 128; /* two columns of tiles: twice the entries */
        assert_int_equal(raster_begin(&r, &o.frame, NULL, 0), RASTER_ERR_LIMIT);
        free(o.blob);
    }
    ref_blob_free(&b);
}

/* Overlapping rectangles in 64 colours, each a mesh of its own at a depth of its own: what is seen is each pixel's
 * nearest, as the pictures of each one alone tell. */
static void check_crowd(int objects, int repeat)
{
    enum { W = 70, H = 40 };
    struct ref_blob b = new_scene();
    static uint8_t expected[W * H][3];
    static double nearest[W * H];
    for (int i = 0; i < W * H; i++) {
        memcpy(expected[i], magenta, 3);
        nearest[i] = 1e9;
    }
    for (int k = 1; k < 64; k++)
        ref_blob_material(&b, 1, 0, k / 64.0, "colour");
    for (int k = 0; k < objects; k++) {
        struct ref_blob alone = new_scene();
        double x = random_between(-900, 900), y = random_between(-900, 900), w = random_between(30, 500);
        double distance = random_between(1, 4);
        int material = 1 + k % 63;
        /* The same rectangle many times over adds meshlets and changes nothing. */
        for (int i = 0; i < repeat; i++)
            ref_blob_object(&b, add_wall(&b, (int)(x - w), (int)(y - w), (int)(x + w), (int)(y + w)), material,
                            (const double[3]){0, 0, -distance}, distance / 1000);
        for (int i = 1; i < 64; i++)
            ref_blob_material(&alone, 1, 0, i / 64.0, "colour");
        ref_blob_object(&alone, add_wall(&alone, (int)(x - w), (int)(y - w), (int)(x + w), (int)(y + w)), material,
                        (const double[3]){0, 0, -distance}, distance / 1000);
        struct picture p = render(&alone, W, H);
        for (int i = 0; i < W * H; i++)
            if (distance < nearest[i] && !is_background(&p, i % W, i / W)) {
                nearest[i] = distance;
                memcpy(expected[i], p.rgb + 3 * i, 3);
            }
        free(p.rgb);
        ref_blob_free(&alone);
    }
    struct picture p = render(&b, W, H);
    assert_memory_equal(p.rgb, expected, sizeof expected);
    free(p.rgb);
    ref_blob_free(&b);
}

static void crowded_tiles_lose_nothing(void **state)
{
    (void)state;
    random_state = 5;
    check_crowd(100, 1); /* 200 meshlets: fewer than the slots of a tile */
    check_crowd(400, 1); /* 800 */
    check_crowd(300, 4); /* 2400 */
    check_crowd(127, 1); /* 254, and the next about the limit of 255 */
    check_crowd(128, 1);
}

static void any_order_of_tiles_gives_the_same_pixels(void **state)
{
    (void)state;
    random_state = 6;
    struct ref_blob b = new_scene();
    struct opened o;
    ref_blob_object(&b, add_cube(&b, 32000, 6, true), 0, origin, 1 / 3200.0);
    ref_blob_object(&b, add_cube(&b, 32000, 6, false), 0, (const double[3]){0, 0, -6}, 1 / 16000.0);
    open_scene(&o, &b, 333, 222);
    struct picture p = render_frame(&o.frame, FORWARD);
    for (int order = BACKWARD; order <= SHUFFLED; order++) {
        struct picture q = render_frame(&o.frame, order);
        assert_memory_equal(p.rgb, q.rgb, 3 * 333 * 222);
        assert_int_equal(p.covered, q.covered);
        free(q.rgb);
    }
    free(p.rgb);
    free(o.blob);
    ref_blob_free(&b);
}

static void every_status_has_its_own_text(void **state)
{
    (void)state;
    for (int i = 0; i <= RASTER_STATUS_COUNT; i++)
        for (int j = 0; j < i; j++)
            assert_string_not_equal(raster_status_text(i), raster_status_text(j));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(room_around_the_eye_leaves_no_background),
        cmocka_unit_test(eye_inside_a_solid_sees_only_back_faces),
        cmocka_unit_test(solid_in_front_covers_its_silhouette),
        cmocka_unit_test(walls_seen_from_behind_are_culled),
        cmocka_unit_test(objects_behind_the_eye_draw_nothing),
        cmocka_unit_test(floors_through_the_near_plane_reach_the_horizon),
        cmocka_unit_test(far_objects_keep_their_place),
        cmocka_unit_test(depth_orders_a_million_to_one),
        cmocka_unit_test(walls_beyond_the_guard_band_fill_the_picture),
        cmocka_unit_test(scene_without_objects_is_background),
        cmocka_unit_test(scene_without_lights_is_black),
        cmocka_unit_test(pictures_of_extreme_shape_are_complete),
        cmocka_unit_test(sizes_out_of_range_are_refused),
        cmocka_unit_test(small_arena_says_what_is_needed),
        cmocka_unit_test(missing_table_is_refused_with_its_material),
        cmocka_unit_test(too_many_meshlets_are_refused),
        cmocka_unit_test(crowded_tiles_lose_nothing),
        cmocka_unit_test(any_order_of_tiles_gives_the_same_pixels),
        cmocka_unit_test(every_status_has_its_own_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
