#!/bin/sh
# trade_test.sh BIN: airlight-trade on a small scene: columns, resuming, wrong usage and input.
set -eu
bin=$1
. "$(dirname "$0")/../programs/expect.sh"

cat >"$work/scene.json" <<'JSON'
{
  "meshes": [{"name": "ball", "shape": {"type": "sphere", "radius_m": 0.5, "subdivisions": 2}}],
  "media": [{"name": "wax", "sigma_s_per_m": 1, "density": {"type": "constant"}}],
  "translucents": [{"name": "ball", "mesh": "ball", "medium": "wax"}],
  "lights": [{"type": "directional", "direction": [1, -1, -1], "irradiance_w_m2": 3}],
  "cameras": [{"name": "front", "position_m": [0, 0, 4], "target_m": [0, 0, 0], "fov_y_degrees": 30}],
  "bake": {"directions": 32, "grid_resolution": 16, "samples": 200, "sh_order": 3}
}
JSON
settings="--size 16x16 --spp 4 --frames 1 --combinations 0 --knob march-step=2,0.5 --knob intervals=4,16"
trade() {
    # shellcheck disable=SC2086
    "$bin/airlight-trade" "$work/scene.json" $settings "$@"
}
finished() { # points that are whole
    find "$work/parts/points" -name '*.json' ! -name '*.*.json' 2>/dev/null | sort
}
untimed() { # without seconds, frame_ms and the front that follows from it
    cut -d, -f1-11,14,15,18 "$1"
}

trade -o "$work/whole" --quiet >"$work/stdout" 2>"$work/stderr" || code=$?
[ "${code:-0}" != 5 ] || skip "$(cat "$work/stderr")"
[ "${code:-0}" = 0 ] || wrong "exit code $code: $(cat "$work/stderr")"
[ ! -s "$work/stderr" ] || wrong "says something: $(cat "$work/stderr")"
# A ball alone: neither fog nor surfaces that light each other.
columns=bake.samples,bake.directions,bake.sh_order,bake.grid_resolution,samples,sh-order,view-leg,intervals,march-step
costs=relative_rmse,flip_ldr,seconds,frame_ms,memory_bytes,asset_bytes,front,held_out_relative_rmse,preset
[ "$(head -1 "$work/whole/trade.csv")" = "$columns,$costs" ] || wrong "columns: $(head -1 "$work/whole/trade.csv")"
[ "$(wc -l <"$work/whole/trade.csv")" = 4 ] || wrong "not three points: $(cat "$work/whole/trade.csv")"
grep -q '^200,32,3,16,all,all,marched,16,0.5,.*,medium$' "$work/whole/trade.csv" || wrong "no medium point"
awk -F, 'NR > 1 && ($16 == 1) != ($17 != "") { exit 1 }' "$work/whole/trade.csv" || wrong "held-out errors are not those of the front"
grep -q '<svg' "$work/whole/trade.html" && grep -q 'data:image/png;base64,' "$work/whole/trade.html" || wrong "no diagrams or pictures"
grep -Eq '(src|href)="[^d]' "$work/whole/trade.html" && wrong "the page is not self-contained"

# Again: nothing is measured again, so that times are the same too.
cp "$work/whole/trade.csv" "$work/first.csv"
run 0 trade -o "$work/whole" --quiet
cmp -s "$work/first.csv" "$work/whole/trade.csv" || wrong "a second run measured again"

# The same folder serves the bake and the player.
"$bin/airlight-bake" "$work/scene.json" -o "$work/whole" --target-error 10 2>"$work/stderr" || wrong "the bake: $(cat "$work/stderr")"
grep -q 'expects relative error 0.*held-out view.*bake.samples=200' "$work/stderr" || wrong "not what is expected: $(cat "$work/stderr")"
grep -q '"expected"' "$work/whole/report.json" || wrong "report.json does not say what is expected"
"$bin/airlight-play" "$work/whole" --headless --size 16x16 --target-error 10 --stats "$work/stats.json" 2>"$work/stderr" ||
    wrong "the player: $(cat "$work/stderr")"
grep -q 'expects relative error 0' "$work/stderr" && grep -q held_out_relative_rmse "$work/stats.json" ||
    wrong "the player does not say what is expected: $(cat "$work/stderr")"
fails 1 "no point meets" "$bin/airlight-play" "$work/whole" --headless --frame-ms 0.0001
# What was baked otherwise is no point of the table.
sed 's/"sh_order": 3/"sh_order": 2/' "$work/scene.json" >"$work/other.json"
run 0 "$bin/airlight-bake" "$work/other.json" -o "$work/whole" --quiet
fails 1 "no point was baked with the settings" "$bin/airlight-play" "$work/whole" --headless --target-error 10
run 0 "$bin/airlight-bake" "$work/scene.json" -o "$work/whole" --quiet
fails 3 "airlight-trade SCENE.json" "$bin/airlight-bake" "$work/scene.json" -o "$work/none" --target-error 1
sed '2s/,[^,]*,medium$/,soon,medium/' "$work/first.csv" >"$work/whole/trade.csv"
fails 3 "trade.csv:2: held_out_relative_rmse is 'soon'" "$bin/airlight-play" "$work/whole" --headless --frame-ms 1e9
cp "$work/first.csv" "$work/whole/trade.csv"

# Stopped after the first point: exit 130, and the same command goes on to the same result.
# shellcheck disable=SC2086
"$bin/airlight-trade" "$work/scene.json" $settings -o "$work/parts" --quiet >"$work/stdout" 2>"$work/stderr" &
child=$!
while kill -0 $child 2>/dev/null && [ -z "$(finished)" ]; do sleep 0.02; done
kill -TERM $child
code=0
wait $child || code=$?
[ $code = 130 ] || wrong "exit code $code, not 130, when stopped: $(cat "$work/stderr")"
kept=$(finished | head -1)
before=$(ls -i "$kept")
run 0 trade -o "$work/parts" --quiet
[ "$before" = "$(ls -i "$kept")" ] || wrong "a finished point was measured again"
untimed "$work/whole/trade.csv" >"$work/a"
untimed "$work/parts/trade.csv" >"$work/b"
cmp -s "$work/a" "$work/b" || wrong "going on gives another result: $(diff "$work/a" "$work/b")"

fails 2 "-o DIR is missing" "$bin/airlight-trade" "$work/scene.json"
fails 2 "fog-steps" trade -o "$work/whole" --quiet --knob fog-steps
fails 3 "none.json" "$bin/airlight-trade" "$work/none.json" -o "$work/none"
sed 's/"samples": 200/"samples": -1/' "$work/scene.json" >"$work/wrong.json"
fails 3 "wrong.json:7" "$bin/airlight-trade" "$work/wrong.json" -o "$work/none"
finish
