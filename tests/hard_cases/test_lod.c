/*
 * Levels of detail: which one a frame draws, what that does to the picture, and what happens when memory is short.
 *
 * Environment: GONIOTILE_SIX_MODELS (scene blob with levels).
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "internal.h"
#include "ref_scene.h"

static struct scene_header *blob;
static size_t blob_bytes;
static struct scene scene;
static struct ref_scene *reference;
static struct scene_material materials[SCENE_MAX_MATERIALS];
static const struct lut_table *no_tables[RASTER_MAX_SLOTS];
static uint32_t random_state = 7;

static uint32_t random_u32(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state;
}

static double random_in(double lo, double hi)
{
    return lo + (hi - lo) * (random_u32() / 4294967296.0);
}

static int load(void **state)
{
    (void)state;
    const char *path = getenv("GONIOTILE_SIX_MODELS");
    if (!path)
        return -1;
    blob = read_file(path, SCENE_MAX_BYTES, &blob_bytes);
    reference = ref_scene_open(blob, blob_bytes);
    if (scene_open(&scene, blob, blob_bytes) != SCENE_OK || !reference)
        return -1;
    memcpy(materials, scene.materials, scene.header->materials.count * sizeof *materials);
    for (uint32_t i = 0; i < scene.header->materials.count; i++)
        materials[i].kind = SCENE_MATERIAL_LAFORTUNE_PHONG;
    return 0;
}

static int unload(void **state)
{
    (void)state;
    ref_scene_close(reference);
    free(blob);
    return 0;
}

static struct raster_frame make_frame(const struct scene_camera *camera, const struct scene_output *output, int width,
                                      int height, double threshold)
{
    blob->lod_error = (uq16_16_t)lrint(threshold * 65536);
    return (struct raster_frame){.parts = &raster_all_parts,
                                 .scene = &scene,
                                 .camera = camera,
                                 .output = output,
                                 .lights = scene.lights,
                                 .materials = materials,
                                 .tables = no_tables,
                                 .width = (uint16_t)width,
                                 .height = (uint16_t)height,
                                 .light_count = (uint8_t)scene.header->lights.count,
                                 .format = RASTER_RGB888};
}

/* The frame's RGB picture (free it); arena of `bytes`, or of what it asks for when 0. */
static uint8_t *render(struct raster *r, const struct raster_frame *f, size_t bytes)
{
    static struct raster_tile work;
    uint8_t *picture = xmalloc(3u * f->width * f->height);
    bytes = bytes ? bytes : raster_arena_bytes(f);
    void *arena = xmalloc(bytes + !bytes);
    assert_int_equal(raster_begin(r, f, arena, bytes), RASTER_OK);
    assert_true(r->arena_needed <= bytes);
    for (uint32_t t = 0; t < raster_tile_count(r); t++) {
        struct raster_rect rect;
        struct raster_stats stats;
        raster_render_tile(r, t, &work, &rect, &stats);
        for (unsigned y = 0; y < rect.height; y++)
            memcpy(picture + 3 * ((size_t)(rect.y + y) * f->width + rect.x),
                   raster_tile_pixels(&work) + 3 * y * rect.width, 3 * rect.width);
    }
    free(arena);
    return picture;
}

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static void normalise(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++)
        v[k] /= length;
}

/* Somewhere up to `reach` from the origin, looking about where the models are. */
static struct scene_camera random_camera(double reach)
{
    struct scene_camera c = {.focal = (uq16_16_t)(65536 * pow(2, random_in(-2, 4))),
                             .near = (uq16_16_t)(65536 * pow(2, random_in(-8, 1)))};
    double m[3][3], up[3] = {0, 1, 0.1};
    for (int k = 0; k < 3; k++) {
        double eye = random_in(-reach, reach);
        c.eye[k] = (q16_16_t)(eye * 65536);
        m[2][k] = eye - random_in(-3, 3);
    }
    normalise(m[2]);
    cross(m[0], up, m[2]);
    normalise(m[0]);
    cross(m[1], m[2], m[0]);
    for (int i = 0; i < 9; i++)
        c.rotation[i] = (q2_30_t)lrint(m[i / 3][i % 3] * (1 << 30));
    assert_int_equal(scene_check_camera(&c), SCENE_OK);
    return c;
}

