#!/bin/sh
# window_test.sh BIN: airlight-play in a window of a virtual X server, driven by keys, mouse and dropped folders.
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
# Another colour behind another object, in a folder whose name a URI has to escape.
sed -e 's/0.1, 0.2, 0.3/3, 1, 0.5/' -e 's/"radius_m": 0.5/"radius_m": 0.3/' "$work/scene.json" >"$work/other.json"
run 0 "$bin/airlight-bake" "$work/other.json" -o "$work/other 100%" --quiet
for name in baked "other 100%"; do
    run 0 "$bin/airlight-play" "$work/$name" --headless --size 640x480 --out "$work/$name.exr"
done
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
window=$(timeout 60 xdotool search --sync --onlyvisible --name 'baked - airlight$' | head -n 1)
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

# says WORDS NUMBER: waits until standard error has NUMBER lines, the last with WORDS.
says() {
    for i in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20; do
        [ "$(wc -l <err)" -ge "$2" ] && break
        sleep 0.5
    done
    [ "$(wc -l <err)" = "$2" ] || wrong "$(wc -l <err) lines on standard error, not $2: $(cat err)"
    tail -n 1 err | grep -qF -e "$1" || wrong "does not say '$1': $(cat err)"
}
# shows NAME NUMBER: screenshot NUMBER shows the folder, but for the jitter of the march.
shows() {
    xdotool key p
    wrote "$2"
    run 0 "$bin/airlight-compare" "airlight-$2.exr" "$1.exr" --fail-above relative_rmse=0.02
    xdotool getwindowname "$window" | grep -q "$1 - airlight\$" || wrong "the title is $(xdotool getwindowname "$window")"
}
xdotool key 1
shows baked 0003
says 0003.png 3
# What is no baked folder is refused in one line, and the picture stays.
mkdir "$work/empty"
run 0 "$bin/programs_drop" "$window" "$work/empty"
says "$work/empty: no scene.air" 4
shows baked 0004
run 0 "$bin/programs_drop" "$window" "$work/scene.json"
says "no scene.air" 6
cut=$work/cut
mkdir "$cut"
head -c 1000 baked/scene.air >"$cut/scene.air"
run 0 "$bin/programs_drop" "$window" "$cut"
says "cut/scene.air" 7
shows baked 0005
# A baked folder, or a file in it, is opened.
run 0 "$bin/programs_drop" "$window" "$work/other 100%"
says "opened $work/other 100%" 9
shows "other 100%" 0006
run 0 "$bin/programs_drop" "$window" "$work/baked/scene.air"
says "opened $work/baked" 11
shows baked 0007
run 1 "$bin/airlight-compare" baked.exr "other 100%.exr" --fail-above relative_rmse=0.1

xdotool key Escape
wait "$player" || wrong "the player ends with $?"
finish
