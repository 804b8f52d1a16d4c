/*
 * One importer, FORMAT, through the registry, and the resampling of what it reads: the file is read, or the tool ends with the exit code
 * for a bad input.
 */
#include "fuzz.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <unistd.h>

#include "common.h"
#include "host_image.h"
#include "host_import.h"
#include "host_resample.h"

/* die() calls exit(), which comes here (ld's --wrap): back to the harness. What the importer held then is freed from a list that malloc
 * and its like keep. */
enum { BLOCKS = 4096 };
static jmp_buf died;
static int exit_code;
static bool running;
static void *blocks[BLOCKS];
static size_t block_count;

_Noreturn void __real_exit(int code);
_Noreturn void __wrap_exit(int code);
void *__real_malloc(size_t bytes);
void *__wrap_malloc(size_t bytes);
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__real_realloc(void *p, size_t bytes);
void *__wrap_realloc(void *p, size_t bytes);
int __real_vasprintf(char **out, const char *format, va_list args);
int __wrap_vasprintf(char **out, const char *format, va_list args);
void __real_free(void *p);
void __wrap_free(void *p);

void __wrap_exit(int code)
{
    if (!running)
        __real_exit(code);
    exit_code = code;
    longjmp(died, 1);
}

static void *block_note(void *p)
{
    if (p && running && block_count < BLOCKS)
        blocks[block_count++] = p;
    return p;
}

static void block_forget(void *p)
{
    for (size_t i = running ? block_count : 0; i > 0; i--)
        if (blocks[i - 1] == p) {
            blocks[i - 1] = blocks[--block_count];
            return;
        }
}

void *__wrap_malloc(size_t bytes)
{
    return block_note(__real_malloc(bytes));
}

void *__wrap_calloc(size_t count, size_t size)
{
    return block_note(__real_calloc(count, size));
}

void *__wrap_realloc(void *p, size_t bytes)
{
    block_forget(p);
    return block_note(__real_realloc(p, bytes));
}

int __wrap_vasprintf(char **out, const char *format, va_list args)
{
    int n = __real_vasprintf(out, format, args);
    if (n >= 0)
        block_note(*out);
    return n;
}

void __wrap_free(void *p)
{
    block_forget(p);
    __real_free(p);
}

/* In OpenImageIO's place, whose own decoding is not what is tried here: the image that a composite's input describes behind the magic
 * of OpenEXR by axes, columns, theta_max, how far off its sides are, and the bytes of its pixels, which repeat. */
static struct {
    int width, height;
    const uint8_t *pixels;
    size_t bytes;
} image;

static void image_describe(struct import_options *o, const uint8_t *data, size_t bytes)
{
    struct input in = {data, bytes};
    const uint8_t *skipped;
    input_bytes(&skipped, &in, 4);
    o->width = 2 + input_byte(&in) % 16u;
    o->height = 2 + input_byte(&in) % 16u;
    o->depth = 1 + input_byte(&in) % 16u;
    unsigned columns = 1 + input_byte(&in) % 16u, rows = (o->depth + columns - 1) / columns;
    o->theta_max = 0.1 + 89.9 / 255 * input_byte(&in);
    image.width = (int)(columns * o->width) + (input_byte(&in) + 1) % 16 - 1; /* one less to 14 more */
    image.height = (int)(rows * o->height) + (input_byte(&in) + 1) % 16 - 1;
    image.bytes = input_bytes(&image.pixels, &in, in.left);
}

float *__wrap_image_read_rgb(int *width, int *height, const char *path, bool linear);
float *__wrap_image_read_rgb(int *width, int *height, const char *path, bool linear)
{
    size_t bytes = 3 * sizeof(float) * (size_t)image.width * (size_t)image.height;
    uint8_t *rgb = xmalloc(bytes + 1);
    (void)path;
    (void)linear;
    for (size_t i = 0; i < bytes; i++)
        rgb[i] = image.bytes ? image.pixels[i % image.bytes] : 0;
    *width = image.width;
    *height = image.height;
    return (float *)(void *)rgb;
}

/* What no random change makes right: a file's length, its checksum. Returns the file and a NUL. */
static uint8_t *file_complete(size_t *bytes, const uint8_t *data, size_t given)
{
    size_t merl = !strcmp(FORMAT, "merl") && given > 12 ? 12 + (size_t)3 * 8 * 90 * 90 * 180 : given;
    uint8_t *file = xmalloc(merl + 1);
    memcpy(file, data, given);
    for (size_t have = given; have < merl;) { /* the values repeat */
        size_t n = have - 12 < merl - have ? have - 12 : merl - have;
        memcpy(file + have, file + 12, n);
        have += n;
    }
    if (!strcmp(FORMAT, "gtm") && given >= 88 && file[20] == 0) {
        uint32_t crc = ~0u;
        for (size_t i = 16; i < given; i++) {
            crc ^= file[i];
            for (int bit = 0; bit < 8; bit++)
                crc = crc >> 1 ^ (0xedb88320u & -(crc & 1));
        }
        crc = ~crc;
        memcpy(file + 12, &crc, sizeof crc);
    }
    file[merl] = 0;
    *bytes = merl;
    return file;
}

static char named_file[64];

static void import(const uint8_t *data, size_t given)
{
    static const struct measurement_geometry geometry = {"fuzz", 40, 1, 0};
    struct import_options options = {.geometry = &geometry, .theta_max = 60, .raw = given & 1};
    const struct import_format *format = import_format_find(FORMAT);
    struct measurement m, grid;
    size_t bytes;
    uint8_t *file = file_complete(&bytes, data, given);
    if (!format->load) { /* a name in a file */
        FILE *f = fopen(named_file, "wb");
        CLAIM(f && fwrite(file, 1, bytes, f) == bytes && !fclose(f));
        char *path = xasprintf("%s:seed", named_file);
        import_read(&m, path, &options);
        free(path);
    } else if (format->recognise(file, bytes)) {
        if (!strcmp(FORMAT, "composite"))
            image_describe(&options, data, given);
        import_load(&m, format, "file", file, bytes, &options);
        char *problem = options.raw ? NULL : measurement_grid_problem(&m);
        if (problem) {
            measurement_resample(&grid, &m, &geometry);
            measurement_free(&grid);
        }
        free(problem);
    } else {
        free(file);
        return;
    }
    measurement_free(&m);
    free(file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes)
{
    snprintf(named_file, sizeof named_file, "/tmp/goniotile_fuzz_%ld.csv", (long)getpid());
    running = true;
    if (!setjmp(died))
        import(data, bytes);
    else
        CLAIM(exit_code == EXIT_BAD_INPUT);
    running = false;
    unlink(named_file);
    while (block_count)
        __real_free(blocks[--block_count]);
    return 0;
}