/* Pixels of error that a level of an object shows, in double precision: at its box's nearest corner, not nearer than the plane. */
static double projected_error(const struct scene_camera *c, const struct ref_object *o, double error, int height)
{
    const struct ref_mesh *mesh = &reference->meshes[o->mesh];
    double nearest = INFINITY, scale = 0;
    for (int corner = 0; corner < 8; corner++) {
        double w = 0;
        for (int i = 0; i < 3; i++) {
            double world = o->matrix[i][3] - c->eye[i] / 65536.0;
            for (int j = 0; j < 3; j++)
                world += o->matrix[i][j] * (corner >> j & 1 ? mesh->hi[j] : mesh->lo[j]);
            w -= ldexp(c->rotation[6 + i], -30) * world;
        }
        nearest = fmin(nearest, w);
    }
    for (int j = 0; j < 3; j++)
        scale += o->matrix[0][j] * o->matrix[0][j];
    return error * sqrt(scale) * (c->focal / 65536.0) * height / 2 / fmax(nearest, c->near / 65536.0);
}

/* Which level of its mesh a meshlet is of. */
static const struct scene_lod *level_of(uint32_t mesh, uint32_t meshlet)
{
    for (uint32_t i = 0; i < scene.meshes[mesh].lod_count; i++) {
        const struct scene_lod *lod = &scene.lods[scene.meshes[mesh].lod_first + i];
        if (meshlet - lod->meshlet_first < lod->meshlet_count)
            return lod;
    }
    fail_msg("meshlet %u is in no level of mesh %u", meshlet, mesh);
    return NULL;
}

/* Whether a meshlet that is drawn is of the level that the threshold, pixels, asks for. */
static void check_level(const struct raster *r, const struct scene_camera *c, uint32_t object, uint32_t meshlet,
                        double threshold, unsigned seen[32], unsigned *coarser)
{
    uint32_t mesh = r->objects[object].mesh;
    const struct scene_lod *lod = level_of(mesh, meshlet);
    const struct ref_object *o = reference->objects;
    while (o->mesh != mesh) /* here every object has a mesh of its own */
        o++;
    uint32_t level = (uint32_t)(lod - scene.lods) - scene.meshes[mesh].lod_first;
    seen[level]++;
    assert_true(projected_error(c, o, lod->error, 240) <= blob->lod_error / 65536.0);
    if (level + 1 < scene.meshes[mesh].lod_count) {
        (*coarser)++; /* the next one is refused but where rounding decides */
        assert_true(projected_error(c, o, lod[1].error, 240) > threshold * 0.98);
    }
}

static const struct raster_run *run_at(const struct raster *r, uint32_t id)
{
    return id ? &r->runs[id - 1] : NULL;
}

static void the_coarsest_level_within_the_threshold_is_drawn(void **state)
{
    (void)state;
    unsigned seen[32] = {0}, coarser = 0;
    for (int n = 0; n < 3000; n++) {
        struct scene_camera c = random_camera(pow(10, random_in(0, 3)));
        double threshold = random_in(0, 4);
        struct raster_frame f = make_frame(&c, &scene.header->output, 320, 240, threshold);
        size_t bytes = raster_arena_bytes(&f);
        void *arena = xmalloc(bytes);
        struct raster r;
        assert_int_equal(raster_begin(&r, &f, arena, bytes), RASTER_OK);
        for (uint32_t tile = 0; tile < raster_tile_count(&r) && !r.lod_bias;
             tile++) /* inside a model ids may run out */
            for (const struct raster_run *run = run_at(&r, r.heads[tile]); run; run = run_at(&r, run->next))
                for (uint32_t k = RUN_USED(run->object), meshlet = VISIBLE_MESHLET(run->meshlet);;
                     meshlet -= run->back[--k]) {
                    check_level(&r, &c, run->object >> RUN_BITS, meshlet, threshold, seen, &coarser);
                    if (!k)
                        break;
                }
        free(arena);
    }
    for (uint32_t i = 0; i < scene.meshes[0].lod_count; i++)
        assert_true(seen[i] > 100);
    assert_true(coarser > 10000);
}

