/*
 * The rasterizer through its public interface: empty scenes, odd pictures, crowded tiles, orders of tiles, refusals.
 */
#include "internal.h"
#include "quality.h"
#include "scene_fixture.h"

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

/* A box inside which the camera is and many objects in it, so that there is an arena that holds a part of them. */
static void small_arena_says_what_is_needed(void **state)
{
    (void)state;
    static const struct raster_costs costs = {.tile = 1600, .tested = 160};
    struct ref_blob b = new_scene();
    struct opened o;
    ref_blob_object(&b, add_cube(&b, 32000, 5, true), 0, origin, 1);
    const unsigned wall = add_wall(&b, -300, -300, 300, 300);
    for (int i = 0; i < 30; i++)
        ref_blob_object(&b, wall, 0, (const double[3]){0, 0, -2}, 1. / 300);
    open_scene(&o, &b, 320, 240);
    for (int bounded = 0; bounded < 2; bounded++) {
        o.frame.costs = bounded ? &costs : NULL;
        o.frame.bounds = bounded ? &raster_tile_bounds : NULL;
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
    }
    free(o.blob);
    ref_blob_free(&b);
}

static void too_many_lights_are_refused(void **state)
{
    (void)state;
    struct scene_light lights[SCENE_MAX_LIGHTS + 1];
    struct ref_blob b = new_scene();
    struct opened o;
    struct raster r;
    ref_blob_object(&b, add_wall(&b, -100, -100, 100, 100), 0, (const double[3]){0, 0, -1}, 1);
    open_scene(&o, &b, 32, 32);
    for (unsigned i = 0; i <= SCENE_MAX_LIGHTS; i++)
        lights[i] = o.scene.lights[i % o.scene.header->lights.count];
    o.frame.lights = lights;
    o.frame.light_count = SCENE_MAX_LIGHTS;
    free(render_frame(&o.frame, FORWARD).rgb);
    o.frame.light_count = SCENE_MAX_LIGHTS + 1;
    assert_int_equal(raster_begin(&r, &o.frame, NULL, 0), RASTER_ERR_LIMIT);
    free(o.blob);
    ref_blob_free(&b);
}

/* Wide and low pictures, the widest angles, an odd number of pixels: the middle one's ray would have no length. Regions at rate flat are seen from
 * their middle, be the picture smaller. */
static void no_view_ray_is_lost(void **state)
{
    (void)state;
    static const uint16_t sizes[][2] = {{511, 3}, {1023, 7}, {4095, 27}, {1, 1}, {3, 3}, {6, 5}};
    const struct raster_quality flat = {.rate = {[0 ... RASTER_CLASSES - 1] = RASTER_RATE_FLAT},
                                        .lights = RASTER_ALL_LIGHTS};
    static uint64_t arena[1 << 14];
    struct raster_tile *work = malloc(sizeof *work);
    struct ref_blob b = new_scene();
    struct opened o;
    random_state = 5;
    ref_blob_object(&b, add_cube(&b, 32000, 3, true), 0, origin, 1);
    b.focal = 0x1p-8;
    for (unsigned i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        open_scene(&o, &b, sizes[i][0], sizes[i][1]);
        struct picture p = render_frame(&o.frame, FORWARD);
        assert_int_equal(p.covered, p.width * p.height);
        free(p.rgb);
        struct raster r;
        uint32_t covered = 0;
        assert_int_equal(raster_begin(&r, &o.frame, arena, sizeof arena), RASTER_OK);
        for (uint32_t t = 0; t < raster_tile_count(&r); t++) {
            struct raster_rect rect;
            struct raster_stats stats;
            raster_tile_begin(&r, t, work, &rect, &stats);
            assert_int_equal(raster_tile_draw(&r, work, UINT32_MAX, &stats), RASTER_DRAWN);
            const struct raster_survey *survey = raster_tile_survey(&r, work, &rect);
            for (uint32_t k = 0; k < survey->regions; k++)
                raster_tile_shade(&r, work, &rect, k, &flat, &stats);
            raster_tile_finish(&r, work, &rect, &stats);
            covered += stats.covered;
        }
        assert_int_equal(covered, (uint32_t)sizes[i][0] * sizes[i][1]);
        free(o.blob);
    }
    free(work);
    ref_blob_free(&b);
}

