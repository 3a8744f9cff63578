#!/bin/sh
# A picture of the room against an independent renderer: means of 16x16 blocks within four standard errors or 0.5 %. (Single
# pixels beside the light have long-tailed noise, which few samples do not know: scripts/ground_truth.sh asks for chi2.)
# Usage: view.sh PROGRAMS SCENES SHARED SAMPLES
programs=$1 scenes=$2 shared=${AIRLIGHT_SHARED:-$3} samples=$4
truth=$shared/reference/view_point_grid_total
[ -f "$truth.exr" ] || { echo "SKIP: $truth.exr is not there"; exit 77; }
"$programs/airlight-reference" "$scenes/room_point_grid.json" --mode volume-path --spp "$samples" --size 128x128 --quiet \
    -o view_point_grid_total.exr || exit 1
"$programs/airlight-compare" view_point_grid_total.exr "$truth.exr" --error "$truth.error.exr" \
    --noise-a view_point_grid_total.error.exr --fail-above block_worst_sigma=4 --fail-above nan_count=0
