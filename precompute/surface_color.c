#include "surface_color.h"

#include <math.h>

/* IEC 61966-2-1. */
static double srgb_to_linear(double value)
{
    return value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4);
}

al_surface_colors al_surface_colors_of(const al_scene *scene)
{
    al_surface_colors colors = {.scene = scene};
    for (int i = 0; i < 256; i++) colors.linear[i] = (float)srgb_to_linear(i / 255.0);
    return colors;
}

static double decode(const al_surface_colors *colors, const al_texture *texture, uint8_t value)
{
    return texture->srgb ? colors->linear[value] : value / 255.0;
}

/* The texel before a coordinate and the one after it, and the share of the latter. Textures repeat; centres
 * lie at (i + 1/2) / size. */
static double neighbours(double coordinate, uint32_t size, uint32_t index[2])
{
    double turned = coordinate - floor(coordinate), at = turned * size - 0.5, first = floor(at);
    if (!isfinite(at)) at = first = 0;
    index[0] = first < 0 ? size - 1 : (uint32_t)first;
    index[1] = index[0] + 1 == size ? 0 : index[0] + 1;
    return at - first;
}

/* Bilinear, decoded before it is mixed. */
static void look_up(const al_surface_colors *colors, uint32_t texture, const double uv[2], double out[3])
{
    const al_texture *from = &colors->scene->textures[texture];
    uint32_t x[2], y[2];
    double right = neighbours(uv[0], from->width, x), down = neighbours(uv[1], from->height, y);
    for (int c = 0; c < 3; c++) {
        double row[2];
        for (int i = 0; i < 2; i++) {
            const uint8_t *line = from->pixels + (size_t)y[i] * from->width * 4 + c;
            row[i] = (1 - right) * decode(colors, from, line[(size_t)x[0] * 4]) +
                     right * decode(colors, from, line[(size_t)x[1] * 4]);
        }
        out[c] = (1 - down) * row[0] + down * row[1];
    }
}

void al_surface_albedo(const al_surface_colors *colors, const al_material *material, const double uv[2],
                       double albedo[3])
{
    double texel[3], metallic = material->metallic;
    if (material->metallic_roughness_texture != AL_NO_INDEX && metallic > 0) {
        look_up(colors, material->metallic_roughness_texture, uv, texel);
        metallic *= texel[2]; /* glTF 2.0: metalness is the blue channel */
    }
    for (int c = 0; c < 3; c++) albedo[c] = material->base_color[c] * (1 - metallic);
    if (material->base_color_texture == AL_NO_INDEX || metallic == 1) return;
    look_up(colors, material->base_color_texture, uv, texel);
    for (int c = 0; c < 3; c++) albedo[c] *= texel[c];
}

void al_surface_gloss(const al_surface_colors *colors, const al_material *material, const double uv[2],
                      double f0[3], double *roughness)
{
    double texel[3] = {1, 1, 1}, metallic = material->metallic,
           part = (material->ior - 1.0) / (material->ior + 1.0);
    if (material->metallic_roughness_texture != AL_NO_INDEX)
        look_up(colors, material->metallic_roughness_texture, uv, texel);
    metallic *= texel[2]; /* glTF 2.0: metalness is the blue channel, roughness the green one */
    *roughness = material->roughness * texel[1];
    texel[0] = texel[1] = texel[2] = 1;
    if (material->base_color_texture != AL_NO_INDEX) look_up(colors, material->base_color_texture, uv, texel);
    for (int c = 0; c < 3; c++)
        f0[c] = (1 - metallic) * part * part + metallic * material->base_color[c] * texel[c];
}

static bool is_dark(const al_material *material)
{
    const float *e = material->emission_w_m2_sr;
    return e[0] == 0 && e[1] == 0 && e[2] == 0;
}

void al_surface_emission(const al_surface_colors *colors, const al_material *material, const double uv[2],
                         double emission_w_m2_sr[3])
{
    double texel[3];
    for (int c = 0; c < 3; c++) emission_w_m2_sr[c] = material->emission_w_m2_sr[c];
    if (material->emission_texture == AL_NO_INDEX || is_dark(material)) return;
    look_up(colors, material->emission_texture, uv, texel);
    for (int c = 0; c < 3; c++) emission_w_m2_sr[c] *= texel[c];
}

void al_surface_mean_emission(const al_surface_colors *colors, const al_material *material,
                              double emission_w_m2_sr[3])
{
    double sum[3] = {0};
    for (int c = 0; c < 3; c++) emission_w_m2_sr[c] = material->emission_w_m2_sr[c];
    if (material->emission_texture == AL_NO_INDEX || is_dark(material)) return;
    const al_texture *from = &colors->scene->textures[material->emission_texture];
    size_t count = (size_t)from->width * from->height;
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++) sum[c] += decode(colors, from, from->pixels[4 * i + c]);
    for (int c = 0; c < 3; c++) emission_w_m2_sr[c] *= sum[c] / (double)count;
}
