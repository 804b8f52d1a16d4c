/*
 * Counts what the steps of a tile take on an emulated board, exactly, for costs to be fitted to (tests/bench/calibrate.c). Lines:
 *   draw TICKS vertices triangles small facing rows tested              one meshlet; "clip" where some vertex may be clipped
 *   general TICKS rows tested                                           one triangle filled by general.c, every pixel of it seen
 *   survey TICKS clear lights                                           one tile; what clearing it took
 *   shade TICKS shading rate samples lit dark pixels parts blocks       one tile's regions under directional lights alone
 *   broad TICKS ...                                                     the same with lobes of a power below 1
 *   point TICKS ...                                                     ... under point lights alone
 *   point_broad, point_texels, point_bright TICKS ...                   likewise, by the ways of these names
 *   taps TICKS taps lit                                                 the last of these tiles by fewer taps
 *   texels TICKS taps lit                                               ... from the table's texels, by so many
 *   bright TICKS taps lit                                               ... brighter than the loop for the re-packed copy takes
 *   finish TICKS covered shading row_pixels row_lights pixels row_runs runs             one tile; shading and pixels of what is shaded in rows
 *   end hash H                                                          of all pixels: the same on every target
 * Parts are pairs of a cell of 4 x 4 pixels and a meshlet that shows in it. Input: four uint32_t, how many bytes blob, half-vector table and
 * specular-frame table have and 0, then these, 16-aligned. The fourth other than 0: a short walk for the hash alone, every so many tiles, half
 * of them with four samples per pixel. tests/board/host/board.c is a host's board.
 */
#include "board.h"
#include "bound.h"
#include "quality.h"

enum { WIDTH = 320, HEIGHT = 240, ARENA_BYTES = 256 * 1024, LIGHTS = 4, CAMERAS = 4 };

static uint64_t arena[ARENA_BYTES / 8];
static struct scene scene;
static struct lut_table half_vector, specular_frame;
static struct lut_table plain, bright; /* half_vector without its re-packed copy; all beyond the loop for that */
static const struct lut_table *tables[RASTER_MAX_SLOTS] = {&half_vector, &specular_frame};
static struct scene_material materials[SCENE_MAX_MATERIALS];
static struct scene_light lights[LIGHTS];
static struct scene_camera camera;
static struct raster raster;
static struct raster_tile work;
static uint32_t hash = REPORT_HASH_START; /* of all pixels */
static enum raster_taps taps;
static bool broad;          /* lobes */
static uint32_t stride = 3; /* of tiles */
static bool measures = true;

/* One tick for each row: what bound.h counts is their number. */
static const struct raster_costs of_rows = {.row = 16};

__attribute__((noinline)) static uint32_t clock_now(void)
{
    return board_clock();
}

static void checked(bool right, const char *wrong)
{
    if (!right)
        report_failure(wrong);
}

static void open_input(void)
{
    const uint32_t *bytes = (const uint32_t *)(const void *)board_input;
    const uint8_t *at = board_input + 16, *part[3];
    for (int i = 0; i < 3; at += (bytes[i++] + 15) & ~15u)
        part[i] = at;
    checked(scene_open(&scene, part[0], bytes[0]) == SCENE_OK, "no scene");
    checked(lut_open(&half_vector, part[1], bytes[1]) == LUT_OK, "no half-vector table");
    checked(lut_open(&specular_frame, part[2], bytes[2]) == LUT_OK, "no specular-frame table");
    plain = half_vector;
    plain.slabs = NULL;
    bright = half_vector;
    bright.scale = 40;
    measures = !bytes[3];
    stride = measures ? stride : bytes[3];
}

/* All materials of one way of shading. */
static void set_materials(enum raster_shading shading)
{
    static const uint8_t kind[RASTER_SHADE_COUNT] = {SCENE_MATERIAL_MEASURED,           SCENE_MATERIAL_MEASURED,
                                                     SCENE_MATERIAL_LAFORTUNE_PHONG,    SCENE_MATERIAL_BLINN_PHONG,
                                                     SCENE_MATERIAL_METALLIC_ROUGHNESS, SCENE_MATERIAL_LAFORTUNE_PHONG,
                                                     SCENE_MATERIAL_BLINN_PHONG};
    for (uint32_t i = 0; i < scene.header->materials.count; i++) {
        struct scene_material *m = &materials[i];
        *m = scene.materials[i];
        m->kind = kind[shading];
        m->slot = shading == RASTER_SHADE_SPECULAR_FRAME;
        m->roughness = 1 << 14;
        /* run by run in rows: powers of two, see blinn_phong_run.c */
        m->exponent = broad ? 1u << 15 : (shading == RASTER_SHADE_BLINN_PHONG_ROW ? 32u : 37u) << 16;
        for (int k = 0; k < 3; k++) {
            m->kd[k] = 1 << 14;
            m->ks[k] = shading == RASTER_SHADE_DIFFUSE_ROW || shading == RASTER_SHADE_METALLIC_ROUGHNESS ? 0 : 1 << 15;
        }
    }
}

