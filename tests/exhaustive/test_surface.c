/*
 * What a pixel's surface holds, depth and normal, against double precision: how far apart two surfaces may be and still be seen in the
 * wrong order, and how far a normal is from unit length and from linear interpolation and normalisation.
 *
 * Depth. A pixel's depth is 2^23 near2 / w, near2 the power of two at or below the near distance. It errs by at most BOUND units of
 * that, so two surfaces at w and w + d keep their order when
 *   2^23 near2 (1/w - 1/(w+d)) > 2 BOUND,  about  d/w > BOUND * 2^-22 * w/near2.
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

enum { TILE_W = RASTER_TILE_WIDTH, TILE_H = RASTER_TILE_HEIGHT, BOUND = 128 + 1 };

static struct raster_tile tile;
static uint64_t random_state = 1;

static double random_between(double lo, double hi)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return lo + (hi - lo) * ((double)(random_state >> 40) * 0x1p-24);
}

static int repeat(void)
{
    return getenv("GONIOTILE_LONG") ? 30 : 1;
}

/* A triangle on the screen: its corners in 1/256 px, w, unit normals; and what the rasterizer is given of it. */
struct surface {
    int32_t xy[3][2];
    double inv_w[3], normal[3][3];
    struct raster_vertex vertex[3];
    unsigned shift; /* from 1/w to D */
    bool small;
    struct ref_triangle exact;
};

/* Draws as tile.c does: the small path when it may. */
static void surface_draw(const struct surface *s, uint32_t slot)
{
    static const struct scene_triangle triangle = {{0, 1, 2}};
    struct raster_stats stats = {0};
    struct raster_small packed[3];
    for (int i = 0; i < 3; i++)
        packed[i] = (struct raster_small){
            ((uint32_t)(s->vertex[i].x - 128) & 0xffff) | (uint32_t)(s->vertex[i].y - 128) << 16, s->vertex[i].inv_w,
            ((uint32_t)s->vertex[i].u & 0xffff) | (uint32_t)s->vertex[i].v << 16};
    if (s->small)
        raster_draw_small(&tile, packed, &triangle, 1, slot, &stats);
    else
        raster_draw_general(&tile, &s->vertex[0], &s->vertex[1], &s->vertex[2], slot, &stats);
}

/* Front-facing, over the tile; 1/w in units, largest `nearest`, varying by up to `ratio`. */
static void surface_random(struct surface *s, double nearest, double ratio, bool small)
{
    do {
        double reach = small ? 31 * 256 : 256 * exp2(random_between(4, 12));
        for (int i = 0; i < 3; i++) {
            s->xy[i][0] = (int32_t)(128 * TILE_W + random_between(-reach, reach));
            s->xy[i][1] = (int32_t)(128 * TILE_H + random_between(-reach, reach));
        }
        ref_triangle_setup(&s->exact, (const int32_t(*)[2])s->xy);
    } while (s->exact.area < 1 << 20);
    uint32_t most = 0, least = UINT32_MAX;
    for (int i = 0; i < 3; i++) {
        s->inv_w[i] = nearest * pow(ratio, -random_between(0, 1));
        s->vertex[i] = (struct raster_vertex){.x = s->xy[i][0], .y = s->xy[i][1], .inv_w = (uint32_t)s->inv_w[i]};
        most = s->vertex[i].inv_w > most ? s->vertex[i].inv_w : most;
        least = s->vertex[i].inv_w < least ? s->vertex[i].inv_w : least;
    }
    s->small = small && most - least <= SMALL_DEPTH;
    s->shift = 0;
    while (most >> s->shift >= 1 << NORMAL_BITS)
        s->shift++;
}

static void depth_never_swaps_surfaces_further_apart_than_the_stated_bound(void **state)
{
    (void)state;
    long ordered = 0, closer = 0, swapped = 0;
    double widest = 0;
    for (int n = 0; n < 20000 * repeat(); n++) {
        struct surface s[2];
        double nearest = exp2(random_between(10, 23)), apart = exp2(random_between(3, 12));
        for (int k = 0; k < 2; k++)
            surface_random(&s[k], fmin(nearest + k * apart, (1 << 23) - 1), exp2(random_between(0, n % 4 ? 0.01 : 2)),
                           n & 1);
        memset(tile.surface, 0, sizeof tile.surface);
        surface_draw(&s[n >> 1 & 1], 1u + (n >> 1 & 1));
        surface_draw(&s[~n >> 1 & 1], 1u + (~n >> 1 & 1));
        for (int i = 0; i < TILE_W * TILE_H; i++) {
            int x = i % TILE_W, y = i / TILE_W;
            if (!ref_triangle_covers(&s[0].exact, x, y) || !ref_triangle_covers(&s[1].exact, x, y))
                continue;
            double depth[2] = {0, 0}, weight[3];
            for (int k = 0; k < 2; k++) {
                ref_triangle_weights(weight, &s[k].exact, x, y);
                for (int j = 0; j < 3; j++)
                    depth[k] += weight[j] * s[k].inv_w[j];
            }
            uint32_t seen = (tile.surface[i].depth_slot & 255) - 1;
            double gap = fabs(depth[0] - depth[1]);
            assert_true(seen < 2);
            bool wrong = depth[seen] < depth[1 - seen];
            if (wrong && gap > 2 * BOUND)
                fail_msg("pixel (%d, %d): depths %.1f and %.1f are swapped", x, y, depth[0], depth[1]);
            ordered += gap > 2 * BOUND;
            closer += gap <= 2 * BOUND;
            swapped += wrong;
            widest = wrong ? fmax(widest, gap) : widest;
        }
    }
    print_message(
        "# %ld pixels further apart than %d units keep their order; of %ld closer ones %ld are swapped, at most %.1f "
        "apart\n",
        ordered, 2 * BOUND, closer, swapped, widest);
    assert_true(ordered > 100000 && closer > 100000 && swapped > 0);
}

