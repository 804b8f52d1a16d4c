/*
 * raster_draw_small and raster_draw_general against exact coverage and double-precision interpolation, triangle by triangle in a cleared
 * tile: every pixel of the tile is decided by both.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "internal.h"
#include "ref_coverage.h"

enum { TILE_W = RASTER_TILE_WIDTH, TILE_H = RASTER_TILE_HEIGHT };
enum { GUARD = 256 << GUARD_BITS, CENTRE_MAX = 256 * 2048 };

static struct raster_tile tile;
static uint64_t random_state = 1;
static long decisions, covered_pixels, triangles;
static double worst_depth, worst_normal;

static uint32_t random32(void)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(random_state >> 32);
}

/* lo..hi */
static int32_t random_in(int32_t lo, int32_t hi)
{
    return lo + (int32_t)(((uint64_t)random32() * (uint32_t)(hi - lo + 1)) >> 32);
}

static void draw_over(const int32_t v[3][2], bool small, const struct raster_vertex attributes[3],
                      struct raster_stats *stats)
{
    static const struct scene_triangle triangle = {{0, 1, 2}};
    struct raster_vertex general[3];
    struct raster_small packed[3];
    for (int i = 0; i < 3; i++) {
        const struct raster_vertex *a = &attributes[i];
        general[i] = (struct raster_vertex){v[i][0], v[i][1], a->inv_w, a->u, a->v};
        packed[i] = (struct raster_small){((uint32_t)(v[i][0] - 128) & 0xffff) | (uint32_t)(v[i][1] - 128) << 16,
                                          a->inv_w, ((uint32_t)a->u & 0xffff) | (uint32_t)a->v << 16};
    }
    triangles++;
    if (small)
        raster_draw_small(&tile, packed, &triangle, 1, 1, stats);
    else
        raster_draw_general(&tile, &general[0], &general[1], &general[2], 1, stats);
}

static void draw(const int32_t v[3][2], bool small, const struct raster_vertex attributes[3])
{
    struct raster_stats stats = {0};
    memset(tile.surface, 0, sizeof tile.surface);
    draw_over(v, small, attributes, &stats);
}

/* How far the surface is from linear interpolation, in the units of its depth and of its normal's coordinates. */
static void measure(const struct raster_surface *s, const double weight[3], const struct raster_vertex a[3])
{
    double inv_w = 0, u = 0, v = 0;
    for (int i = 0; i < 3; i++) {
        inv_w += weight[i] * a[i].inv_w;
        u += weight[i] * a[i].u;
        v += weight[i] * a[i].v;
    }
    worst_depth = fmax(worst_depth, fabs((double)(s->depth_slot >> 8) - DEPTH_BIAS - inv_w));
    worst_normal =
        fmax(worst_normal, fmax(fabs((int16_t)(s->normal & 0xffff) - u), fabs((int16_t)(s->normal >> 16) - v)));
}

/* Draws and compares; counts of mismatching pixels are failures. */
static void check_with(const int32_t v[3][2], bool small, const struct raster_vertex attributes[3])
{
    struct ref_triangle t;
    ref_triangle_setup(&t, v);
    draw(v, small, attributes);
    for (int y = 0; y < TILE_H; y++)
        for (int x = 0; x < TILE_W; x++) {
            const struct raster_surface *s = &tile.surface[y * TILE_W + x];
            bool drawn = s->depth_slot != 0, expected = ref_triangle_covers(&t, x, y);
            decisions++;
            covered_pixels += expected;
            if (drawn != expected || (drawn && (s->depth_slot & 255) != 1))
                fail_msg("pixel (%d, %d) %s: (%d, %d) (%d, %d) (%d, %d) %s path", x, y,
                         expected ? "is not drawn" : "must not be drawn", v[0][0], v[0][1], v[1][0], v[1][1], v[2][0],
                         v[2][1], small ? "small" : "general");
            if (drawn) {
                double weight[3];
                ref_triangle_weights(weight, &t, x, y);
                measure(s, weight, attributes);
            }
        }
}

