// The part [entry, leave] of a ray inside a box grown by `margin`; entry > leave when it misses.
#ifndef AL_BOX_GLSL
#define AL_BOX_GLSL

void box_span(vec3 origin, vec3 direction, vec3 low, vec3 size, float margin, out float entry,
              out float leave)
{
    // A component of exactly 0 would make 0 * infinity on the box's face.
    vec3 safe = mix(direction, vec3(1e-30), lessThan(abs(direction), vec3(1e-30)));
    vec3 a = (low - margin - origin) / safe, b = (low + size + margin - origin) / safe;
    vec3 near = min(a, b), far = max(a, b);
    entry = max(max(near.x, near.y), near.z);
    leave = min(min(far.x, far.y), far.z);
}

#endif
