#!/bin/sh
# How far light of surfaces in smoke is off over the player's knobs: draws docs/images/cornell_smoke.png and
# cornell_smoke_curves.svg, and writes one table, FOLDER/scattering.csv: knob, value, frames, relative RMSE (the truth's noise
# taken out), FLIP (clamped sRGB), sum over truth, relative RMSE against the truth in which walls hide nothing between surface
# and smoke, surfels.
# usage: scripts/scattering_figures.sh [FOLDER [SAMPLES_PER_PIXEL]] (default out/scattering and 8: each carries 32 paths)
# Pictures and truth stay in FOLDER and are not made again: an empty one makes all. AIRLIGHT_SHARED names the folder of
# scenes (default ../shared).
set -eu
cd "$(dirname "$0")/.."

scripts/build.sh >/dev/null
bin=build/bin
folder=${1:-out/scattering}
spp=${2:-8}
shared=${AIRLIGHT_SHARED:-../shared}
scene=build/tests/scenes/cornell_smoke.json
[ -f "$shared/data/scenes/tim_cornell/cornell.obj" ] || { echo "SKIP: no scenes in $shared/data"; exit 0; }
mkdir -p "$folder"
[ -d "$folder/baked" ] || "$bin/airlight-bake" "$scene" -o "$folder/baked" --quiet

# truth NAME OPTIONS...
truth() {
    name=$folder/$1
    shift
    [ -f "$name.error.exr" ] || "$bin/airlight-reference" "$scene" --mode surface-to-volume --size 160x160 --spp "$spp" \
        --quiet -o "$name.exr" "$@"
}

# picture KNOB VALUE FRAMES OPTIONS... 1.3 pixels: 15 000 surfels.
picture() {
    name=$folder/$1-$2-$3 frames=$3
    shift 3
    [ -f "$name.json" ] || "$bin/airlight-play" "$folder/baked" --headless --size 160x160 --pass surface-scattering \
        --surfel-size 1.3 --shell-epsilon 0.06 --frames "$frames" --accumulate --quiet --out "$name.exr" \
        --stats "$name.json" "$@"
}

# row KNOB VALUE FRAMES ...: the picture's line in the table.
row() {
    name=$folder/$1-$2-$3
    for against in truth open; do
        "$bin/airlight-compare" "$name.exr" "$folder/$against.exr" --error "$folder/$against.error.exr" --json \
            >"$folder/$against.json"
    done
    echo "$1,$2,$3,$(field relative_rmse_without_noise truth),$(field flip_ldr truth),$(field mean_ratio truth),$(
        field relative_rmse_without_noise open),$(field surfels "$1-$2-$3")"
}
field() { sed -n "s/.*\"$1\": *\([0-9.e-]*\).*/\1/p" "$folder/$2.json"; }

# each DO: DO for every line of the table.
each() {
    for frames in 1 8; do
        "$1" variant paper $frames --shells-closed --shells-clamped --no-second-leg --blur-plain \
            --interval-weights coefficients
        "$1" variant default $frames
        "$1" variant switches $frames --visibility --bounce-radius 0.6 --bounce-overlap 4 --blur 1 --shell-levels 3
    done
    for value in 0.24 0.12 0.06 0.03 0.015; do
        "$1" epsilon $value 1 --shell-epsilon $value
        "$1" epsilon-closed $value 1 --shell-epsilon $value --shells-closed
    done
    for value in 1 2 3 4 5 6 7; do "$1" levels $value 1 --shell-levels $value; done
    for value in 4 8 16 24 32; do "$1" intervals $value 1 --intervals $value; done
    for value in 0.65 1.3 2.6 5.2; do "$1" surfel-size $value 1 --surfel-size $value; done
    for value in 0 1 2 3 4; do "$1" blur $value 1 --blur $value; done
}
each picture
truth truth
truth open --no-visibility
{
    echo "knob,value,frames,relative_rmse,flip_ldr,mean_ratio,relative_rmse_open,surfels"
    each row
} | tee "$folder/scattering.csv"
awk -f scripts/curves.awk "$folder/scattering.csv" >docs/images/cornell_smoke_curves.svg
set --
for frames in 8 1; do
    set -- "$@" "$folder/truth.exr" "$folder/variant-paper-$frames.exr" "$folder/variant-default-$frames.exr" \
        "$folder/variant-switches-$frames.exr"
done
"$bin/picture_sheet" docs/images/cornell_smoke.png 4 4 "$@"