/* A unit normal at most `angle` from `axis`. */
static void normal_near(double n[3], const double axis[3], double angle)
{
    double length;
    do {
        double dot = 0;
        length = 0;
        for (int i = 0; i < 3; i++) {
            n[i] = axis[i] + sin(angle) * random_between(-1, 1);
            length += n[i] * n[i];
        }
        length = sqrt(length);
        for (int i = 0; i < 3; i++) {
            n[i] /= length;
            dot += n[i] * axis[i];
        }
        length = dot;
    } while (length < cos(angle) || n[2] < 0.05);
}

static double angle_between(const double a[3], const double b[3])
{
    double cross = 0, dot = 0;
    for (int i = 0; i < 3; i++) {
        double c = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
        cross += c * c;
        dot += a[i] * b[i];
    }
    return atan2(sqrt(cross), dot) * 180 / M_PI;
}

/* Vertex normals within `spread` degrees of each other. */
static void surface_normals(struct surface *s, double spread, double tilt)
{
    const double z[3] = {0, 0, 1};
    double axis[3];
    normal_near(axis, z, tilt * M_PI / 180);
    for (int i = 0; i < 3; i++) {
        double *n = s->normal[i];
        normal_near(n, axis, spread / 2 * M_PI / 180);
        int32_t u = (int32_t)floor(16384 * n[0] / (1 + n[2]) + 0.5),
                v = (int32_t)floor(16384 * n[1] / (1 + n[2]) + 0.5);
        s->vertex[i].u = (int16_t)raster_homogeneous(u, s->vertex[i].inv_w, s->shift);
        s->vertex[i].v = (int16_t)raster_homogeneous(v, s->vertex[i].inv_w, s->shift);
    }
}

struct worst {
    double length, angle;
    long pixels;
};

/* `lo`, `hi`: powers of two between which the triangle's largest 1/w is. */
static void measure_normals(struct worst *w, double spread, double ratio, double lo, double hi)
{
    *w = (struct worst){0, 0, 0};
    for (int n = 0; n < 3000 * repeat(); n++) {
        struct surface s;
        surface_random(&s, exp2(random_between(lo, hi)), ratio, n & 1);
        surface_normals(&s, spread, random_between(0, 60));
        memset(tile.surface, 0, sizeof tile.surface);
        surface_draw(&s, 200);
        for (int i = 0; i < TILE_W * TILE_H; i++) {
            if (!tile.surface[i].depth_slot)
                continue;
            double weight[3], expected[3] = {0, 0, 0}, length = 0;
            ref_triangle_weights(weight, &s.exact, i % TILE_W, i / TILE_W);
            for (int j = 0; j < 9; j++)
                expected[j % 3] += weight[j / 3] * s.inv_w[j / 3] * s.normal[j / 3][j % 3];
            struct raster_normal r = raster_decode_normal(&tile.surface[i], s.shift);
            const double got[3] = {ldexp((double)r.u * r.m, -28), ldexp((double)r.v * r.m, -28),
                                   ldexp((double)r.d * r.m, -28) - 1};
            for (int j = 0; j < 3; j++)
                length += got[j] * got[j];
            w->length = fmax(w->length, fabs(sqrt(length) - 1));
            w->angle = fmax(w->angle, angle_between(got, expected));
            w->pixels++;
        }
    }
}

/*
 * The direction's error grows with the angle between a triangle's normals, since stereographic coordinates are linear, not the normals;
 * with the range of w in a triangle, since the third coordinate D is as 1/w; and with w beyond 512 near2, where 1/w has less than
 * NORMAL_BITS bits.
 */
static void normals_are_unit_and_near_interpolation_and_normalisation(void **state)
{
    (void)state;
    static const struct {
        double spread, ratio, lo, hi, limit; /* degrees, farthest over nearest w, log2 of 1/w, degrees */
    } rows[] = {
        {5, 1.5, 14, 22.9, 0.25}, {10, 1.5, 14, 22.9, 0.25}, {20, 1.5, 14, 22.9, 0.6}, {30, 1.5, 14, 22.9, 1.5},
        {40, 1.5, 14, 22.9, 2.3}, {5, 1.5, 20, 22.9, 0.08},  {5, 10, 20, 22.9, 0.2},   {5, 100, 20, 22.9, 1.2},
        {5, 1.02, 13, 13, 0.7},   {5, 1.02, 12, 12, 1.2},    {5, 1.02, 11, 11, 2.5},   {5, 1.02, 10, 10, 5},
        {5, 1.02, 8, 8, 24},
    };
    for (unsigned i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct worst w;
        measure_normals(&w, rows[i].spread, rows[i].ratio, rows[i].lo, rows[i].hi);
        print_message(
            "# normals within %2.0f degrees, w within 1:%.4g, near2/w 2^%.0f to 2^%.0f: %ld pixels, length off by "
            "%.6f, direction by %.2f degrees\n",
            rows[i].spread, rows[i].ratio, rows[i].lo - 23, rows[i].hi - 23, w.pixels, w.length, w.angle);
        assert_true(w.pixels > 10000);
        assert_true(w.length <= 0.00014);
        assert_true(w.angle <= rows[i].limit);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(depth_never_swaps_surfaces_further_apart_than_the_stated_bound),
        cmocka_unit_test(normals_are_unit_and_near_interpolation_and_normalisation),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
