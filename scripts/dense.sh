#!/bin/sh
# Makes the table of dense media in docs/accuracy.md: bakes spheres of radius 1 m that grow denser and holds the
# player's pictures against airlight-reference.
# usage: scripts/dense.sh [FOLDER]   (default out/dense; pictures and bakes stay there)
set -eu
cd "$(dirname "$0")/.."

scripts/build.sh >/dev/null
bin=build/bin
folder=${1:-out/dense}
mkdir -p "$folder"

# field FILE NAME: a number of a JSON file.
field() {
    sed -n "s/.*\"$2\": *\([0-9.e-]*\).*/\1/p" "$1"
}

# row SIGMA_T SAMPLES
row() {
    scene=$folder/$1-$2.json baked=$folder/$1-$2 truth=$folder/$1-truth
    cat >"$scene" <<SCENE
{
  "meshes": [{"name": "ball", "shape": {"type": "sphere", "radius_m": 1, "subdivisions": 5}}],
  "lights": [{"name": "sun", "type": "directional", "direction": [-0.6, 0, -0.8], "irradiance_w_m2": 3.14159}],
  "cameras": [{"name": "front", "position_m": [0, 0, 6], "target_m": [0, 0, 0], "fov_y_degrees": 20}],
  "media": [{"name": "inside", "albedo": 0.9, "mean_free_path_m": $(awk "BEGIN { print 1 / $1 }")}],
  "translucents": [{"name": "object", "mesh": "ball", "medium": "inside"}],
  "bake": {"samples": $2, "directions": 512, "grid_resolution": 128, "sh_order": 8, "coefficient_format": "float",
           "too_dense": "bake"}
}
SCENE
    "$bin/airlight-bake" "$scene" -o "$baked" --quiet
    [ -f "$truth.exr" ] ||
        "$bin/airlight-reference" "$scene" --mode single-scatter --spp 64 --size 64x64 --quiet -o "$truth.exr"
    "$bin/airlight-play" "$baked" --headless --quiet --size 64x64 --frames 8 --accumulate --no-surface \
        --no-background --no-lod --out "$baked.exr"
    "$bin/airlight-inspect" --json "$baked/object.translucent.air" >"$baked.json"
    "$bin/airlight-compare" "$baked.exr" "$truth.exr" --error "$truth.error.exr" --json >"$baked.compared.json"
    echo "$1 $2 $(field "$baked.json" sampling_radius_m) $(field "$baked.compared.json" mean_ratio)" \
        "$(field "$baked.compared.json" relative_rmse_without_noise)" |
        awk '{ printf "| %d | %d | %.2f | %.2f | %.1f %% |\n", $1, $2, 1 / ($1 * $3), $4, 100 * $5 }'
}

echo "| sigma_t times radius | samples | mean free path / base radius | mean | error |"
echo "| --- | --- | --- | --- | --- |"
for sigma in 5 10 20 40 80 160; do row $sigma 5000; done
for sigma in 10 20 40 80 160; do row $sigma 50000; done
