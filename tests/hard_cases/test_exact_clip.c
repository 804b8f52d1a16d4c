/*
 * Clipping against the exact answer: which pixels the unclipped triangle covers in homogeneous coordinates, by edge functions in 128 bits.
 * The reference starts from the transformed vertices, whole numbers, that the rasterizer clips; test_projection.c holds those to
 * double precision.
 */
#include "scene_fixture.h"

#include "internal.h"

enum { WIDTH = 150, HEIGHT = 90 };

typedef __int128 wide;

/* Vertices (x, y, w): half sub-pixels from the picture's centre are x/w, y/w. */
struct homogeneous {
    int64_t p[3][3];
    wide edge[3][3]; /* edge i, opposite vertex i: a x + b y + c, positive inside */
    long double near_w, det;
};

static void homogeneous_setup(struct homogeneous *h, const struct raster_object *o, const struct scene_vertex v[3])
{
    int32_t up = 29 - o->shift_xy;
    assert_in_range(up + 24, 0, 48);
    for (int i = 0; i < 3; i++) {
        struct raster_clip_vertex c;
        raster_transform(&c, o, &v[i]);
        h->p[i][0] = (int64_t)c.x * ((int64_t)1 << (up > 0 ? up : 0));
        h->p[i][1] = (int64_t)c.y * ((int64_t)1 << (up > 0 ? up : 0));
        h->p[i][2] = (int64_t)c.w * ((int64_t)1 << (up < 0 ? -up : 0));
    }
    h->near_w = (long double)o->near_w * ((int64_t)1 << (up < 0 ? -up : 0));
    for (int i = 0; i < 3; i++) { /* seen counter-clockwise with y up is clockwise with y down: j and k change places */
        const int64_t *j = h->p[(i + 2) % 3], *k = h->p[(i + 1) % 3];
        for (int a = 0; a < 3; a++) /* below 2^(2 * 55 + 1) */
            h->edge[i][a] = (wide)j[(a + 1) % 3] * k[(a + 2) % 3] - (wide)j[(a + 2) % 3] * k[(a + 1) % 3];
    }
    h->det = 0;
    for (int a = 0; a < 3; a++)
        h->det += (long double)h->edge[0][a] * h->p[0][a];
}

struct answer {
    bool inside;
    long double distance; /* pixels, from the nearest of the edges and the near plane */
};

/* At the centre of pixel (x, y). Edges are exact, the distances and the near plane rounded. */
static struct answer homogeneous_at(const struct homogeneous *h, int x, int y)
{
    int64_t hx = 512 * x + 256 - 256 * WIDTH, hy = 512 * y + 256 - 256 * HEIGHT;
    struct answer a = {h->det > 0, INFINITY};
    long double sum[3] = {0, 0, -h->det / h->near_w}; /* w >= near: the sum of all edges is at most det / near */
    for (int i = 0; i < 3; i++) {
        const wide *e = h->edge[i], value = e[0] * hx + e[1] * hy + e[2];
        if (value < 0)
            a.inside = false;
        a.distance = fminl(a.distance, fabsl((long double)value) / hypotl((long double)e[0], (long double)e[1]));
        for (int k = 0; k < 3; k++)
            sum[k] += (long double)e[k];
    }
    long double beyond = sum[0] * hx + sum[1] * hy + sum[2];
    if (beyond > 0)
        a.inside = false;
    a.distance = fminl(a.distance, fabsl(beyond) / hypotl(sum[0], sum[1])) / 512;
    return a;
}

static bool drawn[HEIGHT][WIDTH];
static long decisions, covered, differing, repeat;
static long double worst;

static void begin(uint64_t seed)
{
    repeat = getenv("GONIOTILE_LONG") ? 15 : 1;
    random_state = seed + (uint64_t)repeat;
    decisions = covered = differing = 0;
    worst = 0;
}

static void end(const char *what)
{
    print_message("# %s: %ld pixels decided, %ld covered, %ld differ, the farthest by %.4Lf px\n", what, decisions,
                  covered, differing, worst);
    assert_true(covered > 1000);
}

/* Renders one triangle alone through the public interface; *object is its transform, *h its exact edges. */
static void draw_alone(struct homogeneous *h, struct raster_object *object, const struct ref_blob *b,
                       const int16_t v[3][3], const double at[3], double scale)
{
    static const uint16_t corner[1][3] = {{0, 1, 2}};
    struct ref_blob alone = *b; /* shares lights and materials */
    struct scene_vertex s[3];
    struct opened o;
    memset(&alone.array[2], 0, (REF_BLOB_ARRAYS - 2) * sizeof alone.array[0]);
    ref_blob_object(&alone, ref_blob_mesh(&alone, v, corner, 1), 0, at, scale);
    open_scene(&o, &alone, WIDTH, HEIGHT);
    raster_object_setup(object, &o.frame, &o.scene.objects[0]);
    memcpy(s, o.scene.vertices, sizeof s);
    homogeneous_setup(h, object, s);
    struct picture p = render_frame(&o.frame, FORWARD);
    for (unsigned i = 0; i < WIDTH * HEIGHT; i++)
        drawn[i / WIDTH][i % WIDTH] = !is_background(&p, i % WIDTH, i / WIDTH);
    free(p.rgb);
    free(o.blob);
    for (int i = 2; i < REF_BLOB_ARRAYS; i++)
        free(alone.array[i].data);
}

