#!/bin/sh
# Draws figures 8 and 9 of the 2019 paper anew, docs/images/half_fog.png and back_scatter.png, and prints how far gathered
# light is off at their points: relative RMSE of the scattered layer and of all light, the path tracer's noise taken out,
# and the ratio of the sums. usage: scripts/light_figures.sh [TABLES.air [PATHS]]
# (default out/tables.air, made if missing, and 2048 paths a point of airlight-reference)
set -eu
cd "$(dirname "$0")/.."

scripts/build.sh >/dev/null
bin=build/bin
tables=${1:-out/tables.air}
paths=${2:-2048}
mkdir -p out
[ -f "$tables" ] || "$bin/airlight-bake" --tables "$tables" --quiet
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# 32 x 32 points on a floor of edge $1 at height $2; on the wall z = -1 of the room.
floor() { awk -v w="$1" -v y="$2" 'BEGIN { for (j = 0; j < 1024; j++)
    printf "%g,%g,%g,0,1,0\n", w * ((j % 32 + 0.5) / 32 - 0.5), y, w * ((int(j / 32) + 0.5) / 32 - 0.5) }'; }
wall() { awk 'BEGIN { for (j = 0; j < 1024; j++)
    printf "%g,%g,-1,0,0,1\n", (j % 32 + 0.5) / 16 - 1, 1 - (int(j / 32) + 0.5) / 16 }'; }
{ wall; floor 2 -1; } >"$folder/half_fog.points"
floor 2 -1 >"$folder/full_fog.points"
floor 4 0 >"$folder/floor_fog.points"

# truth SCENE LAYER: the path tracer's SCENE.LAYER.csv, a line for each point.
truth() {
    least=
    [ "$2" = total ] || least="--min-events 1"
    # shellcheck disable=SC2086
    "$bin/airlight-reference" "tests/scenes/$1.json" --mode volume-path --spp "$paths" --quiet $least \
        --points "$folder/$1.points" -o "$folder/truth.csv"
    grep -v '^[#x]' "$folder/truth.csv" >"$folder/$1.$2.csv"
}

# ours SCENE LAYER NAME OPTIONS...: gathered light, SCENE.LAYER.NAME.csv. Points in the block see nothing: left out, black.
ours() {
    lit=$folder/$1.$2.csv out=$folder/$1.$2.$3.csv description=tests/scenes/$1.json layer=$2 name="| $1 | $2 | $3 |"
    shift 3
    awk -F, '$7 > 0' "$lit" >"$folder/lit.csv"
    "$bin/gather_points" "$description" "$folder/lit.csv" --layer "$layer" --tables "$tables" --samples 512 --repeats 1 --list \
        "$@" >"$folder/list"
    awk -v list="$folder/list" -F, '{ split("0 0 0", v, " ")
        if ($7 > 0) { getline line <list; split(line, v, " ") }
        print $1 "," $2 "," $3 "," $4 "," $5 "," $6 "," v[1] "," v[2] "," v[3] }' "$lit" >"$out"
    tail -n 1 "$folder/list" | awk -v name="$name" '{ printf "%s %.1f %% | %.3f |\n", name, 100 * $1, $2 }'
}

# difference A B: A - B: red where A is too bright, blue where it is too dark.
difference() {
    paste -d, "$1" "$2" | awk -F, '{ d = $8 - $17
        print $1 "," $2 "," $3 "," $4 "," $5 "," $6 "," (d > 0 ? d : 0) ",0," (d < 0 ? -d : 0) }'
}

echo "| scene | light | gathered | error | sum over truth |"
echo "| --- | --- | --- | --- | --- |"
truth half_fog total
truth half_fog scattered
for layer in total scattered; do
    for walls in published bounded traced; do ours half_fog $layer $walls --walls $walls; done
done
ours half_fog scattered "bounded, 32 fog points" --walls bounded --fog-points 32
at=$folder/half_fog
"$bin/light_figure" docs/images/half_fog.png 32 4 \
    "$at.total.csv:0.2" "$at.total.published.csv:0.2" "$at.total.bounded.csv:0.2" "$at.total.traced.csv:0.2" \
    "$at.scattered.csv:0.6" "$at.scattered.published.csv:0.6" "$at.scattered.bounded.csv:0.6" "$at.scattered.traced.csv:0.6"

set --
for scene in floor_fog full_fog; do
    brightness=0.2
    [ $scene = floor_fog ] || brightness=0.8
    truth $scene scattered
    at=$folder/$scene.scattered
    ours $scene scattered off --walls published
    ours $scene scattered on --walls published --back-scatter
    ours $scene scattered bounded --walls bounded
    for name in off on; do difference "$at.$name.csv" "$at.csv" >"$at.$name.difference.csv"; done
    set -- "$@" "$at.csv:$brightness" "$at.off.csv:$brightness" "$at.on.csv:$brightness" \
        "$at.off.difference.csv:$brightness" "$at.on.difference.csv:$brightness" "$at.bounded.csv:$brightness"
done
"$bin/light_figure" docs/images/back_scatter.png 32 6 "$@"
