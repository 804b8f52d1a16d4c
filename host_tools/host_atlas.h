/*
 * An atlas (Cezner and Havran 2024, 4.2): the tables of several materials in one 3-D texture. Every slice is a grid of cells, row by row;
 * cell i of slice z holds slice z of table i. All tables are of one kind and size. The file is a KTX 2.0 file like a table's
 * (SPEC.md, "Atlas file"); it keeps what stands before each table's texels, so that tables come out as they went in, to the byte.
 */
#ifndef HOST_TOOLS_HOST_ATLAS_H
#define HOST_TOOLS_HOST_ATLAS_H

#include <stdbool.h>

#include "lut.h"

enum { ATLAS_MAX_TABLES = 1000 };
#define ATLAS_MAX_BYTES ((size_t)1 << 28)

struct atlas {
    struct ktx2_view view;
    uint32_t columns, rows, tables;
    uint32_t width, height, depth; /* of a table */
};

/* The grid that `tables` cells are laid out in: as many columns as rows, or one more. */
uint32_t atlas_columns(uint32_t tables);

/* True for an intact KTX 2.0 file that says it is an atlas. */
bool atlas_recognise(const void *data, size_t bytes);

/* Checks the file and all tables in it. Its bytes stay the caller's, 4-aligned, and must outlive the atlas. NULL, or what is wrong,
 * malloc'd. */
char *atlas_read(struct atlas *out, const void *data, size_t bytes);

/* The same. Dies with EXIT_BAD_INPUT. */
void atlas_open(struct atlas *out, const char *path, const void *data, size_t bytes);

/* The table file number `index`, malloc'd; never NULL once the atlas is open. */
uint8_t *atlas_table(size_t *bytes, const struct atlas *a, uint32_t index);

struct atlas_member {
    const char *path; /* for messages */
    const uint8_t *data;
    size_t bytes;
};

/* The atlas file, malloc'd, of table files. Dies with EXIT_BAD_INPUT when one is none or unlike the first, with EXIT_USAGE when they are
 * too many for one texture. */
uint8_t *atlas_compose(size_t *bytes, const struct atlas_member *members, uint32_t count);

#endif