/* Squared distance of p from a triangle, by its smallest distance over a fine subdivision's nearest point: edges and plane. */
static double triangle_distance2(const double p[3], const double *t[3])
{
    double e[2][3], n[3], best = INFINITY, area2 = 0, height = 0;
    bool inside = true;
    for (int k = 0; k < 3; k++) {
        e[0][k] = t[1][k] - t[0][k];
        e[1][k] = t[2][k] - t[0][k];
    }
    cross(n, e[0], e[1]);
    for (int k = 0; k < 3; k++) {
        area2 += n[k] * n[k];
        height += n[k] * (p[k] - t[0][k]);
    }
    for (int c = 0; c < 3; c++) {
        double d[3], to[3], out[3], along = 0, length2 = 0, side = 0, distance2 = 0;
        for (int k = 0; k < 3; k++) {
            d[k] = t[(c + 1) % 3][k] - t[c][k];
            to[k] = p[k] - t[c][k];
            along += d[k] * to[k];
            length2 += d[k] * d[k];
        }
        cross(out, d, to);
        for (int k = 0; k < 3; k++) {
            side += out[k] * n[k];
            distance2 += pow(to[k] - fmin(1, fmax(0, along / length2)) * d[k], 2);
        }
        inside = inside && side >= 0;
        best = fmin(best, distance2);
    }
    return inside ? height * height / area2 : best;
}

/* Distance of p from all triangles of a level. */
static double level_distance(const double p[3], const struct scene_lod *lod)
{
    double best = INFINITY;
    for (uint32_t i = 0; i < lod->meshlet_count; i++) {
        const struct ref_meshlet *m = &reference->meshlets[lod->meshlet_first + i];
        for (unsigned j = 0; j < m->triangle_count; j++) {
            const double *t[3];
            for (int k = 0; k < 3; k++)
                t[k] = reference->vertices[m->vertex_first + reference->triangles[m->triangle_first + j][k]].position;
            best = fmin(best, triangle_distance2(p, t));
        }
    }
    return sqrt(best);
}

static void random_point(double p[3], const struct scene_lod *lod)
{
    const struct ref_meshlet *m = &reference->meshlets[lod->meshlet_first + random_u32() % lod->meshlet_count];
    const unsigned *t = reference->triangles[m->triangle_first + random_u32() % m->triangle_count];
    double u = random_in(0, 1), v = random_in(0, 1);
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    const double weight[3] = {1 - u - v, u, v};
    memset(p, 0, 3 * sizeof *p);
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++)
            p[k] += weight[c] * reference->vertices[m->vertex_first + t[c]].position[k];
}

static void stored_errors_hold_and_levels_shrink(void **state)
{
    (void)state;
    for (uint32_t mesh = 0; mesh < scene.header->meshes.count; mesh++) {
        const struct scene_lod *finest = &scene.lods[scene.meshes[mesh].lod_first];
        uint32_t before = UINT32_MAX;
        assert_true(scene.meshes[mesh].lod_count >= 6);
        assert_int_equal(finest->error, 0);
        for (const struct scene_lod *lod = finest; lod < finest + scene.meshes[mesh].lod_count; lod++) {
            uint32_t triangles = 0;
            double there = 0, back = 0;
            for (uint32_t i = 0; i < lod->meshlet_count; i++)
                triangles += scene.meshlets[lod->meshlet_first + i].triangle_count;
            for (int n = 0; n < 60 && lod != finest; n++) {
                double p[3];
                random_point(p, finest);
                there = fmax(there, level_distance(p, lod));
                random_point(p, lod);
                back = fmax(back, level_distance(p, finest));
            }
            if (lod != finest)
                assert_true(lod->error >= lod[-1].error);
            assert_true(triangles < 0.8 * before);
            assert_true(fmax(there, back) <= lod->error);
            assert_true(fmax(there, back) >= 0.1 * lod->error); /* and no more than they must */
            before = triangles;
        }
        assert_true(before < 64);
    }
}

