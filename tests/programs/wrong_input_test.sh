#!/bin/sh
# wrong_input_test.sh BIN CASE SHARED: one wrong input. Each is one line on standard error that names the file, the right
# exit code, and nothing half-written.
set -eu
bin=$1 case=$2
. "$(dirname "$0")/expect.sh"

# A scene around one translucent mesh; $1 the mesh's JSON, $2 the medium's density.
scene() {
    cat >"$work/scene.json" <<JSON
{
  "meshes": [{"name": "thing", $1}],
  "media": [{"name": "fog", "sigma_s_per_m": 2, "density": $2}],
  "translucents": [{"name": "thing", "mesh": "thing", "medium": "fog"}],
  "lights": [{"type": "directional", "direction": [0, -1, 0], "irradiance_w_m2": 1}],
  "cameras": [{"position_m": [0, 0, 4], "target_m": [0, 0, 0]}],
  "bake": {"directions": 8, "grid_resolution": 8, "radius_m": 0.2, "sh_order": 2}
}
JSON
}

ball='"shape": {"type": "sphere", "subdivisions": 2}'
constant='{"type": "constant"}'

# A tetrahedron as OFF: $1 its vertices' first line, $2 the faces.
tetrahedron() {
    faces=$(printf '%b' "$2" | wc -l)
    printf "OFF\n4 $faces 0\n$1\n1 0 0\n0 1 0\n0 0 1\n$2" >"$work/mesh.off"
    scene '"file": "mesh.off"' "$constant"
}
outwards='3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n'

bake() {
    "$bin/airlight-bake" "$work/scene.json" -o "$work/baked" "$@"
}

# Baking must fail with exit code 3 and a line that contains $1; nothing may be left.
bake_refuses() {
    fails 3 "$1" "$bin/airlight-bake" "$work/scene.json" -o "$work/baked"
    empty "$work/baked"
}

baked_scene() {
    scene "$ball" "$constant"
    bake --quiet || { wrong "a good scene does not bake"; finish; }
    asset=$(find "$work/baked" -name '*.air' ! -name scene.air)
}

case $case in
open_mesh)
    tetrahedron '0 0 0' '3 0 2 1\n3 0 1 3\n3 0 3 2\n'
    bake_refuses mesh.off
    ;;
inside_out)
    tetrahedron '0 0 0' '3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n'
    bake_refuses mesh.off
    ;;
closed_mesh) # the same helper's good case, so that the refusals above are about what they say
    tetrahedron '0 0 0' "$outwards"
    run 0 bake --quiet
    ;;
empty_mesh)
    printf 'OFF\n0 0 0\n' >"$work/mesh.off"
    scene '"file": "mesh.off"' "$constant"
    bake_refuses mesh.off
    : >"$work/mesh.off"
    bake_refuses mesh.off
    ;;
nan_vertex)
    tetrahedron 'nan 0 0' "$outwards"
    bake_refuses mesh.off
    # binary STL: 80 bytes, four triangles; the first corner's x is a quiet NaN
    { head -c 80 /dev/zero; printf '\004\000\000\000'; head -c 12 /dev/zero; printf '\000\000\300\177'
      head -c $((50 * 4 - 16)) /dev/zero; } >"$work/mesh.stl"
    scene '"file": "mesh.stl"' "$constant"
    bake_refuses mesh.stl
    ;;
grid)
    volumes=${AIRLIGHT_SHARED:-$3}/data/volumes
    [ -f "$volumes/smoke.vdb" ] || skip "$volumes/smoke.vdb is not there; AIRLIGHT_SHARED may name another place"
    scene "$ball" "{\"type\": \"grid\", \"file\": \"$volumes/smoke.vdb\", \"grid\": \"no such grid\"}"
    bake_refuses smoke.vdb
    for file in neg_arnold_pointgrid.vdb neg_zeno_res_levelset.vdb; do # points, a level set
        scene "$ball" "{\"type\": \"grid\", \"file\": \"$volumes/$file\"}"
        bake_refuses "$file"
    done
    ;;
