/* Reads a lightmap's OpenEXR picture with OpenEXR's own C++ library and holds it against the asset: every channel of
 * every texel is the same float. usage: exr_layers NAME.lightmap.air lightmap_0.exr */
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>

#include <cstdio>
#include <cstring>
#include <vector>

#include "airlight/lightmap.h"

static const char *const layers[] = {"surface", "attenuated", "scattered"};

static unsigned count_wrong(const al_lightmap_info &info, const al_lightmap_page &page, const char *path)
{
    Imf::InputFile file(path);
    const size_t texels = static_cast<size_t>(page.width) * page.height, line = page.width * 3 * sizeof(float);
    std::vector<std::vector<float>> values(AL_LAYER_COUNT, std::vector<float>(3 * texels));
    Imf::FrameBuffer buffer;
    unsigned wrong = 0, channels = 0;
    for (auto i = file.header().channels().begin(); i != file.header().channels().end(); ++i) channels++;
    if (channels != 9 || file.header().dataWindow().max.x + 1 != static_cast<int>(page.width)) return 1;
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++)
        for (int c = 0; c < 3; c++)
            buffer.insert(std::string(layers[layer]) + "." + "RGB"[c],
                          Imf::Slice(Imf::FLOAT, reinterpret_cast<char *>(values[layer].data() + c), 3 * sizeof(float),
                                     line));
    file.setFrameBuffer(buffer);
    file.readPixels(0, static_cast<int>(page.height) - 1);
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++)
        for (size_t i = 0; i < texels; i++) {
            float texel[3];
            al_lightmap_texel(&info, &page, static_cast<al_lightmap_layer>(layer), i, texel);
            wrong += std::memcmp(texel, &values[layer][3 * i], sizeof texel) != 0;
        }
    return wrong;
}

int main(int argc, char **argv)
{
    al_file *file;
    al_error error;
    al_lightmap_info info;
    al_lightmap_page page;
    if (argc != 3 || al_file_open(argv[1], nullptr, &file, &error) != AL_OK) return 2;
    bool good = al_lightmap_read(file, &info, &error) == AL_OK &&
                al_lightmap_read_page(file, &info, 0, &page, &error) == AL_OK;
    unsigned wrong = good ? count_wrong(info, page, argv[2]) : 1;
    al_file_close(file);
    std::printf("%u texels differ\n", wrong);
    return wrong ? 1 : 0;
}
