#!/bin/sh
# play_test.sh BIN: airlight-play without a display, on a small baked scene.
set -eu
bin=$1
. "$(dirname "$0")/expect.sh"

cat >"$work/scene.json" <<'JSON'
{
  "meshes": [
    {"name": "ball", "shape": {"type": "sphere", "radius_m": 0.5, "subdivisions": 3}},
    {"name": "floor", "shape": {"type": "plane", "width_m": 4, "depth_m": 4}, "transform": {"translate_m": [0, -0.6, 0]}}
  ],
  "media": [{"name": "fog", "sigma_s_per_m": 3, "density": {"type": "constant"}}],
  "translucents": [{"name": "ball", "mesh": "ball", "medium": "fog"}],
  "lights": [{"type": "directional", "direction": [1, -1, -1], "irradiance_w_m2": 3}],
  "cameras": [
    {"name": "front", "position_m": [0, 0, 4], "target_m": [0, 0, 0], "fov_y_degrees": 30},
    {"name": "top", "position_m": [0, 4, 0], "target_m": [0, 0, 0], "up": [0, 0, -1], "fov_y_degrees": 30}
  ],
  "bake": {"directions": 32, "grid_resolution": 16, "radius_m": 0.1, "sh_order": 3}
}
JSON
run 0 "$bin/airlight-bake" "$work/scene.json" -o "$work/baked" --quiet
[ "$failures" = 0 ] || finish

play() {
    "$bin/airlight-play" "$work/baked" --headless --size 48x32 "$@"
}
differs() { # by more than rounding
    run 1 "$bin/airlight-compare" "$1" "$2" --fail-above max_abs=1e-3
}
same() {
    run 0 "$bin/airlight-compare" "$1" "$2" --fail-above max_abs=0
}

# The same frame twice is the same picture; cameras, passes and knobs change it.
run 0 play --out "$work/a.exr" --out "$work/a.png" --stats "$work/stats.json"
[ ! -s "$work/stdout" ] && [ ! -s "$work/stderr" ] || wrong "says something: $(cat "$work/stderr")"
[ -s "$work/a.png" ] || wrong "no PNG"
run 0 play --out "$work/b.exr"
same "$work/a.exr" "$work/b.exr"
run 0 play --camera front --out "$work/b.exr"
same "$work/a.exr" "$work/b.exr"
run 0 play --camera top --out "$work/b.exr"
differs "$work/a.exr" "$work/b.exr"
run 0 play --pass translucent --out "$work/b.exr"
differs "$work/a.exr" "$work/b.exr"
run 0 play --pass direct-scattering --no-fog --scattered off --fog-steps 8 --out "$work/b.exr"
differs "$work/a.exr" "$work/b.exr"
run 0 play --pass surfels --surfel-size 2 --surfel-limit 500 --no-surface-scattering --out "$work/b.exr"
differs "$work/a.exr" "$work/b.exr"
run 0 play --no-surface --out "$work/b.exr"
differs "$work/a.exr" "$work/b.exr"
run 0 play --exposure 3 --out "$work/b.exr" --out "$work/b.png"
same "$work/a.exr" "$work/b.exr" # EXR is before exposure, PNG after
! cmp -s "$work/a.png" "$work/b.png" || wrong "--exposure does not change the PNG"
run 0 play --size 1x1 --out "$work/b.exr"
run 0 play --samples 20 --no-surface --out "$work/b.exr"
run 0 play --no-surface --out "$work/c.exr"
differs "$work/b.exr" "$work/c.exr"

# %04d numbers every frame; averaging moves the edges but not the mean.
run 0 play --frames 3 --fps 10 --out "$work/f%04d.exr"
for frame in 0000 0001 0002; do [ -s "$work/f$frame.exr" ] || wrong "no frame $frame"; done
same "$work/f0000.exr" "$work/a.exr"
run 0 play --frames 16 --accumulate --out "$work/mean.exr"
differs "$work/a.exr" "$work/mean.exr"
run 0 "$bin/airlight-compare" "$work/a.exr" "$work/mean.exr" --fail-above relative_rmse=0.5
run 0 play --frames 1 --accumulate --out "$work/b.exr"
same "$work/a.exr" "$work/b.exr"

# What moves: frame i shows time i / fps, begun anew after the last key; a camera that moves is followed.
cat >"$work/moving.json" <<'JSON'
{
  "meshes": [{"name": "box", "shape": {"type": "box", "size_m": [1, 0.2, 0.2]}, "motion": [
    {"time_s": 0}, {"time_s": 1, "rotate_degrees": [0, 0, 90]}, {"time_s": 2, "rotate_degrees": [0, 0, 180]}]}],
  "lights": [{"type": "point", "position_m": [0, 2, 2], "intensity_w_sr": 9}],
  "cameras": [
    {"name": "still", "position_m": [0, 0, 3], "target_m": [0, 0, 0]},
    {"name": "rail", "position_m": [0, 0, 3], "target_m": [0, 0, 0],
     "motion": [{"time_s": 0}, {"time_s": 2, "translate_m": [1, 0, 0]}]}]
}
JSON
run 0 "$bin/airlight-bake" "$work/moving.json" -o "$work/moving" --quiet
for camera in still rail; do
    run 0 "$bin/airlight-play" "$work/moving" --headless --size 48x32 --camera $camera --frames 9 --fps 4 \
        --out "$work/$camera%04d.exr"
done
differs "$work/still0000.exr" "$work/still0002.exr"
same "$work/still0000.exr" "$work/still0008.exr"
same "$work/rail0000.exr" "$work/rail0008.exr"
same "$work/still0000.exr" "$work/rail0000.exr"
differs "$work/still0004.exr" "$work/rail0004.exr"
run 0 "$bin/airlight-play" "$work/moving" --headless --size 48x32 --frames 2 --fps 1 --out "$work/b.exr"
same "$work/still0004.exr" "$work/b.exr"

