#include "gtlut_json.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

static bool comma;
static int depth;

static void put_text(const char *text, size_t bytes)
{
    putchar('"');
    for (size_t i = 0; i < bytes && text[i]; i++) {
        if (text[i] == '"' || text[i] == '\\')
            putchar('\\');
        putchar(text[i] >= ' ' && text[i] < 0x7f ? text[i] : '?');
    }
    putchar('"');
}

static void begin(const char *key)
{
    if (comma)
        fputs(", ", stdout);
    if (key)
        printf("\"%s\": ", key);
    comma = true;
}

void json_open(const char *key, char bracket)
{
    begin(key);
    putchar(bracket);
    comma = false;
    depth++;
}

void json_close(char bracket)
{
    putchar(bracket);
    comma = true;
    if (--depth == 0) {
        putchar('\n');
        comma = false;
    }
}

void json_number(const char *key, double value)
{
    begin(key);
    if (isfinite(value))
        printf("%.6g", value);
    else
        fputs("null", stdout);
}

void json_integer(const char *key, size_t value)
{
    begin(key);
    printf("%zu", value);
}

void json_numbers(const char *key, const double *values, size_t count)
{
    json_open(key, '[');
    for (size_t i = 0; i < count; i++)
        json_number(NULL, values[i]);
    json_close(']');
}

void json_string(const char *key, const char *text, size_t bytes)
{
    begin(key);
    put_text(text, bytes);
}
