#!/bin/sh
# Irradiance or probes of the room against an independent renderer, see points.awk. Usage:
#   points.sh PROGRAMS SCENES SHARED TRUTH SAMPLES
# TRUTH is a file of the reference data without .csv: irradiance_LIGHT_surfaces, irradiance_LIGHT_FOG_WHAT,
# probes_LIGHT_..., open_LIGHT_FOG, black_LIGHT_FOG (the last two by number of scattering events).
programs=$1 scenes=$2 shared=${AIRLIGHT_SHARED:-$3} name=$4 samples=$5 here=$(dirname "$0")
truth=$shared/reference/$name.csv points=$4.points.csv skip=6 limits= orders=- off=0
[ -f "$truth" ] || { echo "SKIP: $truth is not there"; exit 77; }
scene=${name#*_}
case $name in
*_surfaces) scene=${scene%_surfaces}_none ;;
*_attenuated) scene=${scene%_attenuated} limits="--max-events 0" ;;
*_total) scene=${scene%_total} ;;
open_*) scene=open_${scene#area_} orders="0 1 2 3 4 5 6" off=0.001 ;;
black_*) limits="--max-bounces 0" orders="0 1 2 3 4 5 6" off=0.001 ;;
esac
case $name in probes_*) skip=4 ;; esac

# Receivers stand `off` before the wall, where the truth's do; a probe has a row for each of its coefficients.
awk -F, -v skip=$skip -v off=$off '/^[#x]/ { next }
    skip == 4 && $4 == 0 { print $1 "," $2 "," $3 ",0,0,0" }
    skip == 6 { printf "%.9g,%.9g,%.9g,%s,%s,%s\n", $1 + off * $4, $2 + off * $5, $3 + off * $6, $4, $5, $6 }' \
    "$truth" > "$points"

failed=0
for order in $orders; do
    case $order in
    -) range= column= ;;
    *) range="--min-events $order --max-events $order" column="-v order=$order" ;;
    esac
    "$programs/airlight-reference" "$scenes/room_$scene.json" --mode volume-path --spp "$samples" --quiet \
        $limits $range --points "$points" -o "$name.csv" --stats "$name.json" || exit 1
    printf '%s %s: ' "$name" "$order"
    awk -F, -v skip=$skip $column -f "$here/points.awk" "$name.csv" "$truth" || failed=1
    tr -d '{}\n' < "$name.json"
    echo
done
exit $failed
