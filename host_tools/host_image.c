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

void image_write_u8(const char *path, int width, int height, int channels, const uint8_t *pixels)
{
    /* The union turns dlsym's object pointer into a function pointer, which ISO C has no cast for. */
    union {
        void *object;
        oiio_write_u8_fn *function;
    } write = {shim_symbol("oiio_write_image_u8")};
    char err[512] = "";
    char *temporary = output_begin(path);
    if (write.function(temporary, width, height, channels, pixels, err, sizeof err))
        die(EXIT_FILE, "%s: %s; give a writable .png path", path, err);
    output_commit(temporary, path);
}

void image_write_float(const char *path, int width, int height, int channels, const float *pixels)
{
    union {
        void *object;
        oiio_write_float_fn *function;
    } write = {shim_symbol("oiio_write_image")};
    char err[512] = "";
    char *temporary = output_begin(path);
    if (write.function(temporary, width, height, channels, pixels, err, sizeof err))
        die(EXIT_FILE, "%s: %s; give a writable .exr path", path, err);
    output_commit(temporary, path);
}

float *image_read_rgb(int *width, int *height, const char *path)
{
    union {
        void *object;
        oiio_read_fn *function;
    } read = {shim_symbol("oiio_read_image")};
    char err[512] = "";
    float *rgb;
    if (access(path, R_OK))
        die(EXIT_FILE, "%s: %s; give a readable image file", path, strerror(errno));
    if (read.function(path, (size_t)1 << 25, width, height, &rgb, err, sizeof err)) {
        err[strcspn(err, "\n")] = 0;
        die(EXIT_BAD_INPUT, "%s: %s; give an intact image", path, err);
    }
    return rgb;
}