/* A light from behind that shines past the eye: at one pixel l + v rounds to a vector of no length, where n.l is not 0. */
static void light_against_the_view_has_a_lobe(void **state)
{
    (void)state;
    enum { W = 320, H = 240, X = 272, Y = 176 };
    const struct scene_light light = {.direction = {387440544, -194367620, -982360707},
                                      .irradiance = {65536, 65536, 65536}};
    const struct scene_material material = {.kind = SCENE_MATERIAL_BLINN_PHONG,
                                            .kd = {32768, 32768, 32768},
                                            .ks = {32768, 32768, 32768},
                                            .exponent = 32 << 16,
                                            .roughness = 32768,
                                            .name = "glossy"};
    struct ref_blob b = new_scene();
    struct opened o;
    b.focal = 158217 / 65536.0;
    const double axis = b.focal * H / 2, ray[3] = {(X + 0.5 - W / 2) / axis, -(Y + 0.5 - H / 2) / axis, -1},
                 pull = 1 / sqrt(ray[0] * ray[0] + ray[1] * ray[1] + 1);
    double n[3], h[3], right[3], length = 0, h_length = 0;
    for (int i = 0; i < 3; i++) {
        h[i] = light.direction[i] * 0x1p-30 - ray[i] * pull;
        h_length += h[i] * h[i];
    }
    for (int i = 0; i < 3; i++) { /* between h and the eye */
        n[i] = 0.9 * h[i] / sqrt(h_length) - 0.3 * ray[i] * pull;
        length += n[i] * n[i];
    }
    for (int i = 0; i < 3; i++)
        n[i] /= sqrt(length);
    right[0] = n[2] / hypot(n[0], n[2]), right[1] = 0, right[2] = -n[0] / hypot(n[0], n[2]);
    const double up[3] = {n[1] * right[2], n[2] * right[0] - n[0] * right[2], -n[1] * right[0]};
    int16_t v[4][3];
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 3; i++)
            v[k][i] = (int16_t)lrint(16000 * ((k == 1 || k == 2 ? right[i] : -right[i]) + (k >= 2 ? up[i] : -up[i])));
    const uint16_t t[2][3] = {{0, 1, 2}, {0, 2, 3}};
    ref_blob_object(&b, ref_blob_mesh(&b, (const int16_t(*)[3])v, t, 2), 0,
                    (const double[3]){5 * ray[0], 5 * ray[1], -5}, 1. / 16000);
    open_scene(&o, &b, W, H);
    assert_int_equal(scene_check_light(&light), SCENE_OK);
    assert_int_equal(scene_check_material(&material), SCENE_OK);
    o.frame.lights = &light;
    o.frame.light_count = 1;
    o.frame.materials = &material;
    struct picture p = render_frame(&o.frame, FORWARD);
    assert_false(is_background(&p, X, Y));
    free(p.rgb);
    free(o.blob);
    ref_blob_free(&b);
}

