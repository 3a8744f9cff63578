#!/bin/sh
# Sweeps three scenes (the default one, the Cornell box with smoke, a scan with a cloud inside) and holds --target-error to what
# it promises: bakes and plays what it picks for targets between the front's ends, and prints the error asked for, that of the
# held-out view, and the frame's time over that of the table. Draws docs/images/trade_fronts.svg. For a machine that does
# nothing else: times are of frames by whatever draws them.
# usage: scripts/trade_figures.sh [FOLDER] (default out/trade)
# Finished points stay in FOLDER and are not measured again. AIRLIGHT_SHARED names the folder of meshes (default ../shared).
set -eu
cd "$(dirname "$0")/.."

scripts/build.sh >/dev/null
bin=build/bin
folder=${1:-out/trade}
mkdir -p "$folder"

scene() {
    case $1 in
    default) echo assets/default.json ;;
    cornell_smoke) echo build/tests/scenes/cornell_smoke.json ;;
    scan_cloud) echo build/tests/scenes/object_bunny_cloud.json ;;
    esac
}

# targets NAME: three errors from a third of the way up the front, by ratio, to its top.
targets() {
    awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i; next }
        $column["front"] == 1 { e = $column["relative_rmse"]; if (!low || e < low) low = e; if (e > high) high = e }
        END { for (i = 1; i <= 3; i++) print low * (high / low) ^ (i / 3) * 1.001 }' "$folder/$1/trade.csv"
}
number() { # KEY FILE: the last number of that key
    sed -n "s/.*\"$1\": *\([0-9.e+-]*\).*/\1/p" "$2" | tail -n 1
}

# promise NAME TARGET: one row.
promise() {
    "$bin/airlight-bake" "$(scene "$1")" -o "$folder/$1" --target-error "$2" --quiet
    "$bin/airlight-play" "$folder/$1" --target-error "$2" --headless --size 192x192 --frames 4 --fps 1000000 --accumulate \
        --no-surface --quiet --stats "$folder/stats.json"
    awk -v name="$1" -v target="$2" -v error="$(number relative_rmse "$folder/$1/report.json")" \
        -v held="$(number held_out_relative_rmse "$folder/$1/report.json")" -v expected="$(number frame_ms "$folder/$1/report.json")" \
        -v took="$(number frame_ms_median "$folder/stats.json")" \
        'BEGIN { printf "| %s | %.4f | %.4f | %.4f | %.2f | %.2f |\n", name, target, error, held, held / target, took / expected }'
}

set --
for name in default cornell_smoke scan_cloud; do
    [ -f "$(scene $name)" ] || { echo "SKIP $name: no $(scene $name); AIRLIGHT_SHARED names the folder of meshes" >&2; continue; }
    "$bin/airlight-trade" "$(scene $name)" -o "$folder/$name" --quiet >/dev/null
    set -- "$@" $name
done
echo "| scene | asked for | expected | held-out view | over asked for | time over the table's |"
echo "| --- | --- | --- | --- | --- | --- |"
tables=
for name in "$@"; do
    for target in $(targets "$name"); do
        promise "$name" "$target"
    done
    tables="$tables $name=$folder/$name/trade.csv"
done
# shellcheck disable=SC2086 # options are words
awk -f scripts/fronts.awk $tables >docs/images/trade_fronts.svg
