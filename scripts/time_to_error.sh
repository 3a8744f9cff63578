#!/bin/sh
# Prints the table "Time to the same error" of docs/performance.md: processor time of gathering against our own volume path
# tracer, airlight-reference, at the lightmap points of the reference room and for the same error against an
# independent renderer, whose own error is taken out. usage: scripts/time_to_error.sh [TABLES.air]
# (default out/tables.air, made if missing). AIRLIGHT_SHARED names the folder of reference data (default ../shared).
set -eu
cd "$(dirname "$0")/.."

scripts/build.sh >/dev/null
bin=build/bin scenes=build/tests/scenes
tables=${1:-out/tables.air}
reference=${AIRLIGHT_SHARED:-../shared}/reference
[ -f "$reference/room.obj" ] || { echo "SKIP: no reference data in $reference"; exit 0; }
mkdir -p out
[ -f "$tables" ] || "$bin/airlight-bake" --tables "$tables" --quiet
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# scattered FOG: the scattered light of the room, total less attenuated, errors added in squares.
scattered() {
    for layer in total attenuated; do grep -v '^[#x]' "$reference/irradiance_area_$1_$layer.csv" >"$folder/$layer"; done
    paste -d, "$folder/total" "$folder/attenuated" | awk -F, '{
        printf "%s,%s,%s,%s,%s,%s", $1, $2, $3, $4, $5, $6
        for (c = 7; c < 10; c++) printf ",%.9g", $c - $(12 + c)
        for (c = 10; c < 13; c++) printf ",%.9g", sqrt($c ^ 2 + $(12 + c) ^ 2)
        print "" }'
}

# traced SCENE CSV PATHS OUT.csv OPTIONS...: the path tracer's seconds on one thread, at all points, the least of three runs,
# and its standard error.
traced() {
    scene=$scenes/room_$1.json points=$2 paths=$3 to=$4
    shift 4
    for run in 1 2 3; do
        "$bin/airlight-reference" "$scene" --mode volume-path --spp "$paths" --threads 1 --quiet --points "$points" "$@" \
            -o "$to" --stats "$folder/stats.json"
        awk -F'[:,]' '/"cpu_seconds"/ { seconds = $2 } /relative_standard_error/ { print seconds, $2 + 0 }' "$folder/stats.json"
    done | sort -g | head -1
}

# The light in the fog's points is spread over the texels that the room's lightmap has at preview, medium and final quality.
# rows SCENE LAYER WALLS CSV "SECONDS ERROR" OPTIONS...: the error of one gathering and its time, each the mean of five seeds,
# which all paths follow from, those of the fog's points too; the path tracer's time falls with the square of its error.
rows() {
    scene=$scenes/room_$1.json name="| $1, $2 | $3" layer=$2 walls=$3 truth=$4 tracer=$5 repeats=4
    shift 5
    for samples in 32 128 512 2048; do
        for seed in 0 1 2 3 4; do
            surfaces=$("$bin/gather_points" "$scene" "$truth" --no-fog --samples $samples --repeats $repeats --seed $seed "$@")
            gathered=$("$bin/gather_points" "$scene" "$truth" --layer "$layer" --walls "$walls" --tables "$tables" \
                --samples $samples --repeats $repeats --seed $seed "$@")
            echo "$gathered $tracer $surfaces"
        done | awk -v name="$name | $samples" -v samples=$samples -v repeats=$repeats '{
            points = 49; texels = samples < 128 ? 30000 : samples < 512 ? 120000 : 480000
            square = $1 ^ 2 + (repeats - 1) * $3 ^ 2; time = $4 / points; traced = $6 / points * $7 ^ 2 / square
            shared = $5 / texels; extra = time - $11 / points + shared; over = extra > 0 ? traced / extra : 0
            squares += square; times += time; extras += extra; open += shared; one = $6 / points * $7 ^ 2
            if (NR == 1 || over < least) least = over
            if (over > most) most = over }
            END { square = squares / NR; time = times / NR; traced = one / square
            printf "%s | %.1f %% | %.3g | %.3g | %.3g | %.3g | %.3g (%.2g to %.2g) |\n", name, 100 * sqrt(square), 1000 * time,
                1000 * traced, traced / time, traced / (time + open / NR), traced / (extras / NR), least, most }'
    done
}

echo "| light | walls | paths | error | gathering, ms a point | path tracer | ratio | fog points in it | over surfaces alone (least to most) |"
echo "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"
for fog in mid thick; do
    scattered $fog >"$folder/scattered.csv"
    for layer in scattered total; do
        truth=$folder/scattered.csv least="--min-events 1"
        [ $layer = scattered ] || truth=$reference/irradiance_area_${fog}_total.csv least=
        # shellcheck disable=SC2086
        tracer=$(traced area_$fog "$truth" 4096 "$folder/traced.csv" $least)
        for walls in published bounded traced; do rows area_$fog $layer $walls "$truth" "$tracer"; done
    done
done
# The ground of the published method: no walls. The path tracer with more paths is the truth.
for fog in mid thick; do
    tracer=$(traced open_$fog "$folder/scattered.csv" 65536 "$folder/open.csv" --min-events 1)
    rows open_$fog scattered published "$folder/open.csv" "$tracer" --bounces 0
done
