#!/bin/sh
# airlight-bake as a job: the same bytes for any threads, memory limit and interruption; nothing done twice.
# usage: bake_test.sh FOLDER_OF_PROGRAMS
set -u
bin=$1
. "$(dirname "$0")/../programs/expect.sh"

cat >"$work/scene.json" <<'SCENE'
{
  "meshes": [
    {"name": "ball", "shape": {"type": "sphere", "radius_m": 0.5, "subdivisions": 4}},
    {"name": "core", "shape": {"type": "sphere", "radius_m": 0.1, "subdivisions": 3}}
  ],
  "lights": [{"name": "sun", "type": "directional", "direction": [0, -1, 0], "irradiance_w_m2": 3}],
  "media": [{"name": "jelly", "sigma_s_per_m": [2, 3, 4], "sigma_a_per_m": 0.5}],
  "translucents": [{"name": "object", "mesh": "ball", "medium": "jelly", "blockers": ["core"]}],
  "bake": {"directions": 256, "grid_resolution": 40, "samples": 2000, "sh_order": 4}
}
SCENE

bake() {
    to=$1
    shift
    "$bin/airlight-bake" "$work/scene.json" -o "$work/$to" "$@"
}
same() {
    for asset in scene.air object.translucent.air; do
        cmp "$work/plain/$asset" "$work/$1/$asset" || wrong "$asset of $1 differs"
    done
}

started=$(date +%s%N)
run 0 bake plain
whole_ms=$((($(date +%s%N) - started) / 1000000))
run 0 "$bin/airlight-inspect" --check "$work/plain/object.translucent.air"
run 0 bake one --threads 1 && same one
run 0 bake three --threads 3 && same three
run 0 bake small --memory-limit 16 && same small

# A second run does nothing: the files keep their inodes and the report names no step but the import.
before=$(ls -i "$work/plain"/*.air)
run 0 bake plain
[ "$before" = "$(ls -i "$work/plain"/*.air)" ] || wrong "assets were written again"
grep -q "up to date" "$work/stderr" || wrong "does not say that assets are up to date"
[ "$(grep -c '"bytes_written"' "$work/plain/report.json")" = 1 ] || wrong "the report of an idle run lists steps"

# Interrupted again and again: code 130, no asset half-written, and in the end the same bytes. Each round waits for a
# share of what the whole bake took; a bake that was done before its first interruption begins anew with less.
mkdir "$work/cut"
rounds=0
interrupted=0
share=60
while [ ! -f "$work/cut/scene.air" ] && [ $rounds -lt 60 ]; do
    rounds=$((rounds + 1))
    "$bin/airlight-bake" "$work/scene.json" -o "$work/cut" --quiet 2>"$work/stderr" &
    pid=$!
    sleep "$(awk -v ms=$whole_ms -v share=$share 'BEGIN { print ms * share / 100000 }')"
    kill -TERM $pid 2>/dev/null # as Ctrl-C; a script's background jobs ignore SIGINT until they say otherwise
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
    143) share=$((share + 5)) ;; # before the program had begun
    *) wrong "interrupted bake ends with $code: $(cat "$work/stderr")" ;;
    esac
    [ ! -e "$work/cut/object.translucent.air" ] || cmp "$work/plain/object.translucent.air" "$work/cut/object.translucent.air" ||
        wrong "an interrupted bake left another asset"
done
[ $interrupted -gt 0 ] || wrong "no bake was interrupted"
[ -f "$work/cut/scene.air" ] || run 0 bake cut
same cut
[ ! -e "$work/cut/object.translucent.air.partial" ] || wrong "unfinished work is left behind"
echo "$interrupted interruptions"

# Names that would make the same file name keep assets of their own; a binary PLY whose first byte is a line end.
one='\000\000\200\077' zero='\000\000\000\000' line_end='\012\012\043\075'
{
    printf 'ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n'
    printf 'element face 4\nproperty list uchar uchar vertex_indices\nend_header\n'
    printf "$line_end$zero$zero$one$zero$zero$zero$one$zero$zero$zero$one"
    printf '\003\000\002\001\003\000\001\003\003\001\002\003\003\000\003\002'
} >"$work/line_end.ply"
cat >"$work/names.json" <<'SCENE'
{
  "meshes": [
    {"name": "ball", "shape": {"type": "sphere", "radius_m": 0.5, "subdivisions": 2}},
    {"name": "corner", "file": "line_end.ply"}
  ],
  "media": [{"name": "jelly", "sigma_s_per_m": 1, "sigma_a_per_m": 0}],
  "translucents": [
    {"name": "a/b", "mesh": "ball", "medium": "jelly"},
    {"name": "a_b", "mesh": "corner", "medium": "jelly"}
  ],
  "bake": {"directions": 8, "grid_resolution": 8, "samples": 40, "sh_order": 2}
}
SCENE
run 0 "$bin/airlight-bake" "$work/names.json" -o "$work/names" --quiet
[ "$(find "$work/names" -name '*.translucent.air' | wc -l)" = 2 ] || wrong "two objects share an asset"

run 0 "$bin/airlight-bake" "$work/scene.json" --plan
grep -q '"colour channels"' "$work/stdout" || wrong "the plan does not speak of colour channels"
run 2 "$bin/airlight-bake" "$work/scene.json"
run 2 "$bin/airlight-bake" "$work/scene.json" -o "$work/x" --quality best
run 5 "$bin/airlight-bake" "$work/scene.json" -o "$work/x" --device 999
finish