/* From the scene's own place towards what it looks at; the last with the near plane within the objects. */
static void set_camera(uint32_t index)
{
    static const int32_t sixteenths[CAMERAS] = {16, 11, 6, 6};
    camera = scene.header->camera;
    for (int k = 0; k < 3; k++)
        camera.eye[k] = camera.eye[k] / 16 * sixteenths[index];
    if (index == CAMERAS - 1)
        camera.near = (uq16_16_t)(camera.eye[2] < 0 ? -camera.eye[2] : camera.eye[2]);
}

/* `directional` coloured lights (white ones take less in rows), then point lights near its middle. */
static uint32_t set_lights(uint32_t directional, uint32_t points)
{
    static const q2_30_t direction[3][3] = {
        {619925131, 619925131, 619925131}, {-759250125, 0, 759250125}, {0, -759250125, 759250125}};
    for (uint32_t i = 0; i < directional; i++) {
        lights[i] = (struct scene_light){.kind = SCENE_LIGHT_DIRECTIONAL, .irradiance = {1 << 16, 15 << 12, 7 << 13}};
        for (int k = 0; k < 3; k++)
            lights[i].direction[k] = direction[i][k];
    }
    for (uint32_t i = directional; i < directional + points; i++) {
        lights[i] = (struct scene_light){
            .kind = SCENE_LIGHT_POINT, .irradiance = {1 << 20, 1 << 20, 1 << 20}, .radius = 100u << 16};
        for (int k = 0; k < 3; k++)
            lights[i].position[k] = camera.eye[k] / 2 + (int32_t)((i * 7 + (uint32_t)k * 5) % 9) * 32768 - (4 << 15);
    }
    return directional + points;
}

static void begin(uint32_t light_count, uint8_t samples)
{
    const struct raster_frame frame = {.parts = &raster_all_parts,
                                       .scene = &scene,
                                       .camera = &camera,
                                       .output = &scene.header->output,
                                       .lights = lights,
                                       .materials = materials,
                                       .tables = tables,
                                       .width = WIDTH,
                                       .height = HEIGHT,
                                       .light_count = (uint8_t)light_count,
                                       .format = RASTER_RGB888,
                                       .samples = samples,
                                       .costs = &of_rows,
                                       .bounds = &raster_tile_bounds};
    checked(raster_begin(&raster, &frame, arena, sizeof arena) == RASTER_OK, "no frame");
}

/* Rows that a meshlet's triangles have in a tile. In: its VISIBLE_* flags. */
static uint32_t count_rows(const struct raster_object *o, const struct scene_meshlet *m, uint32_t flags, uint32_t tile)
{
    struct raster_tile_bound *b = &raster.bounds[tile], kept = *b;
    const int32_t x = (int32_t)(tile % raster.tiles_x), y = (int32_t)(tile / raster.tiles_x);
    const struct raster_tiles one = {x, y, x, y};
    b->least = 0;
    raster_tile_bounds.meshlet(&raster, NULL, o, m, &one, 0, flags, false);
    const uint32_t rows = b->least;
    *b = kept;
    return rows;
}

static bool is_clipped(const struct raster_object *o, const struct scene_meshlet *m)
{
    unsigned any = 0;
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        struct raster_clip_vertex c;
        raster_transform(&c, o, &scene.vertices[m->vertex_first + i]);
        any |= raster_clip_code(o, &c);
    }
    return any;
}

static void draw(uint32_t tile, struct raster_stats *stats, bool print)
{
    for (enum raster_drawing drawing = RASTER_MORE; drawing == RASTER_MORE;) {
        const struct raster_stats before = *stats;
        const uint32_t id = work.meshlet, run = work.run;
        const uint32_t start = clock_now();
        drawing = raster_tile_draw(&raster, &work, 1, stats);
        const uint32_t ticks = clock_now() - start;
        checked(drawing != RASTER_NO_SLOT, "more meshlets than slots");
        if (!print || stats->meshlets == before.meshlets)
            continue;
        const struct raster_object *o = &raster.objects[raster.runs[run - 1].object >> RUN_BITS];
        const struct scene_meshlet *m = &scene.meshlets[VISIBLE_MESHLET(id)];
        report_text(is_clipped(o, m) ? "clip" : "draw");
        report_number("", ticks);
        report_number("", m->vertex_count);
        report_number("", m->triangle_count);
        report_number("", (id & VISIBLE_SMALL) != 0);
        report_number("", stats->triangles - before.triangles);
        report_number("", count_rows(o, m, id, tile));
        report_number("", stats->tested - before.tested);
        report_text("\n");
    }
}

