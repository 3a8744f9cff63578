// What every pass of a frame knows. Mirrored by al_frame_block in runtime/frame.h (std140).
#ifndef AL_FRAME_GLSL
#define AL_FRAME_GLSL

#define AL_LIGHT_LIMIT 64
#define AL_CASTER_LIMIT 8

struct Light {
    vec4 vector;    // xyz: direction of travel, or position in m; w: 0 directional, 1 point
    vec4 intensity; // rgb: W/m2 facing the light, or W/sr; w: least squared distance in m2 that it lights from
    vec4 shadow;    // x: first layer of the shadow maps, -1 for none; y: range in m; z: edge of a texel in m,
                    // for point lights per metre of distance; w: texels along an edge
    mat4 to_shadow; // directional: world to [0,1]^3 of the shadow map
};

// A translucent object as it shadows others.
struct Caster {
    mat4 to_object; // from world
    vec4 box_min;   // xyz: lower corner of the density grid in m, object space; w: voxel in m
    vec4 box_size;  // xyz: its size in m; w: 1 when the texture's green channel is the share of blockers
    vec4 sigma_t;   // rgb: per metre where the texture reads 1
};

layout(std140, binding = 0) uniform Frame {
    mat4 view_projection;
    mat4 view_projection_inverse;
    vec4 eye; // xyz: position, w 1; orthographic: the direction towards the eye, w 0
    // The ray of the view's pixel position (x, y), lower left corner (0, 0), in world space: origin + x
    // origin_x + y origin_y, and likewise its direction, not yet of unit length.
    vec4 ray_origin, ray_origin_x, ray_origin_y, ray_direction, ray_direction_x, ray_direction_y;
    ivec4 tile;          // xy: where the tile's lower left pixel is in the view; zw: size of the view
    ivec4 counts;        // lights; casters; environment: 0 none, 1 coefficients only, 2 texture; its levels
    vec4 background;     // rgb: radiance where there is no environment; w: radiance of the environment texture's 1
    vec4 environment[9]; // rgb: SH of incident radiance, world axes
    Light lights[AL_LIGHT_LIMIT];
    Caster casters[AL_CASTER_LIMIT];
};

vec2 view_pixel(vec2 fragment)
{
    return fragment + vec2(tile.xy);
}

void view_ray(vec2 pixel, out vec3 origin, out vec3 direction)
{
    origin = ray_origin.xyz + pixel.x * ray_origin_x.xyz + pixel.y * ray_origin_y.xyz;
    direction = normalize(ray_direction.xyz + pixel.x * ray_direction_x.xyz + pixel.y * ray_direction_y.xyz);
}

// Unit direction from a world position to the eye.
vec3 to_eye(vec3 position)
{
    return normalize(eye.w > 0.0 ? eye.xyz - position : eye.xyz);
}

// Arrival of light `index` at `position`: unit direction towards it, its distance (directional: 1e30 m) and
// irradiance on a plane facing it. Squared distances are held above `least`, in m2, and the light's own least.
vec3 light_arrival(int index, vec3 position, float least, out vec3 direction, out float reach)
{
    Light light = lights[index];
    if (light.vector.w == 0.0) {
        direction = -light.vector.xyz;
        reach = 1e30;
        return light.intensity.rgb;
    }
    vec3 path = light.vector.xyz - position;
    float squared = dot(path, path);
    reach = sqrt(squared);
    direction = reach > 0.0 ? path / reach : vec3(0.0, 1.0, 0.0);
    return light.intensity.rgb / max(squared, max(least, light.intensity.w));
}

#endif
