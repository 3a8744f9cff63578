#!/bin/sh
# Prints the tables of gathered light in docs/accuracy.md: the room of the reference data with each setting of walls, and
# a closed furnace over density. usage: scripts/light_accuracy.sh [TABLES.air]   (default out/tables.air, made if missing)
# AIRLIGHT_SHARED names the folder of reference data (default ../shared).
set -eu
cd "$(dirname "$0")/.."

scripts/build.sh >/dev/null
bin=build/bin scenes=build/tests/scenes
tables=${1:-out/tables.air}
reference=${AIRLIGHT_SHARED:-../shared}/reference
[ -f "$reference/room.obj" ] || { echo "SKIP: no reference data in $reference"; exit 0; }
mkdir -p out
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
[ -f "$tables" ] || "$bin/airlight-bake" --tables "$tables" --quiet

# error SCENE CSV WALLS: relative RMSE and, in brackets, the gather's own noise, percent.
error() {
    "$bin/gather_points" "$1" "$2" --walls "$3" --tables "$tables" |
        awk '{ printf "%.1f (%.1f)", 100 * $1, 100 * $3 }'
}

echo "| light, fog | published | bounded | traced |"
echo "| --- | --- | --- | --- |"
for row in area_thin area_mid area_thick area_grid area_mid_forward area_mid_backward area_mid_absorbing point_mid sun_mid; do
    printf '| %s ' "$row"
    for walls in published bounded traced; do
        printf '| %s ' "$(error "$scenes/room_$row.json" "$reference/irradiance_${row}_total.csv" $walls)"
    done
    echo "|"
done
printf '| probes, area_mid '
for walls in published bounded traced; do
    printf '| %s ' "$(error "$scenes/room_area_mid.json" "$reference/probes_area_mid_total.csv" $walls)"
done
echo "|"

# The atrium, scattered light at the middles of 96 triangles, against our own path tracer.
if [ -f "$scenes/atrium_fog.json" ]; then
    "$bin/airlight-bench-gather" "$scenes/atrium_fog.json" --list 96 >"$folder/places.csv"
    "$bin/airlight-reference" "$scenes/atrium_fog.json" --mode volume-path --spp 65536 --min-events 1 --quiet \
        --points "$folder/places.csv" -o "$folder/atrium.csv"
    for points in 16 24; do
        printf '| atrium, scattered, %s fog points ' $points
        for walls in published bounded traced; do
            printf '| %s ' "$("$bin/gather_points" "$scenes/atrium_fog.json" "$folder/atrium.csv" --layer scattered \
                --walls $walls --tables "$tables" --fog-points $points --bounces 8 --repeats 2 --samples 4096 |
                awk '{ printf "%.1f (%.2f)", 100 * $1, $2 }')"
        done
        echo "|"
    done
fi

# Closed box of 2 m, walls emit 1 and reflect 1/2, fog without absorption: irradiance is 2 pi.
{
    echo "x,y,z,nx,ny,nz,E_r,E_g,E_b,se_r,se_g,se_b"
    for place in 0.3,-1,0.2 -0.7,-1,0.6 0,-1,0 0.9,-1,-0.9; do
        echo "$place,0,1,0,6.2831853,6.2831853,6.2831853,1e-9,1e-9,1e-9"
    done
} >"$folder/furnace.csv"
echo "| sigma_t x 2 m | published | bounded | traced |"
echo "| --- | --- | --- | --- |"
for depth in 0.02 0.2 0.5 1 2 4 10; do
    awk -v depth=$depth 'BEGIN { printf "{\"materials\": [{\"name\": \"wall\", \"base_color\": 0.5, \"emission_w_m2_sr\": 1, \"double_sided\": true}], \"meshes\": [{\"name\": \"box\", \"shape\": {\"type\": \"box\", \"size_m\": 2}, \"material\": \"wall\"}], \"media\": [{\"name\": \"fog\", \"sigma_s_per_m\": %g, \"density\": {\"type\": \"constant\", \"bounds_min_m\": [-1, -1, -1], \"bounds_max_m\": [1, 1, 1]}}], \"fogs\": [\"fog\"]}", depth / 2 }' >"$folder/furnace.json"
    printf '| %s ' $depth
    for walls in published bounded traced; do
        printf '| %s ' "$("$bin/gather_points" "$folder/furnace.json" "$folder/furnace.csv" --walls $walls --tables "$tables" | awk '{ printf "%.3f", $2 }')"
    done
    echo "|"
done
