/*
 * Renders a scene blob through raster.h alone and reports time and memory of one frame.
 *
 *   bench_frame MODEL FRAMES SCENE.blob TABLE.ktx2...
 *
 * MODEL: measured (materials as the scene has them) or lafortune_phong (all of them so shaded); with _aa4 appended, four samples per
 * pixel. Tables fill slots 0, 1, ... in order. 320 x 240, RGB888. Stdout: `ms_per_frame VALUE` (median, processor time) and `arena_bytes VALUE`.
 * Under valgrind --tool=callgrind --toggle-collect=bench_frame only frames count, not the loading.
 */
#define _GNU_SOURCE
#include "common.h"
#include "raster.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { WIDTH = 320, HEIGHT = 240, MAX_FRAMES = 1000 };

/* One frame as a device renders it; the pixels stay in the tile memory. Kept out of line: callgrind finds it by name. */
__attribute__((noinline)) static enum raster_status bench_frame(const struct raster_frame *frame, void *arena,
                                                                size_t arena_bytes, struct raster_tile *work)
{
    struct raster r;
    enum raster_status status = raster_begin(&r, frame, arena, arena_bytes);
    for (uint32_t t = 0; status == RASTER_OK && t < raster_tile_count(&r); t++) {
        struct raster_rect rect;
        struct raster_stats stats;
        raster_render_tile(&r, t, work, &rect, &stats);
    }
    return status;
}

static double milliseconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static int compare_double(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(int argc, char **argv)
{
    common_set_name("bench_frame", NULL);
    if (argc < 4 || argc - 4 > (int)RASTER_MAX_SLOTS)
        die(EXIT_USAGE, "usage: bench_frame measured|lafortune_phong[_aa4] FRAMES SCENE.blob TABLE.ktx2...");
    bool lafortune = !strncmp(argv[1], "lafortune_phong", 15);
    const char *rest = argv[1] + (lafortune ? 15 : 8);
    bool four = !strcmp(rest, "_aa4");
    if ((!lafortune && strncmp(argv[1], "measured", 8)) || (*rest && !four))
        die(EXIT_USAGE, "model: '%s' is neither measured nor lafortune_phong, with or without _aa4", argv[1]);
    int frames = (int)parse_long("FRAMES", argv[2], 1, MAX_FRAMES);

    size_t bytes;
    struct scene scene;
    void *blob = read_file(argv[3], SCENE_MAX_BYTES, &bytes);
    enum scene_status scene_status = scene_open(&scene, blob, bytes);
    if (scene_status != SCENE_OK)
        die(EXIT_BAD_INPUT, "%s: %s; build it with gtscene", argv[3], scene_status_text(scene_status));
    static struct lut_table tables[RASTER_MAX_SLOTS];
    const struct lut_table *slots[RASTER_MAX_SLOTS] = {0};
    for (int i = 4; i < argc; i++) {
        const void *file = read_file(argv[i], 64u << 20, &bytes);
        enum lut_status s = lut_open(&tables[i - 4], file, bytes);
        if (s != LUT_OK)
            die(EXIT_BAD_INPUT, "%s: %s; build it with gtlut", argv[i], lut_status_text(s));
        slots[i - 4] = &tables[i - 4];
    }
    struct scene_material materials[SCENE_MAX_MATERIALS];
    memcpy(materials, scene.materials, scene.header->materials.count * sizeof *materials);
    for (uint32_t i = 0; lafortune && i < scene.header->materials.count; i++)
        materials[i].kind = SCENE_MATERIAL_LAFORTUNE_PHONG;

    struct raster_frame frame = {.parts = &raster_all_parts,
                                 .scene = &scene,
                                 .camera = &scene.header->camera,
                                 .output = &scene.header->output,
                                 .lights = scene.lights,
                                 .materials = materials,
                                 .tables = slots,
                                 .width = WIDTH,
                                 .height = HEIGHT,
                                 .light_count = (uint8_t)scene.header->lights.count,
                                 .format = RASTER_RGB888,
                                 .samples = four ? 4 : 1};
    size_t arena_bytes = raster_arena_bytes(&frame);
    void *arena = xmalloc(arena_bytes);
    static struct raster_tile work;
    static double ms[MAX_FRAMES];
    for (int i = 0; i < frames; i++) {
        double start = milliseconds();
        enum raster_status s = bench_frame(&frame, arena, arena_bytes, &work);
        ms[i] = milliseconds() - start;
        if (s != RASTER_OK)
            die(EXIT_BAD_INPUT, "%s: %s", argv[3], raster_status_text(s));
    }
    qsort(ms, (size_t)frames, sizeof *ms, compare_double);
    printf("ms_per_frame %.3f\narena_bytes %zu\n", ms[frames / 2], arena_bytes);
    return EXIT_OK;
}
