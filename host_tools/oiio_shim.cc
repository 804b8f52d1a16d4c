// OpenImageIO behind a C interface: see oiio_shim.h. The only C++ in the tree.
#include "oiio_shim.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
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

// Into memory: OpenImageIO's PNG writer does not tell when a file could not be written.
int encode(unsigned char **file, size_t *bytes, const char *format, int width, int height, int channels,
           OIIO::TypeDesc type, const void *pixels, const char *colour_space, char *err, size_t err_bytes)
{
    // Exceptions must not cross the C interface.
    try {
        std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create(format);
        if (!out)
            return fail(err, err_bytes, OIIO::geterror());
        OIIO::ImageSpec spec(width, height, channels, type);
        spec.attribute("oiio:ColorSpace", colour_space);
        OIIO::Filesystem::IOVecOutput memory;
        if (!out->set_ioproxy(&memory) || !out->open(std::string("picture.") + format, spec) ||
            !out->write_image(type, pixels) || !out->close())
            return fail(err, err_bytes, out->geterror());
        *bytes = memory.buffer().size();
        *file = static_cast<unsigned char *>(std::malloc(*bytes + 1));
        if (!*file)
            return fail(err, err_bytes, "out of memory");
        std::copy(memory.buffer().begin(), memory.buffer().end(), *file);
    } catch (const std::exception &e) {
        return fail(err, err_bytes, e.what());
    }
    return 0;
}

} // namespace

extern "C" int oiio_encode_exr(unsigned char **file, size_t *bytes, int width, int height, int channels,
                               const void *pixels, char *err, size_t err_bytes)
{
    return encode(file, bytes, "exr", width, height, channels, OIIO::TypeDesc::FLOAT, pixels, "Linear", err, err_bytes);
}

extern "C" int oiio_encode_png(unsigned char **file, size_t *bytes, int width, int height, int channels,
                               const void *pixels, char *err, size_t err_bytes)
{
    return encode(file, bytes, "png", width, height, channels, OIIO::TypeDesc::UINT8, pixels, "sRGB", err, err_bytes);
}

extern "C" int oiio_read_image(const char *path, int linear, size_t max_pixels, int *width, int *height, float **rgb,
                               char *err, size_t err_bytes)
{
    try {
        std::unique_ptr<OIIO::ImageInput> in = OIIO::ImageInput::open(path);
        if (!in)
            return fail(err, err_bytes, OIIO::geterror());
        const OIIO::ImageSpec &spec = in->spec();
        size_t pixels = spec.width > 0 && spec.height > 0 ? size_t(spec.width) * size_t(spec.height) : 0;
        if (!pixels || pixels > max_pixels || spec.nchannels < 1 || spec.nchannels > 4 || spec.depth > 1)
            return fail(err, err_bytes, "an image of 1 to 4 channels within the size limit is wanted");
        if (linear && !spec.format.is_floating_point())
            return fail(err, err_bytes,
                        std::string("pixels are ") + spec.format.c_str() +
                            ", linear floats are wanted: EXR or Radiance HDR");
        int channels = spec.nchannels >= 3 ? 3 : 1;
        *width = spec.width;
        *height = spec.height;
        float *data = static_cast<float *>(std::malloc(pixels * 3 * sizeof(float)));
        if (!data)
            return fail(err, err_bytes, "out of memory");
        if (!in->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, data)) {
            std::free(data);
            return fail(err, err_bytes, in->geterror());
        }
        for (size_t i = pixels; channels == 1 && i-- > 0;)
            data[3 * i] = data[3 * i + 1] = data[3 * i + 2] = data[i];
        *rgb = data;
    } catch (const std::exception &e) {
        return fail(err, err_bytes, e.what());
    }
    return 0;
}