# Report fields.
for field in passes name ms_median ms_min ms_max frame_ms_median memory_bytes surfels samples width height \
    gl_renderer plan step needed why seconds bytes first_picture_ms last_sample_ms; do
    grep -q "\"$field\":" "$work/stats.json" || wrong "stats.json has no $field"
done
grep -q '"width": 48' "$work/stats.json" || wrong "stats.json has another width"
grep -q '"first_picture_ms": null' "$work/stats.json" || wrong "a first picture nobody asked for"
run 0 play --first-picture --stats "$work/stats.json"
grep -Eq '"first_picture_ms": [0-9]' "$work/stats.json" || wrong "the first picture was not timed"
run 0 "$bin/airlight-play" "$work/baked" --plan
grep -Eq ' (yes|no) ' "$work/stdout" || wrong "--plan says: $(cat "$work/stdout")"
full_output "$bin/airlight-play" "$work/baked" --plan

# says_plan WORD ROW OPTION...: the plan of a frame with these options says yes or no to the row.
says_plan() {
    word=$1 row=$2
    shift 2
    run 0 "$bin/airlight-play" "$work/baked" --size 16x16 --plan "$@"
    grep -Eq "^$row +$word " "$work/stdout" || wrong "--plan $* says of $row: $(grep "^$row " "$work/stdout")"
}
says_plan yes shadow
says_plan no shadow --no-shadows
says_plan yes splat
says_plan no splat --pass surfels
says_plan no ambient-occlusion
says_plan yes ambient-occlusion --pass ambient-occlusion
says_plan yes surfels --pass ambient-occlusion
says_plan no surfels --pass ambient-occlusion --occlusion-carrier screen
says_plan no indirect
says_plan yes indirect --indirect
says_plan no surfels --indirect --indirect-carrier volumes
says_plan no visibility --visibility # of a scene without fog

# The least that options of real numbers take, as floats hold it.
run 0 play --shell-epsilon 1e-12 --shell-radius 1e-6 --bounce-radius 1e-6 --occlusion-radius 1e-6 --screen-thickness 1e-6 \
    --surfel-margin 1e-6 --surfel-size 0.1

# Wrong usage.
fails 2 "--headless needs" "$bin/airlight-play" --headless
for option in --out=b.exr --stats=s.json --frames=1 --fps=60 --accumulate --first-picture; do
    fails 2 "need --headless" "$bin/airlight-play" "$work/baked" $option
done
fails 2 "--pass takes one of composite" play --pass nonsense
for option in --out=b.exr --stats=s.json --watch; do
    fails 2 "--plan writes no files" "$bin/airlight-play" "$work/baked" --plan $option
done
for pass in bounce-rays bounce-hits; do
    fails 2 "send no rays that --pass $pass" play --pass $pass --occlusion-carrier volumes-blended
    fails 2 "send no rays that --pass $pass" play --pass $pass --indirect --indirect-carrier surfels-blended
done
fails 2 "--occlusion-carrier takes surfels, surfels-blended" play --occlusion-carrier discs
fails 2 "--indirect-carrier takes surfels, surfels-blended" play --indirect-carrier discs
fails 2 "--indirect-carrier takes surfels, surfels-blended, volumes or screen" play --indirect-carrier volumes-blended
fails 2 "--view-leg takes marched or sh" play --view-leg nonsense
fails 2 "--scattered takes on or off" play --scattered maybe
fails 2 "--second-leg takes marched, baked or none" play --second-leg nonsense
fails 2 "--fog-steps" play --fog-steps 0
fails 2 "--surfel-size" play --surfel-size 0
fails 2 "--surfel-limit" play --surfel-limit 1
fails 2 "b.jpg" play --out "$work/b.jpg"
fails 2 "--size" play --size 0x10
fails 2 "--size" play --size 8193x10
fails 2 "front, top" play --camera nonsense
fails 2 "from 1 to 2147483647, not '0'" play --samples 0
fails 2 "from 1 to 1000000, not '2.5'" play --frames 2.5
fails 2 "--fps" play --fps nan
fails 2 "--stats needs FILE" play --stats ""

# Not a baked folder.
for folder in "$work" "$work/scene.json" "$work/baked/scene.air" "$work/absent"; do
    fails 3 "$folder: no scene.air in it" "$bin/airlight-play" "$folder" --headless
done

# What is no regular file is never replaced: a device or a pipe would be lost.
mkfifo "$work/pipe.exr"
mkdir "$work/folder.png"
for name in pipe.exr folder.png; do fails 4 "$name: is no regular file" play --out "$work/$name"; done
fails 4 "pipe.exr: is no regular file" play --stats "$work/pipe.exr"
[ -p "$work/pipe.exr" ] || wrong "the pipe is gone"

# --watch draws again when the folder changes, and ends well when it is stopped.
"$bin/airlight-play" "$work/baked" --headless --size 48x32 --watch --out "$work/w.exr" 2>"$work/watch" &
player=$!
for i in 1 2 3 4 5 6 7 8 9 10; do [ -s "$work/w.exr" ] && break; sleep 1; done
sed -i 's/"irradiance_w_m2": 3/"irradiance_w_m2": 6/' "$work/scene.json"
sleep 1
run 0 "$bin/airlight-bake" "$work/scene.json" -o "$work/baked" --quiet
for i in 1 2 3 4 5 6 7 8 9 10; do grep -q changed "$work/watch" && break; sleep 1; done
sleep 2
kill -TERM "$player"
wait "$player" || wrong "--watch ends with $?"
differs "$work/a.exr" "$work/w.exr"
finish
