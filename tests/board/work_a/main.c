/*
 * Renders the scene blob at board_input through raster.h alone, 320 x 240 in RGB565, and prints the instructions of
 * one frame: raster_begin and all tiles, without loading, checking the blob or moving the finished tiles.
 */
#include "board.h"
#include "raster.h"

enum { WIDTH = 320, HEIGHT = 240, ARENA_BYTES = 64 * 1024 };

static struct raster raster;
static struct raster_tile work;
static uint64_t arena[ARENA_BYTES / 8];

/* Out of line, so that the clock's readings stay around it. */
__attribute__((noinline)) static enum raster_status frame_render(const struct raster_frame *f, bool keep)
{
    enum raster_status status = raster_begin(&raster, f, arena, sizeof arena);
    for (uint32_t t = 0; status == RASTER_OK && t < raster_tile_count(&raster); t++) {
        struct raster_rect r;
        struct raster_stats stats;
        raster_render_tile(&raster, t, &work, &r, &stats);
        if (keep)
            report_tile(r.x, r.y, r.width, r.height, raster_tile_pixels(&work), WIDTH, 2);
    }
    return status;
}

_Noreturn void board_main(void)
{
    static struct scene scene;
    static const struct lut_table *const no_tables[RASTER_MAX_SLOTS];
    const struct scene_header *h = (const struct scene_header *)(const void *)board_input;
    enum scene_status opened = scene_open(&scene, board_input, h->total_bytes);
    if (opened != SCENE_OK)
        report_failure(scene_status_text(opened));
    struct raster_frame frame = {.parts = &raster_all_parts,
                                 .scene = &scene,
                                 .camera = &h->camera,
                                 .output = &h->output,
                                 .lights = scene.lights,
                                 .materials = scene.materials,
                                 .tables = no_tables,
                                 .width = WIDTH,
                                 .height = HEIGHT,
                                 .light_count = (uint8_t)h->lights.count,
                                 .format = RASTER_RGB565};
    enum raster_status status = frame_render(&frame, true);
    uint32_t start = board_clock();
    frame_render(&frame, false);
    uint32_t instructions = board_clock() - start;
    if (status != RASTER_OK)
        report_failure(raster_status_text(status));
    report_text("frame");
    report_hex("hash", report_hash(REPORT_HASH_START, board_picture, WIDTH * HEIGHT * 2));
    report_number("instructions", instructions);
    report_number("arena", (uint32_t)raster.arena_needed);
    report_number("stack", report_stack());
    report_text("\n");
    board_exit(BOARD_EXIT_OK);
}
