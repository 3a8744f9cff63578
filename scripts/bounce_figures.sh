#!/bin/sh
# How far ambient occlusion is off in three scenes (many boxes on a floor, a still life, a dense yard) by what finds occluders and
# over the player's knobs: draws docs/images/bounce_occlusion.png and bounce_occlusion_curves.svg, and writes one table,
# FOLDER/occlusion.csv: knob, value, frames, relative RMSE (the truth's noise taken out), FLIP (clamped sRGB), sum over truth,
# surfels. Every frame is one direction a pixel, from another place in it.
# usage: scripts/bounce_figures.sh [FOLDER [SAMPLES_PER_PIXEL]] (default out/bounce and 32: each carries 32 rays)
# Pictures and truth stay in FOLDER and are not made again: an empty one makes all. AIRLIGHT_SHARED names the folder of
# meshes (default ../shared).
set -eu
cd "$(dirname "$0")/.."

scripts/build.sh >/dev/null
bin=build/bin
folder=${1:-out/bounce}
spp=${2:-32}
shared=${AIRLIGHT_SHARED:-../shared}
[ -f "$shared/data/meshes/c3d_spot.obj" ] || { echo "SKIP: no meshes in $shared/data"; exit 0; }
mkdir -p "$folder"
"$bin/make_bounce_scenes" build/tests/scenes

radius() {
    case $1 in
    dominoes) echo 0.5 ;;
    still_life) echo 0.1 ;;
    yard) echo 0.25 ;;
    esac
}

# Of the innermost shell, small enough that others are needed.
shell() {
    case $1 in
    dominoes) echo 0.1 ;;
    still_life) echo 0.02 ;;
    yard) echo 0.05 ;;
    esac
}

# prepare SCENE: bakes it, and its truth.
prepare() {
    scene=build/tests/scenes/bounce_$1.json
    [ -d "$folder/$1" ] || "$bin/airlight-bake" "$scene" -o "$folder/$1" --quiet
    [ -f "$folder/$1-truth.error.exr" ] || "$bin/airlight-reference" "$scene" --mode ambient-occlusion --size 192x128 \
        --radius "$(radius "$1")" --spp "$spp" --quiet -o "$folder/$1-truth.exr"
}

# picture SCENE KNOB VALUE FRAMES OPTIONS...
picture() {
    scene=$1 name=$folder/$1-$2-$3-$4 frames=$4
    shift 4
    [ -f "$name.json" ] || "$bin/airlight-play" "$folder/$scene" --headless --size 192x128 --pass ambient-occlusion \
        --occlusion-radius "$(radius "$scene")" --surfel-size 2 --bounce-samples 1 --frames "$frames" --accumulate --quiet \
        --out "$name.exr" --stats "$name.json" "$@"
}

# row SCENE KNOB VALUE FRAMES ...: the picture's line in the table.
row() {
    name=$1-$2-$3-$4
    "$bin/airlight-compare" "$folder/$name.exr" "$folder/$1-truth.exr" --error "$folder/$1-truth.error.exr" --json \
        >"$folder/compared.json"
    echo "$1-$2,$3,$4,$(field relative_rmse_without_noise compared),$(field flip_ldr compared),$(
        field mean_ratio compared),$(field surfels "$name")"
}
field() { sed -n "s/.*\"$1\": *\([0-9.e-]*\).*/\1/p" "$folder/$2.json"; }

# each DO: DO for every line of the table.
each() {
    for scene in dominoes still_life yard; do
        for carrier in surfels volumes volumes-blended screen; do
            "$1" $scene variant $carrier 4 --occlusion-carrier $carrier
        done
        "$1" $scene variant surfels-shells 4 --bounce-radius "$(shell $scene)"
        "$1" $scene variant surfels-near-off 4 --bounce-radius "$(shell $scene)" --bounce-near-off
        "$1" $scene variant surfels-plain 4 --surfels-plain
    done
    for carrier in surfels volumes screen; do
        for frames in 1 4 16 64; do
            "$1" dominoes $carrier-directions $frames $frames --occlusion-carrier $carrier --bounce-filter 0
        done
    done
    for value in 0 1 2 4 8; do "$1" dominoes volumes-filter $value 4 --occlusion-carrier volumes --bounce-filter $value; done
    for value in 0 1 2 4 8; do "$1" dominoes surfels-filter $value 4 --bounce-filter $value; done
    for value in 0.05 0.1 0.2 0.4 0.8; do "$1" dominoes shell-radius $value 4 --bounce-radius $value; done
    for value in 1 2 3 4 6; do "$1" dominoes overlap $value 4 --bounce-overlap $value; done
    for value in 8 16 32 64 128; do
        "$1" dominoes screen-steps $value 4 --occlusion-carrier screen --screen-steps $value
    done
    for value in 0.02 0.05 0.1 0.2 0.5; do
        "$1" dominoes screen-thickness $value 4 --occlusion-carrier screen --screen-thickness $value
    done
}
for scene in dominoes still_life yard; do prepare $scene; done
each picture
{
    echo "knob,value,frames,relative_rmse,flip_ldr,mean_ratio,surfels"
    each row
} | tee "$folder/occlusion.csv"
sed 's/^[a-z_]*-variant,/variant,/' "$folder/occlusion.csv" | awk -f scripts/curves.awk >docs/images/bounce_occlusion_curves.svg
set --
for scene in dominoes still_life yard; do
    for variant in volumes-blended screen surfels volumes; do set -- "$@" "$folder/$scene-variant-$variant-4.exr"; done
    set -- "$@" "$folder/$scene-truth.exr"
done
"$bin/picture_sheet" docs/images/bounce_occlusion.png 1 5 "$@"
