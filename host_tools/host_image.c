#define _GNU_SOURCE
#include "host_image.h"

#include <dlfcn.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common.h"
#include "oiio_shim.h"

static void *shim_symbol(const char *name)
{
    static void *shim;
    if (!shim) {
        char exe[4096];
        ssize_t n = readlink("/proc/self/exe", exe, sizeof exe - 1);
        if (n < 0)
            die(EXIT_FILE, "/proc/self/exe: cannot be read, so goniotile_oiio.so is not found; mount /proc");
        exe[n] = 0;
        *strrchr(exe, '/') = 0;
        char *beside = xasprintf("%s/goniotile_oiio.so", exe);
        char *installed = xasprintf("%s/../lib/goniotile/goniotile_oiio.so", exe);
        const char *found = access(beside, R_OK) ? installed : beside;
        shim = dlopen(found, RTLD_NOW | RTLD_LOCAL);
        if (!shim)
            die(EXIT_FILE, "images need OpenImageIO: %s; run `make` (or install libopenimageio)", dlerror());
        free(beside);
        free(installed);
    }
    void *symbol = dlsym(shim, name);
    if (!symbol)
        die(EXIT_FILE, "goniotile_oiio.so: %s; it is of another version: run `make`", dlerror());
    return symbol;
}

void image_need(const char *path, const char *extension)
{
    const char *dot = strrchr(path, '.');
    if (!dot || strcmp(dot, extension))
        die(EXIT_USAGE, "%s: the picture's name does not end in %s, the only format; rename it", path, extension);
}

static void image_write(const char *path, const char *extension, const char *encoder, int width, int height,
                        int channels, const void *pixels)
{
    /* The union turns dlsym's object pointer into a function pointer, which ISO C has no cast for. */
    union {
        void *object;
        oiio_encode_fn *function;
    } encode = {shim_symbol(encoder)};
    char err[512] = "";
    unsigned char *file;
    size_t bytes;
    image_need(path, extension);
    if (encode.function(&file, &bytes, width, height, channels, pixels, err, sizeof err))
        die(EXIT_FILE, "%s: %s; give a smaller picture", path, err);
    write_file(path, file, bytes);
    free(file);
}

void image_write_u8(const char *path, int width, int height, int channels, const uint8_t *pixels)
{
    image_write(path, ".png", "oiio_encode_png", width, height, channels, pixels);
}

void image_write_float(const char *path, int width, int height, int channels, const float *pixels)
{
    image_write(path, ".exr", "oiio_encode_exr", width, height, channels, pixels);
}

float *image_read_rgb(int *width, int *height, const char *path, bool linear)
{
    union {
        void *object;
        oiio_read_fn *function;
    } read = {shim_symbol("oiio_read_image")};
    char err[512] = "";
    float *rgb;
    if (access(path, R_OK))
        die(EXIT_FILE, "%s: %s; give a readable image file", path, strerror(errno));
    input_remember(path);
    if (read.function(path, linear, (size_t)1 << 25, width, height, &rgb, err, sizeof err)) {
        err[strcspn(err, "\n")] = 0;
        die(EXIT_BAD_INPUT, "%s: %s; give an intact image", path, err);
    }
    return rgb;
}
