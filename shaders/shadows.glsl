// How much of a light arrives: opaque casters by shadow map, translucent ones by marching their baked
// density.
#ifndef AL_SHADOWS_GLSL
#define AL_SHADOWS_GLSL

#include "frame.glsl"
#include "box.glsl"

layout(binding = 0) uniform sampler2DArrayShadow shadow_maps;
layout(binding = 8) uniform sampler3D caster_density[AL_CASTER_LIMIT];

// Share of light `index` that passes the opaque casters on its way to `position`. `normal` is the receiver's,
// or 0 for a point in a medium. The receiver is moved towards the light and along its normal by the size of
// the texel it falls into, so that a surface does not shadow itself.
float opaque_visibility(int index, vec3 position, vec3 normal)
{
    Light light = lights[index];
    if (light.shadow.x < 0.0) return 1.0;
    if (light.vector.w == 0.0) {
        vec3 moved = position + light.shadow.z * 1.5 * (normal - light.vector.xyz);
        vec3 place = (light.to_shadow * vec4(moved, 1.0)).xyz;
        if (any(lessThan(place, vec3(0.0))) || any(greaterThan(place.xy, vec2(1.0)))) return 1.0;
        return texture(shadow_maps, vec4(place.xy, light.shadow.x, min(place.z, 1.0)));
    }
    vec3 path = position - light.vector.xyz;
    float texel = light.shadow.z * length(path);
    path += 1.5 * texel * (normal - normalize(path + vec3(1e-30)));
    vec3 size = abs(path);
    // Face f looks along axis f/2, negative when f is odd; its u and v are the next two axes.
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    float along = path[axis];
    if (along == 0.0) return 1.0;
    vec2 place = vec2(path[(axis + 1) % 3], path[(axis + 2) % 3]) / abs(along) * 0.5 + 0.5;
    // Half a texel from the edge, so that filtering never leaves the face.
    place = clamp(place, 0.5 / light.shadow.w, 1.0 - 0.5 / light.shadow.w);
    float layer = light.shadow.x + float(2 * axis + (along < 0.0 ? 1 : 0));
    return texture(shadow_maps, vec4(place, layer, min(length(path) / light.shadow.y, 1.0)));
}

// The integral of the texture's density along the ray from `origin` over `reach`, in metres (object space is
// a rigid motion away); 1e30 where a blocker is met. Midpoint rule, one step per voxel, at most 64.
float caster_depth(int index, vec3 origin, vec3 direction, float reach)
{
    Caster caster = casters[index];
    vec3 from = (caster.to_object * vec4(origin, 1.0)).xyz, along = mat3(caster.to_object) * direction;
    float entry, leave, depth = 0.0;
    box_span(from, along, caster.box_min.xyz, caster.box_size.xyz, 0.5 * caster.box_min.w, entry, leave);
    entry = max(entry, 0.0);
    leave = min(leave, reach);
    if (!(entry < leave)) return 0.0;
    int count = int(clamp((leave - entry) / caster.box_min.w + 0.5, 1.0, 64.0));
    float step = (leave - entry) / float(count);
    for (int i = 0; i < count; i++) {
        vec3 place = from + along * (entry + (float(i) + 0.5) * step) - caster.box_min.xyz;
        vec2 texel = textureLod(caster_density[index], place / caster.box_size.xyz, 0.0).rg;
        if (caster.box_size.w > 0.0 && texel.g > 0.5) return 1e30;
        depth += texel.r * step;
    }
    return depth;
}

// Transmittance of all translucent objects but `skip` between `position` and the light.
vec3 translucent_visibility(vec3 position, vec3 direction, float reach, int skip)
{
    vec3 transmittance = vec3(1.0);
    for (int i = 0; i < counts.y; i++) {
        if (i == skip) continue;
        float depth = caster_depth(i, position, direction, reach);
        transmittance *= depth >= 1e30 ? vec3(0.0) : exp(-casters[i].sigma_t.rgb * depth);
    }
    return transmittance;
}

#endif
