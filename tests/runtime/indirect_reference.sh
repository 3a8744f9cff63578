#!/bin/sh
# Light of one bounce in the reference room, against the reference folder: indirect_reference.sh BIN SHARED FLOOR
# FLOOR: diffuse, metal_alpha_0.04 or metal_alpha_0.25. The reference's senders are matt.
#
# Bounds on the relative RMSE with the reference's noise taken out: what is asked by surfels, 5 % of matt walls (measured 4.0 %, with one
# level) and 10 % of metal floors (6.6 and 7.4 %, with six and half of the frames); by volumes, of which noise alone is left, 5 % (2.9 to 3.4 %).
set -u
bin=$1
reference=$2/reference
wanted=view_one_bounce_$3
[ -r "$reference/$wanted.exr" ] || {
    echo "SKIP: the shared reference folder is not here (AIRLIGHT_SHARED)"
    exit 77
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
bound=0.1 levels=6 frames=32
case $3 in
diffuse) bound=0.05 levels=1 frames=64 floor='"base_color": 0.7, "ior": 1' ;;
metal_alpha_0.04) floor='"base_color": 1, "metallic": 1, "roughness": 0.2' ;;
metal_alpha_0.25) floor='"base_color": 1, "metallic": 1, "roughness": 0.5' ;;
esac
mesh() {
    printf '{"name": "%s", "file": "%s", "node": "%s", "material": "%s"}' "$1" "$reference/room.obj" "$1" "$1"
}
material() {
    printf '{"name": "%s", %s, "double_sided": true}' "$1" "$2"
}
# The rectangle named `light` is absent.
cat >"$work/room.json" <<END
{"meshes": [$(mesh floor), $(mesh white), $(mesh left), $(mesh right)],
 "materials": [$(material floor "$floor"), $(material white '"base_color": 0.7, "ior": 1'),
               $(material left '"base_color": [0.6, 0.1, 0.1], "ior": 1'),
               $(material right '"base_color": [0.1, 0.5, 0.15], "ior": 1')],
 "lights": [{"type": "point", "position_m": [0.1, 0.55, 0.25], "intensity_w_sr": 2}],
 "cameras": [{"name": "reference", "position_m": [0, 0, 3.9], "target_m": [0, 0, 0], "fov_y_degrees": 39.3}]}
END
"$bin/airlight-bake" --quiet "$work/room.json" -o "$work/baked" || exit 1
# picture BOUND OPTIONS...
picture() {
    most=$1
    shift
    "$bin/airlight-play" "$work/baked" --headless --size 128x128 --pass indirect --lambert-senders --accumulate \
        --bounce-samples 1 "$@" --quiet --out "$work/picture.exr" || {
        code=$?
        [ $code -ne 5 ] || echo "SKIP: no OpenGL 4.5 context"
        [ $code -ne 5 ] || code=77
        exit $code
    }
    echo "$*:"
    "$bin/airlight-compare" "$work/picture.exr" "$reference/$wanted.exr" --error "$reference/$wanted.error.exr" \
        --fail-above nan_count=0 --fail-above inf_count=0 --fail-above relative_rmse_without_noise="$most" || failed=1
}

failed=0
picture 0.05 --frames 64 --indirect-carrier volumes
picture $bound --frames $frames --surfel-size 2 --shell-levels $levels
exit $failed
