/*
 * Strict reading of a JSON document: every mistake ends the program with the file, the place in the document
 * ("objects[2].position"), the value and the limit.
 */
#ifndef GTSCENE_JSON_H
#define GTSCENE_JSON_H

#include <cjson/cJSON.h>
#include <stdbool.h>

/* A value and how it was reached; parents live on the callers' stacks. */
struct node {
    const cJSON *json; /* NULL: absent */
    const struct node *parent;
    const char *file; /* of the whole document */
    const char *key;  /* or NULL: an element */
    int index;
};

/* Parses a whole file. The tree stays allocated until the program ends. */
struct node json_load(const char *path);

/* Dies with EXIT_BAD_INPUT and "<file>: <place>: <message>". */
_Noreturn void json_die(const struct node *n, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Dies unless n is an object whose keys all appear, once, in `keys` (NULL at the end). */
void json_check_keys(const struct node *n, const char *const *keys);

/* A member of an object, or an element of an array. json is NULL when there is none; json_need dies then. */
struct node json_get(const struct node *n, const char *key);
struct node json_need(const struct node *n, const char *key);
struct node json_element(const struct node *n, int index);

/* Number of elements; dies unless it is an array of at most `max`. */
int json_count(const struct node *n, int max);

double json_number(const struct node *n, double lo, double hi);
double json_whole(const struct node *n, double lo, double hi);
const char *json_string(const struct node *n);
void json_vector(double out[3], const struct node *n, double lo, double hi);

#endif
