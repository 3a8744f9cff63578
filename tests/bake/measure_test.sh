#!/bin/sh
# A baked sphere carries its error: what the closed form says, more where it is baked coarser.
# usage: measure_test.sh FOLDER_OF_PROGRAMS MEASURE_CHECK
set -u
bin=$1
check=$2
. "$(dirname "$0")/../programs/expect.sh"

scene() { # NAME SETTINGS
    cat >"$work/$1.json" <<SCENE
{
  "meshes": [{"name": "ball", "shape": {"type": "sphere", "radius_m": 0.5, "subdivisions": 5}}],
  "media": [{"name": "jelly", "sigma_s_per_m": 3, "sigma_a_per_m": 0.5}],
  "translucents": [{"name": "ball", "mesh": "ball", "medium": "jelly"}],
  "bake": {$2}
}
SCENE
    run 0 "$bin/airlight-bake" "$work/$1.json" -o "$work/$1" --quiet
}

scene fine '"directions": 256, "grid_resolution": 40, "samples": 2000, "sh_order": 5'
scene coarse '"directions": 256, "grid_resolution": 40, "samples": 2000, "sh_order": 2'
grep -q '"name": "measure"' "$work/fine/report.json" || wrong "the report lists no step measure"
run 0 "$bin/airlight-inspect" "$work/fine/ball.translucent.air"
grep -q '^measured: transmittance at random points' "$work/stdout" || wrong "airlight-inspect shows no error"
grep -q '1024 numbers; 256 directions, [0-9]* samples, order 5, 40 voxels' "$work/stdout" || wrong "airlight-inspect: other settings"
run 0 "$bin/airlight-inspect" --check "$work/fine/ball.translucent.air"
run 0 "$check" 0.5 3.5 "$work/fine/ball.translucent.air" "$work/coarse/ball.translucent.air"
cat "$work/stdout"
finish
