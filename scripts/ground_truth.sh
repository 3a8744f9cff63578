#!/bin/sh
# Holds airlight-reference against every file of the independent renderer's room that it can be asked for, and against all
# orders in its objects: the figures of docs/accuracy.md, "Ground truth". Usage:
# ground_truth.sh [SAMPLES [SAMPLES_PER_PIXEL]], after a build. Exit 1 when one of them is not within noise.
samples=${1:-65536} pixel_samples=${2:-256}
top=$(cd "$(dirname "$0")/.." && pwd)
build=${AIRLIGHT_BUILD:-$top/build} shared=${AIRLIGHT_SHARED:-$top/../shared} failed=0
[ -f "$shared/reference/room.obj" ] || { echo "SKIP: no reference data in $shared/reference"; exit 0; }
mkdir -p "$build/ground_truth" && cd "$build/ground_truth" || exit 1
for truth in "$shared"/reference/irradiance_*.csv "$shared"/reference/probes_*.csv "$shared"/reference/open_*.csv \
    "$shared"/reference/black_*.csv; do
    sh "$top/tests/reference/points.sh" "$build/bin" "$build/tests/scenes" "$shared" "$(basename "$truth" .csv)" \
        "$samples" || failed=1
done

# picture SCENE TRUTH SIZE
picture() {
    "$build/bin/airlight-reference" "$build/tests/scenes/$1.json" --mode volume-path --spp "$pixel_samples" \
        --size "$3" --quiet -o "$2.exr" || exit 1
    echo "$2:"
    "$build/bin/airlight-compare" "$2.exr" "$shared/reference/$2.exr" --error "$shared/reference/$2.error.exr" \
        --noise-a "$2.error.exr" --fail-above chi2_mean=2 --fail-above block_worst_sigma=4 || failed=1
}
picture room_point_grid view_point_grid_total 128x128
for object in sphere torus scan scan_smoke layers; do picture object_$object object_${object}_all 192x192; done
# An eye ray of the modes beyond direct light carries 32 paths.
for truth in "$shared"/reference/view_*[a-z0-9].exr; do
    name=$(basename "$truth" .exr)
    case $name in
    *.error | *_total) continue ;;
    *_direct | *ambient*) spp=$pixel_samples ;;
    *) spp=$(((pixel_samples + 7) / 8)) ;;
    esac
    echo "$name:"
    sh "$top/tests/reference/view.sh" "$build/bin" "$build/tests/scenes" "$shared" "$name" "$spp" || failed=1
done
exit $failed
