#version 450 core
// The mean of this frame's light c and of history's h, which is the mean of n frames before: (n h + c) / (n + 1), with n
// smaller where the light has changed, so that nothing of what was lit before is left behind.
//
// Let s^2 be the variance of c about what it should be, s^2/n that of h, and b what h is wrong by. Weighed by w and 1 - w,
// the square error of the sum is w^2 (s^2/n + b^2) + (1 - w)^2 s^2. It is least for w = n'/(n' + 1) with
//   1/n' = 1/n + b^2/s^2,
// and then below s^2, the error without history, whatever b is. Both are estimated from N = 25 pairs (c_i, h_i) of pixels
// around, far enough apart for the filter to have mixed other rays in each (its reach and one pixel; 0.09 of neighbours'
// variance is common to both). That light differs from pixel to pixel is no matter, as it does so in both of a pair. The
// mean m of c_i - h_i is b, but for a variance of v/N, v = s^2 (1 + 1/n) the variance of c_i - h_i:
//   b^2 = max(0, |m|^2 - 9 v/N),
// three standard deviations, so that what has not changed is hardly ever doubted. What goes unseen is below s: of fewer
// than N = 9 pairs, sqrt(N) deviations count; of one, none. A change makes the differences differ too, and c_i alone also
// differ as the picture does: v is the lesser of what either of them would have it. Summed over channels.
//
// What is left of a change, as a mean around: |m|/(1 + 1/n + b^2/s^2) <= s / (2 sqrt(1 - 9/N)) at most, 0.63 s: a share of one
// frame's noise, in the first frame; without noise, as when the only light goes out, nothing.
#extension GL_GOOGLE_include_directive : enable
#include "history.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba32f) writeonly uniform image2D result;  // of the tile
layout(binding = 1, rgba32f) readonly uniform image2D carried;  // of the tile; a: frames, 0: none
layout(binding = 2, rgba32f) readonly uniform image2D light;    // of the tile; a: 1, 0: none
layout(binding = 3, rgba32f) writeonly uniform image2D history; // of the view; a: frames

float trusted_frames(ivec2 pixel, vec3 here, float frames)
{
    vec3 change = vec3(0.0), level = vec3(0.0);
    float count = 0.0, changes = 0.0, levels = 0.0;
    for (int i = 0; i < 25; i++) {
        ivec2 at = pixel + (bounce_sample.w + 1) * ivec2(i % 5 - 2, i / 5 - 2);
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, imageSize(light)))) continue;
        vec4 now = imageLoad(light, at), then = imageLoad(carried, at);
        if (now.a == 0.0 || then.a == 0.0) continue;
        vec3 d = now.rgb - then.rgb, e = now.rgb - here;
        change += d;
        level += e;
        changes += dot(d, d);
        levels += dot(e, e);
        count += 1.0;
    }
    if (count < 2.0) return 0.0;
    float both = 1.0 + 1.0 / frames, among = count / (count - 1.0), shift = dot(change, change) / (count * count);
    float spread = among * max(changes / count - shift, 0.0);
    spread = min(spread, both * among * max(levels / count - dot(level, level) / (count * count), 0.0));
    float wrong = shift - min(9.0, count) * spread / count;
    if (wrong <= 0.0) return frames;
    float trusted = 1.0 / (1.0 / frames + wrong * both / spread);
    return trusted > 0.0 ? trusted : 0.0; // without spread, or squares beyond what floats hold
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(light)))) return;
    vec4 here = imageLoad(light, pixel), then = imageLoad(carried, pixel), shown = vec4(0.0), stored = vec4(0.0);
    Receiver r;
    if (receiver_at(pixel, r) && here.a > 0.0) {
        float frames = then.a;
        if (frames > 0.0 && history_rule.z == 0) frames = trusted_frames(pixel, here.rgb, frames);
        stored = vec4(here.rgb, min(frames + 1.0, float(history_rule.y)));
        if (frames > 0.0) stored.rgb = mix(then.rgb, here.rgb, 1.0 / (frames + 1.0));
        shown = vec4(stored.rgb * albedo(r), 1.0);
    }
    imageStore(result, pixel, shown);
    if (is_kept(pixel)) imageStore(history, pixel + tile.xy, stored);
}
