#include "host_gnuplot.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common.h"

static bool ends_in(const char *path, const char *extension)
{
    const char *dot = strrchr(path, '.');
    return dot && !strcmp(dot, extension);
}

bool gnuplot_draws(const char *path)
{
    return ends_in(path, ".svg") || ends_in(path, ".png");
}

void gnuplot_begin(struct gnuplot *g, const char *path, int width, int height)
{
    g->path = xstrdup(path);
    g->temporary = output_begin(path);
    FILE *f = fopen(g->temporary, "w");
    if (!f)
        die(EXIT_FILE, "%s: %s; is its folder there and writable?", path, strerror(errno));
    fclose(f);
    signal(SIGPIPE, SIG_IGN);
    g->to = popen("LC_ALL=C.UTF-8 gnuplot 2>&1 >/dev/null | head -c 300 >&2", "w");
    if (!g->to)
        die(EXIT_FILE, "%s: %s; is gnuplot installed?", path, strerror(errno));
    /* Fonts are in pixels in one, in points of 1/96 inch in the other. */
    if (ends_in(path, ".svg"))
        fprintf(g->to,
                "set terminal svg size %d,%d font 'Helvetica,13' background '#ffffff'\nbig = ',16'\nsmall = ',10'\n",
                width, height);
    else
        fprintf(
            g->to,
            "set terminal pngcairo size %d,%d font 'Helvetica,9.5' background '#ffffff'\nbig = ',12'\nsmall = ',7.5'\n",
            width, height);
    fputs("set encoding utf8\nset output ", g->to);
    gnuplot_text(g, g->temporary);
    fputc('\n', g->to);
}

void gnuplot_end(struct gnuplot *g)
{
    struct stat st;
    if (pclose(g->to) || stat(g->temporary, &st) || !st.st_size)
        die(EXIT_FILE, "%s: gnuplot wrote nothing; install gnuplot-nox", g->path);
    output_commit(g->temporary, g->path);
    free(g->path);
}

void gnuplot_text(struct gnuplot *g, const char *text)
{
    fputc('\'', g->to);
    for (; *text; text++)
        fputs((char[]){*text, *text == '\'' ? '\'' : 0, 0}, g->to);
    fputc('\'', g->to);
}

void gnuplot_picture(struct gnuplot *g, int width, int height, int channels, double x0, double x1, double y0, double y1)
{
    double dx = (x1 - x0) / width, dy = fabs(y1 - y0) / height;
    fprintf(g->to, "'-' binary array=(%d,%d) dx=%.9g dy=%.9g origin=(%.9g,%.9g) format='%%uchar' %s with %s notitle",
            width, height, dx, dy, x0 + dx / 2, fmin(y0, y1) + dy / 2, y0 < y1 ? "flipy" : "",
            channels == 4 ? "rgbalpha" : "rgbimage");
}

void gnuplot_pixels(struct gnuplot *g, int width, int height, int channels, const uint8_t *pixels)
{
    fwrite(pixels, (size_t)channels, (size_t)width * (size_t)height, g->to);
}
