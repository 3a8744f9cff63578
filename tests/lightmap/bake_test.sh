#!/bin/sh
# Lightmaps as a job: the same bytes for any threads and interruption, nothing done twice, wrong input refused.
# usage: bake_test.sh FOLDER_OF_PROGRAMS
set -u
bin=$1
. "$(dirname "$0")/../programs/expect.sh"

# scene LIGHTMAP_SETTINGS MORE: a ball and a block, half in the floor, over it.
scene() {
    cat <<SCENE
{
  "meshes": [
    {"name": "floor", "shape": {"type": "plane", "width_m": 4, "depth_m": 4}, "lighting": "lightmap", "material": "grey"},
    {"name": "ball", "shape": {"type": "sphere", "radius_m": 0.5, "subdivisions": 3}, "lighting": "lightmap",
     "material": "red", "transform": {"translate_m": [0.5, 0.5, 0]}},
    {"name": "block", "shape": {"type": "box", "size_m": [0.5, 1, 0.5]}, "lighting": "lightmap", "material": "grey",
     "transform": {"translate_m": [-1, 0.2, 0.5]}}
  ],
  "materials": [{"name": "red", "base_color": [0.8, 0.2, 0.1]}, {"name": "grey", "base_color": 0.6}],
  "lights": [{"name": "lamp", "type": "point", "position_m": [1, 2, 1.5], "intensity_w_sr": 5}],
  "environment": {"radiance_w_m2_sr": [0.1, 0.15, 0.2]},
  "lightmap": {"texel_m": 0.1, "samples": 64, "bounces": 2, "directional_order": 2$1}$2
}
SCENE
}
scene "" "" >"$work/room.json"

bake() {
    to=$1
    shift
    "$bin/airlight-bake" "$work/room.json" -o "$work/$to" "$@"
}
same() {
    for file in room.lightmap.air scene.air lightmap_0.exr scene.glb; do
        cmp "$work/plain/$file" "$work/$1/$file" || wrong "$file of $1 differs"
    done
}

started=$(date +%s%N)
run 0 bake plain
whole_ms=$((($(date +%s%N) - started) / 1000000))
for asset in room.lightmap.air scene.air; do run 0 "$bin/airlight-inspect" --check "$work/plain/$asset"; done
run 0 "$bin/lightmap_exr_layers" "$work/plain/room.lightmap.air" "$work/plain/lightmap_0.exr"
run 0 bake one --threads 1 && same one
run 0 bake three --threads 3 && same three

# The floor below the lamp: what it sends there, cos / distance^2 from 2 m above, and a sky of 0.1 that the ball hides
# a part of: between them without and with all of the sky, and what the ball sends back.
run 0 "$bin/airlight-inspect" "$work/plain/room.lightmap.air" --eval '{"position": [1, 0, 1.5], "normal": [0, 1, 0]}'
awk -F'[][,]' '{ exit !($2 > 5 / 4 && $2 < 5 / 4 + 3.1416 * 0.1 * 1.1) }' "$work/stdout" || wrong "light below the lamp: $(cat "$work/stdout")"

# The floor inside the block sees its back: replaced, not black.
run 0 "$bin/airlight-inspect" --json "$work/plain/room.lightmap.air"
awk -F'[: ,]+' '/"texels_replaced"/ { exit !($3 >= 9) }' "$work/stdout" || wrong "no texels under the block are replaced"

# The noise that the asset states: between nothing and a tenth with 64 paths, and with 16 times as many a quarter of it
# if paths were independent, less since they are spread evenly.
noise() { "$bin/airlight-inspect" --json "$1" | tr -d ' \n' | sed 's/.*"noise":{"surface":\([0-9.e-]*\).*/\1/'; }
# The same figure beside the layer's measured error, relative to the light of the second paths alone there.
run 0 "$bin/airlight-inspect" --json "$work/plain/room.lightmap.air"
awk -v noise="$(noise "$work/plain/room.lightmap.air")" -F'[: ,]+' '/"truth_rms"/ && !truth { truth = $3 }
    /"standard_error"/ && !error { error = $3 } END { exit !(truth > 0 && error / truth > 0.95 * noise && error / truth < 1.05 * noise) }' \
    "$work/stdout" || wrong "the measured error is not the stated noise"