static const struct raster_vertex flat[3] = {{.inv_w = 1 << 20}, {.inv_w = 1 << 20}, {.inv_w = 1 << 20}};

static bool is_small(const int32_t v[3][2])
{
    for (int j = 0; j < 2; j++) {
        int32_t size = 256 * (j ? TILE_H : TILE_W);
        int32_t lo = fx_min(fx_min(v[0][j], v[1][j]), v[2][j]), hi = fx_max(fx_max(v[0][j], v[1][j]), v[2][j]);
        if (hi - lo >= SMALL_EXTENT || lo <= -SMALL_EXTENT || hi >= size + SMALL_EXTENT)
            return false;
    }
    return true;
}

/* Both windings and every path that may draw it. */
static void check(const int32_t v[3][2])
{
    int32_t back[3][2];
    memcpy(back[0], v[2], sizeof back[0]);
    memcpy(back[1], v[1], sizeof back[1]);
    memcpy(back[2], v[0], sizeof back[2]);
    check_with(v, false, flat);
    check_with((const int32_t(*)[2])back, false, flat);
    if (is_small(v)) {
        check_with(v, true, flat);
        check_with((const int32_t(*)[2])back, true, flat);
    }
}

/* How many times as many random cases as usual, from other seeds: GONIOTILE_LONG=1 asks for more than 10^9 decisions of each kind. */
static int rounds(void)
{
    static int n;
    if (!n)
        n = getenv("GONIOTILE_LONG") ? 12 : 1;
    return n;
}

static void begin(uint64_t seed)
{
    random_state = seed + (rounds() > 1 ? 1000 : 0);
    decisions = covered_pixels = triangles = 0;
    worst_depth = worst_normal = 0;
}

static void end(const char *what)
{
    print_message("# %s: %ld triangles, %ld pixels decided, %ld covered\n", what, triangles, decisions, covered_pixels);
    assert_true(covered_pixels > 0);
}

/* A vertex near the tile, on whole 2^-fraction pixels, half a pixel off: fraction 0 puts it on pixel centres. */
static void random_near(int32_t v[2], int32_t margin, int fraction)
{
    int32_t step = 256 >> fraction;
    v[0] = random_in(-margin / step, (256 * TILE_W + margin) / step) * step + 128;
    v[1] = random_in(-margin / step, (256 * TILE_H + margin) / step) * step + 128;
}

static void triangles_of_every_small_size_cover_exactly(void **state)
{
    (void)state;
    begin(2);
    for (int n = 0; n < 20000 * rounds(); n++) {
        int32_t v[3][2], extent = (SMALL_EXTENT - 1) >> random_in(0, 13);
        random_near(v[0], 2048, random_in(0, 8));
        for (int i = 1; i < 3; i++)
            for (int j = 0; j < 2; j++)
                v[i][j] = v[0][j] + random_in(-extent / 2, extent / 2);
        check(v);
    }
    end("small");
}

static void triangles_across_the_guard_band_cover_exactly(void **state)
{
    (void)state;
    begin(3);
    for (int n = 0; n < 12000 * rounds(); n++) {
        int32_t v[3][2], centre[2], extent = GUARD >> random_in(0, 6);
        for (int j = 0; j < 2; j++)
            centre[j] = random_in(-CENTRE_MAX, CENTRE_MAX);
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 2; j++) {
                int32_t x = n & 1 ? random_in(-extent, extent) + (256 * (j ? TILE_H : TILE_W) / 2)
                                  : centre[j] + (random_in(0, 3)   ? random_in(-GUARD, GUARD)
                                                 : random_in(0, 1) ? GUARD
                                                                   : -GUARD);
                v[i][j] = fx_clamp(x, centre[j] - GUARD, centre[j] + GUARD);
            }
        check((const int32_t(*)[2])v);
    }
    end("guard band");
}

