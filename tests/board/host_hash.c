/*
 * Renders a scene blob through raster.h and prints the hash the emulated boards print: FNV-1a, 32 bits, over the pixels row by row.
 *
 *   host_hash WIDTH HEIGHT rgb565|rgb888 [-o PIXELS] SCENE.blob [TABLE.ktx2...]
 *
 * Tables fill slots 0, 1, ... in order; -o keeps the pixels. Compiled together with lut/ and raster/ by each compiler and at each level
 * that has to agree.
 */
#include "raster.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static _Noreturn void fail(const char *what, const char *why)
{
    fprintf(stderr, "host_hash: %s: %s\n", what, why);
    exit(1);
}

static void *file_read(const char *path, size_t *bytes)
{
    FILE *f = fopen(path, "rb");
    long end = f && !fseek(f, 0, SEEK_END) ? ftell(f) : -1;
    void *data = end > 0 ? malloc((size_t)end) : NULL;
    if (!data || fseek(f, 0, SEEK_SET) || fread(data, 1, (size_t)end, f) != (size_t)end)
        fail(path, "cannot be read");
    fclose(f);
    *bytes = (size_t)end;
    return data;
}

static uint8_t *picture_render(const struct raster_frame *f, size_t pixel_bytes)
{
    static struct raster r;
    static struct raster_tile work;
    size_t row_bytes = f->width * pixel_bytes, arena_bytes = raster_arena_bytes(f);
    uint8_t *picture = malloc(row_bytes * f->height);
    void *arena = malloc(arena_bytes);
    if (!picture || !arena)
        fail("picture", "memory is out");
    enum raster_status status = raster_begin(&r, f, arena, arena_bytes);
    if (status != RASTER_OK)
        fail("frame", raster_status_text(status));
    for (uint32_t t = 0; t < raster_tile_count(&r); t++) {
        struct raster_rect rect;
        struct raster_stats stats;
        raster_render_tile(&r, t, &work, &rect, &stats);
        for (size_t y = 0; y < rect.height; y++)
            memcpy(picture + (rect.y + y) * row_bytes + rect.x * pixel_bytes,
                   raster_tile_pixels(&work) + y * rect.width * pixel_bytes, rect.width * pixel_bytes);
    }
    free(arena);
    return picture;
}

int main(int argc, char **argv)
{
    static struct lut_table tables[RASTER_MAX_SLOTS];
    static void *files[RASTER_MAX_SLOTS];
    const struct lut_table *slots[RASTER_MAX_SLOTS] = {0};
    struct scene scene;
    const char *output = argc > 5 && !strcmp(argv[4], "-o") ? argv[5] : NULL;
    int first = output ? 6 : 4;
    if (argc <= first || argc - first - 1 > (int)RASTER_MAX_SLOTS)
        fail("usage", "host_hash WIDTH HEIGHT rgb565|rgb888 [-o PIXELS] SCENE.blob [TABLE.ktx2...]");
    size_t bytes, pixel_bytes = strcmp(argv[3], "rgb565") ? 3 : 2;
    void *blob = file_read(argv[first], &bytes);
    enum scene_status status = scene_open(&scene, blob, bytes);
    if (status != SCENE_OK)
        fail(argv[first], scene_status_text(status));
    for (int i = first + 1; i < argc; i++) {
        struct lut_table *table = &tables[i - first - 1];
        void *file = files[i - first - 1] = file_read(argv[i], &bytes);
        enum lut_status opened = lut_open(table, file, bytes);
        if (opened != LUT_OK)
            fail(argv[i], lut_status_text(opened));
        slots[i - first - 1] = table;
    }
    struct raster_frame frame = {.parts = &raster_all_parts,
                                 .scene = &scene,
                                 .camera = &scene.header->camera,
                                 .output = &scene.header->output,
                                 .lights = scene.lights,
                                 .materials = scene.materials,
                                 .tables = slots,
                                 .width = (uint16_t)atoi(argv[1]),
                                 .height = (uint16_t)atoi(argv[2]),
                                 .light_count = (uint8_t)scene.header->lights.count,
                                 .format = pixel_bytes == 2 ? RASTER_RGB565 : RASTER_RGB888};
    uint8_t *picture = picture_render(&frame, pixel_bytes);
    size_t total = (size_t)frame.width * frame.height * pixel_bytes;
    uint32_t hash = 2166136261u;
    for (size_t i = 0; i < total; i++)
        hash = (hash ^ picture[i]) * 16777619u;
    printf("frame hash %08x\n", hash);
    if (output) {
        FILE *f = fopen(output, "wb");
        if (!f || fwrite(picture, 1, total, f) != total || fclose(f))
            fail(output, "cannot be written");
    }
    for (size_t i = 0; i < RASTER_MAX_SLOTS; i++)
        free(files[i]);
    free(picture);
    free(blob);
    return 0;
}
