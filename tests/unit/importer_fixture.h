/*
 * What the tests of the importers share: running a reader that may die, and files in every format made from one analytic BRDF.
 */
#ifndef TESTS_UNIT_IMPORTER_FIXTURE_H
#define TESTS_UNIT_IMPORTER_FIXTURE_H

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common.h"

struct bytes {
    uint8_t *data;
    size_t count;
};

static char child_message[4096];

/* Skips the leak check at the child's end: what it holds when it dies is no leak. */
static inline void leave(int status, void *unused)
{
    (void)unused;
    _exit(status);
}

/* Runs `read` on the bytes in a child process; returns its exit code and keeps what it said on stderr in child_message. */
static inline int exit_code_of(void (*read)(const struct bytes *), const struct bytes *b)
{
    static FILE *said;
    if (!said)
        said = tmpfile();
    assert_non_null(said);
    assert_int_equal(ftruncate(fileno(said), 0), 0);
    rewind(said);
    fflush(NULL);
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        on_exit(leave, NULL);
        dup2(fileno(said), 2);
        common_set_name("test", NULL);
        read(b);
        _exit(0);
    }
    int status;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    rewind(said);
    child_message[fread(child_message, 1, sizeof child_message - 1, said)] = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

/* Reading ends with EXIT_BAD_INPUT and the message. */
static inline void dies_reading(void (*read)(const struct bytes *), const struct bytes *b, const char *message)
{
    int code = exit_code_of(read, b);
    if (code != EXIT_BAD_INPUT || !strstr(child_message, message))
        fail_msg("exit code %d, want %d and '%s'; said: %s", code, EXIT_BAD_INPUT, message, child_message);
}

/* A copy with exactly `count` bytes (and csv_parse's NUL), so that the sanitizer sees any access beyond. */
static inline void *copy_of(const struct bytes *b, bool with_nul)
{
    uint8_t *copy = xmalloc(b->count + with_nul);
    memcpy(copy, b->data, b->count);
    if (with_nul)
        copy[b->count] = 0;
    return copy;
}

__attribute__((format(printf, 2, 3))) static inline void put_text(struct bytes *b, const char *format, ...)
{
    va_list args;
    b->data = xrealloc(b->data, b->count + 512); /* one line at most */
    va_start(args, format);
    b->count += (size_t)vsnprintf((char *)b->data + b->count, 512, format, args);
    va_end(args);
}

static const double fixture_pi = 3.14159265358979323846;

/* A reciprocal BRDF with a broad lobe around the mirror direction over a diffuse base; angles in degrees. */
static inline double fixture_brdf(double theta_in, double theta_out, double phi)
{
    double a = theta_in * fixture_pi / 180, b = theta_out * fixture_pi / 180, p = phi * fixture_pi / 180;
    double h[3] = {sin(a) + sin(b) * cos(p), sin(b) * sin(p), cos(a) + cos(b)};
    double c2 = h[2] * h[2] / (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    return 0.1 + 0.8 * pow(c2, 4);
}

enum { SCATTERED = 900 };

/* Directions spread over the hemisphere by the golden angle, as gonioreflectometers with free axes give them. */
static inline void fixture_spread(double *theta, double *phi, int i, double theta_max)
{
    double low = cos(theta_max * fixture_pi / 180), z = 1 - (1 - low) * (i + 0.5) / SCATTERED;
    *theta = acos(z) * 180 / fixture_pi;
    *phi = fmod(i * 137.50776405, 360);
}

#endif