sed 's/"samples": 64/"samples": 1024/' "$work/room.json" >"$work/many.json"
run 0 "$bin/airlight-bake" "$work/many.json" -o "$work/many" --quiet
awk -v few="$(noise "$work/plain/room.lightmap.air")" -v many="$(noise "$work/many/many.lightmap.air")" \
    'BEGIN { exit !(few > 0.001 && few < 0.1 && many > 0 && many < 0.35 * few) }' ||
    wrong "stated noise: $(noise "$work/plain/room.lightmap.air"), with more paths $(noise "$work/many/many.lightmap.air")"

# A closed room whose walls emit 1 and reflect a half: 1 / (1 - 0.5) everywhere, so pi times that falls onto every texel.
# 16 bounces leave out 2^-17 of it. Paths are drawn, so the mean of all texels is held to 0.5 %.
{
    for y in -1 1; do for z in -1 1; do for x in -1 1; do echo "v $x $y $z"; done; done; done
    printf 'f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n'
} >"$work/furnace.obj"
cat >"$work/furnace.json" <<SCENE
{"meshes": [{"name": "walls", "file": "furnace.obj", "lighting": "lightmap", "material": "glow"}],
 "materials": [{"name": "glow", "base_color": 0.5, "emission_w_m2_sr": 1, "double_sided": true}],
 "lightmap": {"texel_m": 0.1, "samples": 256, "bounces": 16}}
SCENE
run 0 "$bin/airlight-bake" "$work/furnace.json" -o "$work/furnace" --quiet
run 0 "$bin/airlight-inspect" --json "$work/furnace/furnace.lightmap.air"
tr -d ' \n' <"$work/stdout" | sed 's/.*"surface":{"mean_w_m2":\[\([0-9.]*\),.*/\1/' |
    awk '{ exit !($1 > 0.995 * 6.2832 && $1 < 1.005 * 6.2832) }' || wrong "furnace: $(cat "$work/stdout")"
grep -q '"texels_baked": 2400,' "$work/stdout" || wrong "six walls of 20 x 20 texels: $(grep texels_ "$work/stdout")"

# A second run does nothing.
files() { find "$work/plain" -type f ! -name report.json -exec ls -i {} + | sort; }
before=$(files)
run 0 bake plain
grep -q "room.lightmap.air is up to date" "$work/stderr" || wrong "does not say that the lightmap is up to date"
[ "$before" = "$(files)" ] || wrong "files were written again"
[ "$(grep -c '"bytes_written"' "$work/plain/report.json")" = 1 ] || wrong "the report of an idle run lists steps"

# The report lists what lies in the folder, written in this run or not, and how large it is.
listed() {
    tr -d ' \n' <"$1/report.json" | grep -o '"path":"[^"]*","kind":"[^"]*","bytes":[0-9]*' |
        sed 's/"path":"\(.*\)","kind":"\(.*\)","bytes":/\1 \2 /' | sort
}
for folder in plain one; do
    [ "$(listed "$work/$folder" | cut -d ' ' -f 1,2)" = "lightmap_0.exr exr
room.lightmap.air lightmap
scene.air scene
scene.glb glb" ] || wrong "the report of $folder lists $(listed "$work/$folder")"
    [ "$(listed "$work/$folder" | cut -d ' ' -f 1,3)" = "$(find "$work/$folder" -type f ! -name report.json -printf '%P %s\n' | sort)" ] ||
        wrong "the report of $folder does not list what is there: $(listed "$work/$folder")"
done

# What is gone is made again, to the same bytes, and only that: no light is gathered, other assets stay the files they
# are. Without scene.air, which is written last, nobody knows whether the pictures are this lightmap's: they are written
# too. In a report, steps alone have a name.
again() {
    gone=$1 steps=$2
    before=$(files | grep -v "/$gone$")
    rm "$work/plain/$gone"
    run 0 bake plain
    grep -q "room.lightmap.air is up to date" "$work/stderr" || wrong "the lightmap is baked again for a missing $gone"
    cmp "$work/one/$gone" "$work/plain/$gone" || wrong "another $gone"
    did=$(sed -n 's/.*"name": "\(.*\)",/\1/p' "$work/plain/report.json" | tr '\n' ' ')
    [ "$did" = "$steps" ] || wrong "steps for a missing $gone: $did"
    [ "$gone" = scene.air ] || [ "$before" = "$(files | grep -v "/$gone$")" ] || wrong "more than $gone was written"
}
again lightmap_0.exr "import pages "
again scene.glb "import scene atlas "
again scene.air "import scene atlas pages "
run 0 bake plain
same one
[ "$(grep -c '"bytes_written"' "$work/plain/report.json")" = 1 ] || wrong "an idle run after repairs lists steps"

# Stopped and killed, again and again: in the end the same bytes.
mkdir "$work/cut"
rounds=0
interrupted=0
share=40
signal=TERM
while [ ! -f "$work/cut/scene.air" ] && [ $rounds -lt 60 ]; do
    rounds=$((rounds + 1))
    "$bin/airlight-bake" "$work/room.json" -o "$work/cut" --quiet --threads 1 2>"$work/stderr" &
    pid=$!
    sleep "$(awk -v ms=$whole_ms -v share=$share 'BEGIN { print ms * share / 100000 }')"
    kill -$signal $pid 2>/dev/null
    code=0
    wait $pid || code=$?
    case $code in
    0)
        if [ $interrupted = 0 ]; then
            rm -rf "$work/cut"
            mkdir "$work/cut"
            share=$((share * 3 / 4 + 1))
        fi
        ;;
    130) interrupted=$((interrupted + 1)) ;;
    137) interrupted=$((interrupted + 1)) ;;
    143) share=$((share + 5)) ;; # before the program had begun
    *) wrong "interrupted bake ends with $code: $(cat "$work/stderr")" ;;
    esac
    if [ $signal = TERM ]; then signal=KILL; else signal=TERM; fi
    share=$((share + 3))
