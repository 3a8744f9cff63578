#!/bin/sh
# The bake at its extremes: right against the closed form, or refused with one line. Spheres: from the centre the
# transmittance is exp(-sigma_t R) in every direction. Grids: a voxel of a million.
# usage: extremes_test.sh FOLDER_OF_PROGRAMS
set -u
bin=$1
. "$(dirname "$0")/../programs/expect.sh"

# scene RADIUS_M MEDIUM BAKE: a sphere and its medium.
scene() {
    cat >"$work/scene.json" <<SCENE
{
  "meshes": [{"name": "ball", "shape": {"type": "sphere", "radius_m": $1, "subdivisions": 4}}],
  "lights": [{"name": "sun", "type": "directional", "direction": [0, -1, 0], "irradiance_w_m2": 1}],
  "media": [{"name": "inside", $2}],
  "translucents": [{"name": "object", "mesh": "ball", "medium": "inside"}],
  "bake": {"coefficient_format": "float", $3}
}
SCENE
}
plain='"directions": 64, "grid_resolution": 32, "samples": 3000, "sh_order": 3'

# right EXTREME NAME TAU TOLERANCE: bakes, is valid, and answers exp(-TAU) at the centre. What the asset answers is a mean
# over the samples whose Gaussians reach the centre: lying within reach q (in radii) on all sides, they give between
# 1 and cosh(q TAU) of it; the voxels give 2 % of TAU, the format and float sums TOLERANCE.
right() {
    extreme_name=$1
    shift
    rm -rf "$work/baked"
    run 0 "$bin/airlight-bake" "$work/scene.json" -o "$work/baked" --quiet
    asset=$work/baked/object.translucent.air
    run 0 "$bin/airlight-inspect" --check "$asset"
    run 0 "$bin/airlight-inspect" --json "$asset"
    reach=$(tr -d ' \n' <"$work/stdout" | sed 's/.*"bounds_max_m":\[\([^,]*\),.*"gaussian_radius_m":\[[^,]*,\([^]]*\)\].*/\1 \2/')
    run 0 "$bin/airlight-inspect" "$asset" --eval '{"position":[0,0,0],"direction":[0.3,0.5,-0.8]}'
    value=$(tr -d ' \n' <"$work/stdout" | sed 's/.*"transmittance":\[\([^,]*\),.*/\1/')
    # shellcheck disable=SC2046
    extreme "$extreme_name" "object, baked: transmittance from the middle, $1" "$value" $(echo "$2 $3 $reach" | awk '{
        q = $4 / $3 * $1; e = exp(-$1); high = e * (exp(q) + exp(-q)) / 2
        printf "%.17g %.17g %.17g", e, e * (1 - 0.02 * $1) - $2, high * (1 + 0.02 * $1) + $2 }')
}
# refused EXTREME NAME WORDS
refused() {
    rm -rf "$work/baked"
    fails 3 "$3" "$bin/airlight-bake" "$work/scene.json" -o "$work/baked" --quiet
    empty "$work/baked"
    refusal "$1" "object, baked: $2"
}
# thick TAU: which extreme it is.
thick() {
    case $1 in
    1e-6 | 1e-3 | 1e4) echo "sigma_t times size $1" ;;
    *) echo "sigma_t times size 1 to 100" ;;
    esac
}

# Optical thickness tau = sigma_t R, and sizes.
for size in 1e-4 1 1e4; do
    for tau in 1e-6 1e-3 1 3; do
        sigma=$(awk -v t=$tau -v r=$size 'BEGIN { printf "%.9g", t / r }')
        scene $size "\"sigma_s_per_m\": $sigma, \"sigma_a_per_m\": 0" "$plain"
        case $size in
        1) right "$(thick $tau)" "sigma_t times radius $tau" $tau 1e-6 ;;
        *) right "scene of $size m" "radius $size m, sigma_t times radius $tau" $tau 1e-6 ;;
        esac
    done