density)
    for value in '"type": "constant", "scale": 0' '"type": "constant", "scale": -1' \
        '"type": "layers", "axis": [0, 1, 0], "period_m": 0.2, "thickness_m": 0.1, "low": -1, "high": 1' \
        '"type": "layers", "axis": [0, 1, 0], "period_m": 0.2, "thickness_m": 0.1, "low": 0, "high": 0'; do
        scene "$ball" "{$value}"
        bake_refuses scene.json
    done
    ;;
missing_file)
    fails 3 absent.json "$bin/airlight-bake" "$work/absent.json" -o "$work/baked"
    empty "$work/baked"
    scene '"file": "absent.off"' "$constant"
    bake_refuses absent.off
    scene "$ball" '{"type": "grid", "file": "absent.vdb", "grid": "density"}'
    bake_refuses absent.vdb
    fails 3 absent.air "$bin/airlight-inspect" "$work/absent.air"
    fails 3 absent.exr "$bin/airlight-compare" "$work/absent.exr" "$work/absent.exr"
    fails 3 absent.json "$bin/airlight-reference" "$work/absent.json" --mode single-scatter --spp 2 -o "$work/ref.exr"
    fails 3 absent "$bin/airlight-play" "$work/absent" --headless
    ;;
truncated_asset)
    baked_scene
    size=$(wc -c <"$asset")
    for keep in 0 1 16 $((size / 2)) $((size - 1)); do
        head -c "$keep" "$asset" >"$work/cut.air"
        fails 3 cut.air "$bin/airlight-inspect" "$work/cut.air"
        run 1 "$bin/airlight-inspect" --check "$work/cut.air"
    done
    head -c $((size / 2)) "$asset" >"$work/cut.air"
    mv "$work/cut.air" "$asset"
    fails 3 "$(basename "$asset")" "$bin/airlight-play" "$work/baked" --headless --out "$work/picture.exr"
    [ ! -e "$work/picture.exr" ] || wrong "a picture of a truncated asset"
    ;;
newer_major)
    baked_scene
    # The header's major version: two bytes, little-endian, at offset 8 (docs/formats.md).
    for file in "$asset" "$work/baked/scene.air"; do
        cp "$file" "$work/kept.air"
        printf '\377' | dd of="$file" bs=1 seek=8 conv=notrunc 2>/dev/null
        fails 3 version "$bin/airlight-inspect" "$file"
        grep -qF "$(basename "$file")" "$work/stderr" || wrong "does not name the file"
        fails 3 "$(basename "$file")" "$bin/airlight-play" "$work/baked" --headless
        cp "$work/kept.air" "$file"
    done
    run 0 "$bin/airlight-play" "$work/baked" --headless --size 16x16
    ;;
no_opencl)
    scene "$ball" "$constant"
    mkdir "$work/none"
    fails 5 OpenCL env OCL_ICD_VENDORS="$work/none" "$bin/airlight-bake" "$work/scene.json" -o "$work/baked"
    empty "$work/baked"
    fails 5 OpenCL env OCL_ICD_VENDORS="$work/none" "$bin/airlight-bake" --list-devices
    ;;
no_opengl)
    baked_scene
    fails 5 "OpenGL 4.5" env MESA_GL_VERSION_OVERRIDE=3.3 MESA_GLSL_VERSION_OVERRIDE=330 \
        "$bin/airlight-play" "$work/baked" --headless --out "$work/picture.exr"
    [ ! -e "$work/picture.exr" ] || wrong "a picture without OpenGL"
    fails 5 "OpenGL 4.5" env __EGL_VENDOR_LIBRARY_FILENAMES=/dev/null "$bin/airlight-play" "$work/baked" --headless
    fails 5 "OpenGL 4.5" env LIBGL_DRIVERS_PATH=/nonexistent "$bin/airlight-play" "$work/baked" --headless
    ;;
no_display)
    baked_scene
    fails 5 "no window" env -u DISPLAY -u WAYLAND_DISPLAY "$bin/airlight-play" "$work/baked"
    ;;
