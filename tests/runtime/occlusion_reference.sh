#!/bin/sh
# Ambient occlusion of the reference room by volumes with the bounced z-buffer against the reference folder:
# occlusion_reference.sh BIN SHARED
#
# Bounds on the relative RMSE with the reference's noise taken out: the aim of 2.5 %, half of what is asked. Measured 1.9 and
# 1.5 %: noise of 256 directions, and what the filter blurs.
set -u
bin=$1
reference=$2/reference
[ -r "$reference/view_ambient_occlusion.exr" ] || {
    echo "SKIP: the shared reference folder is not here (AIRLIGHT_SHARED)"
    exit 77
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mesh() {
    printf '{"name": "%s", "file": "%s", "node": "%s"}' "$1" "$reference/room.obj" "$1"
}
cat >"$work/room.json" <<END
{"meshes": [$(mesh floor), $(mesh white), $(mesh left), $(mesh right)],
 "cameras": [{"name": "reference", "position_m": [0, 0, 3.9], "target_m": [0, 0, 0], "fov_y_degrees": 39.3}]}
END
"$bin/airlight-bake" --quiet "$work/room.json" -o "$work/baked" || exit 1

# picture WANTED OPTIONS...
picture() {
    wanted=$1
    shift
    "$bin/airlight-play" "$work/baked" --headless --size 128x128 --pass ambient-occlusion --occlusion-carrier volumes \
        --accumulate --frames 64 "$@" --quiet --out "$work/picture.exr" || {
        code=$?
        [ $code -ne 5 ] || echo "SKIP: no OpenGL 4.5 context"
        [ $code -ne 5 ] || code=77
        exit $code
    }
    echo "$wanted:"
    "$bin/airlight-compare" "$work/picture.exr" "$reference/$wanted.exr" --error "$reference/$wanted.error.exr" \
        --fail-above nan_count=0 --fail-above inf_count=0 --fail-above relative_rmse_without_noise=0.025 || failed=1
}

failed=0
picture view_ambient_occlusion
picture view_ambient_occlusion_radius_half --occlusion-radius 0.5
exit $failed
