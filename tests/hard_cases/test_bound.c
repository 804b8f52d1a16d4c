/*
 * What a tile takes at most: never less than what is counted, and not much more where meshes are made for the picture.
 *
 * Environment: GONIOTILE_SIX_MODELS (scene blob with levels).
 */
#include "scene_fixture.h"

#include "common.h"
#include "internal.h"
#include "quality.h"

enum { WIDTH = 320, HEIGHT = 240 };

static struct scene_header *blob;
static struct scene six;
static struct scene_material materials[SCENE_MAX_MATERIALS];
static struct raster_tile work;
static uint64_t arena[1 << 17];

static int load(void **state)
{
    (void)state;
    size_t bytes;
    const char *path = getenv("GONIOTILE_SIX_MODELS");
    if (!path)
        return -1;
    blob = read_file(path, SCENE_MAX_BYTES, &bytes);
    if (scene_open_bounded(&six, blob, bytes) != SCENE_OK)
        return -1;
    memcpy(materials, six.materials, six.header->materials.count * sizeof *materials);
    for (uint32_t i = 0; i < six.header->materials.count; i++)
        materials[i].kind = SCENE_MATERIAL_LAFORTUNE_PHONG;
    return 0;
}

static int unload(void **state)
{
    (void)state;
    free(blob);
    return 0;
}

static struct raster_frame six_models(const struct scene_camera *camera, const struct raster_costs *costs)
{
    return (struct raster_frame){.parts = &raster_all_parts,
                                 .scene = &six,
                                 .camera = camera,
                                 .output = &six.header->output,
                                 .lights = six.lights,
                                 .materials = materials,
                                 .tables = no_tables,
                                 .width = WIDTH,
                                 .height = HEIGHT,
                                 .light_count = (uint8_t)six.header->lights.count,
                                 .format = RASTER_RGB888,
                                 .costs = costs,
                                 .bounds = &raster_tile_bounds};
}

struct sums {
    double bound, counted;
};

/* One tick for each pixel tested: the bound is of their number. */
static const struct raster_costs of_tested = {.tested = 16};
static const struct raster_costs of_meshlets = {.meshlet = 16};
static const struct raster_costs of_triangles = {.facing = 16};

/* In: a frame whose objects have one level: what is drawn is the coarsest. */
static struct sums frame_within_bounds(const struct raster_frame *f)
{
    struct sums sums = {0, 0};
    struct raster r;
    struct raster_rect rect;
    struct raster_stats stats;
    assert_string_equal(raster_status_text(raster_begin(&r, f, arena, sizeof arena)), raster_status_text(RASTER_OK));
    double total = 0;
    for (uint32_t t = 0; t < raster_tile_count(&r); t++) {
        const struct raster_tile_bound *b = &r.bounds[t];
        raster_render_tile(&r, t, &work, &rect, &stats);
        const uint32_t counted = f->costs == &of_tested      ? stats.tested
                                 : f->costs == &of_triangles ? stats.triangles
                                                             : stats.meshlets;
        assert_true(b->least >= counted);
        if (f->costs == &of_meshlets)
            assert_int_equal(b->least, counted);
        assert_int_equal(b->meshlets, stats.meshlets);
        assert_true(b->pixels >= stats.tested && b->largest * stats.meshlets >= counted);
        sums.bound += b->least;
        sums.counted += counted;
        total += b->least;
    }
    assert_int_equal(r.budget_needed, (uint32_t)ceil(total / raster_tile_count(&r)));
    return sums;
}

