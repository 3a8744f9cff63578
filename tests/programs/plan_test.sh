#!/bin/bash
# Only what a scene needs: of every row of both plans a scene that needs it and the plain one, which does not; rows that are not
# needed cost nothing, passes that ran are those of needed rows, and the rows' bytes are all that is held.
# usage: plan_test.sh FOLDER_OF_PROGRAMS
set -u
bin=$1
. "$(dirname "$0")/expect.sh"

# rows FILE: "STEP NEEDED SECONDS BYTES" of each row, words of a step joined by dashes.
rows() {
    awk -F': ' '/"step":/ { gsub(/[",]/, "", $2); gsub(/ /, "-", $2); step = $2 }
        /"needed":/ { sub(/,/, "", $2); needed = $2 }
        /"why": ""/ { print "no-reason" }
        /"seconds":/ && step { sub(/,/, "", $2); seconds = $2 }
        /"bytes":/ && step { print step, needed, seconds, $2; step = "" }' "$1"
}
needed() { awk '$2 == "true" { print $1 }' "$1" | sort | xargs; }
same() { [ "$1" = "$2" ] || wrong "$3: '$1', not '$2'"; }

# needs ROWS FILE NAME: these, not those of the plain scene, and all that are not needed cost nothing.
needs() {
    for row in $1; do
        grep -q "^$row true " "$2" || wrong "$3: row $row is not needed"
        [ "$3" = plain ] || [ "$row" = scene ] || grep -q "^$row false 0.0 0\$" "${2%/*}/plain.${2##*.}" || wrong "row $row is needed in the plain scene"
        echo "$row" >>"$work/seen.${2##*.}"
    done
    awk '$2 != "true" && ($3 != 0 || $4 != 0)' "$2" | grep . && wrong "$3: skipped rows cost something"
}

# bakes NAME ROWS: by the plan of scene NAME.
bakes() {
    run 0 "$bin/airlight-bake" "$work/$1.json" -o "$work/$1" --plan
    rows "$work/stdout" >"$work/$1.bake"
    needs "$2" "$work/$1.bake" "$1"
}

# plays NAME ROWS SCENE OPTIONS...: by what a frame of that baked scene ran and holds.
plays() {
    name=$1 list=$2 scene=$3
    shift 3
    [ -e "$work/$scene" ] || run 0 "$bin/airlight-bake" "$work/$scene.json" -o "$work/$scene" --quiet
    run 0 "$bin/airlight-play" "$work/$scene" --headless --size 16x16 --bounce-samples 1 --stats "$work/$name.json_" "$@"
    rows "$work/$name.json_" >"$work/$name.play"
    needs "$list" "$work/$name.play" "$name"
    held=$(sed -n 's/ *"memory_bytes": \([0-9]*\).*/\1/p' "$work/$name.json_")
    same "$(awk '$2 == "true" { sum += $4 } END { printf "%.0f", sum }' "$work/$name.play")" "$held" "$name: bytes of needed rows"
    sed -n 's/.*"name": "\(.*\)",*/\1/p' "$work/$name.json_" | tr ' ' - | sort | xargs >"$work/$name.passes"
    for row in $(awk '$2 == "false" { print $1 }' "$work/$name.play"); do
        case " $(cat "$work/$name.passes") " in *" $row "*) wrong "$name: $row ran" ;; esac
    done
}

# scene NAME MEMBERS: with a floor, a lamp and a bar that hides some of it.
scene() {
    cat >"$work/$1.json" <<JSON
{
  "cameras": [{"name": "c", "position_m": [0, 1, 3], "target_m": [0, 0, 0]}],
  "bake": {"directions": 32, "grid_resolution": 8, "samples": 200, "sh_order": 3, "too_dense": "bake"},
  "lightmap": {"texel_m": 1, "samples": 4, "bounces": 1, "fog_points": 2, "directional_order": ${3:-0},
    "walls": "${4:-bounded}"},
  "lights": [{"name": "lamp", "type": "point", "position_m": [0, 2, 1], "intensity_w_sr": 9}],
  $2
}
JSON
}
floor='{"name": "floor", "material": "matt", "shape": {"type": "plane", "width_m": 4, "depth_m": 4}}'
bar='{"name": "bar", "material": "matt", "shape": {"type": "box", "size_m": [0.3, 0.3, 0.3]}, "transform": {"translate_m": [1, 0.5, 0]}}'
matt='"materials": [{"name": "matt", "ior": 1}]'
meshes='"meshes": ['$floor', '$bar']'
box='"bounds_min_m": [-1, 0, -1], "bounds_max_m": [1, 1, 1]'
constant='{"name": "haze", "sigma_s_per_m": 0.2, "sigma_a_per_m": 0.1}'

# --- the plain scene: passes and rows by name ---
scene plain "$matt, $meshes"
bakes plain scene
same "$(needed "$work/plain.bake")" scene "the plain scene's bakes"
plays plain "scene shadow surface composite" plain
same "$(needed "$work/plain.play")" "composite scene shadow surface" "the plain scene's rows"
same "$(cat "$work/plain.passes")" "composite shadow surface" "the plain scene's passes"
same "$(sed -n 's/.*"name": "\(.*\)",/\1/p' "$work/plain/report.json" | sort -u | xargs)" "import scene" "the plain scene's steps"

