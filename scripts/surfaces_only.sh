#!/bin/bash
# A scene that needs nothing but surfaces, by the whole programs and by a build without all other parts
# (AIRLIGHT_SURFACES_ONLY): the passes that ran, the bytes they hold, and medians of times over runs that take turns.
# CPU time counts the program's own work, whatever else the machine does.
# usage: scripts/surfaces_only.sh [FOLDER [RUNS]]   (defaults: out/surfaces_only, 21)
set -eu
cd "$(dirname "$0")/.."

folder=${1:-out/surfaces_only}
runs=${2:-21}
mkdir -p "$folder"
scripts/build.sh >/dev/null
cmake -S . -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DAIRLIGHT_SURFACES_ONLY=ON >/dev/null
cmake --build "$folder/build" >/dev/null
declare -A bin=([whole]=build/bin [surfaces]=$folder/build/bin)

cat >"$folder/scene.json" <<JSON
{
  "environment": {"radiance_w_m2_sr": [0.2, 0.25, 0.3]},
  "materials": [{"name": "brass", "base_color": [0.8, 0.6, 0.3], "metallic": 1, "roughness": 0.3}],
  "meshes": [
    {"name": "floor", "shape": {"type": "plane", "width_m": 8, "depth_m": 8}, "transform": {"translate_m": [0, -0.2, 0]}},
    {"name": "ring", "material": "brass", "shape": {"type": "torus", "major_segments": 1024, "minor_segments": 256}},
    {"name": "ball", "shape": {"type": "sphere", "radius_m": 0.2, "subdivisions": 7}}
  ],
  "lights": [
    {"name": "lamp", "type": "point", "position_m": [1, 2, 1], "intensity_w_sr": 9},
    {"name": "sun", "type": "directional", "direction": [-1, -2, -0.5], "irradiance_w_m2": 2}
  ],
  "cameras": [{"name": "front", "position_m": [0.6, 0.9, 1.4], "target_m": [0, 0, 0]}]
}
JSON

# timed FILE COMMAND...: adds the CPU seconds that the command took to the file.
timed() {
    local file=$1 TIMEFORMAT='%U %S'
    shift
    { time "$@" >/dev/null 2>"$folder/said"; } 2>&1 | awk '{ print $1 + $2 }' >>"$file"
    [ ! -s "$folder/said" ] || { cat "$folder/said" >&2; exit 1; }
}
number() { # KEY FILE: the first number of that key
    sed -n "s/.*\"$1\": *\([0-9.e+-]*\).*/\1/p" "$2" | head -n 1
}
median() { # FILE
    sort -g "$1" | awk '{ a[NR] = $1 } END { print a[int((NR + 1) / 2)] }'
}
row() { # NAME: medians of both builds and their ratio
    awk -v name="$1" -v a="$(median "$folder/$2.whole")" -v b="$(median "$folder/$2.surfaces")" \
        'BEGIN { printf "| %s | %.4g | %.4g | %.3f |\n", name, a, b, a / b }'
}

rm -f "$folder"/*.whole "$folder"/*.surfaces
for ((i = 0; i < runs; i++)); do
    for build in whole surfaces; do
        rm -rf "$folder/baked.$build"
        timed "$folder/bake.$build" "${bin[$build]}/airlight-bake" "$folder/scene.json" -o "$folder/baked.$build" --quiet
        timed "$folder/play.$build" "${bin[$build]}/airlight-play" "$folder/baked.$build" --headless --quiet --size 768x512 \
            --frames 11 --stats "$folder/stats.$build.json"
        number frame_ms_median "$folder/stats.$build.json" >>"$folder/frame.$build"
    done
done

for build in whole surfaces; do
    grep -o '"name": "[a-z-]*"' "$folder/stats.$build.json" | sort >"$folder/passes.$build"
    number memory_bytes "$folder/stats.$build.json" >"$folder/bytes.$build"
done
cmp "$folder/passes.whole" "$folder/passes.surfaces"
cmp "$folder/bytes.whole" "$folder/bytes.surfaces"
cmp "$folder/baked.whole/scene.air" "$folder/baked.surfaces/scene.air"
echo "passes: $(sed 's/.*: //' "$folder/passes.whole" | tr -d '"' | tr '\n' ' '); $(cat "$folder/bytes.whole") bytes in both"
echo "| median of $runs | whole | surfaces alone | ratio |"
echo "| --- | --- | --- | --- |"
row "bake, CPU s" bake
row "play, CPU s" play
row "frame, ms" frame
