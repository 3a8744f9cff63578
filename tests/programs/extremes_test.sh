#!/bin/sh
# Extremes by the programs, where no other test asks them: strong and weak surfaces, no, 64 and too many lights, pictures of one
# pixel, sizes and counts that are not. Prints rows of the table of extremes. usage: extremes_test.sh FOLDER_OF_PROGRAMS
set -u
bin=$1
. "$(dirname "$0")/expect.sh"

ask() { sed -n "s/.*\"$1\": *\([-0-9.e+]*\).*/\1/p" "$work/stdout"; }

# Surfaces that give off L and reflect half of all light, all around: irradiance 2 pi L, also through fog that does not absorb;
# within 4.5 of the standard errors that the program states.
for radiosity in 1e-6 1e6; do
    cat >"$work/furnace.json" <<SCENE
{
  "materials": [{"name": "wall", "base_color": 0.5, "emission_w_m2_sr": $radiosity, "double_sided": true}],
  "meshes": [{"name": "box", "shape": {"type": "box", "size_m": 2}, "material": "wall"}],
  "media": [{"name": "fog", "sigma_s_per_m": 0.5}],
  "fogs": ["fog"]
}
SCENE
    printf 'x,y,z,nx,ny,nz\n0.3,-1,0.2,0,1,0\n' >"$work/points.csv"
    run 0 "$bin/airlight-reference" "$work/furnace.json" --mode volume-path --spp 4096 --points "$work/points.csv" \
        -o "$work/furnace.csv" --quiet
    tail -n 1 "$work/furnace.csv" | awk -F, -v l=$radiosity '{ e = 8 * atan2(1, 1) * l; printf "%s %.9g %.9g %.9g", $7, e,
        e - 4.5 * $10 - 1e-5 * e, e + 4.5 * $10 + 1e-5 * e }' >"$work/row"
    # shellcheck disable=SC2046
    extreme "radiosity $radiosity" "airlight-reference: irradiance in a closed room that emits it and reflects half, fog of albedo 1" \
        $(cat "$work/row")
done

# A sphere in the light of suns behind the eye that share 1 W/m2. The player's 2000 samples leave 10 %: analytic_test.c, 8.3 % with
# 1000.
scene() { # COUNT_OF_LIGHTS
    cat >"$work/ball.json" <<SCENE
{
  "meshes": [{"name": "ball", "shape": {"type": "sphere", "radius_m": 1, "subdivisions": 5}}],
  "lights": [$(awk -v n="$1" 'BEGIN { for (i = 0; i < n; i++)
    printf "%s{\"type\": \"directional\", \"direction\": [0, 0, -1], \"irradiance_w_m2\": %.9g}", i ? ", " : "", 1 / n }')],
  "media": [{"name": "inside", "sigma_s_per_m": 0.5}],
  "translucents": [{"name": "object", "mesh": "ball", "medium": "inside"}],
  "cameras": [{"name": "front", "position_m": [0, 0, 8], "target_m": [0, 0, 0], "fov_y_degrees": 1}],
  "bake": {"directions": 128, "grid_resolution": 32, "samples": 2000, "sh_order": 5}
}
SCENE
}
scene 65
fails 3 "64" "$bin/airlight-bake" "$work/ball.json" -o "$work/baked" --quiet
refusal "64 lights" "airlight-bake: 65 of them"
for lights in 1 64 0; do
    scene $lights
    run 0 "$bin/airlight-bake" "$work/ball.json" -o "$work/baked" --quiet
    code=0
    "$bin/airlight-play" "$work/baked" --headless --size 1x1 --frames 4 --accumulate --pass translucent --quiet --no-background \
        --out "$work/played.exr" 2>"$work/stderr" || code=$?
    [ "$code" = 5 ] && skip "no OpenGL 4.5 context: $(cat "$work/stderr")"
    run 0 "$bin/airlight-reference" "$work/ball.json" --mode single-scatter --size 1x1 --spp 1024 --quiet -o "$work/truth.exr"
    run 0 "$bin/airlight-compare" "$work/played.exr" "$work/truth.exr" --json --fail-above nan_count=0 --fail-above inf_count=0
    case $lights in
    1) extreme "1 x 1 pixels" "airlight-play: a picture of an object over airlight-reference's" "$(ask mean_ratio)" 1 0.9 1.1 ;;
    64) extreme "64 lights" "airlight-play: a picture under 64 suns over airlight-reference's" "$(ask mean_ratio)" 1 0.9 1.1 ;;
    0) extreme "0 lights" "airlight-play: largest difference from airlight-reference's black picture" "$(ask max_abs)" 0 0 0 ;;
    esac
done

# Sizes and counts that are not.
scene 1
fails 2 "--size" "$bin/airlight-play" "$work/baked" --headless --size 1x0 --out "$work/none.exr"
refusal "1 x 1 pixels" "airlight-play: --size 1x0"
fails 2 "--size" "$bin/airlight-play" "$work/baked" --headless --size 8192x8193 --out "$work/none.exr"
refusal "8192 x 8192 pixels" "airlight-play: --size 8192x8193"
fails 2 "--samples" "$bin/airlight-play" "$work/baked" --headless --samples 0 --out "$work/none.exr"
refusal "0 samples" "airlight-play: --samples 0"
fails 2 "--spp" "$bin/airlight-reference" "$work/ball.json" --mode single-scatter --spp 0 -o "$work/none.exr"
refusal "0 samples" "airlight-reference: --spp 0"
[ ! -e "$work/none.exr" ] || wrong "a picture of nothing"
cat >"$work/floor.json" <<'SCENE'
{
  "meshes": [{"name": "floor", "shape": {"type": "plane"}, "lighting": "lightmap"}],
  "lightmap": {"samples": 0}
}
SCENE
fails 3 "lightmap.samples" "$bin/airlight-bake" "$work/floor.json" -o "$work/floor" --quiet
refusal "0 samples" "airlight-bake: a lightmap's"

finish
