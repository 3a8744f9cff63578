#!/bin/sh
# default_scene_test.sh PROGRAM ASSETS: the program makes the committed meshes again, byte for byte.
set -eu

made=$(mktemp -d)
trap 'rm -rf "$made"' EXIT

"$1" "$made"
for mesh in bear knot face backdrop; do
    cmp "$made/$mesh.ply" "$2/$mesh.ply"
done
