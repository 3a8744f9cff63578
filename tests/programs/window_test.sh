#!/bin/sh
# window_test.sh BIN: airlight-play in a window of a virtual X server, driven by keys and mouse.
set -eu
bin=$1
. "$(dirname "$0")/expect.sh"
for tool in Xvfb xdotool; do command -v $tool >/dev/null || skip "$tool is not installed"; done

cat >"$work/scene.json" <<'JSON'
{
  "meshes": [{"name": "ball", "shape": {"type": "sphere", "radius_m": 0.5, "subdivisions": 3}}],
  "media": [{"name": "fog", "sigma_s_per_m": 3, "density": {"type": "constant"}}],
  "translucents": [{"name": "ball", "mesh": "ball", "medium": "fog"}],
  "lights": [{"type": "directional", "direction": [1, -1, -1], "irradiance_w_m2": 3}],
  "environment": {"radiance_w_m2_sr": [0.1, 0.2, 0.3]},
  "cameras": [{"position_m": [0, 0, 4], "target_m": [0, 0, 0], "fov_y_degrees": 30}],
  "bake": {"directions": 32, "grid_resolution": 16, "radius_m": 0.1, "sh_order": 3}
}
JSON
run 0 "$bin/airlight-bake" "$work/scene.json" -o "$work/baked" --quiet
[ "$failures" = 0 ] || finish

# The server picks a free display number and writes it to descriptor 3.
Xvfb -displayfd 3 -screen 0 640x480x24 3>"$work/display" 2>"$work/xvfb.log" &
server=$!
stop_server() { kill "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; clean_up; }
trap stop_server EXIT
for i in 1 2 3 4 5 6 7 8 9 10; do [ -s "$work/display" ] && break; sleep 0.5; done
[ -s "$work/display" ] || skip "Xvfb does not start: $(tail -n 1 "$work/xvfb.log")"
DISPLAY=:$(cat "$work/display")
export DISPLAY

cd "$work"
"$bin/airlight-play" "$work/baked" --size 640x480 >"$work/out" 2>"$work/err" &
player=$!
window=$(timeout 60 xdotool search --sync --onlyvisible --name '^airlight$' | head -n 1)
xdotool windowfocus "$window" 2>/dev/null || true

# wrote NUMBER: waits for the screenshot.
wrote() {
    for i in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20; do
        [ -s "airlight-$1.exr" ] && [ -s "airlight-$1.png" ] && return 0
        sleep 0.5
    done
    wrong "no screenshot $1: $(cat "$work/err")"
}
xdotool mousemove 500 300
sleep 1
xdotool key p
wrote 0001
xdotool mousemove 450 200 mousedown 1 mousemove 500 180 sleep 0.3 mousemove 560 220 sleep 0.3 mouseup 1
sleep 0.5
xdotool key p
wrote 0002
run 1 "$bin/airlight-compare" airlight-0001.exr airlight-0002.exr --fail-above max_abs=1e-3
xdotool key Escape
wait "$player" || wrong "the player ends with $?"
finish
