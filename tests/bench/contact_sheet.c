/*
 * Renders scenes side by side, to be looked at.
 *
 *   contact_sheet OUT.png WIDTHxHEIGHT SCENE.blob[:TABLE.ktx2]... [/ SCENE.blob[:TABLE.ktx2]...]...
 *
 * Rows of pictures, a `/` between them; a table fills slot 0. From a row's second picture on, its difference from the first follows it: ten
 * times, around mid-grey. Stdout: per picture its row, column, mean and largest difference in 8-bit steps, and what it shows.
 */
#include "common.h"
#include "host_canvas.h"
#include "host_image.h"
#include "raster.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_CELL = 2048, GAIN = 10 };

struct sheet {
    int cell_width, cell_height, columns, rows;
    uint8_t *rgb;
};

static void cell_put(struct sheet *s, int row, int column, const uint8_t *rgb)
{
    const size_t stride = 3 * (size_t)s->columns * (size_t)s->cell_width;
    uint8_t *out = s->rgb + (size_t)row * (size_t)s->cell_height * stride + 3 * (size_t)column * (size_t)s->cell_width;
    for (int y = 0; y < s->cell_height; y++)
        memcpy(out + (size_t)y * stride, rgb + 3 * y * s->cell_width, 3 * (size_t)s->cell_width);
}

/* `what`: SCENE.blob[:TABLE.ktx2] */
static void picture_render(struct canvas *c, const char *what)
{
    char *path = xstrdup(what), *colon = strchr(path, ':');
    size_t bytes, table_bytes;
    struct scene scene;
    struct lut_table table;
    void *file = NULL;
    if (colon)
        *colon = 0;
    void *blob = read_file(path, SCENE_MAX_BYTES, &bytes);
    enum scene_status status = scene_open(&scene, blob, bytes);
    if (status != SCENE_OK)
        die(EXIT_BAD_INPUT, "%s: %s; build it with gtscene", path, scene_status_text(status));
    if (colon) {
        file = read_file(colon + 1, 64u << 20, &table_bytes);
        enum lut_status opened = lut_open(&table, file, table_bytes);
        if (opened != LUT_OK)
            die(EXIT_BAD_INPUT, "%s: %s; build it with gtlut", colon + 1, lut_status_text(opened));
    }
    const struct lut_table *slots[RASTER_MAX_SLOTS] = {colon ? &table : NULL};
    const struct raster_frame frame = {.parts = &raster_all_parts,
                                       .scene = &scene,
                                       .camera = &scene.header->camera,
                                       .output = &scene.header->output,
                                       .lights = scene.lights,
                                       .materials = scene.materials,
                                       .tables = slots,
                                       .width = c->width,
                                       .height = c->height,
                                       .light_count = (uint8_t)scene.header->lights.count,
                                       .format = RASTER_RGB888,
                                       .samples = 4};
    const size_t arena_bytes = raster_arena_bytes(&frame);
    void *arena = xmalloc(arena_bytes);
    static struct raster r;
    static struct raster_tile work;
    enum raster_status begun = raster_begin(&r, &frame, arena, arena_bytes);
    if (begun != RASTER_OK)
        die(EXIT_BAD_INPUT, "%s: %s", what, raster_status_text(begun));
    for (uint32_t t = 0; t < raster_tile_count(&r); t++) {
        struct raster_rect rect;
        struct raster_stats stats;
        raster_render_tile(&r, t, &work, &rect, &stats);
        canvas_put(c, rect.x, rect.y, rect.width, rect.height, raster_tile_pixels(&work));
    }
    free(arena);
    free(file);
    free(blob);
    free(path);
}

/* Leaves the amplified difference in `rgb`. */
static void difference(uint8_t *rgb, const uint8_t *first, size_t n, double *mean, int *largest)
{
    long sum = 0;
    *largest = 0;
    for (size_t i = 0; i < n; i++) {
        const int d = rgb[i] - first[i], grey = 128 + GAIN * d;
        sum += abs(d);
        *largest = abs(d) > *largest ? abs(d) : *largest;
        rgb[i] = (uint8_t)(grey < 0 ? 0 : grey > 255 ? 255 : grey);
    }
    *mean = (double)sum / (double)n;
}

/* One row's pictures; returns what follows them. */
static char **row_put(struct sheet *s, int row, char **what)
{
    struct canvas first, next;
    const uint16_t width = (uint16_t)s->cell_width, height = (uint16_t)s->cell_height;
    const size_t n = 3 * (size_t)width * height;
    canvas_init(&first, width, height, RASTER_RGB888);
    picture_render(&first, *what);
    cell_put(s, row, 0, first.rgb);
    printf("row %d column 0 %s\n", row, *what);
    int column = 1;
    for (what++; *what && strcmp(*what, "/"); what++, column += 2) {
        double mean;
        int largest;
        canvas_init(&next, width, height, RASTER_RGB888);
        picture_render(&next, *what);
        cell_put(s, row, column, next.rgb);
        difference(next.rgb, first.rgb, n, &mean, &largest);
        cell_put(s, row, column + 1, next.rgb);
        printf("row %d column %d mean %.3f largest %d %s\n", row, column, mean, largest, *what);
        canvas_free(&next);
    }
    canvas_free(&first);
    return *what ? what + 1 : what;
}

int main(int argc, char **argv)
{
    struct sheet s = {.rows = 1};
    common_set_name("contact_sheet", NULL);
    if (argc < 4 || sscanf(argv[2], "%dx%d", &s.cell_width, &s.cell_height) != 2 || s.cell_width < 1 ||
        s.cell_height < 1 || s.cell_width > MOST_CELL || s.cell_height > MOST_CELL)
        die(EXIT_USAGE, "usage: contact_sheet OUT.png WIDTHxHEIGHT SCENE.blob[:TABLE.ktx2]... [/ ...]...");
    for (int i = 3, column = 0; i < argc; i++) {
        const bool next = !strcmp(argv[i], "/");
        s.rows += next;
        column = next ? 0 : column + (column ? 2 : 1);
        s.columns = column > s.columns ? column : s.columns;
    }
    s.rgb = xmalloc(3 * (size_t)s.columns * (size_t)s.cell_width * (size_t)s.rows * (size_t)s.cell_height);
    memset(s.rgb, 0, 3 * (size_t)s.columns * (size_t)s.cell_width * (size_t)s.rows * (size_t)s.cell_height);
    char **what = argv + 3;
    for (int row = 0; row < s.rows && *what; row++)
        what = row_put(&s, row, what);
    image_write_u8(argv[1], s.columns * s.cell_width, s.rows * s.cell_height, 3, s.rgb);
    free(s.rgb);
    return EXIT_OK;
}
