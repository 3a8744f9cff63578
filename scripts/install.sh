#!/bin/sh
# Installs what building, running and testing airlight needs on Debian 12. Does nothing when all is there.
set -eu

packages="
cmake ninja-build gcc g++ pkg-config
libjansson-dev libxxhash-dev libpng-dev libopenexr-dev
libassimp-dev libopenvdb-dev libboost-dev libembree-dev libtbb-dev libtet1.5-dev libstb-dev
ocl-icd-opencl-dev pocl-opencl-icd
libepoxy-dev libegl-dev libgl-dev libegl1 libgl1 libgl1-mesa-dri libglfw3-dev libcglm-dev libglm-dev libimgui-dev
xvfb xdotool libx11-dev
"

missing() {
    for package in $packages; do
        dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null | grep -q '^ii' || echo "$package"
    done
}

wanted=$(missing | tr '\n' ' ')
[ -n "$wanted" ] || exit 0

if [ "$(id -u)" = 0 ]; then
    as_root=
elif command -v sudo >/dev/null; then
    as_root=sudo
else
    echo "install.sh: these packages are missing: $wanted- install them as root, or install sudo" >&2
    exit 4
fi

echo "installing: $wanted"
$as_root apt-get update -q
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $wanted
