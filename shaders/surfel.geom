#version 450 core
// Thins fine surfels to the wanted size and captures those that are kept, with their material where their light will
// be. A surfel of area A is dropped with probability max(1 - A/A*, 0), a kept one gets max(A, A*): min(1, A/A*)
// max(A, A*) = A, so that areas add up to the triangle's in expectation. The random number is even over the
// surfels of the triangle, k + u of n for the k-th, all with one u: where A* is the same all over it, |T| / A* of them
// are kept but for rounding up or down, and as A* falls they come one by one. They leave by stream 1; by stream 0,
// whose primitives are counted apart, parts of huge triangles. AL_PLAIN: all are kept.
#extension GL_GOOGLE_include_directive : enable
#include "packed_color.glsl"
#include "surfel_edges.glsl"
#include "surfel_size.glsl"

layout(points) in;
layout(points, max_vertices = 1) out;

layout(binding = 2) uniform sampler2D base_color_map;
layout(binding = 3) uniform sampler2D emission_map;
layout(binding = 4) uniform sampler2D metallic_roughness_map;

layout(location = 1) uniform vec4 base;     // rgb, metallic
layout(location = 2) uniform vec4 emission; // rgb in W/(m2 sr), roughness
layout(location = 3) uniform vec4 optics;   // x: dielectric reflectance along the normal; y: 1 double-sided
layout(location = 4) uniform ivec4 maps;    // which of the textures exist
layout(location = 5) uniform ivec3 choice;  // y: 1 these are parts of huge triangles
layout(location = 9) uniform float margin;  // m, 0: surfels may be anywhere

in vec3 fine_position[];
in vec3 first_corner[];
in vec3 second_corner[];
in vec3 third_corner[];
in vec3 fine_normal[];
in vec2 fine_uv[];
in float fine_size[];
in float fine_density[];
in float fine_random[];

layout(stream = 1) out;
layout(xfb_buffer = 0, xfb_stride = 80, xfb_offset = 0, stream = 1) out vec4 place;
layout(xfb_buffer = 0, xfb_offset = 16, stream = 1) out vec4 facing;
layout(xfb_buffer = 0, xfb_offset = 32, stream = 1) out vec4 diffuse; // rgb: albedo; w: reflectance along the normal, packed
layout(xfb_buffer = 0, xfb_offset = 48, stream = 1) out vec4 glow;    // rgb: emission; w: 1 from both sides
layout(xfb_buffer = 0, xfb_offset = 64, stream = 1) out uvec4 edges;

// The texture's mean over a square as large as the surfel.
vec4 read_map(sampler2D map, float area)
{
    vec2 edge = vec2(textureSize(map, 0));
    float texels = area * fine_density[0] * edge.x * edge.y;
    return textureLod(map, fine_uv[0], 0.5 * log2(max(texels, 1.0)));
}

// Whether the place is in the view volume or within the margin of each of its planes but the far one.
bool is_kept(vec3 position)
{
    mat4 rows = transpose(view_projection);
    for (int i = 0; i < 5 && margin > 0.0; i++) {
        vec4 plane = rows[3] + (i < 2 ? rows[0] : i < 4 ? rows[1] : rows[2]) * ((i & 1) == 0 ? 1.0 : -1.0);
        if (dot(plane.xyz, position) + plane.w < -margin * length(plane.xyz)) return false;
    }
    return true;
}

void main()
{
    float wanted = wanted_area(distance(fine_position[0], eye.xyz));
#ifdef AL_PLAIN
    wanted = fine_size[0];
#endif
    if (fine_random[0] * wanted >= fine_size[0] || !is_kept(fine_position[0])) return;
    float area = max(fine_size[0], wanted), metallic = base.a, roughness = emission.a;
    vec3 color = base.rgb, light = emission.rgb;
    if (maps.x != 0) color *= read_map(base_color_map, area).rgb;
    if (maps.y != 0) light *= read_map(emission_map, area).rgb;
    if (maps.z != 0) {
        vec4 texel = read_map(metallic_roughness_map, area);
        metallic *= texel.b;
        roughness *= texel.g;
    }
    place = vec4(fine_position[0], area);
    facing = vec4(fine_normal[0], roughness);
    diffuse = vec4(color * (1.0 - metallic), pack_color(mix(vec3(optics.x), color, metallic)));
    glow = vec4(light, optics.y);
    edges = pack_edges(vec3[3](first_corner[0], second_corner[0], third_corner[0]), choice.y != 0, fine_position[0],
                       fine_normal[0], area);
    EmitStreamVertex(1);
    EndStreamPrimitive(1);
}