done
[ $interrupted -gt 0 ] || wrong "no bake was interrupted"
[ -f "$work/cut/scene.air" ] || run 0 bake cut
same cut
[ ! -e "$work/cut/room.lightmap.air.partial" ] || wrong "unfinished work is left behind"
echo "$interrupted interruptions"

# refused WORDS SETTINGS MORE
refused() {
    scene "$2" "$3" >"$work/wrong.json"
    fails 3 "$1" "$bin/airlight-bake" "$work/wrong.json" -o "$work/wrong"
    [ ! -e "$work/wrong/wrong.lightmap.air" ] || wrong "a lightmap was written: $1"
}
refused 'wrong.json: mesh "floor" has no second UV set, which "uv": "file" asks for' ', "uv": "file"' ""
sed 's/"position_m": \[1, 2, 1.5\]/"position_m": [0.5, 0.5, 0]/' "$work/room.json" >"$work/inside.json"
fails 3 'light "lamp" at (0.5, 0.5, 0) stands inside walls' "$bin/airlight-bake" "$work/inside.json" -o "$work/wrong"
printf 'v 0 3 0\nv 1 3 0\nv 2 3 0\nf 1 2 3\n' >"$work/line.obj"
sed -e 's/"meshes": \[/"meshes": [{"name": "line", "file": "line.obj", "material": "hot"},/' \
    -e 's/"materials": \[/"materials": [{"name": "hot", "emission_w_m2_sr": 5},/' "$work/room.json" >"$work/flat.json"
fails 3 'has no area and cannot emit as its material "hot" says' "$bin/airlight-bake" "$work/flat.json" -o "$work/wrong"
# Second UV sets of a file: a square whose triangles overlap there, or one of whose triangles has no area.
square() {
    cat >"$work/square.gltf" <<GLTF
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 1}, "indices": 2}]}],
 "buffers": [{"byteLength": 92, "uri": "data:application/octet-stream;base64,$1"}],
 "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
                 {"buffer": 0, "byteOffset": 80, "byteLength": 12}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 0, 1]},
               {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
               {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}]}
GLTF
    echo '{"meshes": [{"name": "square", "file": "square.gltf", "lighting": "lightmap"}],
        "lightmap": {"texel_m": 0.1, "samples": 1, "bounces": 0, "uv": "'"$2"'"}}' >"$work/square.json"
}
overlapping=AAAAAAAAAAAAAAAAAAAAAAAAAAAAAIA/AACAPwAAAAAAAAAAAACAPwAAAAAAAIA/AAAAAAAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAAAAAAAEAAgACAAEAAwA=
flat=AAAAAAAAAAAAAAAAAAAAAAAAAAAAAIA/AACAPwAAAAAAAAAAAACAPwAAAAAAAIA/AAAAAAAAAAAAAAAAAACAPwAAgD8AAAAAAAAAPwAAAD8AAAEAAgACAAEAAwA=
square $overlapping file
fails 3 'triangles 0 and 1 overlap in the second UV set' "$bin/airlight-bake" "$work/square.json" -o "$work/wrong"
square $flat file
fails 3 'triangle 1 has no area in the second UV set' "$bin/airlight-bake" "$work/square.json" -o "$work/wrong"
for set in $overlapping $flat; do
    square $set auto
    run 0 "$bin/airlight-bake" "$work/square.json" -o "$work/auto"