full_disk)
    [ "$(id -u)" = 0 ] || skip "a full disk needs a small mount, and that needs root"
    mkdir "$work/small"
    mount -t tmpfs -o size=64k tmpfs "$work/small" 2>/dev/null || skip "mounting a tmpfs is not allowed here"
    mounted=$work/small
    baked_scene
    head -c 1000000 /dev/zero >"$work/small/filler" 2>/dev/null || true
    fails 4 "$work/small" "$bin/airlight-bake" "$work/scene.json" -o "$work/small/baked"
    fails 4 "$work/small/picture.exr" "$bin/airlight-play" "$work/baked" --headless --size 64x64 \
        --out "$work/small/picture.exr"
    fails 4 "$work/small/stats.json" "$bin/airlight-play" "$work/baked" --headless --size 16x16 \
        --stats "$work/small/stats.json"
    fails 4 "$work/small" "$bin/airlight-reference" "$work/scene.json" --mode single-scatter --spp 2 --size 64x64 \
        -o "$work/small/ref.exr"
    fails 4 "$work/small/slice.png" "$bin/airlight-inspect" "$asset" --image "$work/small/slice.png"
    rm "$work/small/filler"
    empty "$work/small"
    ;;
unwritable)
    baked_scene
    echo >"$work/file"
    fails 4 "$work/file" "$bin/airlight-bake" "$work/scene.json" -o "$work/file/baked"
    for ending in exr png; do
        fails 4 "$work/file/picture.$ending" "$bin/airlight-play" "$work/baked" --headless --size 16x16 \
            --out "$work/file/picture.$ending"
    done
    fails 4 "$work/file/stats.json" "$bin/airlight-play" "$work/baked" --headless --stats "$work/file/stats.json"
    fails 4 "$work/file/slice.png" "$bin/airlight-inspect" "$asset" --image "$work/file/slice.png"
    fails 4 "$work/file/ref" "$bin/airlight-reference" "$work/scene.json" --mode single-scatter --spp 2 \
        --size 16x16 -o "$work/file/ref.exr"
    [ "$(cat "$work/file")" = "" ] || wrong "the file was written to"
    ;;
read_only)
    [ "$(id -u)" = 0 ] || skip "a read-only folder that root may not write to needs a mount"
    mkdir "$work/fixed"
    mount -t tmpfs -o size=64k,ro tmpfs "$work/fixed" 2>/dev/null || skip "mounting a tmpfs is not allowed here"
    mounted=$work/fixed
    baked_scene
    fails 4 "Read-only" "$bin/airlight-bake" "$work/scene.json" -o "$work/fixed/baked"
    fails 4 "Read-only" "$bin/airlight-bake" "$work/scene.json" -o "$work/fixed"
    fails 4 "Read-only" "$bin/airlight-play" "$work/baked" --headless --size 16x16 --out "$work/fixed/picture.exr"
    fails 4 "Read-only" "$bin/airlight-play" "$work/baked" --headless --size 16x16 --stats "$work/fixed/stats.json"
    fails 4 "Read-only" "$bin/airlight-inspect" "$asset" --image "$work/fixed/slice.png"
    fails 4 "Read-only" "$bin/airlight-reference" "$work/scene.json" --mode single-scatter --spp 2 --size 16x16 \
        -o "$work/fixed/ref.exr"
    ;;
picture_names) # a PNG does not go into a file of another name
    baked_scene
    fails 2 ".png" "$bin/airlight-inspect" "$asset" --image "$work/slice.jpg"
    run 0 "$bin/airlight-play" "$work/baked" --headless --size 16x16 --out "$work/picture.exr"
    fails 2 ".png" "$bin/airlight-compare" "$work/picture.exr" "$work/picture.exr" --diff "$work/diff.exr"
    [ ! -e "$work/slice.jpg" ] && [ ! -e "$work/diff.exr" ] || wrong "a picture of another name"
    ;;
tetrahedra_output) # four points: magic, counts, coordinates (precompute/tetrahedra/main.cpp)
    one='\000\000\000\000\000\000\360\077' zero='\000\000\000\000\000\000\000\000'
    printf "ALTETIN1\004\000\000\000\000\000\000\000$zero$zero$zero$zero$one$zero$zero$zero$one$zero$zero$zero$one" \
        >"$work/points"
    run 0 "$bin/airlight-tetrahedra" "$work/points" -o "$work/cells"
    fails 4 "$work/absent/cells" "$bin/airlight-tetrahedra" "$work/points" -o "$work/absent/cells"
    full_output "$bin/airlight-tetrahedra" "$work/points"
    ;;
*)
    echo "no case is named '$case'" >&2
    exit 2
    ;;
esac
finish
