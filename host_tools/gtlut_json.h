/*
 * JSON on stdout, member by member: the comma is put where it belongs.
 */
#ifndef HOST_TOOLS_GTLUT_JSON_H
#define HOST_TOOLS_GTLUT_JSON_H

#include <stddef.h>

/* `key` is NULL for the outermost value and for elements of an array. */
void json_open(const char *key, char bracket);   /* { or [ */
void json_close(char bracket);                   /* } or ]; the outermost ends the line */
void json_number(const char *key, double value); /* null when not finite */
void json_integer(const char *key, size_t value);
void json_numbers(const char *key, const double *values, size_t count);

/* At most `bytes` bytes, up to a NUL; what is not printable ASCII becomes '?'. */
void json_string(const char *key, const char *text, size_t bytes);

#endif