done
scene 1 '"sigma_s_per_m": 1e4, "sigma_a_per_m": 0' "$plain"
refused "$(thick 1e4)" "sigma_t times radius 1e4" "mean free path"
scene 1 '"sigma_s_per_m": 40, "sigma_a_per_m": 0' "$plain, \"too_dense\": \"bake\""
right "$(thick 40)" "sigma_t times radius 40, \"too_dense\": \"bake\"" 40 1e-6

# Just too dense: refused with a count of samples that is not.
scene 1 '"sigma_s_per_m": 12, "sigma_a_per_m": 0' "$plain"
refused "$(thick 12)" "sigma_t times radius 12, 3000 samples" "mean free path"
count=$(sed -n 's/.*"samples" of about \([0-9]*\).*/\1/p' "$work/stderr")
scene 1 '"sigma_s_per_m": 12, "sigma_a_per_m": 0' '"directions": 64, "grid_resolution": 32, "sh_order": 3, "samples": '"$count"
right "$(thick 12)" "sigma_t times radius 12, as many samples as that names: $count" 12 1e-6

# Albedo and phase function do not touch the transmittance.
for albedo in 0 0.999999 1; do
    scene 1 "\"albedo\": $albedo, \"mean_free_path_m\": 1" "$plain"
    case $albedo in
    0.999999) right "albedo 1 - 1e-6" "sigma_t times radius 1" 1 1e-6 ;;
    *) right "albedo $albedo" "sigma_t times radius 1" 1 1e-6 ;;
    esac
done
for g in -0.99 0.99; do
    scene 1 "\"sigma_s_per_m\": 1, \"sigma_a_per_m\": 0, \"g\": $g" "$plain"
    right "g $g" "sigma_t times radius 1" 1 1e-6
done
scene 1 '"sigma_s_per_m": 0, "sigma_a_per_m": 0' "$plain"
refused "density 0" "no extinction" sigma_s_per_m

# Counts.
one='"directions": 64, "grid_resolution": 32, "samples": 1, "sh_order": 1'
scene 1 '"sigma_s_per_m": 1, "sigma_a_per_m": 0' "$one"
refused "1 sample" "sigma_t times radius 1" "mean free path"
scene 1 '"sigma_s_per_m": 1, "sigma_a_per_m": 0' "$one, \"too_dense\": \"bake\""
right "1 sample" "sigma_t times radius 1, \"too_dense\": \"bake\"" 1 1e-6
scene 1 '"sigma_s_per_m": 1, "sigma_a_per_m": 0' '"directions": 2, "grid_resolution": 32, "samples": 200, "sh_order": 1'
right "1 sample" "2 directions, 200 samples" 1 1e-6
scene 1 '"sigma_s_per_m": 1e-6, "sigma_a_per_m": 0' '"directions": 32, "grid_resolution": 1, "samples": 10, "sh_order": 2'
right "one voxel" "sigma_t times radius 1e-6" 1e-6 1e-6
scene 1 '"sigma_s_per_m": 1, "sigma_a_per_m": 0' '"directions": 32, "grid_resolution": 16, "samples": 0, "sh_order": 2'
refused "0 samples" "asked for" samples

scene 1 '"sigma_s_per_m": 1, "sigma_a_per_m": 0, "density": {"type": "constant", "scale": 0}' "$plain"
refused "density 0" "a scale of 0" "density"
scene 1 '"sigma_s_per_m": -1, "sigma_a_per_m": 0' "$plain"
refused "sigma_t times size 1 to 100" "scattering of -1 per metre" sigma_s_per_m
scene 1 '"sigma_s_per_m": 1, "sigma_a_per_m": 0, "g": 1' "$plain"
refused "g 0.99" "g of 1" g