done
rm -rf "$work/wrong"

# One triangle, from a tenth of a millimetre to ten kilometres, and one in a single texel, under a sky of 1, of a millionth
# and of a million: pi times that, from cosine-distributed directions that all find the same within what halfs and draws of
# the sky allow, 1 %.
printf 'v 0 0 0\nv 0 0 1\nv 1 0 0\nf 1 2 3\n' >"$work/triangle.obj"
triangle() {
    cat >"$work/triangle.json" <<SCENE
{"meshes": [{"name": "t", "file": "triangle.obj", "unit_m": $1, "lighting": "lightmap"}],
 "environment": {"radiance_w_m2_sr": $3}, "lightmap": {"samples": 256$2}}
SCENE
    run 0 "$bin/airlight-bake" "$work/triangle.json" -o "$work/triangle" --quiet --quality preview
    run 0 "$bin/airlight-inspect" --json "$work/triangle/triangle.lightmap.air"
    tr -d ' \n' <"$work/stdout" | sed 's/.*"surface":{"mean_w_m2":\[\([0-9.e+-]*\),.*/\1/' |
        awk -v sky="$3" '{ exit !($1 > 0.99 * 3.1416 * sky && $1 < 1.01 * 3.1416 * sky) }' ||
        wrong "a triangle of $1 m$2 under a sky of $3: $(cat "$work/stdout")"
}
triangle 1e-4 "" 1
triangle 1 "" 1
triangle 1e4 "" 1
triangle 1 ', "texel_m": 10' 1
triangle 1 "" 1e-6
triangle 1 "" 1e6

# Another scene in the same folder and back: the picture is of the lightmap that was asked for last.
sed 's/"radiance_w_m2_sr": 1/"radiance_w_m2_sr": 0.25/' "$work/triangle.json" >"$work/dim.json"
run 0 "$bin/airlight-bake" "$work/dim.json" -o "$work/triangle" --quality preview
run 1 "$bin/lightmap_exr_layers" "$work/triangle/triangle.lightmap.air" "$work/triangle/lightmap_0.exr"
run 0 "$bin/airlight-bake" "$work/triangle.json" -o "$work/triangle" --quality preview
grep -q "triangle.lightmap.air is up to date" "$work/stderr" || wrong "light is gathered again after another scene"
run 0 "$bin/lightmap_exr_layers" "$work/triangle/triangle.lightmap.air" "$work/triangle/lightmap_0.exr"

# The plan says that it is needed, and for a scene without that it is not.
run 0 "$bin/airlight-bake" "$work/room.json" --plan
grep -A1 '"lightmap"' "$work/stdout" | grep -q '"needed": true' || wrong "the plan has no lightmap"
sed 's/"lighting": "lightmap"/"lighting": "dynamic"/' "$work/room.json" >"$work/without.json"
run 0 "$bin/airlight-bake" "$work/without.json" --plan
grep -A1 '"lightmap"' "$work/stdout" | grep -q '"needed": false' || wrong "the plan has a lightmap for nothing"
run 0 "$bin/airlight-bake" "$work/without.json" -o "$work/without"
[ ! -e "$work/without/scene.glb" ] && [ ! -e "$work/without/without.lightmap.air" ] || wrong "a lightmap for nothing"

# A full disk: one line, code 4, no half asset.
if [ "$(id -u)" = 0 ] && mkdir "$work/full" && mount -t tmpfs -o size=300k tmpfs "$work/full" 2>/dev/null; then
    mounted="$work/full"
    fails 4 "$work/full" "$bin/airlight-bake" "$work/room.json" -o "$work/full" --quiet
    [ ! -e "$work/full/room.lightmap.air" ] || wrong "a lightmap on a full disk"
else
    echo "SKIP: a full disk needs a small mount, and that needs root"
fi
finish