static uint32_t count_pixels(uint32_t *parts)
{
    uint32_t sum = 0;
    *parts = 0;
    for (uint32_t m = 0; m < work.m.shading.survey.classes; m++) {
        sum += work.m.shading.survey.total[m].pixels;
        *parts += work.m.shading.survey.total[m].cells;
    }
    return sum;
}

/* Ticks of shading the regions where something waits, and their blocks. */
static uint32_t shade(const struct raster_survey *s, const struct raster_rect *rect, enum raster_rate rate,
                      uint32_t *blocks, struct raster_stats *stats)
{
    static struct raster_quality q;
    const uint32_t regions = s->regions;
    uint32_t ticks = 0;
    for (uint32_t i = 0; i < RASTER_CLASSES; i++)
        q.rate[i] = (uint8_t)rate;
    q.lights = RASTER_ALL_LIGHTS;
    q.taps = (uint8_t)taps;
    *blocks = 0;
    for (uint32_t region = 0; region < regions; region++) {
        const uint32_t before = *blocks;
        for (uint32_t m = 0; m < s->classes; m++)
            if (s->area[m][region].pixels)
                *blocks += raster_region_blocks(&raster, raster_region_planes(&raster, rect, region), rate);
        if (*blocks == before)
            continue;
        const uint32_t start = clock_now();
        raster_tile_shade(&raster, &work, rect, region, &q, stats);
        ticks += clock_now() - start;
    }
    return ticks;
}

/* Rows' runs of surfaces, and in *of_slots those of one meshlet. */
static uint32_t count_runs(uint32_t *of_slots, const struct raster_rect *rect)
{
    uint32_t runs = 0;
    *of_slots = 0;
    for (uint32_t y = 0; y < rect->height; y++)
        for (uint32_t x = 0; x < rect->width; x++) {
            const struct raster_surface *s = &work.surface[y * RASTER_TILE_WIDTH + x];
            runs += s->depth_slot && (!x || !s[-1].depth_slot);
            *of_slots += s->depth_slot & 255 && (!x || (s->depth_slot ^ s[-1].depth_slot) & 255);
        }
    return runs;
}

static void tile(uint32_t index, enum raster_shading shading, enum raster_rate rate, bool print)
{
    struct raster_rect rect;
    struct raster_stats stats;
    uint32_t blocks, parts, start = clock_now();
    raster_tile_begin(&raster, index, &work, &rect, &stats);
    const uint32_t clear = clock_now() - start;
    draw(index, &stats, print);
    start = clock_now();
    const struct raster_survey *survey = raster_tile_survey(&raster, &work, &rect);
    const uint32_t surveyed = clock_now() - start, pixels = count_pixels(&parts);
    const bool rows = raster_shading_of(&raster, 0, rate) >= RASTER_SHADE_DIFFUSE_ROW;
    const uint32_t ticks = shade(survey, &rect, rate, &blocks, &stats);
    const struct raster_stats shaded = stats;
    uint32_t of_slots;
    const uint32_t runs = count_runs(&of_slots, &rect);
    start = clock_now();
    raster_tile_finish(&raster, &work, &rect, &stats);
    const uint32_t finish = clock_now() - start;
    hash = report_hash(hash, raster_tile_pixels(&work), 3u * rect.width * rect.height);
    if (!measures)
        return;
    if (raster.directional && (taps || tables[0] != &half_vector)) {
        report_text(tables[0] == &bright ? "bright" : tables[0] == &plain ? "texels" : "taps");
        report_number("", ticks);
        report_number("", taps);
        report_number("", shaded.shaded);
        report_text("\n");
        return;
    }
    if (print) {
        report_text("survey");
        report_number("", surveyed);
        report_number("", clear);
        report_number("", raster.frame.light_count);
        report_text("\n");
    }
    if (pixels && !rows) {
        report_text(raster.directional     ? broad ? "broad" : "shade"
                    : broad                ? "point_broad"
                    : tables[0] == &plain  ? "point_texels"
                    : tables[0] == &bright ? "point_bright"
                                           : "point");
        report_number("", ticks);
        report_number("", shading);
        report_number("", rate);
        report_number("", shaded.samples);
        report_number("", shaded.shaded);
        report_number("", shaded.tried - shaded.shaded);
        report_number("", pixels);
        report_number("", parts);
        report_number("", blocks);
        report_text("\n");
    }
    if (tables[0] != &half_vector)
        return;
    report_text("finish");
    report_number("", finish);
    report_number("", stats.covered);
    report_number("", rows ? shading : 0);
    report_number("", rows ? pixels : 0);
    report_number("", rows ? pixels * raster.frame.light_count : 0);
    report_number("", (uint32_t)rect.width * rect.height);
    report_number("", rows ? of_slots : 0);
    report_number("", runs);
    report_text("\n");
}

