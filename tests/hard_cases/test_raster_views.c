/*
 * Where the eye may be: inside, in front of and behind things, next to the near plane, with walls beyond the guard band, far away and with
 * everything at once.
 */
#include "scene_fixture.h"

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
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
