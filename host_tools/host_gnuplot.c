#define _GNU_SOURCE
#include "host_gnuplot.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

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

enum { CANNOT_START = 127, MAX_MESSAGE = 300 };

/* In the child: drawing and messages go to memory. */
static _Noreturn void become_gnuplot(const struct gnuplot *g, int commands)
{
    setenv("LC_ALL", "C.UTF-8", 1);
    if (dup2(commands, 0) >= 0 && dup2(g->drawing, 1) >= 0 && dup2(g->messages, 2) >= 0)
        execlp("gnuplot", "gnuplot", (char *)NULL);
    _exit(CANNOT_START);
}

static void start(struct gnuplot *g)
{
    int pipe_ends[2];
    g->drawing = memfd_create("drawing", MFD_CLOEXEC);
    g->messages = memfd_create("messages", MFD_CLOEXEC);
    if (g->drawing < 0 || g->messages < 0 || pipe2(pipe_ends, O_CLOEXEC) || (g->pid = fork()) < 0)
        die(EXIT_INTERNAL, "%s: gnuplot cannot be started: %s", g->path, strerror(errno));
    if (!g->pid)
        become_gnuplot(g, pipe_ends[0]);
    close(pipe_ends[0]);
    signal(SIGPIPE, SIG_IGN);
    g->to = fdopen(pipe_ends[1], "w");
    if (!g->to)
        die(EXIT_INTERNAL, "%s: gnuplot cannot be started: %s", g->path, strerror(errno));
}

void gnuplot_begin(struct gnuplot *g, const char *path, int width, int height)
{
    g->path = xstrdup(path);
    start(g);
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
    fputs("set encoding utf8\n", g->to);
}

/* Line ends and indents of what gnuplot says become single blanks, and all of it one line of limited length. */
static void one_line(char *message)
{
    char *to = message;
    for (const char *from = message; *from && to - message < MAX_MESSAGE; from++)
        if (!strchr(" \n", *from))
            *to++ = *from;
        else if (to > message && to[-1] != ' ')
            *to++ = ' ';
    *to = 0;
}

/* All of a file in memory, with a NUL behind it. */
static char *contents(size_t *bytes, int fd)
{
    off_t end = lseek(fd, 0, SEEK_END);
    char *data = xmalloc((size_t)(end > 0 ? end : 0) + 1);
    ssize_t n = end > 0 ? pread(fd, data, (size_t)end, 0) : 0;
    *bytes = n > 0 ? (size_t)n : 0;
    data[*bytes] = 0;
    close(fd);
    return data;
}

/* Both kinds of file have an end that nothing but a whole one has. */
static bool is_whole(const char *path, const char *drawing, size_t bytes)
{
    static const char svg[] = "</svg>", png[] = "IEND\xae\x42\x60\x82";
    const char *end = ends_in(path, ".svg") ? svg : png;
    while (end == svg && bytes && strchr(" \r\n", drawing[bytes - 1]))
        bytes--;
    return bytes > strlen(end) && !memcmp(drawing + bytes - strlen(end), end, strlen(end));
}

void gnuplot_end(struct gnuplot *g)
{
    int status = 0;
    size_t bytes, message_bytes;
    fputs("\nunset output\n", g->to); /* the end of the file is written now */
    fclose(g->to);
    while (waitpid(g->pid, &status, 0) < 0 && errno == EINTR)
        ;
    char *drawing = contents(&bytes, g->drawing), *message = contents(&message_bytes, g->messages);
    one_line(message);
    if (WIFEXITED(status) && WEXITSTATUS(status) == CANNOT_START)
        die(EXIT_FILE, "%s: gnuplot cannot be started; install gnuplot-nox", g->path);
    if (status)
        die(EXIT_FILE, "%s: gnuplot failed with status %d: %s; it may be another version", g->path, status, message);
    if (!is_whole(g->path, drawing, bytes))
        die(EXIT_FILE, "%s: gnuplot's drawing has no end after %zu bytes; is there memory enough? %s", g->path, bytes,
            message);
    if (*message)
        warn("%s: gnuplot says: %s", g->path, message);
    write_file(g->path, drawing, bytes);
    free(drawing);
    free(message);
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
