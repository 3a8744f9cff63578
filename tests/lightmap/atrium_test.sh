#!/bin/sh
# Scattered light in the atrium, whose galleries are as wide as a cell of the fog's points, against our own path tracer at
# the middles of 96 triangles: relative RMSE, the path tracer's noise taken out. The limits are what was first measured
# (11.6 and 7.7 %) and a quarter: light that leaks through a wall, or is lost in one, shows.
# Usage: atrium_test.sh PROGRAMS SCENES
programs=$1 scene=$2/atrium_fog.json
[ -f "$scene" ] || { echo "SKIP: no atrium in the reference data"; exit 77; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failed=0

"$programs/airlight-bench-gather" "$scene" --list 96 >"$folder/places.csv" &&
    "$programs/airlight-reference" "$scene" --mode volume-path --spp 16384 --min-events 1 --quiet \
        --points "$folder/places.csv" -o "$folder/truth.csv" || exit 1
while read -r walls limit; do
    result=$("$programs/gather_points" "$scene" "$folder/truth.csv" --layer scattered --walls "$walls" --bounces 8 \
        --samples 1024 --repeats 1) || failed=1
    echo "$walls: $result (limit $limit)"
    echo "$result" | awk -v limit="$limit" '{ exit !($1 <= limit) }' || { echo "FAILED"; failed=1; }
done <<LIMITS
bounded 0.145
traced 0.096
LIMITS
exit $failed
