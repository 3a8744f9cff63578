#!/bin/sh
# Installs what is missing, builds, bakes the default scene and renders it without a display.
set -eu
cd "$(dirname "$0")/.."

baked=out/demo
picture=out/default

scripts/build.sh
build/bin/airlight-bake assets/default.json -o "$baked"
for asset in "$baked"/*.air; do
    build/bin/airlight-inspect --check "$asset"
done
build/bin/airlight-play "$baked" --headless --size 1280x720 --frames 8 --accumulate \
    --out "$picture.exr" --out "$picture.png" --stats "$picture.stats.json"

echo
echo "baked:    $baked (build/bin/airlight-inspect shows what is in each file)"
echo "pictures: $picture.png and $picture.exr, times in $picture.stats.json"
if [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; then
    echo "to walk around in it: build/bin/airlight-play $baked"
fi
