#!/bin/sh
# Against the pictures of an independent renderer: chi2 below 2, and 16x16 block means within four standard errors or
# 0.5 %. Usage: objects.sh PROGRAMS SCENES SHARED NAME SAMPLES
programs=$1 scenes=$2 shared=${AIRLIGHT_SHARED:-$3} name=$4 samples=$5
truth=$shared/reference/object_${name}_single
[ -f "$truth.exr" ] || { echo "SKIP: $truth.exr is not there"; exit 77; }
"$programs/airlight-reference" "$scenes/object_$name.json" --mode single-scatter --spp "$samples" --quiet \
    -o "object_$name.exr" || exit 1
"$programs/airlight-compare" "object_$name.exr" "$truth.exr" --error "$truth.error.exr" \
    --noise-a "object_$name.error.exr" --fail-above chi2_mean=2 --fail-above block_worst_sigma=4 \
    --fail-above nan_count=0
