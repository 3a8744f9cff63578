#!/bin/sh
# Makes the tables of docs/accuracy.md: bakes the five reference objects at final quality, plays them as published
# and at best, and holds them against the independent renderer's pictures.
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

# error PICTURE REFERENCE: relative RMSE in percent, noise taken out.
error() {
    "$bin/airlight-compare" "$1" "$reference/$2.exr" --error "$reference/$2.error.exr" --json |
        sed -n 's/.*"relative_rmse_without_noise": *\([0-9.e-]*\).*/\1/p' | awk '{ printf "%.1f", 100 * $1 }'
}

# play OBJECT NAME OPTIONS...: a picture of the scattered light alone, antialiased.
play() {
    object=$1 name=$2
    shift 2
    "$bin/airlight-play" "$folder/$object" --headless --quiet --size 192x192 --frames 16 --accumulate --no-surface \
        --no-background --no-lod --out "$folder/$object-$name.exr" --out "$folder/$object-$name.png" "$@"
}

echo "| object | published, order 5 | published, order 8 | marched, order 5 | marched, order 8 | single over all orders |"
echo "| --- | --- | --- | --- | --- | --- |"
for object in sphere layers torus scan scan_smoke; do
    "$bin/airlight-bake" "build/tests/scenes/object_$object.json" -o "$folder/$object" --quality final --quiet
    row="| $object |"
    for leg in sh marched; do
        for order in 5 8; do
            play "$object" "$leg-$order" --view-leg "$leg" --sh-order "$order"
            row="$row $(error "$folder/$object-$leg-$order.exr" "object_${object}_single") % |"
        done
    done
    share=$("$bin/airlight-compare" "$reference/object_${object}_single.exr" "$reference/object_${object}_all.exr" --json |
        sed -n 's/.*"mean_ratio": *\([0-9.e-]*\).*/\1/p')
    echo "$row $share |"
done