static void vertices_on_pixel_centres_cover_exactly(void **state)
{
    (void)state;
    begin(4);
    for (int n = 0; n < 8000 * rounds(); n++) {
        int32_t v[3][2];
        for (int i = 0; i < 3; i++)
            random_near(v[i], n & 1 ? 256 : 4096, 0);
        if (n & 2) /* edges along an axis, where ties are all along */
            v[1][0] = v[0][0];
        if (n & 4)
            v[2][1] = v[0][1];
        if (n & 8) /* and along a diagonal */
            v[1][1] = v[0][1] + (v[1][0] - v[0][0]);
        check((const int32_t(*)[2])v);
    }
    /* Every triangle on a 4 x 4 lattice of pixel centres and corners. */
    for (int code = 0; code < 1 << 12; code++) {
        int32_t v[3][2];
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 2; j++)
                v[i][j] = 1024 + 128 * (code >> (4 * i + 2 * j) & 3);
        check((const int32_t(*)[2])v);
    }
    end("pixel centres");
}

/* Compares around the first pixels only; a pixel drawn elsewhere is a failure, too. */
static void check_corner(const int32_t v[3][2], bool small)
{
    enum { REACH = 4 };
    struct ref_triangle t;
    struct raster_stats stats = {0};
    int expected = 0;
    ref_triangle_setup(&t, v);
    for (int y = 0; y < REACH; y++)
        memset(&tile.surface[y * TILE_W], 0, REACH * sizeof tile.surface[0]);
    draw_over(v, small, flat, &stats);
    for (int y = 0; y < REACH; y++)
        for (int x = 0; x < REACH; x++) {
            bool inside = ref_triangle_covers(&t, x, y);
            expected += inside;
            decisions++;
            if ((tile.surface[y * TILE_W + x].depth_slot != 0) != inside)
                fail_msg("pixel (%d, %d): (%d, %d) (%d, %d) (%d, %d) %s path", x, y, v[0][0], v[0][1], v[1][0], v[1][1],
                         v[2][0], v[2][1], small ? "small" : "general");
        }
    covered_pixels += expected;
    assert_int_equal(stats.tested, expected);
}

/* Every triangle whose vertices lie on or one 1/256 px off the centres of 3 x 3 pixels, the first of them the tile's own. */
static void every_triangle_about_pixel_centres_covers_exactly(void **state)
{
    (void)state;
    enum { POINTS = 81 };
    int32_t point[POINTS][2];
    begin(11);
    for (int i = 0; i < POINTS; i++) {
        int x = i % 9, y = i / 9;
        point[i][0] = 128 + 256 * (x / 3) + x % 3 - 1;
        point[i][1] = 128 + 256 * (y / 3) + y % 3 - 1;
    }
    for (int code = 0; code < POINTS * POINTS * POINTS; code++) {
        int32_t v[3][2];
        memcpy(v[0], point[code % POINTS], sizeof v[0]);
        memcpy(v[1], point[code / POINTS % POINTS], sizeof v[1]);
        memcpy(v[2], point[code / POINTS / POINTS], sizeof v[2]);
        check_corner((const int32_t(*)[2])v, false);
        check_corner((const int32_t(*)[2])v, true);
    }
    end("about pixel centres");
}

static void slivers_cover_exactly(void **state)
{
    (void)state;
    begin(5);
    for (int n = 0; n < 10000 * rounds(); n++) {
        int32_t v[3][2], margin = n & 1 ? 2048 : GUARD / 2;
        random_near(v[0], margin, 8);
        random_near(v[1], margin, 8);
        int32_t t = random_in(0, 256), off = 1 << random_in(0, 6);
        for (int j = 0; j < 2; j++) /* near the line, within it or beyond an end */
            v[2][j] =
                v[0][j] + (int32_t)(((int64_t)(v[1][j] - v[0][j]) * (n & 2 ? t : 256)) >> 8) + random_in(-off, off);
        check((const int32_t(*)[2])v);
    }
    end("slivers");
}

static void triangles_without_area_draw_nothing(void **state)
{
    (void)state;
    begin(6);
    for (int n = 0; n < 2000 * rounds(); n++) {
        int32_t v[3][2], k = random_in(-3, 3);
        random_near(v[0], 512, n & 1 ? 0 : 8);
        random_near(v[1], 512, n & 1 ? 0 : 8);
        for (int j = 0; j < 2; j++)
            v[2][j] = v[0][j] + k * (v[1][j] - v[0][j]);
        check((const int32_t(*)[2])v);
    }
    assert_int_equal(covered_pixels, 0);
    assert_true(decisions > 0);
}

