#define _GNU_SOURCE /* open_memstream */
#include "gtscene_json.h"

#include "common.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_FILE_BYTES (16u << 20)

static void place_print(FILE *f, const struct node *n)
{
    if (n->parent)
        place_print(f, n->parent);
    if (n->key)
        fprintf(f, "%s%s", n->parent && n->parent->parent ? "." : "", n->key);
    else if (n->parent)
        fprintf(f, "[%d]", n->index);
}

void json_die(const struct node *n, const char *format, ...)
{
    char *place = NULL;
    size_t bytes;
    FILE *f = open_memstream(&place, &bytes);
    if (!f)
        die(EXIT_INTERNAL, "out of memory");
    place_print(f, n);
    fclose(f);
    va_list args;
    va_start(args, format);
    char text[512];
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    die(EXIT_BAD_INPUT, "%s: %s: %s", n->file, *place ? place : "document", text);
}

struct node json_load(const char *path)
{
    size_t bytes;
    const char *text = read_file(path, MAX_FILE_BYTES, &bytes), *end = NULL;
    if (strlen(text) != bytes)
        die(EXIT_BAD_INPUT, "%s: NUL byte at offset %zu; give a JSON text", path, strlen(text));
    cJSON *json = cJSON_ParseWithOpts(text, &end, 1);
    if (!json) {
        int line = 1, column = 1;
        for (const char *c = text; end && c < end; c++) {
            column = *c == '\n' ? 1 : column + 1;
            line += *c == '\n';
        }
        die(EXIT_BAD_INPUT, "%s:%d:%d: not valid JSON; mend it there or just before", path, line, column);
    }
    return (struct node){.json = json, .file = path};
}

static void need_object(const struct node *n)
{
    if (!cJSON_IsObject(n->json))
        json_die(n, "not an object; write { ... }");
}

void json_check_keys(const struct node *n, const char *const *keys)
{
    need_object(n);
    for (const cJSON *c = n->json->child; c; c = c->next) {
        struct node member = {c, n, n->file, c->string, 0};
        const char *const *k = keys;
        while (*k && strcmp(*k, c->string))
            k++;
        if (!*k) {
            char list[256] = "";
            for (k = keys; *k; k++)
                snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", k == keys ? "" : ", ", *k);
            json_die(&member, "unknown key; known here: %s", list);
        }
        for (const cJSON *d = c->next; d; d = d->next)
            if (!strcmp(c->string, d->string))
                json_die(&member, "given twice; remove one");
    }
}

struct node json_get(const struct node *n, const char *key)
{
    need_object(n);
    return (struct node){cJSON_GetObjectItemCaseSensitive(n->json, key), n, n->file, key, 0};
}

struct node json_need(const struct node *n, const char *key)
{
    struct node member = json_get(n, key);
    if (!member.json)
        json_die(&member, "missing; it must be given");
    return member;
}

struct node json_element(const struct node *n, int index)
{
    return (struct node){cJSON_GetArrayItem(n->json, index), n, n->file, NULL, index};
}

int json_count(const struct node *n, int max)
{
    if (!cJSON_IsArray(n->json))
        json_die(n, "not an array; write [ ... ]");
    int count = cJSON_GetArraySize(n->json);
    if (count > max)
        json_die(n, "%d elements, more than the limit of %d", count, max);
    return count;
}

double json_number(const struct node *n, double lo, double hi)
{
    if (!cJSON_IsNumber(n->json))
        json_die(n, "not a number; give one from %g to %g", lo, hi);
    double x = n->json->valuedouble;
    if (!(x >= lo && x <= hi))
        json_die(n, "%g is out of range; give a number from %g to %g", x, lo, hi);
    return x;
}

double json_whole(const struct node *n, double lo, double hi)
{
    double x = json_number(n, lo, hi);
    if (x != floor(x))
        json_die(n, "%g is not a whole number; give one from %g to %g", x, lo, hi);
    return x;
}

const char *json_string(const struct node *n)
{
    if (!cJSON_IsString(n->json))
        json_die(n, "not a string; write \"...\"");
    return n->json->valuestring;
}

void json_vector(double out[3], const struct node *n, double lo, double hi)
{
    if (!cJSON_IsArray(n->json) || cJSON_GetArraySize(n->json) != 3)
        json_die(n, "not three numbers; write [x, y, z]");
    for (int k = 0; k < 3; k++) {
        struct node element = json_element(n, k);
        out[k] = json_number(&element, lo, hi);
    }
}