static uint32_t random_below(uint32_t below)
{
    static uint32_t state = 1;
    state = state * 1664525 + 1013904223;
    return (uint32_t)((uint64_t)state * below >> 32);
}

/* Triangles of all shapes about a tile. */
static void fill_general(void)
{
    struct raster_rect rect;
    struct raster_stats stats;
    struct raster_vertex p[3];
    begin(set_lights(1, 0), 1);
    for (uint32_t n = 0; n < 600; n++) {
        raster_tile_begin(&raster, 0, &work, &rect, &stats);
        const int32_t size = 256 << (4 + n % 6);
        const int32_t x = (int32_t)random_below(RASTER_TILE_WIDTH * 256),
                      y = (int32_t)random_below(RASTER_TILE_HEIGHT * 256);
        for (int i = 0; i < 3; i++)
            p[i] = (struct raster_vertex){x + (int32_t)random_below((uint32_t)size) - size / 2,
                                          y + (int32_t)random_below((uint32_t)size) - size / 2,
                                          1000 + random_below(1 << 22), (int16_t)random_below(1 << 14),
                                          (int16_t)random_below(1 << 14)};
        const int64_t area =
            (int64_t)(p[1].x - p[0].x) * (p[2].y - p[0].y) - (int64_t)(p[1].y - p[0].y) * (p[2].x - p[0].x);
        if (area <= 0)
            continue;
        const uint32_t start = clock_now();
        raster_fill_general(&work, &p[0], &p[1], &p[2], (uint64_t)area, 1, &stats);
        const uint32_t ticks = clock_now() - start;
        const int32_t top = fx_max(fx_min(p[0].y, fx_min(p[1].y, p[2].y)) + 127, 0) >> 8,
                      bottom = fx_min(fx_max(p[0].y, fx_max(p[1].y, p[2].y)) - 128, RASTER_TILE_HEIGHT * 256 - 1) >> 8;
        report_text("general");
        report_number("", ticks);
        report_number("", (uint32_t)fx_max(bottom - top + 1, 0));
        report_number("", stats.tested);
        report_text("\n");
    }
}

_Noreturn void board_main(void)
{
    open_input();
    set_camera(0);
    set_materials(RASTER_SHADE_LAFORTUNE_PHONG);
    if (measures)
        fill_general();
    for (uint32_t c = 0; c < CAMERAS; c++) {
        set_camera(c);
        for (unsigned way = 0; way < RASTER_SHADE_COUNT + 2; way++) {
            static const uint8_t broad_ways[2] = {RASTER_SHADE_LAFORTUNE_PHONG, RASTER_SHADE_BLINN_PHONG};
            broad = way >= RASTER_SHADE_COUNT;
            const unsigned shading = broad ? broad_ways[way - RASTER_SHADE_COUNT] : way;
            set_materials((enum raster_shading)shading);
            for (unsigned rate = 0; rate < RASTER_RATE_COUNT; rate++)
                for (unsigned light = 0; light < 3; light++) {
                    if (shading >= RASTER_SHADE_DIFFUSE_ROW && (rate || light == 2))
                        continue; /* rows are of rate 1x1 under directional lights */
                    if (broad && rate == RASTER_RATE_FLAT)
                        continue;
                    begin(light == 0   ? set_lights(3, 0)
                          : light == 1 ? set_lights(1, 0)
                                       : set_lights(0, 4),
                          !measures && c % 2 ? 4 : 1);
                    const bool print = measures && shading == 0 && rate == 0 && light == 0;
                    const bool table = shading == RASTER_SHADE_HALF_VECTOR, fewer = table && raster.directional;
                    for (uint32_t t = c; t < raster_tile_count(&raster); t += stride) {
                        tile(t, (enum raster_shading)shading, (enum raster_rate)rate, print);
                        for (taps = RASTER_TAPS_4; fewer && taps < RASTER_TAPS_COUNT; taps++)
                            tile(t, (enum raster_shading)shading, (enum raster_rate)rate, false);
                        for (unsigned slow = 0; slow < 2; slow++) {
                            tables[0] = slow ? &bright : &plain;
                            for (taps = RASTER_TAPS_8; table && taps < (fewer ? RASTER_TAPS_COUNT : 1); taps++)
                                tile(t, (enum raster_shading)shading, (enum raster_rate)rate, false);
                        }
                        tables[0] = &half_vector;
                        taps = RASTER_TAPS_8;
                    }
                }
        }
    }
    report_text("end");
    report_hex("hash", hash);
    report_text("\n");
    board_exit(BOARD_EXIT_OK);
}