# Grids: a box of 2 m in 9^3 voxels, SPECK in the middle one and REST elsewhere.
speck() { # SPECK REST
    "$bin/vdb_speck" "$work/speck.vdb" 9 2 "$1" "$2"
    cat >"$work/scene.json" <<SCENE
{
  "meshes": [{"name": "box", "shape": {"type": "box", "size_m": 2}}],
  "lights": [{"name": "sun", "type": "directional", "direction": [0, 0, -1], "irradiance_w_m2": 1}],
  "media": [{"name": "smoke", "sigma_s_per_m": 1, "density": {"type": "grid", "file": "speck.vdb"}}],
  "translucents": [{"name": "object", "mesh": "box", "medium": "smoke"}],
  "cameras": [{"name": "front", "position_m": [0, 0, 8], "target_m": [0, 0, 0], "fov_y_degrees": 16}],
  "bake": {"coefficient_format": "float", "directions": 512, "grid_resolution": 64, "samples": 3000, "sh_order": 8}
}
SCENE
}
speck 0 0
refused "density 0" "a grid of zeros" "0 everywhere"
speck 1e6 0
refused "one voxel of 1e6" "in nothing" "mean free path"
speck 1e6 0.1
rm -rf "$work/baked"
run 0 "$bin/airlight-bake" "$work/scene.json" -o "$work/baked" --quiet
run 0 "$bin/airlight-inspect" --check "$work/baked/object.translucent.air"
run 0 "$bin/speck_check" "$work/baked/object.translucent.air" 9 0.1
cat "$work/stdout"
# The picture: finite, never negative, and as bright as the reference's: 1.08 of it as measured, 1.01
# without the speck; nearly black while the speck's density was the unit of a 16-bit grid.
code=0
"$bin/runtime_extremes_test" "$work/baked" || code=$?
if [ "$code" = 0 ]; then
    run 0 "$bin/airlight-play" "$work/baked" --headless --size 48x48 --frames 4 --accumulate --pass translucent \
        --out "$work/played.exr" --quiet
    run 0 "$bin/airlight-reference" "$work/scene.json" --mode single-scatter --spp 32 --size 48x48 \
        -o "$work/reference.exr" --quiet
    run 0 "$bin/airlight-compare" "$work/played.exr" "$work/reference.exr" --fail-above nan_count=0 \
        --fail-above inf_count=0
    ratio=$(sed -n 's/^mean_ratio //p' "$work/stdout")
    extreme "one voxel of 1e6" "object in the player, 0.1 in all other voxels: mean of the picture over the reference's" "$ratio" 1 0.9 1.12
elif [ "$code" != 77 ]; then
    wrong "pictures of a voxel of a million"
fi

# Meshes: a box of 2 m, the same with triangles that have no area, and one triangle, which closes nothing.
mesh() { # NAME, then lines of an .obj behind the box's corners
    cat >"$work/$1.obj" <<'OBJ'
v -1 -1 -1
v 1 -1 -1
v 1 1 -1
v -1 1 -1
v -1 -1 1
v 1 -1 1
v 1 1 1
v -1 1 1
OBJ
    cat >>"$work/$1.obj"
    cat >"$work/$1.json" <<SCENE
{
  "meshes": [{"name": "body", "file": "$1.obj"}],
  "media": [{"name": "m", "sigma_s_per_m": 0.5}],
  "translucents": [{"name": "object", "mesh": "body", "medium": "m"}],
  "bake": {"directions": 128, "grid_resolution": 16, "samples": 500, "sh_order": 4}
}
SCENE
}
box='f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 3 4 8 7
f 1 5 8 4
f 2 3 7 6'
echo "$box" | mesh box
printf '%s\nf 1 1 2\nf 1 2 2\n' "$box" | mesh flat
echo 'f 1 2 3' | mesh one
for name in box flat; do
    run 0 "$bin/airlight-bake" "$work/$name.json" -o "$work/$name" --quiet
    run 0 "$bin/airlight-inspect" "$work/$name/object.translucent.air" --eval '{"position":[0,0,0],"direction":[0,0,1]}'
    cp "$work/stdout" "$work/$name.answer"
done
extreme "triangles without area" "object, baked: bytes of the answer that they change" \
    "$(cmp -l "$work/box.answer" "$work/flat.answer" | wc -l)" 0 0 0
fails 3 "open edge" "$bin/airlight-bake" "$work/one.json" -o "$work/one" --quiet
refusal "one triangle" "object, baked"
empty "$work/one"

finish
