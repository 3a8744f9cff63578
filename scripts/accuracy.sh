#!/bin/sh
# Makes the tables of docs/accuracy.md: bakes the reference objects at final quality, plays them as published, with
# the sum divided out, and marched, and holds them against the independent renderer's pictures.
# usage: scripts/accuracy.sh [FOLDER]   (default out/accuracy; pictures and bakes stay there)
# AIRLIGHT_SHARED names the folder of reference pictures (default ../shared).
set -eu
cd "$(dirname "$0")/.."

scripts/build.sh >/dev/null
bin=build/bin
folder=${1:-out/accuracy}
reference=${AIRLIGHT_SHARED:-../shared}/reference
[ -f "$reference/object_sphere_single.exr" ] || { echo "SKIP: no reference pictures in $reference"; exit 0; }
mkdir -p "$folder"

# error PICTURE TRUTH: relative RMSE in percent, noise taken out; TRUTH.exr and TRUTH.error.exr.
error() {
    "$bin/airlight-compare" "$1" "$2.exr" --error "$2.error.exr" --json |
        sed -n 's/.*"relative_rmse_without_noise": *\([0-9.e-]*\).*/\1/p' | awk '{ printf "%.1f", 100 * $1 }'
}

# play OBJECT NAME OPTIONS...: a picture of the scattered light alone, antialiased.
play() {
    object=$1 name=$2
    shift 2
    "$bin/airlight-play" "$folder/$object" --headless --quiet --size 192x192 --frames 16 --accumulate --no-surface \
        --no-background --no-lod --out "$folder/$object-$name.exr" --out "$folder/$object-$name.png" "$@"
}

# row OBJECT TRUTH: bakes and compares all six settings.
row() {
    "$bin/airlight-bake" "build/tests/scenes/object_$1.json" -o "$folder/$1" --quality final --quiet
    line="| $1 |"
    for leg in published sh marched; do
        case $leg in
        published) view=sh division=--no-normalise ;;
        *) view=$leg division= ;;
        esac
        for order in 5 8; do
            play "$1" "$leg-$order" --view-leg "$view" --sh-order "$order" ${division:+"$division"}
            line="$line $(error "$folder/$1-$leg-$order.exr" "$2") % |"
        done
    done
    "$bin/airlight-compare" "$folder/$1-marched-8.exr" "$2.exr" --diff "$folder/$1-difference.png" >/dev/null
    echo "$line"
}

echo "| object | as published, order 5 | as published, order 8 | divided, order 5 | divided, order 8 | marched, order 5 | marched, order 8 |"
echo "| --- | --- | --- | --- | --- | --- | --- |"
for object in sphere layers torus scan scan_smoke; do row "$object" "$reference/object_${object}_single"; done
for object in elephant_smoke bunny_cloud; do
    [ -f "$folder/$object-truth.exr" ] ||
        "$bin/airlight-reference" "build/tests/scenes/object_$object.json" --mode single-scatter --spp 128 --size 192x192 \
            --quiet -o "$folder/$object-truth.exr"
    row "$object" "$folder/$object-truth"
done

echo "| object | share of single scattering in all orders |"
echo "| --- | --- |"
for object in sphere layers torus scan scan_smoke; do
    share=$("$bin/airlight-compare" "$reference/object_${object}_single.exr" "$reference/object_${object}_all.exr" --json |
        sed -n 's/.*"mean_ratio": *\([0-9.e-]*\).*/\1/p')
    echo "| $object | $share |"
done

echo "| samples drawn of the sphere's 50 000 | marched, order 8 |"
echo "| --- | --- |"
for samples in 500 2000 8000 20000 50000; do
    play sphere "samples-$samples" --samples "$samples"
    echo "| $samples | $(error "$folder/sphere-samples-$samples.exr" "$reference/object_sphere_single") % |"
done
