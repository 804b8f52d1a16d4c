/* A scene blob: validation, and a small picture of what opens, in little memory. */
#include "fuzz.h"
#include "raster.h"

enum { WIDTH = 16, HEIGHT = 16, ARENA = 4096 };

static const uint32_t texels[8] = {0x80402010, 0x80402010, 0x80402010, 0x80402010,
                                   0x80402010, 0x80402010, 0x80402010, 0x80402010};
static const struct lut_table table = {
    .kind = LUT_SPECULAR_FRAME, .texels = texels, .width = 2, .height = 2, .depth = 1};

static void render(const struct scene *s, uint8_t samples)
{
    const struct lut_table *const tables[RASTER_MAX_SLOTS] = {&table};
    struct raster_frame f = {.parts = &raster_all_parts,
                             .scene = s,
                             .camera = &s->header->camera,
                             .output = &s->header->output,
                             .lights = s->lights,
                             .materials = s->materials,
                             .tables = tables,
                             .width = WIDTH,
                             .height = HEIGHT,
                             .samples = samples,
                             .light_count = (uint8_t)s->header->lights.count,
                             .format = RASTER_RGB888};
    struct raster r;
    void *arena = malloc(ARENA);
    struct raster_tile *work = malloc(sizeof *work);
    CLAIM(arena && work);
    enum raster_status status = raster_begin(&r, &f, arena, ARENA);
    uint32_t pixels = 0;
    for (uint32_t t = 0; status == RASTER_OK && t < raster_tile_count(&r); t++) {
        struct raster_rect rect;
        struct raster_stats stats;
        raster_render_tile(&r, t, work, &rect, &stats);
        pixels += (uint32_t)rect.width * rect.height;
    }
    CLAIM(status != RASTER_ERR_SIZE && (status != RASTER_OK || pixels == WIDTH * HEIGHT));
    free(work);
    free(arena);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes)
{
    struct scene s;
    void *blob = exact_copy(data, bytes);
    if (scene_open(&s, blob, bytes) == SCENE_OK)
        render(&s, s.header->output.background[0] & 1 ? 4 : 1);
    free(blob);
    return 0;
}