/* A triangle near the tile or, if not small, of any size; nearness from 2^8 to 2^23, varying by a factor of at most
 * `ratio` in the triangle. */
static void random_triangle(int32_t v[3][2], struct raster_vertex a[3], bool small, double ratio)
{
    int32_t extent = small ? (SMALL_EXTENT - 1) >> random_in(0, 8) : GUARD >> random_in(0, 12);
    random_near(v[0], 1024, 8);
    for (int i = 1; i < 3; i++)
        for (int j = 0; j < 2; j++)
            v[i][j] = fx_clamp(v[0][j] + random_in(-extent / 2, extent / 2), -GUARD, GUARD);
    double nearest = exp2(random_in(80, 230) / 10.0), span = random_in(1, 16384);
    for (int i = 0; i < 3; i++) {
        a[i].inv_w = (uint32_t)fmax(1, nearest / pow(ratio, random_in(0, 1000) / 1000.0));
        if (small)
            a[i].inv_w = (uint32_t)fmax(a[i].inv_w, nearest - SMALL_DEPTH);
        a[i].u = (int16_t)(span * random_in(-1000, 1000) / 1000);
        a[i].v = (int16_t)(span * random_in(-1000, 1000) / 1000);
    }
}

static void check_interpolation(bool small, double ratio)
{
    for (int n = 0; n < 40000 * rounds(); n++) {
        int32_t v[3][2];
        struct raster_vertex a[3];
        random_triangle(v, a, small, ratio);
        if (!small || is_small((const int32_t(*)[2])v))
            check_with((const int32_t(*)[2])v, small, a);
    }
}

/* Depth, of 2^23, errs by 320 units and a normal's coordinates, of 2^14, by five: what rounded gradients may add up to. */
static void interpolation_stays_near_double(void **state)
{
    (void)state;
    for (int small = 0; small < 2; small++) {
        begin(8 + small);
        for (double ratio = 1; ratio < 1e7; ratio *= 10)
            check_interpolation(small, ratio);
        end(small ? "small interpolation" : "general interpolation");
        print_message("# worst error: depth %.2f units, normal %.2f units\n", worst_depth, worst_normal);
        assert_true(worst_depth <= 320);
        assert_true(worst_normal <= 5);
    }
}

/* The same triangle seen from tiles that start elsewhere has the same surface where they overlap. */
static void pixels_do_not_depend_on_the_tile(void **state)
{
    (void)state;
    static struct raster_surface first[TILE_W * TILE_H];
    begin(10);
    for (int n = 0; n < 60000 * rounds(); n++) {
        bool small = n & 1;
        int32_t v[3][2], moved[3][2], by[2] = {random_in(-TILE_W + 1, TILE_W - 1), random_in(-TILE_H + 1, TILE_H - 1)};
        struct raster_vertex a[3];
        random_triangle(v, a, small, exp2(random_in(0, 20)));
        for (int i = 0; i < 6; i++)
            moved[i / 2][i % 2] = v[i / 2][i % 2] + 256 * by[i % 2];
        if (small && !(is_small((const int32_t(*)[2])v) && is_small((const int32_t(*)[2])moved)))
            continue;
        draw((const int32_t(*)[2])v, small, a);
        memcpy(first, tile.surface, sizeof first);
        draw((const int32_t(*)[2])moved, small, a);
        for (int y = fx_max(0, -by[1]); y < TILE_H && y + by[1] < TILE_H; y++)
            for (int x = fx_max(0, -by[0]); x < TILE_W && x + by[0] < TILE_W; x++) {
                const struct raster_surface *p = &first[y * TILE_W + x];
                const struct raster_surface *q = &tile.surface[(y + by[1]) * TILE_W + x + by[0]];
                decisions++;
                covered_pixels += p->depth_slot != 0;
                if (p->depth_slot != q->depth_slot || p->normal != q->normal)
                    fail_msg("pixel (%d, %d), tile moved by (%d, %d): %08x %08x, not %08x %08x", x, y, by[0], by[1],
                             q->depth_slot, q->normal, p->depth_slot, p->normal);
            }
    }
    end("moved tiles");
}

