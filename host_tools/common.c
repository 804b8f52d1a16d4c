#define _GNU_SOURCE
#include "common.h"

#include <errno.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static const char *program_name = "goniotile", *subcommand_name = "";
static bool dying;                    /* with a message */
static jmp_buf *survivor;             /* where a death by a file leads, or NULL */
static char *volatile pending_output; /* temporary file to remove when the program dies */

/* The files that were read last, which no output may replace. */
enum { MAX_INPUTS = 1024 };
static struct {
    dev_t device;
    ino_t inode;
} inputs[MAX_INPUTS];
static size_t input_count;

/* What was printed must have arrived, whoever printed it and ended the program. */
static void check_stdout(void)
{
    if (!dying && (fflush(stdout) || ferror(stdout))) {
        fprintf(stderr, "%s: standard output: cannot be written; is its disk full?\n", program_name);
        _exit(EXIT_FILE);
    }
}

void common_set_name(const char *program, const char *subcommand)
{
    static bool known;
    if (!known)
        atexit(check_stdout);
    known = true;
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
    if (survivor && (code == EXIT_FILE || code == EXIT_BAD_INPUT))
        longjmp(*survivor, 1);
    if (pending_output)
        unlink(pending_output);
    dying = code != EXIT_OK;
    exit((int)code);
}

bool survives(void (*work)(void *ctx), void *ctx)
{
    jmp_buf here;
    survivor = &here;
    bool died = setjmp(here) != 0;
    if (!died)
        work(ctx);
    survivor = NULL;
    return !died;
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

static void remember_input(const struct stat *st)
{
    if (!S_ISREG(st->st_mode))
        return;
    size_t i = input_count++ % MAX_INPUTS;
    inputs[i].device = st->st_dev;
    inputs[i].inode = st->st_ino;
}

void input_remember(const char *path)
{
    struct stat st;
    if (!stat(path, &st))
        remember_input(&st);
}

static bool is_input(const struct stat *st)
{
    for (size_t i = 0; i < input_count && i < MAX_INPUTS; i++)
        if (inputs[i].device == st->st_dev && inputs[i].inode == st->st_ino)
            return true;
    return false;
}

void *read_file(const char *path, size_t max_bytes, size_t *bytes)
{
    struct stat st;
    FILE *f = strcmp(path, "-") ? fopen(path, "rb") : stdin;
    if (!f)
        die(EXIT_FILE, "%s: %s; give a readable file", path, strerror(errno));
    if (!fstat(fileno(f), &st))
        remember_input(&st);
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

/* --- output --- */

static const int deadly[] = {SIGINT, SIGTERM, SIGHUP};
enum { DEADLY = sizeof deadly / sizeof *deadly };

/* The signal strikes again, by its default action, when this returns (SA_RESETHAND). */
static void remove_pending(int signal_number)
{
    if (pending_output)
        unlink(pending_output);
    raise(signal_number);
}

/* Whoever handles such a signal, or was started with it ignored, goes on with the write. */
static void guard(struct sigaction old[DEADLY])
{
    struct sigaction remove = {.sa_handler = remove_pending, .sa_flags = SA_RESETHAND};
    sigemptyset(&remove.sa_mask);
    for (int i = 0; i < DEADLY; i++)
        if (!sigaction(deadly[i], NULL, &old[i]) && old[i].sa_handler == SIG_DFL)
            sigaction(deadly[i], &remove, NULL);
}

static void unguard(const struct sigaction old[DEADLY])
{
    for (int i = 0; i < DEADLY; i++)
        sigaction(deadly[i], &old[i], NULL);
}

/* Writes and closes; stdout is flushed, it may be written to again. What is to be renamed is on the disk first. */
static void write_all(FILE *f, const char *path, const void *data, size_t bytes)
{
    if (!f)
        die(EXIT_FILE, "%s: %s; is its folder there and writable?", path, strerror(errno));
    if (fwrite(data, 1, bytes, f) != bytes || fflush(f) || (pending_output && fsync(fileno(f))) ||
        (f != stdout && fclose(f)))
        die(EXIT_FILE, "%s: %s while writing", path, strerror(errno));
}

static void replace_file(const char *path, const char *target, const void *data, size_t bytes)
{
    struct sigaction old[DEADLY];
    const char *slash = strrchr(target, '/'), *base = slash ? slash + 1 : target;
    char *t = xasprintf("%.*s.%ld.tmp.%.200s", (int)(base - target), target, (long)getpid(), base);
    guard(old);
    pending_output = t;
    write_all(fopen(t, "wb"), path, data, bytes);
    if (rename(t, target))
        die(EXIT_FILE, "%s: %s; is its folder writable?", path, strerror(errno));
    pending_output = NULL;
    unguard(old);
    free(t);
}

void write_file(const char *path, const void *data, size_t bytes)
{
    struct stat st;
    if (!strcmp(path, "-")) {
        write_all(stdout, path, data, bytes);
        return;
    }
    bool is_there = !stat(path, &st);
    if (is_there && (S_ISCHR(st.st_mode) || S_ISFIFO(st.st_mode))) {
        write_all(fopen(path, "wb"), path, data, bytes);
        return;
    }
    if (is_there && !S_ISREG(st.st_mode))
        die(EXIT_FILE, "%s: %s; give the name of a file", path, S_ISDIR(st.st_mode) ? strerror(EISDIR) : "no file");
    if (is_there && is_input(&st))
        die(EXIT_USAGE, "%s: is the input, too; give the output (-o) another name", path);
    /* The file that a link leads to is replaced, not the link. */
    char *target = NULL;
    if (!lstat(path, &st) && S_ISLNK(st.st_mode) && !(target = realpath(path, NULL)))
        die(EXIT_FILE, "%s: a link that leads nowhere (%s); remove it", path, strerror(errno));
    replace_file(path, target ? target : path, data, bytes);
    free(target);
}

bool decimal(const char *text, double *x)
{
    char *end;
    *x = strtod(text, &end);
    return end != text && !*end && !strpbrk(text, "xX");
}

double parse_double(const char *option, const char *text, double lo, double hi)
{
    double x;
    if (!decimal(text, &x) || !isfinite(x) || x < lo || x > hi)
        die(EXIT_USAGE, "%s: '%s' is not a number from %g to %g", option, text, lo, hi);
    return x;
}

long parse_long(const char *option, const char *text, long lo, long hi)
{
    char *end;
    errno = 0;
    long x = strtol(text, &end, 10);
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
