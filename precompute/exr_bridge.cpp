/* OpenEXR's C++ library, which reads every compression (its C interface of this version has no DWA). */
#include "picture.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>

#include <cstdlib>
#include <cstring>
#include <exception>
#include <stdexcept>

namespace
{

class memory_stream : public Imf::IStream
{
  public:
    memory_stream(const char *name, const uint8_t *data, size_t size)
        : Imf::IStream(name), bytes(reinterpret_cast<const char *>(data)), length(size)
    {
    }
    bool read(char c[], int n) override
    {
        if (n < 0 || static_cast<size_t>(n) > length - at)
            throw std::runtime_error("the file ends too early");
        std::memcpy(c, bytes + at, static_cast<size_t>(n));
        at += static_cast<size_t>(n);
        return at < length;
    }
    uint64_t tellg() override
    {
        return at;
    }
    void seekg(uint64_t position) override
    {
        if (position > length) throw std::runtime_error("the file ends too early");
        at = position;
    }

  private:
    const char *bytes;
    size_t length, at = 0;
};

} // namespace

extern "C" al_status al_picture_decode_exr(const char *name, const uint8_t *data, size_t size,
                                           uint32_t *width, uint32_t *height, float **rgb, al_error *error)
{
    float *pixels = nullptr;
    *rgb = nullptr;
    try {
        memory_stream stream(name, data, size);
        Imf::InputFile file(stream);
        const Imath::Box2i window = file.header().dataWindow();
        const int64_t columns = int64_t(window.max.x) - window.min.x + 1,
                      rows = int64_t(window.max.y) - window.min.y + 1;
        if (columns < 1 || rows < 1 || columns > AL_PICTURE_EDGE_LIMIT || rows > AL_PICTURE_EDGE_LIMIT)
            return al_fail(error, AL_BAD_INPUT, "%s: is %lld x %lld pixels; 1 to %d along each edge is right",
                           name, (long long)columns, (long long)rows, AL_PICTURE_EDGE_LIMIT);
        const Imf::ChannelList &channels = file.header().channels();
        const bool color =
            channels.findChannel("R") && channels.findChannel("G") && channels.findChannel("B");
        if (!color && !channels.findChannel("Y"))
            return al_fail(error, AL_BAD_INPUT, "%s: has neither channels R, G, B nor Y", name);
        pixels = static_cast<float *>(std::calloc(static_cast<size_t>(columns) * rows, 3 * sizeof(float)));
        if (!pixels) return al_fail(error, AL_IO, "%s: out of memory for its pixels", name);
        const char *const names[3] = {color ? "R" : "Y", "G", "B"};
        Imf::FrameBuffer frame;
        for (int i = 0; i < (color ? 3 : 1); i++)
            frame.insert(names[i], Imf::Slice::Make(Imf::FLOAT, pixels + i, window, 3 * sizeof(float),
                                                    3 * sizeof(float) * static_cast<size_t>(columns)));
        file.setFrameBuffer(frame);
        file.readPixels(window.min.y, window.max.y);
        for (int64_t i = 0; i < columns * rows && !color; i++)
            pixels[i * 3 + 1] = pixels[i * 3 + 2] = pixels[i * 3];
        *width = static_cast<uint32_t>(columns);
        *height = static_cast<uint32_t>(rows);
        *rgb = pixels;
        return AL_OK;
    } catch (const std::exception &problem) {
        std::free(pixels);
        return al_fail(error, AL_BAD_INPUT, "%s: cannot be read as OpenEXR: %s", name, problem.what());
    }
}
