#!/bin/sh
# lost_context_test.sh BIN SHIM: airlight-play loses its context (lose_context.c): one line, exit code 5, and nothing on
# disk but whole pictures of the frames before.
set -eu
bin=$1 shim=$2
. "$(dirname "$0")/expect.sh"

cat >"$work/scene.json" <<'JSON'
{
  "meshes": [{"name": "floor", "shape": {"type": "plane", "width_m": 4, "depth_m": 4}}],
  "media": [{"name": "smoke", "sigma_s_per_m": 0.5,
    "density": {"type": "constant", "bounds_min_m": [-1, 0, -1], "bounds_max_m": [1, 2, 1]}}],
  "fogs": ["smoke"],
  "lights": [{"type": "point", "position_m": [0, 1, 0], "intensity_w_sr": 3}],
  "cameras": [{"position_m": [0, 1, 4], "target_m": [0, 1, 0], "fov_y_degrees": 40}]
}
JSON
run 0 "$bin/airlight-bake" "$work/scene.json" -o "$work/baked" --quiet
mkdir "$work/good"
run 0 "$bin/airlight-play" "$work/baked" --headless --size 48x32 --frames 2 --fps 2 --out "$work/good/f%04d.exr"
[ "$failures" = 0 ] || finish

# play FILE CALLS OPTIONS...: loses the context as AIRLIGHT_LOST_FILE and _CALLS say.
play() {
    AIRLIGHT_LOST_FILE=$1 AIRLIGHT_LOST_CALLS=$2
    export AIRLIGHT_LOST_FILE AIRLIGHT_LOST_CALLS
    shift 2
    LD_PRELOAD=$shim ASAN_OPTIONS=verify_asan_link_order=0 "$bin/airlight-play" "$work/baked" "$@"
}
words="the context is lost, the device was reset while it drew for this program; start anew with a new context"

# While it loads.
mkdir "$work/out"
fails 5 "$words" play "$work/good" 0 --headless --size 48x32 --out "$work/out/f%04d.exr" --stats "$work/out/stats.json"
empty "$work/out"

# In the third frame: before its update, before it is drawn and after.
for calls in 0 1 2; do
    rm -rf "$work/out"
    mkdir "$work/out"
    fails 5 "$words" play "$work/out/f0001.exr" $calls --headless --size 48x32 --frames 4 --fps 2 \
        --out "$work/out/f%04d.exr" --stats "$work/out/stats.json"
    [ "$(cd "$work/out" && echo *)" = "f0000.exr f0001.exr" ] || wrong "on disk: $(cd "$work/out" && echo *)"
    for frame in f0000 f0001; do cmp "$work/good/$frame.exr" "$work/out/$frame.exr" || wrong "another $frame"; done
done

# In a window.
for tool in Xvfb xdotool; do command -v $tool >/dev/null || { echo "without a window: $tool is not installed"; finish; exit; }; done
Xvfb -displayfd 3 -screen 0 640x480x24 3>"$work/display" 2>"$work/xvfb.log" &
server=$!
stop_server() { kill "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; clean_up; }
trap stop_server EXIT
for i in 1 2 3 4 5 6 7 8 9 10; do [ -s "$work/display" ] && break; sleep 0.5; done
[ -s "$work/display" ] || { echo "without a window: $(tail -n 1 "$work/xvfb.log")"; finish; exit; }
DISPLAY=:$(cat "$work/display")
export DISPLAY
( timeout 60 xdotool search --sync --onlyvisible --name 'baked - airlight$' && touch "$work/lost" ) >/dev/null 2>&1 &
fails 5 "$words" play "$work/lost" 0 --size 320x240
[ -e "$work/lost" ] || wrong "the context was lost before the window was there"
finish
