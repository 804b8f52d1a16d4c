/*
 * Drawing a page with gnuplot: commands go down a pipe, the file is complete or not there.
 */
#ifndef HOST_TOOLS_HOST_GNUPLOT_H
#define HOST_TOOLS_HOST_GNUPLOT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

struct gnuplot {
    FILE *to; /* commands */
    char *path;
    int pid, drawing, messages; /* the latter two are files in memory */
};

/* True when the path ends in .svg or .png. */
bool gnuplot_draws(const char *path);

/* A page of that many pixels; `path` is what gnuplot_draws. Sets the variables `big` and `small` to fonts. Dies with EXIT_FILE. */
void gnuplot_begin(struct gnuplot *g, const char *path, int width, int height);

/* Writes the file. Dies with EXIT_FILE when gnuplot is missing or has failed, saying what gnuplot says, or when what it drew has no
 * end. */
void gnuplot_end(struct gnuplot *g);

/* A text in single quotes. */
void gnuplot_text(struct gnuplot *g, const char *text);

/* A plot command's part for a picture of `channels` bytes a pixel (3 RGB, 4 RGBA), top row first, over x0..x1 and, from its lower edge
 * to its upper one, y0..y1; y0 > y1 on an axis that points downwards. The bytes follow the whole command, by gnuplot_pixels, in the
 * order of the parts. */
void gnuplot_picture(struct gnuplot *g, int width, int height, int channels, double x0, double x1, double y0,
                     double y1);
void gnuplot_pixels(struct gnuplot *g, int width, int height, int channels, const uint8_t *pixels);

#endif
