/*
 * What every host program shares: exit codes, messages, whole-file input and atomic output, option parsing helpers.
 */
#ifndef HOST_TOOLS_COMMON_H
#define HOST_TOOLS_COMMON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum exit_code {
    EXIT_OK = 0,
    EXIT_INTERNAL = 1,
    EXIT_USAGE = 2,
    EXIT_FILE = 3,      /* file I/O */
    EXIT_BAD_INPUT = 4, /* bad input file */
    EXIT_NO_DEVICE = 5,
    EXIT_SEVERAL = 6, /* several devices match */
    EXIT_PERMISSION = 7,
    EXIT_USB = 8,       /* USB transfer failed */
    EXIT_REFUSED = 9,   /* the device refused */
    EXIT_MISMATCH = 10, /* verification found a difference */
    EXIT_WANTING = 11,  /* checked and found wanting */
    EXIT_INTERRUPTED = 130
};

/* Program and subcommand for messages: set by main ("gtlut", "build"). At its end the program fails with EXIT_FILE when stdout could
 * not be written. */
void common_set_name(const char *program, const char *subcommand);

/* Prints "program: subcommand: <message>\n" to stderr and exits with `code`. The message says what, where (value and limit)
 * and, after a semicolon, what to do. Temporary files of open atomic outputs are removed. */
_Noreturn void die(enum exit_code code, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Does the work and returns true; false when it died of a file (EXIT_FILE, EXIT_BAD_INPUT), which has said why. What the work held then
 * is not freed. On one thread, not within another. */
bool survives(void (*work)(void *ctx), void *ctx);

/* Same form, goes on. */
void warn(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Allocation that dies with EXIT_INTERNAL when memory is out. */
void *xmalloc(size_t bytes);
void *xcalloc(size_t count, size_t size);
void *xrealloc(void *p, size_t bytes);
char *xstrdup(const char *s);
char *xasprintf(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Whole file, malloc'd (aligned for any type, one NUL after the end). Dies with EXIT_FILE, or EXIT_BAD_INPUT when longer
 * than max_bytes. "-" reads stdin. */
void *read_file(const char *path, size_t max_bytes, size_t *bytes);

/* For a file that a library reads: write_file refuses to replace it, as it does what read_file has read. */
void input_remember(const char *path);

/* Writes to a temporary name beside `path` and renames it: readers see the old file or the whole new one; where `path` is a link,
 * the file it leads to. A device or a pipe is written directly, "-" is stdout. Dies with EXIT_FILE; with EXIT_USAGE when `path` is an
 * input. SIGINT, SIGTERM and SIGHUP remove the temporary file, too. */
void write_file(const char *path, const void *data, size_t bytes);

/* True when the whole text is a number in decimal; nan and inf are. */
bool decimal(const char *text, double *x);

/* Strict numbers for options: whole string, decimal, finite, within [lo, hi]; dies with EXIT_USAGE naming the option and its range. */
double parse_double(const char *option, const char *text, double lo, double hi);
long parse_long(const char *option, const char *text, long lo, long hi);

/* A progress line on stderr ("push: 43 %, 450 of 1045 KB, 6.1 MB/s, 0 s left"), only when stderr is a terminal; call with
 * done == total to finish. */
void progress(const char *what, uint64_t done, uint64_t total);

#endif