/* Pixels that differ are nearer to an edge than vertices are snapped: 1/256 px. */
static void compare(const struct homogeneous *h)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            struct answer a = homogeneous_at(h, x, y);
            decisions++;
            covered += drawn[y][x];
            if (a.inside == drawn[y][x])
                continue;
            differing++;
            worst = fmaxl(worst, a.distance);
            if (a.distance > 1 / 256.0L)
                fail_msg("pixel (%d, %d) is %s, %.4Lf px from the nearest edge", x, y, a.inside ? "not drawn" : "drawn",
                         a.distance);
        }
}

static void random_vertices(int16_t v[3][3], int reach)
{
    for (int i = 0; i < 9; i++)
        v[i / 3][i % 3] = (int16_t)random_between(-reach, reach);
}

/* All around the eye, so that nearly each is cut by the near plane, most by the guard band; the nearest point seen up to 2^22 times
 * nearer than the farthest. */
static void triangles_around_the_eye_cover_what_the_unclipped_ones_do(void **state)
{
    (void)state;
    begin(20);
    for (int n = 0; n < 400 * repeat; n++) {
        struct ref_blob b = new_scene();
        struct raster_object o;
        struct homogeneous h;
        int16_t v[3][3];
        double scale = exp2(random_between(-15, 0));
        turn_camera(&b);
        random_vertices(v, 32000);
        b.near = fmax(32000 * scale * exp2(-random_between(0, 22)), 1 / 65536.0);
        b.focal = exp2(random_between(-1, 2));
        draw_alone(&h, &o, &b, (const int16_t(*)[3])v, origin, scale);
        compare(&h);
        ref_blob_free(&b);
    }
    end("around the eye");
}

/* Floors that reach from behind the eye to the horizon. */
static void floors_below_the_eye_cover_what_the_unclipped_ones_do(void **state)
{
    (void)state;
    begin(21);
    for (int n = 0; n < 400 * repeat; n++) {
        struct ref_blob b = new_scene();
        struct raster_object o;
        struct homogeneous h;
        int16_t v[3][3];
        double scale = exp2(random_between(-12, 0)), depth = exp2(random_between(0, 12));
        random_vertices(v, 32000);
        for (int i = 0; i < 3; i++)
            v[i][1] = (int16_t)(-depth * random_between(0.7, 1.3));
        b.near = fmax(depth * scale * exp2(-random_between(-2, 10)), 1 / 65536.0);
        b.focal = exp2(random_between(-1, 2));
        draw_alone(&h, &o, &b, (const int16_t(*)[3])v, origin, scale);
        compare(&h);
        ref_blob_free(&b);
    }
    end("floors");
}

/* Vertices exactly on the near plane, in the eye's own plane, behind it, next to either; powers of two, so that nothing rounds. */
static void vertices_on_the_near_plane_cover_what_the_unclipped_ones_do(void **state)
{
    (void)state;
    static const int16_t depth[] = {-64, -64, 0, 64, 32000, -65, -63, -1, -200, -2000, -32000};
    long on_plane = 0;
    begin(22);
    for (int n = 0; n < 500 * repeat; n++) {
        struct ref_blob b = new_scene();
        struct raster_object o;
        struct homogeneous h;
        int16_t v[3][3];
        random_vertices(v, n % 2 ? 200 : 32000);
        for (int i = 0; i < 3; i++)
            v[i][2] = depth[(int)random_between(0, 10.99)];
        b.near = 64 / 1024.0;
        draw_alone(&h, &o, &b, (const int16_t(*)[3])v, origin, 1 / 1024.0);
        for (int i = 0; i < 3; i++) {
            on_plane += v[i][2] == -64;
            assert_int_equal((long double)h.p[i][2] == h.near_w, v[i][2] == -64);
        }
        compare(&h);
        ref_blob_free(&b);
    }
    end("on the near plane");
    assert_true(on_plane > 100);
}

