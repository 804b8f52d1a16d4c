/* What gtlut preview takes (gtlut_preview.h). */
#include "gtlut_preview.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common.h"
#include "gtlut_import.h"
#include "host_rgl.h"

#define MAX_FILE_BYTES ((size_t)1 << 30)

/* The last part of a path, or what a table of fits calls it. */
static char *title_of(const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *colon = strrchr(name, ':');
    return xstrdup(colon && colon[1] ? colon + 1 : name);
}

static void open_samples(struct preview *out, const char *path, const struct import_options *options)
{
    struct measurement m;
    struct measurement_grid grid;
    import_read(&m, path, options);
    gtlut_import_grid(&m, options, path);
    measurement_grid_make(&out->samples, &m, path);
    measurement_grid_make(&grid, &m, path);
    source_from_grid(&out->source, &grid, m.source);
    measurement_free(&m);
}

void preview_input_open(struct preview_input *out, const char *path, const struct import_options *options)
{
    struct stat st;
    const char *colon = strrchr(path, ':');
    memset(out, 0, sizeof *out);
    out->preview.title = title_of(path);
    if (colon && stat(path, &st)) {
        source_open(&out->preview.source, path);
        return;
    }
    size_t bytes;
    uint8_t *data = read_file(path, MAX_FILE_BYTES, &bytes);
    if (table_recognise(data, bytes)) {
        void *copy = xmalloc(bytes + 1);
        memcpy(copy, data, bytes);
        out->is_table = true;
        table_open(&out->table, path, copy, bytes);
        source_from_table(&out->preview.source, path, data, bytes);
        return;
    }
    bool is_rgl = rgl_recognise(data, bytes);
    free(data);
    if (is_rgl)
        source_open(&out->preview.source, path);
    else
        open_samples(&out->preview, path, options);
}

void preview_input_close(struct preview_input *in)
{
    preview_free(&in->preview);
    if (in->is_table)
        table_close(&in->table);
}

/* --- many --- */

static bool is_table_of_fits(const char *path)
{
    static const char start[] = "material,rhoD_r,";
    char line[sizeof start] = "";
    FILE *f = fopen(path, "r");
    if (!f)
        return false;
    bool is = fgets(line, sizeof line, f) && !strcmp(line, start);
    fclose(f);
    return is;
}

static void list_add(char ***paths, size_t *count, char *path)
{
    *paths = xrealloc(*paths, (*count + 1) * sizeof **paths);
    (*paths)[(*count)++] = path;
}

static void list_fits(char ***paths, size_t *count, const char *path)
{
    char(*names)[64];
    size_t fits = source_fit_names(&names, path);
    for (size_t i = 0; i < fits; i++)
        list_add(paths, count, xasprintf("%s:%s", path, names[i]));
    free(names);
}

/* By its name: other files may stand beside. */
static int may_be_material(const struct dirent *entry)
{
    static const char *const extensions[] = {".ktx2", ".gtm", ".csv", ".bsdf", ".binary", ".brdf", ".astm"};
    const char *dot = strrchr(entry->d_name, '.');
    for (size_t i = 0; dot && dot > entry->d_name && i < sizeof extensions / sizeof *extensions; i++)
        if (!strcmp(dot, extensions[i]))
            return 1;
    return 0;
}

size_t preview_input_list(char ***paths, const char *path)
{
    struct stat st;
    size_t count = 0;
    *paths = NULL;
    if (is_table_of_fits(path)) {
        list_fits(paths, &count, path);
        if (!count)
            die(EXIT_BAD_INPUT, "%s: holds no materials; the file is truncated", path);
    } else if (!stat(path, &st) && S_ISDIR(st.st_mode)) {
        struct dirent **entries;
        int n = scandir(path, &entries, may_be_material, alphasort);
        if (n < 0)
            die(EXIT_FILE, "%s: %s; give a readable folder", path, strerror(errno));
        for (int i = 0; i < n; i++) {
            char *file = xasprintf("%s/%s", path, entries[i]->d_name);
            if (is_table_of_fits(file)) {
                list_fits(paths, &count, file);
                free(file);
            } else {
                list_add(paths, &count, file);
            }
            free(entries[i]);
        }
        free(entries);
        if (!count)
            die(EXIT_BAD_INPUT, "%s: no file in it is named as a table or measurement; see gtlut formats", path);
    }
    return count;
}
