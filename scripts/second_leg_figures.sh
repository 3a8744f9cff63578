#!/bin/sh
# What extinction between walls and smoke costs and brings, marched and from baked optical depths, in the scene of
# scripts/scattering_figures.sh: writes FOLDER/second_leg.csv: way, steps or order, relative RMSE against 64 steps and sum over
# theirs, relative RMSE against ground truth in which walls hide nothing (its noise taken out) and sum over its, time of the
# passes shells and legs over that without extinction (the least of three frames).
# usage: scripts/second_leg_figures.sh [FOLDER [SAMPLES_PER_PIXEL]] (default out/scattering and 8, as the other script, whose
# truth is taken where it is there)
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
[ -f "$folder/open.error.exr" ] || "$bin/airlight-reference" "$scene" --mode surface-to-volume --no-visibility --size 160x160 \
    --spp "$spp" --quiet -o "$folder/open.exr"
for order in 1 2 3 4 5; do
    sed 's/"sigma_s_per_m"/"optical_depth_order": '$order', &/' "$scene" >"$folder/depth_$order.json"
    "$bin/airlight-bake" "$folder/depth_$order.json" -o "$folder/depth_$order" --quiet
done

# picture WAY VALUE BAKED OPTIONS...
picture() {
    name=$folder/leg-$1-$2 baked=$folder/$3
    shift 3
    "$bin/airlight-play" "$baked" --headless --size 160x160 --pass surface-scattering --surfel-size 1.3 --shell-epsilon 0.06 \
        --frames 3 --accumulate --quiet --out "$name.exr" --stats "$name.json" "$@"
}
field() { sed -n "s/.*\"$1\": *\([0-9.e-]*\).*/\1/p" "$folder/leg.json"; }
pass_ms() { sed -n "/\"name\": \"$1\"/,/}/s/.*\"ms_min\": *\([0-9.e-]*\).*/\1/p" "$folder/leg-$2.json"; }

# row WAY VALUE ...: the picture's line in the table.
row() {
    name=$folder/leg-$1-$2
    "$bin/airlight-compare" "$name.exr" "$folder/leg-marched-64.exr" --json >"$folder/leg.json"
    line=$1,$2,$(field relative_rmse),$(field mean_ratio)
    "$bin/airlight-compare" "$name.exr" "$folder/open.exr" --error "$folder/open.error.exr" --json >"$folder/leg.json"
    line=$line,$(field relative_rmse_without_noise),$(field mean_ratio)
    ms=$(pass_ms shells "$1-$2") legs=$(pass_ms legs "$1-$2") none=$(pass_ms shells none-0)
    echo "$line,$(awk "BEGIN { printf \"%.2f\", ($ms + ${legs:-0}) / $none }")"
}

# each DO: DO for every line of the table.
each() {
    "$1" none 0 depth_5 --second-leg none
    for steps in 1 2 4 8 16 64; do "$1" marched $steps depth_5 --second-leg-steps $steps; done
    for order in 1 2 3 4 5; do "$1" baked $order depth_$order --second-leg baked; done
}
each picture
{
    echo "way,value,relative_rmse_64,ratio_64,relative_rmse,ratio,time"
    each row
} | tee "$folder/second_leg.csv"
