/*
 * Reading line-oriented measurement files: comments, numbers, and messages that name the line.
 */
#ifndef HOST_TOOLS_HOST_TEXT_H
#define HOST_TOOLS_HOST_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_measurement.h"

struct text_reader {
    const char *path;
    char *rest;  /* NULL at the end */
    char *token; /* where text_token goes on in the current line; NULL: needs the next one */
    size_t line;
    bool radians; /* the file's angles, for messages */
};

/* Bytes of the UTF-8 byte order mark that the text begins with: 3 or 0. */
size_t text_mark(const uint8_t *data, size_t bytes);

/* Dies with EXIT_BAD_INPUT when there are several lines, but none ends in LF. */
void text_check_line_ends(const char *path, const char *text);

/* In: `data` of `bytes` bytes and a NUL after them, cut up in place. A byte order mark is skipped. Dies with EXIT_BAD_INPUT when there is
 * a NUL within, or no line ends in LF. */
void text_open(struct text_reader *out, const char *path, uint8_t *data, size_t bytes);

/* The next line that is neither empty nor a comment (#), trimmed; NULL at the end. */
char *text_line(struct text_reader *r);

/* The next word of such lines, which end where a blank, tab or comma is; NULL at the end. */
char *text_token(struct text_reader *r);

/* A finite number, or with `any` also nan and inf; dies with EXIT_BAD_INPUT naming the line and `what`. `token` may be NULL: the
 * file ended. */
double text_number(const struct text_reader *r, const char *what, const char *token, bool any);

/* The next word as a whole number from 1 to `max`; dies likewise. */
size_t text_count(struct text_reader *r, const char *what, size_t max);

/* Dies unless the token is that word. */
void text_want(const struct text_reader *r, const char *token, const char *word);

/* The numbers of one line, separated by blanks or commas; dies unless there are exactly `count`. Those from `any_from` on may be
 * nan or inf. */
void text_numbers(double *out, size_t count, size_t any_from, const struct text_reader *r, char *line);

/* True when one of the first 256 lines that are no comments begins with the word. Reads nothing beyond the bytes. */
bool text_begins(const uint8_t *data, size_t bytes, const char *word);

/* Adds a sample given in degrees by incident theta and phi and scattered theta and phi (a theta below 0 is one on the other side of
 * the normal). Dies with EXIT_BAD_INPUT when they are not in the upper hemisphere. */
void text_add(struct measurement *m, const struct text_reader *r, const double angle[4], const double rgb[3]);

#endif
