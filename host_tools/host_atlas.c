#include "host_atlas.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "goniotile_version.h"
#include "host_ktx2.h"

#define KEY_BYTES 24 /* 20 are used, so that the value is aligned in the file */

static void key_of(char key[KEY_BYTES], uint32_t index)
{
    snprintf(key, KEY_BYTES, "goniotile.table.%03u", index);
}

uint32_t atlas_columns(uint32_t tables)
{
    return (uint32_t)ceil(sqrt(tables));
}

static size_t texels_of(const struct atlas *a)
{
    return (size_t)a->width * a->height * a->depth;
}

/* A row of a table in the atlas' texture. */
static size_t row_offset(const struct atlas *a, uint32_t index, uint32_t y, uint32_t z)
{
    size_t stride = (size_t)a->columns * a->width, top = ((size_t)z * a->rows + index / a->columns) * a->height;
    return (top + y) * stride + (size_t)(index % a->columns) * a->width;
}

bool atlas_recognise(const void *data, size_t bytes)
{
    struct ktx2_view view;
    uint32_t length;
    if (ktx2_open(&view, data, bytes))
        return false;
    const uint8_t *kind = ktx2_find(&view, "goniotile.kind", &length);
    return kind && length == 5 && !memcmp(kind, "atlas", 5);
}

/* --- reading --- */

/* A decimal number of 1 to 4 digits, or 0. */
static uint32_t number_of(const struct ktx2_view *v, const char *key)
{
    uint32_t length, x = 0;
    const uint8_t *text = ktx2_find(v, key, &length);
    if (!text || length > 4)
        return 0;
    for (uint32_t i = 0; i < length; i++) {
        if (text[i] < '0' || text[i] > '9')
            return 0;
        x = 10 * x + text[i] - '0';
    }
    return x;
}

uint8_t *atlas_table(size_t *bytes, const struct atlas *a, uint32_t index)
{
    char key[KEY_BYTES];
    uint32_t head_bytes;
    key_of(key, index);
    const uint8_t *head = ktx2_find_bytes(&a->view, key, &head_bytes);
    if (!head || head_bytes % 4)
        return NULL;
    *bytes = head_bytes + 4 * texels_of(a);
    uint8_t *file = xmalloc(*bytes), *p = file + head_bytes;
    memcpy(file, head, head_bytes);
    for (uint32_t z = 0; z < a->depth; z++)
        for (uint32_t y = 0; y < a->height; y++, p += 4 * (size_t)a->width)
            memcpy(p, a->view.texels + row_offset(a, index, y, z), 4 * (size_t)a->width);
    return file;
}

static bool tables_alike(const struct lut_table *a, const struct lut_table *b)
{
    return a->kind == b->kind && a->width == b->width && a->height == b->height && a->depth == b->depth &&
           (a->kind == LUT_HALF_VECTOR || (a->slice_scale == b->slice_scale && a->swap == b->swap));
}

/* What is wrong with table i, malloc'd, or NULL. *first is table 0's, filled by its own call. */
static char *table_problem(struct lut_table *first, const struct atlas *a, uint32_t i)
{
    struct lut_table t = {0};
    size_t bytes = 0;
    uint8_t *file = atlas_table(&bytes, a, i);
    enum lut_status status = file ? lut_open(&t, file, bytes) : LUT_ERR_AXES;
    free(file);
    if (status)
        return xasprintf("table %u: %s", i, lut_status_text(status));
    if (!i)
        *first = t;
    return tables_alike(&t, first) && t.width == a->width && t.height == a->height
               ? NULL
               : xasprintf("table %u is not of the atlas' kind and size", i);
}

