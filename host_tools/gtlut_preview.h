/*
 * Opening whatever gtlut preview takes, and the picture of slices, which needs the file's inside.
 */
#ifndef HOST_TOOLS_GTLUT_PREVIEW_H
#define HOST_TOOLS_GTLUT_PREVIEW_H

#include "gtlut_table.h"
#include "host_import.h"
#include "host_preview.h"

struct preview_input {
    struct preview preview;
    bool is_table;
    struct table_file table; /* when it is one */
};

/* Any table or measurement, or FILE.csv:NAME. Dies with EXIT_FILE or EXIT_BAD_INPUT. */
void preview_input_open(struct preview_input *out, const char *path, const struct import_options *options);
void preview_input_close(struct preview_input *in);

/* The materials of a folder or of a table of fits, sorted in a folder: paths for preview_input_open. Returns their number, at least 1;
 * 0 when `path` is neither. Dies with EXIT_FILE or EXIT_BAD_INPUT. */
size_t preview_input_list(char ***paths, const char *path);

/* Every slice as a picture: of a table its texels, of a measurement its samples. Dies with EXIT_USAGE when it is neither. */
void preview_slices(const struct preview_input *in, const char *path);

#endif
