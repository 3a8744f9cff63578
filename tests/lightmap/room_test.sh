#!/bin/sh
# Gathered light against the room of an independent renderer: relative RMSE over its points, the reference's noise taken
# out. Surfaces and attenuated light within 1 %; everything, walls bounded, within 3 %, 5 % in thick fog, both with the
# gather's own noise in it (0.5 to 2 %). Usage: room_test.sh PROGRAMS SCENES SHARED
programs=$1 scenes=$2 shared=${AIRLIGHT_SHARED:-$3}
reference=$shared/reference
[ -d "$reference" ] || { echo "SKIP: $reference is not there"; exit 77; }
failed=0

# within LIMIT SCENE CSV OPTIONS...
within() {
    limit=$1 scene=$2 csv=$3
    shift 3
    result=$("$programs/gather_points" "$scenes/room_$scene.json" "$reference/$csv.csv" "$@") || { failed=1; return; }
    echo "$csv $*: $result (limit $limit)"
    echo "$result" | awk -v limit="$limit" '{ exit !($1 <= limit) }' || { echo "FAILED"; failed=1; }
}

within 0.01 area_mid irradiance_area_surfaces --layer surface --samples 2048
within 0.01 point_mid irradiance_point_surfaces --layer surface --samples 2048
within 0.01 sun_mid irradiance_sun_surfaces --layer surface --samples 2048
within 0.01 area_mid probes_area_surfaces --layer surface --samples 2048
for fog in thin mid thick grid; do
    within 0.01 area_$fog irradiance_area_${fog}_attenuated --layer attenuated --samples 1024 --fog-points 2
done
for light in point sun; do
    within 0.01 ${light}_mid irradiance_${light}_mid_attenuated --layer attenuated --samples 2048 --fog-points 2
done
small="--samples 512 --fog-samples 64"
for fog in thin mid grid mid_forward mid_backward mid_absorbing; do
    within 0.03 area_$fog irradiance_area_${fog}_total $small
done
within 0.05 area_thick irradiance_area_thick_total $small
within 0.03 point_mid irradiance_point_mid_total $small
within 0.03 sun_mid irradiance_sun_mid_total $small
within 0.03 area_mid probes_area_mid_total --samples 1024 --fog-samples 64
within 0.03 area_thin irradiance_area_thin_total $small --walls traced
within 0.03 area_mid irradiance_area_mid_total $small --walls traced
exit $failed
