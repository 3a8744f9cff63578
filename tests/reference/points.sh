#!/bin/sh
# Irradiance or probes of the room against an independent renderer, see points.awk.
# Usage: points.sh PROGRAMS SCENES SHARED TRUTH SCENE SAMPLES OPTIONS... TRUTH: irradiance_area_mid_total and so on
programs=$1 scenes=$2 shared=${AIRLIGHT_SHARED:-$3} name=$4 scene=$5 samples=$6 here=$(dirname "$0")
shift 6
truth=$shared/reference/$name.csv
[ -f "$truth" ] || { echo "SKIP: $truth is not there"; exit 77; }
points=$truth skip=6
case $name in
probes_*)
    points=$name.points.csv skip=4
    grep -v '^[#x]' "$truth" | cut -d, -f1-3 | uniq | sed 's/$/,0,0,0/' > "$points" ;;
esac
"$programs/airlight-reference" "$scenes/$scene.json" --mode volume-path --spp "$samples" --quiet "$@" \
    --points "$points" -o "$name.csv" --stats "$name.json" || exit 1
tr -d '{}\n' < "$name.json"
printf '\n%s: ' "$name"
awk -F, -v skip=$skip -f "$here/points.awk" "$name.csv" "$truth"
