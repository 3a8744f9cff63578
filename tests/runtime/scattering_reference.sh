#!/bin/sh
# Light that the reference room's walls send into fog, at default and at best settings, against the reference folder:
# scattering_reference.sh BIN SHARED FOG[_unattenuated_second_leg]
#
# Bounds on the relative RMSE with the reference's noise taken out. Default settings take walls as transparent and draw
# about 700 surfels into so small a picture: measured 11 to 14 %, held to 20 %. Best ones: measured 4.1 to 4.6 %, held to
# 6 %, below the 10 % asked of them.
set -u
bin=$1
shared=$2
fog=${3%%_*}
reference=$shared/reference
leg=
wanted=view_point_${fog}_surface_to_volume
[ "$3" = "$fog" ] || leg=--no-second-leg wanted=${wanted}_unattenuated_second_leg
[ -r "$reference/$wanted.exr" ] || {
    echo "SKIP: the shared reference folder is not here (AIRLIGHT_SHARED)"
    exit 77
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
box='"bounds_min_m": [-1.2, -1.2, -1.2], "bounds_max_m": [1.2, 1.2, 1.2]'
case $fog in
mid) medium="\"sigma_s_per_m\": 0.45, \"sigma_a_per_m\": 0.05, \"density\": {\"type\": \"constant\", $box}" ;;
grid) medium="\"sigma_s_per_m\": 0.9, \"sigma_a_per_m\": 0.1, \"density\": {\"type\": \"grid\", \"file\": \"$reference/fog.vdb\", $box}" ;;
esac
mesh() {
    printf '{"name": "%s", "file": "%s", "node": "%s", "material": "%s"}' "$1" "$reference/room.obj" "$1" "$1"
}
material() {
    printf '{"name": "%s", "base_color": [%s], "ior": 1, "double_sided": true}' "$1" "$2"
}
# The rectangle named `light` is absent.
cat >"$work/room.json" <<END
{"meshes": [$(mesh floor), $(mesh white), $(mesh left), $(mesh right)],
 "materials": [$(material floor "0.7, 0.7, 0.7"), $(material white "0.7, 0.7, 0.7"),
               $(material left "0.6, 0.1, 0.1"), $(material right "0.1, 0.5, 0.15")],
 "lights": [{"type": "point", "position_m": [0.1, 0.55, 0.25], "intensity_w_sr": 2}],
 "cameras": [{"name": "reference", "position_m": [0, 0, 3.9], "target_m": [0, 0, 0], "fov_y_degrees": 39.3}],
 "media": [{"name": "fog", $medium}],
 "fogs": ["fog"]}
END
"$bin/airlight-bake" --quiet "$work/room.json" -o "$work/baked" || exit 1

# picture NAME BOUND OPTIONS...
picture() {
    name=$1
    bound=$2
    shift 2
    "$bin/airlight-play" "$work/baked" --headless --size 128x128 --pass surface-scattering $leg "$@" --quiet \
        --out "$work/picture.exr" || {
        code=$?
        [ $code -ne 5 ] || echo "SKIP: no OpenGL 4.5 context"
        [ $code -ne 5 ] || code=77
        exit $code
    }
    echo "$name:"
    "$bin/airlight-compare" "$work/picture.exr" "$reference/$wanted.exr" --error "$reference/$wanted.error.exr" \
        --fail-above nan_count=0 --fail-above inf_count=0 --fail-above relative_rmse_without_noise="$bound" || failed=1
}

failed=0
picture "default settings" 0.2
picture "best settings" 0.06 --visibility --accumulate --frames 64 --bounce-samples 1 --bounce-radius 0.5 --blur 1 \
    --surfel-size 2 --shell-levels 2
exit $failed