/* Under the least budget, where what meshlets take at most is a part of it that matters: drawn one by one, none takes more. */
static void meshlets_stay_within_the_largest(const struct raster_frame *frame)
{
    struct raster_frame f = *frame;
    struct raster r;
    struct raster_rect rect;
    struct raster_stats stats;
    assert_int_equal(raster_begin(&r, &f, arena, sizeof arena), RASTER_OK);
    f.tile_budget = r.budget_needed > 1 ? r.budget_needed : 1;
    assert_int_equal(raster_begin(&r, &f, arena, sizeof arena), RASTER_OK);
    for (uint32_t t = 0; t < raster_tile_count(&r); t++) {
        enum raster_drawing drawn = RASTER_MORE;
        raster_tile_begin(&r, t, &work, &rect, &stats);
        while (drawn == RASTER_MORE) {
            const uint32_t triangles = stats.triangles, tested = stats.tested;
            drawn = raster_tile_draw(&r, &work, 1, &stats);
            assert_true((f.costs == &of_tested ? stats.tested - tested : stats.triangles - triangles) <=
                        r.bounds[t].largest);
        }
        assert_int_equal(drawn, RASTER_DRAWN);
    }
}

/* Every mesh with its last level alone. */
static void keep_coarsest(struct scene *out, struct scene_mesh meshes[6])
{
    *out = six;
    for (int i = 0; i < 6; i++) {
        meshes[i] = six.meshes[i];
        meshes[i].lod_first += meshes[i].lod_count - 1;
        meshes[i].lod_count = 1;
    }
    out->meshes = meshes;
}

static void coarsest_levels_stay_within_their_bounds(void **state)
{
    (void)state;
    static const struct raster_costs *const costs[] = {&of_tested, &of_triangles, &of_meshlets};
    static const char *const name[] = {"pixels tested", "triangles facing", "meshlets"};
    struct scene coarsest;
    struct scene_mesh meshes[6];
    keep_coarsest(&coarsest, meshes);
    for (int i = 0; i < 3; i++) {
        struct scene_camera camera = six.header->camera;
        struct raster_frame f = six_models(&camera, costs[i]);
        f.scene = &coarsest;
        struct sums s = frame_within_bounds(&f);
        print_message("# %s: at most %.0f, counted %.0f\n", name[i], s.bound, s.counted);
        assert_true(s.bound < 8 * s.counted);
        for (int n = 0; n < 12; n++) { /* towards and through them, more or less wide */
            for (int k = 0; k < 3; k++)
                camera.eye[k] = (q16_16_t)(six.header->camera.eye[k] * random_between(-0.2, 1.2));
            camera.focal = (uq16_16_t)(six.header->camera.focal * random_between(0.4, 3));
            camera.near = (uq16_16_t)(65536 * random_between(0.001, 0.2));
            frame_within_bounds(&f);
        }
    }
}

/* Triangles of all sizes and shapes, through the near plane and around the eye, too. */
static void random_triangles_stay_within_their_bounds(void **state)
{
    (void)state;
    double bound = 0, counted = 0;
    for (int n = 0; n < 400; n++) {
        struct ref_blob b = new_scene();
        enum { COUNT = 40 };
        int16_t v[3 * COUNT][3];
        uint16_t t[COUNT][3];
        const double size = pow(2, random_between(-7, 0)), sliver = n % 3 ? 1 : 0.01;
        for (int i = 0; i < COUNT; i++) {
            double c[3];
            for (int k = 0; k < 3; k++)
                c[k] = random_between(-1, 1) * (1 - size);
            for (int j = 0; j < 3; j++) {
                t[i][j] = (uint16_t)(3 * i + j);
                for (int k = 0; k < 3; k++)
                    v[3 * i + j][k] =
                        (int16_t)(32000 * (c[k] + size * random_between(-1, 1) * (j == 2 || k == n % 3 ? 1 : sliver)));
            }
        }
        unsigned mesh = ref_blob_mesh(&b, (const int16_t(*)[3])v, (const uint16_t(*)[3])t, COUNT);
        ref_blob_object(&b, mesh, 0, (const double[3]){0, 0, random_between(-3, 0)},
                        pow(2, random_between(-1, 3)) / 32768);
        struct opened o;
        open_scene(&o, &b, n % 2 ? WIDTH : 97, n % 2 ? HEIGHT : 61);
        o.frame.costs = n & 4 ? &of_tested : &of_triangles;
        o.frame.bounds = &raster_tile_bounds;
        o.frame.samples = n & 8 ? 4 : 1;
        struct sums s = frame_within_bounds(&o.frame);
        meshlets_stay_within_the_largest(&o.frame);
        if (o.frame.costs == &of_tested) {
            bound += s.bound;
            counted += s.counted;
        }
        free(o.blob);
        ref_blob_free(&b);
    }
    print_message("# pixels tested: at most %.0f, counted %.0f\n", bound, counted);
    assert_true(counted > 1e5);
}