enum { GRID = 9 };

/* Draws the triangles one by one and counts how often each pixel is drawn. */
static void count_grid(int count[TILE_H][TILE_W], int32_t grid[GRID][GRID][2])
{
    memset(count, 0, sizeof(int[TILE_H][TILE_W]));
    for (int k = 0; k < 2 * (GRID - 1) * (GRID - 1); k++) {
        int r = k / 2 / (GRID - 1), c = k / 2 % (GRID - 1);
        const int32_t *a = grid[r][c], *b = grid[r + 1][c], *d = grid[r + 1][c + 1], *e = grid[r][c + 1];
        const int32_t *corner[4][3] = {{a, b, d}, {a, d, e}, {a, b, e}, {b, d, e}}; /* either diagonal */
        int32_t v[3][2];
        for (int i = 0; i < 3; i++)
            memcpy(v[i], corner[2 * ((r + c) & 1) + (k & 1)][i], sizeof v[i]);
        draw((const int32_t(*)[2])v, is_small((const int32_t(*)[2])v) && random_in(0, 1), flat);
        for (int i = 0; i < TILE_W * TILE_H; i++)
            count[i / TILE_W][i % TILE_W] += tile.surface[i].depth_slot != 0;
    }
}

/* A rectangle of quads whose inner vertices are jittered by less than half a quad and whose outer ones move along the
 * border: no triangle is turned over, and a pixel of the rectangle belongs to exactly one. */
static void meshes_cover_every_pixel_once(void **state)
{
    (void)state;
    begin(7);
    for (int n = 0; n < 150 * rounds(); n++) {
        static int count[TILE_H][TILE_W];
        int32_t grid[GRID][GRID][2], lo[2], step[2];
        for (int j = 0; j < 2; j++) {
            int scale = n % 3 == 0 ? 64 : n % 3 == 1 ? 1 << random_in(4, 10) : 256 * 1000;
            step[j] = random_in(scale / 2 + 8, scale);
            lo[j] = random_in(-4 * step[j], 256 * (j ? TILE_H : TILE_W) - 4 * step[j]);
        }
        for (int r = 0; r < GRID; r++)
            for (int c = 0; c < GRID; c++)
                for (int j = 0; j < 2; j++) {
                    int at = j ? r : c;
                    int32_t jitter = at == 0 || at == GRID - 1 ? 0 : step[j] / 4 - 1;
                    grid[r][c][j] = lo[j] + at * step[j] + random_in(-jitter, jitter);
                }
        count_grid(count, grid);
        for (int y = 0; y < TILE_H; y++)
            for (int x = 0; x < TILE_W; x++) {
                int px = 256 * x + 128, py = 256 * y + 128;
                int inside = px >= lo[0] && px < lo[0] + (GRID - 1) * step[0] && py >= lo[1] &&
                             py < lo[1] + (GRID - 1) * step[1];
                decisions++;
                covered_pixels += inside;
                if (count[y][x] != inside)
                    fail_msg("mesh %d: pixel (%d, %d) is drawn %d times, not %d", n, x, y, count[y][x], inside);
            }
    }
    end("meshes");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(triangles_of_every_small_size_cover_exactly),
        cmocka_unit_test(triangles_across_the_guard_band_cover_exactly),
        cmocka_unit_test(vertices_on_pixel_centres_cover_exactly),
        cmocka_unit_test(every_triangle_about_pixel_centres_covers_exactly),
        cmocka_unit_test(slivers_cover_exactly),
        cmocka_unit_test(triangles_without_area_draw_nothing),
        cmocka_unit_test(interpolation_stays_near_double),
        cmocka_unit_test(pixels_do_not_depend_on_the_tile),
        cmocka_unit_test(meshes_cover_every_pixel_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
