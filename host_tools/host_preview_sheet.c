/* A contact sheet (host_preview.h). */
#include "host_preview_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

enum { GAP = 14, LABEL = 22, HEAD = 12, FOOT = 40, MIN_CELL = 134, MIN_WIDTH = 560, MAX_SIDE = 16000 };

void preview_sheet(bool (*open)(struct preview *out, const void *ctx, size_t i), const void *ctx, size_t count,
                   const struct preview_view *view, const char *path)
{
    int cell = (int)fmax(view->size + GAP, MIN_CELL), tall = view->size + GAP + LABEL, n = (int)count;
    int columns = (int)ceil(sqrt(1.4 * n * tall / cell)), rows;
    columns = columns > n ? n : columns;
    rows = (n + columns - 1) / columns;
    /* The legend below needs a width, too. */
    int width = (int)fmax(columns * cell, MIN_WIDTH), left = (width - columns * cell) / 2, height = rows * tall;
    int placed = 0;
    if (width > MAX_SIDE || height > MAX_SIDE)
        die(EXIT_USAGE, "a sheet of %d x %d pixels is larger than %d; give a smaller --size or fewer materials", width,
            height, MAX_SIDE);
    uint8_t *rgb = xmalloc(3 * (size_t)width * (size_t)height);
    char **titles = xmalloc(count * sizeof *titles);
    unsigned marks = 0;
    memset(rgb, 255, 3 * (size_t)width * (size_t)height);
    for (int i = 0; i < n; i++) {
        struct preview p;
        struct preview_image image;
        progress("preview", (uint64_t)i + 1, count);
        if (!open(&p, ctx, (size_t)i))
            continue;
        preview_render(&image, &p, view, false);
        marks |= preview_place(rgb, width, left + placed % columns * cell + (cell - image.width) / 2,
                               placed / columns * tall + view->size + GAP - image.height, &image, view);
        titles[placed++] = xstrdup(p.title);
        preview_image_free(&image);
        preview_free(&p);
    }
    if (!placed)
        die(EXIT_BAD_INPUT, "none of %d materials can be read; see gtlut formats", n);
    height = (placed + columns - 1) / columns * tall;
    struct gnuplot g;
    gnuplot_begin(&g, path, width, height + HEAD + FOOT);
    fprintf(g.to,
            "set lmargin at screen 0\nset rmargin at screen 1\nset bmargin at screen %.9g\nset tmargin at screen %.9g\n"
            "unset border\nunset tics\nunset key\nset xrange [0:%d]\nset yrange [0:%d]\n",
            (double)FOOT / (height + HEAD + FOOT), 1 - (double)HEAD / (height + HEAD + FOOT), width, height);
    preview_legend(&g, marks);
    for (int i = 0; i < placed; i++) {
        fprintf(g.to, "set label %d ", 10 + i);
        gnuplot_text(&g, titles[i]);
        fprintf(g.to, " at %d,%d center noenhanced font small front\n", left + i % columns * cell + cell / 2,
                height - (i / columns + 1) * tall + LABEL / 2 - 2);
        free(titles[i]);
    }
    fputs("plot ", g.to);
    gnuplot_picture(&g, width, height, 3, 0, width, 0, height);
    fputc('\n', g.to);
    gnuplot_pixels(&g, width, height, 3, rgb);
    gnuplot_end(&g);
    free(titles);
    free(rgb);
}
