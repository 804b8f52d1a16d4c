// OpenImageIO behind a C interface: see oiio_shim.h. The only C++ in the tree.
#include "oiio_shim.h"

#include <OpenImageIO/imageio.h>

#include <cstdio>
#include <exception>
#include <memory>
#include <string>

namespace
{

int fail(char *err, size_t err_bytes, const std::string &message)
{
    std::snprintf(err, err_bytes, "%s", message.empty() ? "unknown OpenImageIO error" : message.c_str());
    return -1;
}

int write(const char *path, int width, int height, int channels, OIIO::TypeDesc type, const void *pixels,
          const char *colour_space, char *err, size_t err_bytes)
{
    // Exceptions must not cross the C interface.
    try {
        std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create(path);
        if (!out)
            return fail(err, err_bytes, OIIO::geterror());
        OIIO::ImageSpec spec(width, height, channels, type);
        spec.attribute("oiio:ColorSpace", colour_space);
        if (!out->open(path, spec) || !out->write_image(type, pixels) || !out->close())
            return fail(err, err_bytes, out->geterror());
    } catch (const std::exception &e) {
        return fail(err, err_bytes, e.what());
    }
    return 0;
}

} // namespace

extern "C" int oiio_write_image(const char *path, int width, int height, int channels, const float *pixels, char *err,
                                size_t err_bytes)
{
    return write(path, width, height, channels, OIIO::TypeDesc::FLOAT, pixels, "Linear", err, err_bytes);
}

extern "C" int oiio_write_image_u8(const char *path, int width, int height, int channels, const uint8_t *pixels,
                                   char *err, size_t err_bytes)
{
    return write(path, width, height, channels, OIIO::TypeDesc::UINT8, pixels, "sRGB", err, err_bytes);
}