# --- rows of what else is lit, seen or moved ---
scene sky "$matt, $meshes, \"environment\": {\"radiance_w_m2_sr\": 0.2}"
bakes sky environment
plays sky "environment surfels ambient-occlusion indirect" sky --ambient-occlusion --indirect
grep -q '^glossy false' "$work/sky.play" || wrong "matt surfaces are glossy"
scene gloss "\"materials\": [{\"name\": \"matt\", \"roughness\": 0.3}], $meshes"
plays gloss "indirect glossy temporal" gloss --indirect --temporal 4
scene fog "$matt, $meshes, \"media\": [$constant], \"fogs\": [\"haze\"]"
plays fog "direct-scattering surfels interval-map surface-scattering visibility" fog --visibility
haze='"media": [{"name": "haze", "sigma_s_per_m": 0.2, "optical_depth_order": 2, "density": {"type": "layers", "period_m": 0.5,
    "thickness_m": 0.25, '$box'}}], "fogs": ["haze"]'
scene layers "$matt, $meshes, $haze, \"environment\": {\"radiance_w_m2_sr\": 0.2}"
bakes layers "medium sky-light fog-depth"
plays layers "density-grid sky-light" layers
jelly='{"name": "jelly", "shape": {"type": "sphere", "subdivisions": 2, "radius_m": 0.4}}'
seed='{"name": "seed", "shape": {"type": "sphere", "subdivisions": 1, "radius_m": 0.1}}'
scene object "$matt, \"meshes\": [$floor, $jelly, $seed],
  \"media\": [{\"name\": \"jelly\", \"sigma_s_per_m\": [1, 2, 3]}],
  \"translucents\": [{\"mesh\": \"jelly\", \"medium\": \"jelly\", \"blockers\": [\"seed\"]}]"
bakes object "voxelise blockers optical-depth moment divergence sample project measure colour-channels"
plays object "light intervals splat" object
lit='{"name": "floor", "material": "matt", "lighting": "lightmap", "shape": {"type": "plane", "width_m": 4, "depth_m": 4}}'
moving='{"name": "bar", "material": "matt", "lighting": "probes", "shape": {"type": "box", "size_m": 0.3}, "motion": [{"time_s": 0},
    {"time_s": 1, "translate_m": [0, 1, 0]}]}'
scene baked "$matt, \"meshes\": [$lit, $moving], \"probes\": {\"points\": [{\"position_m\": [0, 1, 0]}], \"samples\": 4}" 2
bakes baked "motion atlas lightmap directional-lightmap seams probes"
plays baked "lightmap probes" baked
scene tables "$matt, \"meshes\": [$lit], \"media\": [$constant], \"fogs\": [\"haze\"]" 0 published
bakes tables "impulse-tables"

# A triangle with one morph target that moves its first corner by 1 m: positions, steps, times, weights.
zero='\0\0\0\0' one='\0\0\200\077'
printf "$zero$zero$zero$one$zero$zero$zero$one$zero$one$zero$zero$zero$zero$zero$zero$zero$zero$zero$one$zero$one" >"$work/morph.bin"
cat >"$work/morph.gltf" <<'JSON'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
 "buffers": [{"uri": "morph.bin", "byteLength": 88}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 36},
   {"buffer": 0, "byteOffset": 72, "byteLength": 8}, {"buffer": 0, "byteOffset": 80, "byteLength": 8}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
   {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 0, 0]},
   {"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
   {"bufferView": 3, "componentType": 5126, "count": 2, "type": "SCALAR"}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 1}]}]}],
 "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}], "samplers": [{"input": 2, "output": 3}]}]}
JSON
morph='{"name": "morph", "file": "morph.gltf"}'
scene skin "$matt, \"meshes\": [$floor, $morph]"
bakes skin motion
plays skin skin skin

# --- the sum of all ---
scene all "$matt, \"meshes\": [$lit, $moving, $jelly, $seed, $morph, {\"name\": \"gloss\", \"shape\": {\"type\": \"box\", \"size_m\": 0.2},
    \"transform\": {\"translate_m\": [-1, 0.5, 0]}}],
  \"probes\": {\"points\": [{\"position_m\": [0, 1, 0]}], \"samples\": 4}, \"environment\": {\"radiance_w_m2_sr\": 0.2},
  \"media\": [{\"name\": \"jelly\", \"sigma_s_per_m\": [1, 2, 3]}, ${haze#*[}, \"translucents\": [{\"mesh\": \"jelly\", \"medium\": \"jelly\",
    \"blockers\": [\"seed\"]}]" 2
plays all "" all --ambient-occlusion --indirect --visibility --temporal 4
same "$(needed "$work/all.play")" "$(awk '{ print $1 }' "$work/all.play" | sort | xargs)" "rows of the sum of all"
sed 's/"walls": "bounded"/"walls": "published"/' "$work/all.json" >"$work/whole.json"
bakes whole ""
same "$(needed "$work/whole.bake")" "$(awk '{ print $1 }' "$work/whole.bake" | sort | xargs)" "bakes of the sum of all"

for plan in bake play; do
    same "$(sort -u "$work/seen.$plan" | xargs)" "$(awk '{ print $1 }' "$work/plain.$plan" | sort | xargs)" "rows with a scene, $plan"
done
finish
