#!/bin/sh
# Fogs as a job: a varying one becomes an asset, once; constant ones need none; what is wrong is refused.
# usage: fog_test.sh FOLDER_OF_PROGRAMS
set -u
bin=$1
. "$(dirname "$0")/../programs/expect.sh"

# scene SIGMA PERIOD: a layered and a constant fog.
scene() {
    cat >"$work/fog.json" <<SCENE
{
  "lights": [{"name": "sun", "type": "directional", "direction": [0, -1, 0], "irradiance_w_m2": 3}],
  "media": [
    {"name": "haze", "sigma_s_per_m": $1, "density": {"type": "layers", "period_m": $2, "thickness_m": 0.25,
     "bounds_min_m": [0, 0, 0], "bounds_max_m": [1, 1, 1]}},
    {"name": "air", "sigma_s_per_m": 0.1}
  ],
  "fogs": ["haze", "air"]
}
SCENE
}
scene 1 0.5
run 0 "$bin/airlight-bake" "$work/fog.json" -o "$work/fog"
run 0 "$bin/airlight-inspect" --check "$work/fog/haze.medium.air"
[ "$(ls "$work/fog")" = "haze.medium.air
report.json
scene.air" ] || wrong "the folder holds $(ls "$work/fog")"
[ "$(grep -c '"kind": "medium"' "$work/fog/report.json")" = 1 ] || wrong "the report does not name the asset once"
[ "$(grep -c '"name": "medium"' "$work/fog/report.json")" = 1 ] || wrong "the asset was not made once"
run 0 "$bin/airlight-inspect" "$work/fog/scene.air"
grep -q '"medium": "haze", "asset": "haze.medium.air"' "$work/stdout" || wrong "scene.air does not name the asset"
grep -q '"medium": "air", "asset": ""' "$work/stdout" || wrong "a constant fog has an asset"

# Where period and thickness are 1/2 and 1/4 m, y = 0.1 lies in a layer and y = 0.4 does not.
run 0 "$bin/airlight-inspect" "$work/fog/haze.medium.air" --eval '{"position": [0.5, 0.1, 0.5]}'
grep -q '"sigma_s_per_m": \[1.0, 1.0, 1.0\]' "$work/stdout" || wrong "says $(cat "$work/stdout")"
run 0 "$bin/airlight-inspect" "$work/fog/haze.medium.air" --eval '{"position": [0.5, 0.4, 0.5], "time": 3}'
grep -q '"sigma_s_per_m": \[0.0, 0.0, 0.0\]' "$work/stdout" || wrong "says $(cat "$work/stdout")"

# Nothing twice; what changed, again.
before=$(ls -i "$work/fog/haze.medium.air")
run 0 "$bin/airlight-bake" "$work/fog.json" -o "$work/fog"
[ "$before" = "$(ls -i "$work/fog/haze.medium.air")" ] || wrong "the asset was written again"
scene 2 0.5
run 0 "$bin/airlight-bake" "$work/fog.json" -o "$work/fog"
run 0 "$bin/airlight-inspect" "$work/fog/haze.medium.air" --eval '{"position": [0.5, 0.1, 0.5]}'
grep -q '"sigma_s_per_m": \[2.0, 2.0, 2.0\]' "$work/stdout" || wrong "another medium was not baked anew"

run 0 "$bin/airlight-bake" "$work/fog.json" --plan
grep -A1 '"step": "medium"' "$work/stdout" | grep -q '"needed": true' || wrong "the plan leaves the medium out"

# Under a sky a constant fog with bounds has an asset, which holds the sky's light; one without none.
cat >"$work/sky.json" <<SCENE
{
  "environment": {"radiance_w_m2_sr": 1},
  "media": [
    {"name": "haze", "sigma_s_per_m": 1, "g": 0.3, "density": {"type": "constant", "bounds_min_m": [0, 0, 0], "bounds_max_m": [1, 1, 1]}},
    {"name": "smoke", "sigma_a_per_m": 1, "density": {"type": "constant", "bounds_min_m": [2, 0, 0], "bounds_max_m": [3, 1, 1]}}
  ],
  "fogs": ["haze", "smoke"]
}
SCENE
run 0 "$bin/airlight-bake" "$work/sky.json" -o "$work/sky" --threads 1
[ "$(ls "$work/sky")" = "haze.medium.air
report.json
scene.air" ] || wrong "the folder holds $(ls "$work/sky")"
run 0 "$bin/airlight-inspect" --check "$work/sky/haze.medium.air"
grep -A1 '"step": "sky light"' "$work/sky/report.json" | grep -q '"needed": true' || wrong "the plan leaves the sky out"
cp "$work/sky/haze.medium.air" "$work/one.air"
rm "$work/sky/haze.medium.air"
run 0 "$bin/airlight-bake" "$work/sky.json" -o "$work/sky" --threads 3
cmp -s "$work/one.air" "$work/sky/haze.medium.air" || wrong "the number of threads changes the sky's light"
sed -i 's/"radiance_w_m2_sr": 1/"radiance_w_m2_sr": 0/' "$work/sky.json"
run 0 "$bin/airlight-bake" "$work/sky.json" --plan
grep -A2 '"step": "sky light"' "$work/stdout" | grep -q 'no environment light' || wrong "the plan does not say why not"

# Optical depths only where they are asked for and vary; the same bytes by any number of threads.
run 0 "$bin/airlight-bake" "$work/fog.json" --plan
grep -A2 '"step": "fog depth"' "$work/stdout" | grep -q 'no fog asks for optical_depth_order' || wrong "the plan does not say why not"
sed 's/"sigma_s_per_m"/"optical_depth_order": 3, &/' "$work/fog.json" >"$work/depth.json"
run 0 "$bin/airlight-bake" "$work/depth.json" -o "$work/depth" --threads 1
grep -A1 '"step": "fog depth"' "$work/depth/report.json" | grep -q '"needed": true' || wrong "the plan leaves the depths out"
grep -q '"name": "fog depth"' "$work/depth/report.json" || wrong "the report has no step of depths"
run 0 "$bin/airlight-inspect" --check "$work/depth/haze.medium.air"
cp "$work/depth/haze.medium.air" "$work/one.air"
rm "$work/depth/haze.medium.air"
run 0 "$bin/airlight-bake" "$work/depth.json" -o "$work/depth" --threads 3
cmp -s "$work/one.air" "$work/depth/haze.medium.air" || wrong "the number of threads changes the depths"
sed -i 's/"optical_depth_order": 3/"optical_depth_order": 6/' "$work/depth.json"
fails 3 'optical_depth_order' "$bin/airlight-bake" "$work/depth.json" -o "$work/depth"

# Negative coefficients.
cp "$work/fog.json" "$work/kept.json"
scene -1 0.5
fails 3 'media[0].sigma_s_per_m: is -1; a number or a list of 3 numbers from 0' "$bin/airlight-bake" "$work/fog.json" -o "$work/negative"
empty "$work/negative"
mv "$work/kept.json" "$work/fog.json"

# A grid beyond the memory that was allowed: one line that says what to do.
sed -i 's/"thickness_m": 0.25/"thickness_m": 0.02/' "$work/fog.json"
run 3 "$bin/airlight-bake" "$work/fog.json" -o "$work/fog" --memory-limit 16
grep -q 'fog.json: medium "haze" (line 4): its 256 x 256 x 256 voxels take 64 MiB as floats, --memory-limit allows 16' \
    "$work/stderr" || wrong "says $(cat "$work/stderr")"
# A sequence of grids: an asset of as many frames, baked again when one of the files changes, shown frame by frame.
for frame in 0 1 2; do "$bin/vdb_speck" "$work/smoke_$frame.vdb" $((5 + 2 * frame)) "$(echo "$frame" | awk '{print (5 + 2 * $1) / 10}')" \
    $((frame + 1)) $((frame + 1)); done
cat >"$work/smoke.json" <<'SCENE'
{
  "media": [{"name": "smoke", "sigma_a_per_m": 1, "density": {"type": "grid", "file": "smoke_%d.vdb", "frame_count": 3,
   "frames_per_second": 4}}],
  "fogs": ["smoke"],
  "cameras": [{"position_m": [0, 0, 4], "target_m": [0, 0, 0], "fov_y_degrees": 4}],
  "play": {"background": 1}
}
SCENE
run 0 "$bin/airlight-bake" "$work/smoke.json" -o "$work/smoke"
run 0 "$bin/airlight-inspect" --check "$work/smoke/smoke.medium.air"
for frame in 0 1 2; do
    run 0 "$bin/airlight-inspect" "$work/smoke/smoke.medium.air" --eval \
        "{\"position\": [0, 0, 0], \"time\": $(echo $frame | awk '{print $1 / 4}')}"
    grep -q "\"sigma_a_per_m\": \[$((frame + 1)).0, " "$work/stdout" || wrong "frame $frame says $(cat "$work/stdout")"
done
before=$(ls -i "$work/smoke/smoke.medium.air")
run 0 "$bin/airlight-bake" "$work/smoke.json" -o "$work/smoke"
[ "$before" = "$(ls -i "$work/smoke/smoke.medium.air")" ] || wrong "the sequence was written again"
"$bin/vdb_speck" "$work/smoke_2.vdb" 9 0.9 4 4
run 0 "$bin/airlight-bake" "$work/smoke.json" -o "$work/smoke"
run 0 "$bin/airlight-inspect" "$work/smoke/smoke.medium.air" --eval '{"position": [0, 0, 0], "time": 0.5}'
grep -q '"sigma_a_per_m": \[4.0, ' "$work/stdout" || wrong "another frame was not baked anew: $(cat "$work/stdout")"
run 0 "$bin/airlight-play" "$work/smoke" --headless --size 16x16 --frames 6 --fps 4 --out "$work/s%04d.exr"
run 0 "$bin/airlight-compare" "$work/s0000.exr" "$work/s0003.exr" --fail-above max_abs=1e-5
run 1 "$bin/airlight-compare" "$work/s0001.exr" "$work/s0002.exr" --fail-above max_abs=0.1
rm "$work/smoke_1.vdb"
fails 3 "smoke_1.vdb" "$bin/airlight-bake" "$work/smoke.json" -o "$work/smoke"

# A fog that is little more than one voxel of many mean free paths is refused where surfaces light it.
dense() { # DENSITY REST [MESH [BAKE]]: 9^3 voxels of 2/9 m
    "$bin/vdb_speck" "$work/speck.vdb" 9 2 "$1" "$2"
    cat >"$work/dense.json" <<SCENE
{
  "meshes": [${3-}],
  "lights": [{"name": "lamp", "type": "point", "position_m": [0, 3, 0], "intensity_w_sr": 1}],
  "media": [{"name": "smoke", "sigma_s_per_m": 1, "density": {"type": "grid", "file": "speck.vdb"}}],
  "fogs": ["smoke"], "bake": {${4-}}
}
SCENE
    rm -rf "$work/dense"
}
floor='{"name": "floor", "shape": {"type": "plane", "width_m": 4, "depth_m": 4}}'
dense 1000 0 "$floor"
fails 3 "voxels thicker than 200 mean free paths stop 100 % of its light" "$bin/airlight-bake" "$work/dense.json" -o "$work/dense"
[ ! -e "$work/dense/smoke.medium.air" ] || wrong "a refused fog was written"
for case in "800 0" "1e6 0.1"; do
    # shellcheck disable=SC2086
    dense $case "$floor"
    run 0 "$bin/airlight-bake" "$work/dense.json" -o "$work/dense" --quiet
done
dense 1e6 0
run 0 "$bin/airlight-bake" "$work/dense.json" -o "$work/dense" --quiet
mv "$work/dense" "$work/kept" # and is not good enough with surfaces
dense 1e6 0 "$floor"
mv "$work/kept" "$work/dense"
fails 3 "200 mean free paths" "$bin/airlight-bake" "$work/dense.json" -o "$work/dense"
dense 1e6 0 "$floor" '"too_dense": "bake"'
run 0 "$bin/airlight-bake" "$work/dense.json" -o "$work/dense"
grep -q "light of surfaces in it will look wrong" "$work/stderr" || wrong "a fog too dense is not called wrong"

finish