/* Which pixels a surface covers: those that do not change with the background. Free it. */
static uint8_t *coverage(uint32_t *covered, const struct scene_camera *c, int width, int height, double threshold)
{
    struct scene_output output = scene.header->output;
    struct raster r;
    struct raster_frame f = make_frame(c, &output, width, height, threshold);
    memset(output.background, 0, 3);
    uint8_t *black = render(&r, &f, 0);
    memset(output.background, 255, 3);
    uint8_t *white = render(&r, &f, 0);
    *covered = 0;
    for (int i = 0; i < width * height; i++)
        *covered += black[i] = !memcmp(black + 3 * i, white + 3 * i, 3);
    free(white);
    return black;
}

static void levels_hardly_change_the_picture(void **state)
{
    (void)state;
    for (int size = 1; size <= 3; size += 2) {
        int width = 320 * size, height = 240 * size;
        struct raster r;
        struct raster_frame f = make_frame(&scene.header->camera, &scene.header->output, width, height, 0);
        uint8_t *fine = render(&r, &f, 0);
        uint32_t finest = r.visible_count, covered[2], differ = 0;
        f = make_frame(&scene.header->camera, &scene.header->output, width, height, 0.5);
        uint8_t *coarse = render(&r, &f, 0);
        double squares = 0;
        for (int i = 0; i < 3 * width * height; i++)
            squares += (fine[i] - coarse[i]) * (fine[i] - coarse[i]);
        uint8_t *a = coverage(&covered[0], &scene.header->camera, width, height, 0);
        uint8_t *b = coverage(&covered[1], &scene.header->camera, width, height, 0.5);
        for (int i = 0; i < width * height; i++) {
            int x = i % width, y = i / width;
            bool edge = false; /* of the finest picture's silhouettes, within one pixel */
            for (int n = 0; n < 9; n++) {
                int px = x + n % 3 - 1, py = y + n / 3 - 1;
                edge = edge || px < 0 || py < 0 || px >= width || py >= height || a[py * width + px] != a[i];
            }
            differ += a[i] != b[i];
            assert_true(a[i] == b[i] || edge);
        }
        double psnr = 10 * log10(255.0 * 255 * 3 * width * height / squares);
        print_message(
            "# %d x %d at 0.5 px: %u meshlets instead of %u, PSNR %.1f dB, %u of %u pixels' coverage differs\n", width,
            height, r.visible_count, finest, psnr, differ, covered[0]);
        assert_true(r.visible_count < finest);
        assert_true(psnr > 30);
        assert_true(differ < covered[0] / 50);
        free(fine);
        free(coarse);
        free(a);
        free(b);
    }
}

