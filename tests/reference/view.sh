#!/bin/sh
# A view of the reference folder against an independent renderer: chi2 below 2, and means of 16x16 blocks within four
# standard errors or 0.5 %. Usage: view.sh PROGRAMS SCENES SHARED TRUTH SAMPLES
# TRUTH is a picture of the reference data without .exr: view_point_FOG_WHAT, view_ambient_occlusion...,
# view_one_bounce_....
programs=$1 scenes=$2 shared=${AIRLIGHT_SHARED:-$3} name=$4 samples=$5
truth=$shared/reference/$name error=$shared/reference/$name.error.exr chi2='--fail-above chi2_mean=2'
[ -f "$truth.exr" ] || { echo "SKIP: $truth.exr is not there"; exit 77; }
rest=${name#view_point_}
scene=room_point_${rest%%_*}
case $name in
# Single pixels beside the light have long-tailed noise, which few samples do not know: scripts/ground_truth.sh asks.
*_total) mode=volume-path chi2= ;;
*_direct)
    mode=single-scatter error=$name.left.exr
    "$programs/reference_leave_out" "$truth.error.exr" "$error" || exit 1
    ;;
view_ambient_occlusion) scene=room_point_none mode=ambient-occlusion ;;
view_ambient_occlusion_radius_half) scene=room_point_none mode='ambient-occlusion --radius 0.5' ;;
view_one_bounce_diffuse) scene=room_point_none mode=indirect ;;
view_one_bounce_metal_*) scene=room_point_${name#view_one_bounce_metal_} mode=indirect ;;
*_unattenuated_second_leg) mode='surface-to-volume --no-attenuation' ;;
*) mode=surface-to-volume ;;
esac
"$programs/airlight-reference" "$scenes/$scene.json" --mode $mode --spp "$samples" --size 128x128 --quiet \
    -o "$name.exr" || exit 1
"$programs/airlight-compare" "$name.exr" "$truth.exr" --error "$error" --noise-a "$name.error.exr" $chi2 \
    --fail-above block_worst_sigma=4 --fail-above nan_count=0