static void frame_that_asks_for_a_missing_part_is_refused(void **state)
{
    (void)state;
    enum { KINDS = 4 };
    static const unsigned kind[KINDS] = {SCENE_MATERIAL_LAFORTUNE_PHONG, SCENE_MATERIAL_BLINN_PHONG,
                                         SCENE_MATERIAL_METALLIC_ROUGHNESS, SCENE_MATERIAL_MEASURED};
    const struct raster_parts *all = &raster_all_parts;
    const struct raster_parts with[KINDS] = {{.lafortune_phong = all->lafortune_phong},
                                             {.blinn_phong = all->blinn_phong},
                                             {.metallic_roughness = all->metallic_roughness},
                                             {.half_vector = all->half_vector}};
    const struct lut_table half_vector = {.kind = LUT_HALF_VECTOR}, specular = {.kind = LUT_SPECULAR_FRAME};
    const struct lut_table *tables[RASTER_MAX_SLOTS];
    const struct scene_light point = {.kind = SCENE_LIGHT_POINT, .radius = 1 << 16};
    struct scene_material m[2];
    struct ref_blob b = new_scene();
    struct opened o;
    struct raster r;
    ref_blob_material(&b, SCENE_MATERIAL_LAFORTUNE_PHONG, 0, 0.5, "the one");
    ref_blob_object(&b, add_wall(&b, -100, -100, 100, 100), 1, (const double[3]){0, 0, -1}, 1);
    open_scene(&o, &b, 32, 32);
    memcpy(m, o.frame.materials, sizeof m);
    o.frame.materials = m;
    o.frame.tables = tables;
    for (int i = 0; i < KINDS; i++) {
        m[1].kind = (uint8_t)kind[i];
        tables[0] = &half_vector;
        for (int k = 0; k < KINDS; k++) {
            o.frame.parts = &with[k];
            memset(&r, 0xa5, sizeof r);
            assert_int_equal(raster_begin(&r, &o.frame, NULL, 0), k == i ? RASTER_ERR_ARENA : RASTER_ERR_MODEL);
            assert_true(k == i || r.bad_material == 1);
        }
        o.frame.parts = &with[i];
        tables[0] = &specular;
        assert_int_equal(raster_begin(&r, &o.frame, NULL, 0),
                         kind[i] == SCENE_MATERIAL_MEASURED ? RASTER_ERR_MODEL : RASTER_ERR_ARENA);
    }
    o.frame.lights = &point;
    o.frame.light_count = 1;
    tables[0] = &half_vector;
    assert_int_equal(raster_begin(&r, &o.frame, NULL, 0), RASTER_ERR_POINT);
    o.frame.light_count = 0;
    o.frame.samples = 4;
    assert_int_equal(raster_begin(&r, &o.frame, NULL, 0), RASTER_ERR_SIZE);
    o.frame.parts = all;
    o.frame.light_count = 1;
    assert_int_equal(raster_begin(&r, &o.frame, NULL, 0), RASTER_ERR_ARENA);
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

/* 65,000 meshlets in one tile: every one of every object, the newest first. */
static void a_tile_lists_every_meshlet(void **state)
{
    (void)state;
    enum { PER_MESH = 1000, OBJECTS = 65 };
    static uint16_t t[PER_MESH][3];
    const int16_t v[3][3] = {{-100, -100, 0}, {100, -100, 0}, {0, 100, 0}};
    for (int i = 0; i < PER_MESH; i++)
        memcpy(t[i], (const uint16_t[3]){0, 1, 2}, sizeof t[i]);
    struct ref_blob b = new_scene();
    unsigned mesh = ref_blob_mesh(&b, v, (const uint16_t(*)[3])t, PER_MESH);
    for (int i = 0; i < OBJECTS; i++)
        ref_blob_object(&b, mesh, 0, (const double[3]){0, 0, -4}, 0.01);
    struct opened o;
    struct raster r;
    open_scene(&o, &b, 32, 32);
    size_t bytes = raster_arena_bytes(&o.frame);
    void *arena = malloc(bytes);
    assert_int_equal(raster_begin(&r, &o.frame, arena, bytes), RASTER_OK);
    assert_int_equal(r.visible_count, OBJECTS * PER_MESH);
    uint32_t expected = OBJECTS * PER_MESH;
    for (uint32_t id = r.heads[0]; id; id = r.runs[id - 1].next) {
        const struct raster_run *run = &r.runs[id - 1];
        uint32_t k = RUN_USED(run->object), meshlet = VISIBLE_MESHLET(run->meshlet);
        assert_in_range(k, 0, RUN_BACK);
        for (k++; k--; meshlet -= k ? run->back[k - 1] : 0)
            assert_int_equal((run->object >> RUN_BITS) * PER_MESH + meshlet, --expected);
    }
    assert_int_equal(expected, 0);
    free(arena);
    free(o.blob);
    ref_blob_free(&b);
}

static void too_many_runs_are_refused(void **state)
{
    (void)state;
    const int16_t v[3][3] = {{-30000, -30000, 0}, {30000, -30000, 0}, {0, 30000, 0}};
    struct ref_blob b = new_scene();
    unsigned mesh = ref_blob_mesh(&b, v, (const uint16_t[1][3]){{0, 1, 2}}, 1);
    for (unsigned i = 0; i < SCENE_MAX_OBJECTS; i++)
        ref_blob_object(&b, mesh, 0, (const double[3]){0, 0, -4}, 0.01);
    struct opened o; /* a run for every tile and object */
    struct raster r;
    open_scene(&o, &b, 15 * RASTER_TILE_WIDTH, RASTER_TILE_HEIGHT);
    assert_true(raster_arena_bytes(&o.frame) > sizeof(struct raster_run) * 15 * SCENE_MAX_OBJECTS);
    assert_int_equal(raster_begin(&r, &o.frame, NULL, 0), RASTER_ERR_ARENA);
    o.frame.width = 16 * RASTER_TILE_WIDTH;
    assert_int_equal(raster_begin(&r, &o.frame, NULL, 0), RASTER_ERR_LIMIT);
    assert_int_equal(raster_arena_bytes(&o.frame), 0);
    size_t bytes = 4u << 20;
    void *arena = malloc(bytes);
    assert_int_equal(raster_begin(&r, &o.frame, arena, bytes), RASTER_ERR_LIMIT);
    free(arena);
    free(o.blob);
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
    check_crowd(50, 1);  /* 100 meshlets: fewer than the slots of a tile */
    check_crowd(400, 1); /* 800 */
    check_crowd(300, 4); /* 2400 */
    for (int walls = RASTER_SLOTS / 2 - 2; walls <= RASTER_SLOTS / 2 + 1; walls++)
        check_crowd(walls, 1); /* two meshlets each: about the limit */
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
        cmocka_unit_test(scene_without_objects_is_background),
        cmocka_unit_test(scene_without_lights_is_black),
        cmocka_unit_test(pictures_of_extreme_shape_are_complete),
        cmocka_unit_test(sizes_out_of_range_are_refused),
        cmocka_unit_test(small_arena_says_what_is_needed),
        cmocka_unit_test(too_many_lights_are_refused),
        cmocka_unit_test(no_view_ray_is_lost),
        cmocka_unit_test(light_against_the_view_has_a_lobe),
        cmocka_unit_test(frame_that_asks_for_a_missing_part_is_refused),
        cmocka_unit_test(missing_table_is_refused_with_its_material),
        cmocka_unit_test(a_tile_lists_every_meshlet),
        cmocka_unit_test(too_many_runs_are_refused),
        cmocka_unit_test(crowded_tiles_lose_nothing),
        cmocka_unit_test(any_order_of_tiles_gives_the_same_pixels),
        cmocka_unit_test(every_status_has_its_own_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