static void a_small_arena_raises_the_threshold_and_loses_nothing(void **state)
{
    (void)state;
    struct raster r;
    struct raster_frame f = make_frame(&scene.header->camera, &scene.header->output, 320, 240, 0);
    size_t needed = raster_arena_bytes(&f), bytes = needed;
    uint8_t *full = render(&r, &f, needed);
    uint32_t bias = 0;
    long least_same = 320 * 240;
    void *arena = xmalloc(needed);
    assert_int_equal(r.lod_bias, 0);
    assert_int_equal(r.arena_needed, needed);
    while (raster_begin(&r, &f, arena, bytes) == RASTER_OK) {
        assert_true(r.arena_needed <= bytes && r.lod_bias >= bias);
        bias = r.lod_bias;
        uint8_t *picture = render(&r, &f, bytes);
        long same = 0;
        for (int i = 0; i < 320 * 240; i++)
            same += abs(full[3 * i] - picture[3 * i]) < 64;
        least_same = same < least_same ? same : least_same;
        free(picture);
        bytes -= 64;
    }
    print_message(
        "# %zu bytes at the finest levels, %zu at the coarsest, threshold doubled %u times, at least %.1f %% of the "
        "pixels alike\n",
        needed, r.arena_needed, bias, 100.0 * (double)least_same / (320 * 240));
    assert_true(least_same > 320 * 240 * 0.85); /* six solid models, however coarse */
    assert_true(bias > 4 && bytes < needed * 3 / 5);
    /* what the error asks for is enough, and exactly enough */
    size_t least = r.arena_needed;
    assert_int_equal(raster_begin(&r, &f, arena, least), RASTER_OK);
    for (bytes = 0; bytes < least; bytes += 4) {
        assert_int_equal(raster_begin(&r, &f, arena, bytes), RASTER_ERR_ARENA);
        assert_int_equal(r.arena_needed, least);
    }
    free(arena);
    free(full);
}

static void what_is_out_of_view_takes_no_arena(void **state)
{
    (void)state;
    struct scene_camera away = scene.header->camera;
    for (int i = 0; i < 9; i++) /* turned by 180 degrees about its up axis */
        away.rotation[i] = i / 3 == 1 ? away.rotation[i] : -away.rotation[i];
    struct raster_frame f = make_frame(&away, &scene.header->output, 320, 240, 0.5);
    size_t tiles = (320 / RASTER_TILE_WIDTH) * ((240 + RASTER_TILE_HEIGHT - 1) / RASTER_TILE_HEIGHT);
    /* bins and lights only; of the six materials' lobes each takes less than 304 bytes */
    const size_t heads = (2 * tiles + 7) & ~(size_t)7;
    assert_int_equal(raster_arena_bytes(&f), heads + raster_light_bytes(&f));
    assert_in_range(raster_light_bytes(&f), 1, f.light_count * 32u + 6 * 304);
}

static void any_camera_gives_a_picture(void **state)
{
    (void)state;
    for (int n = 0; n < 400; n++) {
        struct scene_camera c = random_camera(pow(10, random_in(-2, 4.5)));
        if (n % 4 == 0) /* in the middle of a model */
            memcpy(c.eye, scene.objects[n / 4 % scene.header->objects.count].position, sizeof c.eye);
        struct raster_frame f = make_frame(&c, &scene.header->output, 160, 120, n % 3 ? 0.5 : 0);
        struct raster r;
        free(render(&r, &f, 0));
        size_t tight = 4096;
        void *arena = xmalloc(tight);
        enum raster_status status = raster_begin(&r, &f, arena, tight);
        assert_true(status == RASTER_OK || (status == RASTER_ERR_ARENA && r.arena_needed > tight));
        free(arena);
    }
    struct scene_camera far_away = scene.header->camera;
    far_away.eye[2] = 32767 << 16;
    struct raster_frame f = make_frame(&far_away, &scene.header->output, 320, 240, 0.5);
    assert_true(raster_arena_bytes(&f) > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_coarsest_level_within_the_threshold_is_drawn),
        cmocka_unit_test(stored_errors_hold_and_levels_shrink),
        cmocka_unit_test(levels_hardly_change_the_picture),
        cmocka_unit_test(a_small_arena_raises_the_threshold_and_loses_nothing),
        cmocka_unit_test(what_is_out_of_view_takes_no_arena),
        cmocka_unit_test(any_camera_gives_a_picture),
    };
    common_set_name("test_lod", NULL);
    return cmocka_run_group_tests(tests, load, unload);
}