/* From a 32nd of a unit before the eye to 32000 units: w changes by a factor of a million in one triangle. */
static void a_million_to_one_in_a_triangle_covers_what_the_unclipped_one_does(void **state)
{
    (void)state;
    begin(23);
    for (int n = 0; n < 150 * repeat; n++) {
        struct ref_blob b = new_scene();
        struct raster_object o;
        struct homogeneous h;
        double near = 1 / 64.0;
        int16_t v[3][3] = {{0, 0, 0}, {0, 0, -32000}, {0, 0, (int16_t)random_between(-32000, -2)}};
        for (int i = 1; i < 3; i++)
            for (int j = 0; j < 2; j++)
                v[i][j] = (int16_t)random_between(v[i][2], -v[i][2]);
        b.near = near;
        const double at[3] = {random_between(-0.1, 0.1), random_between(-0.1, 0.1), -1 / 32.0};
        for (int turn = 0; turn < 2; turn++) { /* one of the windings faces the eye */
            draw_alone(&h, &o, &b, (const int16_t(*)[3])v, at, 1);
            assert_true(h.p[1][2] >= 1000000 * h.p[0][2]);
            compare(&h);
            int16_t swap[3];
            memcpy(swap, v[1], sizeof swap);
            memcpy(v[1], v[2], sizeof swap);
            memcpy(v[2], swap, sizeof swap);
            if (v[1][2] != -32000)
                break;
        }
        ref_blob_free(&b);
    }
    end("a million to one");
}

enum { GRID = 6 };

/* A plane of jittered quads, some behind the near plane, some beyond the guard band. Each triangle is drawn alone: no pixel is
 * drawn twice, and every pixel is drawn that is inside of the plane's part in view together with its neighbours. */
static void check_plane(void)
{
    static int count[HEIGHT][WIDTH];
    static bool inside[HEIGHT][WIDTH];
    struct ref_blob b = new_scene();
    int16_t grid[GRID][GRID][3];
    double scale = exp2(random_between(-10, 0)), depth = exp2(random_between(-6, 3)) * 1000;
    for (int r = 0; r < GRID; r++)
        for (int c = 0; c < GRID; c++) {
            bool rim = r == 0 || c == 0 || r == GRID - 1 || c == GRID - 1;
            grid[r][c][0] = (int16_t)(c * 12000 - 30000 + (rim ? 0 : random_between(-3900, 3900)));
            grid[r][c][1] = 0;
            grid[r][c][2] = (int16_t)(r * 12000 - 30000 + (rim ? 0 : random_between(-3900, 3900)));
        }
    const double at[3] = {random_between(-9000, 9000) * scale, -depth * scale, random_between(-9000, 9000) * scale};
    turn_camera(&b);
    b.near = fmax(depth * scale * exp2(random_between(-6, 1)), 1 / 65536.0);
    memset(count, 0, sizeof count);
    memset(inside, 0, sizeof inside);
    for (int k = 0; k < 2 * (GRID - 1) * (GRID - 1); k++) {
        int r = k / 2 / (GRID - 1), c = k / 2 % (GRID - 1);
        int16_t v[3][3];
        struct raster_object o;
        struct homogeneous h;
        memcpy(v[0], grid[r][c], sizeof v[0]);
        memcpy(v[1], k & 1 ? grid[r + 1][c + 1] : grid[r + 1][c], sizeof v[1]);
        memcpy(v[2], k & 1 ? grid[r][c + 1] : grid[r + 1][c + 1], sizeof v[2]);
        draw_alone(&h, &o, &b, (const int16_t(*)[3])v, at, scale);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            count[i / WIDTH][i % WIDTH] += drawn[i / WIDTH][i % WIDTH];
            inside[i / WIDTH][i % WIDTH] |= homogeneous_at(&h, i % WIDTH, i / WIDTH).inside;
        }
    }
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            bool clear = true;
            for (int k = 0; k < 9; k++) {
                int nx = fx_clamp(x + k % 3 - 1, 0, WIDTH - 1), ny = fx_clamp(y + k / 3 - 1, 0, HEIGHT - 1);
                clear = clear && inside[ny][nx];
            }
            decisions++;
            covered += count[y][x];
            if (count[y][x] > 1 || (clear && !count[y][x]))
                fail_msg("pixel (%d, %d) is drawn %d times", x, y, count[y][x]);
        }
    ref_blob_free(&b);
}

static void shared_edges_across_the_near_plane_are_watertight(void **state)
{
    (void)state;
    begin(24);
    for (int n = 0; n < 14 * repeat; n++)
        check_plane();
    end("watertight planes");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(triangles_around_the_eye_cover_what_the_unclipped_ones_do),
        cmocka_unit_test(floors_below_the_eye_cover_what_the_unclipped_ones_do),
        cmocka_unit_test(vertices_on_the_near_plane_cover_what_the_unclipped_ones_do),
        cmocka_unit_test(a_million_to_one_in_a_triangle_covers_what_the_unclipped_one_does),
        cmocka_unit_test(shared_edges_across_the_near_plane_are_watertight),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