/* The same pixels as where there is no other level. */
static void restarted_tiles_show_the_coarsest_levels(void **state)
{
    (void)state;
    struct scene_camera camera = six.header->camera;
    struct raster_frame f = six_models(&camera, &of_tested), g;
    struct scene coarsest;
    struct scene_mesh meshes[6];
    struct raster r, s;
    struct raster_rect rect;
    struct raster_stats stats;
    static struct raster_tile other;
    static uint64_t other_arena[1 << 17];
    keep_coarsest(&coarsest, meshes);
    g = f;
    g.scene = &coarsest;
    assert_int_equal(raster_begin(&r, &f, arena, sizeof arena), RASTER_OK);
    assert_int_equal(raster_begin(&s, &g, other_arena, sizeof other_arena), RASTER_OK);
    uint32_t covered = 0;
    for (uint32_t t = 0; t < raster_tile_count(&r); t++) {
        raster_tile_begin(&r, t, &work, &rect, &stats);
        assert_int_not_equal(raster_tile_draw(&r, &work, t, &stats), RASTER_NO_SLOT); /* some of the others */
        raster_tile_restart(&r, t, &work);
        assert_int_equal(raster_tile_draw(&r, &work, UINT32_MAX, &stats), RASTER_DRAWN);
        raster_shade_tile(&r, &work, &rect, &stats);
        raster_render_tile(&s, t, &other, &rect, &stats);
        assert_memory_equal(raster_tile_pixels(&work), raster_tile_pixels(&other), 3 * rect.width * rect.height);
        covered += stats.covered;
    }
    assert_true(covered > 30000);
}

static void budgets_take_coarser_levels_down_to_the_least_and_are_refused_below(void **state)
{
    (void)state;
    static const struct raster_costs costs = {
        .tile = 1600, .meshlet = 8000, .vertex = 1300, .triangle = 4800, .row = 880, .tested = 208, .finished = 160};
    struct scene_camera camera = six.header->camera;
    struct raster_frame f = six_models(&camera, &costs);
    struct raster r;
    assert_int_equal(raster_begin(&r, &f, arena, sizeof arena), RASTER_OK);
    const uint32_t least = r.budget_needed;
    const uint32_t tiles = raster_tile_count(&r);
    uint64_t drawing = 0;
    uint32_t bias = r.lod_bias;
    for (uint32_t t = 0; t < tiles; t++)
        drawing += r.bounds[t].besides;
    print_message("# drawing takes about %.0f a tile; the least budget is %u\n", (double)drawing / tiles, least);
    assert_int_equal(bias, 0);
    for (uint32_t budget = (uint32_t)(drawing * 2 / tiles); budget >= least; budget -= budget / 4 + 1) {
        f.tile_budget = budget;
        assert_int_equal(raster_begin(&r, &f, arena, sizeof arena), RASTER_OK);
        assert_int_equal(r.budget_needed, least); /* whatever levels are wanted */
        assert_true(r.lod_bias >= bias);
        bias = r.lod_bias;
    }
    assert_true(bias >= 3);
    f.tile_budget = least;
    assert_int_equal(raster_begin(&r, &f, arena, sizeof arena), RASTER_OK);
    f.tile_budget = least - 1;
    assert_int_equal(raster_begin(&r, &f, arena, sizeof arena), RASTER_ERR_BUDGET);
    assert_int_equal(r.budget_needed, least);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coarsest_levels_stay_within_their_bounds),
        cmocka_unit_test(restarted_tiles_show_the_coarsest_levels),
        cmocka_unit_test(random_triangles_stay_within_their_bounds),
        cmocka_unit_test(budgets_take_coarser_levels_down_to_the_least_and_are_refused_below),
    };
    return cmocka_run_group_tests(tests, load, unload);
}
