// What the passes of one translucent object know. Mirrored by al_object_block in runtime/frame.h (std140).
#ifndef AL_OBJECT_GLSL
#define AL_OBJECT_GLSL

layout(std140, binding = 1) uniform Object {
    mat4 object_to_world;
    mat4 world_to_object;
    // As Frame's, in object space.
    vec4 object_ray_origin, object_ray_origin_x, object_ray_origin_y, object_ray_direction,
        object_ray_direction_x, object_ray_direction_y;
    vec4 box_min;  // xyz: lower corner of the density grid, m; w: voxel, m
    vec4 box_size; // xyz: its size, m; w: 1 when the texture's green channel is the share of blockers
    vec4 albedo;   // rgb: sigma_s / sigma_t, 0 without extinction; w: Henyey-Greenstein g
    vec4 sigma_s;  // rgb: per metre at density 1
    vec4 ratio;    // rgb: sigma_t over the largest of the three; w: how many are not 0
    vec4 march;    // x: largest sigma_t per metre where the texture reads 1; y: step of the march, m;
                   // z: largest sigma_t per metre at density 1; w: unused
    vec4 prefix;   // x: factor on the Gaussians' a; y: on their radii; zw: unused
    ivec4 sizes;   // samples drawn; knots of the interval map; own index among the casters, -1; frame number
    ivec4 toggles; // clip by the front; normalise; light shadows; 1 when there is any environment
    vec4 object_environment[64]; // rgb: SH of environment radiance times phase function, object space
};

void object_ray(vec2 pixel, out vec3 origin, out vec3 direction)
{
    origin = object_ray_origin.xyz + pixel.x * object_ray_origin_x.xyz + pixel.y * object_ray_origin_y.xyz;
    direction = normalize(object_ray_direction.xyz + pixel.x * object_ray_direction_x.xyz +
                          pixel.y * object_ray_direction_y.xyz);
}

// The reference of the interval map is the mean over the channels that have extinction; `tau` is the optical
// depth of the largest one. Its depletion, 1 - transmittance, without cancellation for small tau.
float reference_depletion(float tau)
{
    if (ratio.w == 0.0) return 0.0;
    float sum = al_one_minus_exp(ratio.r * tau) + al_one_minus_exp(ratio.g * tau) +
                al_one_minus_exp(ratio.b * tau);
    return sum / ratio.w;
}

#endif