char *atlas_read(struct atlas *out, const void *data, size_t bytes)
{
    enum lut_status status = ktx2_open(&out->view, data, bytes);
    if (status)
        return xstrdup(lut_status_text(status));
    if (!atlas_recognise(data, bytes))
        return xstrdup("not an atlas");
    if (number_of(&out->view, "goniotile.version") != 1)
        return xstrdup(lut_status_text(LUT_ERR_VERSION));
    out->columns = number_of(&out->view, "goniotile.columns");
    out->tables = number_of(&out->view, "goniotile.tables");
    out->rows = out->columns ? (out->tables + out->columns - 1) / out->columns : 0;
    if (!out->rows || out->tables > ATLAS_MAX_TABLES || out->columns > out->tables || out->view.width % out->columns ||
        out->view.height % out->rows)
        return xasprintf("%u tables in %u columns do not fill %u x %u texels", out->tables, out->columns,
                         out->view.width, out->view.height);
    out->width = out->view.width / out->columns;
    out->height = out->view.height / out->rows;
    out->depth = out->view.depth;
    struct lut_table first = {0};
    char *problem = NULL;
    for (uint32_t i = 0; i < out->tables && !problem; i++)
        problem = table_problem(&first, out, i);
    return problem;
}

void atlas_open(struct atlas *out, const char *path, const void *data, size_t bytes)
{
    char *problem = atlas_read(out, data, bytes);
    if (problem)
        die(EXIT_BAD_INPUT, "%s: %s; make the atlas again with gtlut atlas", path, problem);
}

/* --- writing --- */

static void members_check(struct lut_table *tables, const struct atlas_member *members, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        enum lut_status status = lut_open(&tables[i], members[i].data, members[i].bytes);
        if (status)
            die(EXIT_BAD_INPUT, "%s: %s; build the table again", members[i].path, lut_status_text(status));
        if (!tables_alike(&tables[i], &tables[0]))
            die(EXIT_BAD_INPUT, "%s: not of the same kind, size and angles as %s; build both alike", members[i].path,
                members[0].path);
    }
}

uint8_t *atlas_compose(size_t *bytes, const struct atlas_member *members, uint32_t count)
{
    struct lut_table *tables = xcalloc(count, sizeof *tables);
    struct ktx2_pair *pairs = xcalloc(count + 5, sizeof *pairs);
    char(*keys)[KEY_BYTES] = xcalloc(count, sizeof *keys);
    members_check(tables, members, count);
    struct atlas a = {.columns = atlas_columns(count),
                      .tables = count,
                      .width = tables->width,
                      .height = tables->height,
                      .depth = tables->depth};
    a.rows = (count + a.columns - 1) / a.columns;
    const uint32_t width = a.columns * a.width, height = a.rows * a.height;
    if (count > ATLAS_MAX_TABLES || width > KTX2_MAX_EXTENT || height > KTX2_MAX_EXTENT ||
        (size_t)width * height * a.depth > KTX2_MAX_TEXELS)
        die(EXIT_USAGE, "%u tables make %u x %u x %u texels, at most %u a side and %u in all fit; give fewer", count,
            width, height, a.depth, KTX2_MAX_EXTENT, KTX2_MAX_TEXELS);
    uint32_t *texels = xcalloc((size_t)width * height * a.depth, sizeof *texels);
    char *columns = xasprintf("%u", a.columns), *number = xasprintf("%u", count);
    pairs[0] = (struct ktx2_pair){"KTXwriter", "Goniotile gtlut " GONIOTILE_VERSION, 0};
    pairs[1] = (struct ktx2_pair){"goniotile.columns", columns, 0};
    pairs[2] = (struct ktx2_pair){"goniotile.kind", "atlas", 0};
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t *from = tables[i].texels;
        for (uint32_t z = 0; z < a.depth; z++)
            for (uint32_t y = 0; y < a.height; y++, from += a.width)
                memcpy(texels + row_offset(&a, i, y, z), from, 4 * (size_t)a.width);
        key_of(keys[i], i);
        pairs[3 + i] = (struct ktx2_pair){keys[i], members[i].data, members[i].bytes - 4 * texels_of(&a)};
    }
    pairs[3 + count] = (struct ktx2_pair){"goniotile.tables", number, 0};
    pairs[4 + count] = (struct ktx2_pair){"goniotile.version", "1", 0};
    uint8_t *file = ktx2_compose(bytes, texels, width, height, a.depth, pairs, count + 5);
    free(columns);
    free(number);
    free(texels);
    free(keys);
    free(pairs);
    free(tables);
    return file;
}
