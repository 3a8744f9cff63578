#!/bin/sh
# How far light between surfaces is off in three scenes (many boxes on a floor, a still life, a dense yard), ambient occlusion and
# light of one bounce, by what finds the other surfaces; and ambient occlusion over the player's knobs. Draws
# docs/images/bounce_EFFECT.png and bounce_occlusion_curves.svg and writes one table, FOLDER/bounce.csv: effect and knob, value, frames, relative RMSE (the truth's
# noise taken out), FLIP (clamped sRGB), sum over truth, surfels. A frame is one direction a pixel, from another place in it.
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

# Of the sheet's pictures.
brightness() {
    case $1 in
    occlusion) echo 1 ;;
    indirect) echo 3 ;;
    esac
}

# prepare SCENE: bakes it, and its truths.
prepare() {
    scene=build/tests/scenes/bounce_$1.json truth=$folder/truth-$1
    [ -d "$folder/$1" ] || "$bin/airlight-bake" "$scene" -o "$folder/$1" --quiet
    [ -f "$truth-occlusion.error.exr" ] || "$bin/airlight-reference" "$scene" --mode ambient-occlusion --size 192x128 \
        --radius "$(radius "$1")" --spp "$spp" --quiet -o "$truth-occlusion.exr"
    [ -f "$truth-indirect.error.exr" ] || "$bin/airlight-reference" "$scene" --mode indirect --size 192x128 --spp "$spp" \
        --quiet -o "$truth-indirect.exr"
}

# effect EFFECT SCENE CARRIER: the player's options.
effect() {
    case $1 in
    occlusion) echo "--pass ambient-occlusion --occlusion-radius $(radius "$2") --occlusion-carrier $3" ;;
    indirect) echo "--pass indirect --lambert-senders --indirect-carrier $3" ;;
    esac
}

# picture EFFECT SCENE KNOB VALUE FRAMES CARRIER OPTIONS...
picture() {
    name=$folder/$1-$2-$3-$4-$5 scene=$2 frames=$5 options=$(effect "$1" "$2" "$6")
    shift 6
    # shellcheck disable=SC2086 # options are words
    [ -f "$name.json" ] || "$bin/airlight-play" "$folder/$scene" --headless --size 192x128 $options --surfel-size 2 \
        --bounce-samples 1 --frames "$frames" --accumulate --quiet --out "$name.exr" --stats "$name.json" "$@"
}

# row EFFECT SCENE KNOB VALUE FRAMES ...: the picture's line in the table.
row() {
    name=$1-$2-$3-$4-$5 truth=$folder/truth-$2-$1
    "$bin/airlight-compare" "$folder/$name.exr" "$truth.exr" --error "$truth.error.exr" --json >"$folder/compared.json"
    echo "$1-$2-$3,$4,$5,$(field relative_rmse_without_noise compared),$(field flip_ldr compared),$(
        field mean_ratio compared),$(field surfels "$name")"
}
field() { sed -n "s/.*\"$1\": *\([0-9.e-]*\).*/\1/p" "$folder/$2.json"; }

scenes="dominoes still_life yard"

# variants DO EFFECT CARRIER...: DO for every line of the table on what finds other surfaces.
variants() {
    what=$1 of=$2
    shift 2
    for scene in $scenes; do
        for carrier in "$@"; do "$what" $of $scene variant $carrier 4 $carrier; done
        "$what" $of $scene variant surfels-1-level 4 surfels --shell-levels 1
        "$what" $of $scene variant surfels-shells 4 surfels --bounce-radius "$(shell $scene)"
        "$what" $of $scene variant surfels-near-off 4 surfels --bounce-radius "$(shell $scene)" --bounce-near-off
        "$what" $of $scene variant surfels-plain 4 surfels --surfels-plain
    done
}

# knobs DO EFFECT: DO for every line on a knob.
knobs() {
    what=$1 of=$2
    for carrier in surfels volumes screen; do
        for frames in 1 4 16; do "$what" $of dominoes $carrier-directions $frames $frames $carrier --bounce-filter 0; done
    done
    for carrier in surfels volumes; do
        for value in 0 1 2 4 8; do "$what" $of dominoes $carrier-filter $value 4 $carrier --bounce-filter $value; done
    done
    for value in 0.05 0.1 0.2 0.4 0.8; do "$what" $of dominoes shell-radius $value 4 surfels --bounce-radius $value; done
    for value in 1 2 3 4 6; do "$what" $of dominoes overlap $value 4 surfels --bounce-overlap $value; done
    for value in 2 4 8; do "$what" $of dominoes surfel-size $value 4 surfels --surfel-size $value; done
    for value in 8 16 32 64 128; do "$what" $of dominoes screen-steps $value 4 screen --screen-steps $value; done
    for value in 0.02 0.05 0.1 0.2 0.5; do
        "$what" $of dominoes screen-thickness $value 4 screen --screen-thickness $value
    done
}
all() {
    variants "$1" occlusion surfels surfels-blended volumes volumes-blended screen
    knobs "$1" occlusion
    variants "$1" indirect surfels surfels-blended volumes screen
}
for scene in $scenes; do prepare $scene; done
all picture
{
    echo "knob,value,frames,relative_rmse,flip_ldr,mean_ratio,surfels"
    all row
} | tee "$folder/bounce.csv"
sed -n '1p;s/^occlusion-dominoes-//p' "$folder/bounce.csv" | awk -f scripts/curves.awk >docs/images/bounce_occlusion_curves.svg
for effect in occlusion indirect; do
    set --
    for scene in $scenes; do
        for variant in surfels-blended screen surfels volumes; do set -- "$@" "$folder/$effect-$scene-variant-$variant-4.exr"; done
        set -- "$@" "$folder/truth-$scene-$effect.exr"
    done
    "$bin/picture_sheet" docs/images/bounce_$effect.png "$(brightness $effect)" 5 "$@"
done
