#define _GNU_SOURCE
#include "common.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const char *program_name = "goniotile", *subcommand_name = "";
static char *pending_output; /* temporary file to remove when the program dies */

void common_set_name(const char *program, const char *subcommand)
{
    program_name = program;
    subcommand_name = subcommand ? subcommand : "";
}

static void message(const char *format, va_list args)
{
    fflush(stdout);
    fprintf(stderr, "%s: %s%s", program_name, subcommand_name, *subcommand_name ? ": " : "");
    vfprintf(stderr, format, args);
    fputc('\n', stderr);
}

void warn(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    message(format, args);
    va_end(args);
}

void die(enum exit_code code, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    message(format, args);
    va_end(args);
    if (pending_output)
        unlink(pending_output);
    exit((int)code);
}

void *xrealloc(void *p, size_t bytes)
{
    void *q = realloc(p, bytes ? bytes : 1);
    if (!q)
        die(EXIT_INTERNAL, "out of memory: %zu bytes wanted", bytes);
    return q;
}

void *xmalloc(size_t bytes)
{
    return xrealloc(NULL, bytes);
}

void *xcalloc(size_t count, size_t size)
{
    void *p = calloc(count ? count : 1, size ? size : 1);
    if (!p)
        die(EXIT_INTERNAL, "out of memory: %zu x %zu bytes wanted", count, size);
    return p;
}

char *xstrdup(const char *s)
{
    size_t n = strlen(s) + 1;
    return memcpy(xmalloc(n), s, n);
}

char *xasprintf(const char *format, ...)
{
    char *s;
    va_list args;
    va_start(args, format);
    if (vasprintf(&s, format, args) < 0)
        die(EXIT_INTERNAL, "out of memory");
    va_end(args);
    return s;
}

void *read_file(const char *path, size_t max_bytes, size_t *bytes)
{
    FILE *f = strcmp(path, "-") ? fopen(path, "rb") : stdin;
    if (!f)
        die(EXIT_FILE, "%s: %s; give a readable file", path, strerror(errno));
    size_t used = 0, room = 1 << 16;
    char *data = xmalloc(room + 1);
    for (;;) {
        size_t n = fread(data + used, 1, room - used, f);
        used += n;
        if (used > max_bytes)
            die(EXIT_BAD_INPUT, "%s: longer than the limit of %zu bytes; is it the right file?", path, max_bytes);
        if (used < room)
            break;
        room *= 2;
        data = xrealloc(data, room + 1);
    }
    if (ferror(f))
        die(EXIT_FILE, "%s: %s while reading", path, strerror(errno));
    if (f != stdin)
        fclose(f);
    data[used] = 0;
    *bytes = used;
    return data;
}

char *output_begin(const char *path)
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path, *dot = strrchr(base, '.');
    char *t = xasprintf("%.*s.%ld.tmp.%s%s", (int)(base - path), path, (long)getpid(), base, dot ? "" : ".tmp");
    pending_output = t;
    return t;
}

void output_commit(char *temporary, const char *path)
{
    if (rename(temporary, path))
        die(EXIT_FILE, "%s: %s; is its folder writable?", path, strerror(errno));
    pending_output = NULL;
    free(temporary);
}

void write_file(const char *path, const void *data, size_t bytes)
{
    bool to_stdout = !strcmp(path, "-");
    char *t = to_stdout ? NULL : output_begin(path);
    FILE *f = to_stdout ? stdout : fopen(t, "wb");
    if (!f)
        die(EXIT_FILE, "%s: %s; is its folder there and writable?", path, strerror(errno));
    if (fwrite(data, 1, bytes, f) != bytes || fflush(f) || (!to_stdout && (fsync(fileno(f)) || fclose(f))))
        die(EXIT_FILE, "%s: %s while writing", path, strerror(errno));
    if (!to_stdout)
        output_commit(t, path);
}

double parse_double(const char *option, const char *text, double lo, double hi)
{
    char *end;
    double x = strtod(text, &end);
    if (end == text || *end || !isfinite(x) || x < lo || x > hi)
        die(EXIT_USAGE, "%s: '%s' is not a number from %g to %g", option, text, lo, hi);
    return x;
}

long parse_long(const char *option, const char *text, long lo, long hi)
{
    char *end;
    errno = 0;
    long x = strtol(text, &end, 0);
    if (end == text || *end || errno || x < lo || x > hi)
        die(EXIT_USAGE, "%s: '%s' is not a whole number from %ld to %ld", option, text, lo, hi);
    return x;
}

void progress(const char *what, uint64_t done, uint64_t total)
{
    static struct timespec start, last;
    static bool running;
    if (!isatty(2))
        return;
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    if (!running) {
        start = last = now;
        running = true;
    }
    double since = (double)(now.tv_sec - last.tv_sec) + 1e-9 * (double)(now.tv_nsec - last.tv_nsec);
    if (done < total && since < 0.1)
        return;
    last = now;
    double t = (double)(now.tv_sec - start.tv_sec) + 1e-9 * (double)(now.tv_nsec - start.tv_nsec);
    double rate = t > 0 ? (double)done / t : 0;
    fprintf(stderr, "\r%s: %3.0f %%, %.0f of %.0f KB, %.2f MB/s, %.0f s left  ", what,
            total ? 100.0 * (double)done / (double)total : 100.0, (double)done / 1e3, (double)total / 1e3, rate / 1e6,
            rate > 0 ? (double)(total - done) / rate : 0);
    if (done >= total) {
        fputc('\n', stderr);
        running = false;
    }
}
