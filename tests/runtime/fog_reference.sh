#!/bin/sh
# The reference room with black walls, a point light and fog, baked and drawn: fog_reference.sh BIN SHARED FOG
set -u
bin=$1
shared=$2
fog=$3
reference=$shared/reference
[ -r "$reference/view_point_${fog}_direct.exr" ] || {
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
    printf '{"name": "%s", "file": "%s", "node": "%s", "material": "black"}' "$1" "$reference/room.obj" "$1"
}
# The rectangle named `light` is absent. Black walls: what is scattered reaches the eye, nothing else.
cat >"$work/room.json" <<END
{"meshes": [$(mesh floor), $(mesh white), $(mesh left), $(mesh right)],
 "materials": [{"name": "black", "base_color": 0, "ior": 1, "double_sided": true}],
 "lights": [{"type": "point", "position_m": [0.1, 0.55, 0.25], "intensity_w_sr": 2}],
 "media": [{"name": "fog", $medium}],
 "fogs": ["fog"]}
END
"$bin/airlight-bake" --quiet "$work/room.json" -o "$work/baked" || exit 1
# Default settings, and twice as many cells; 2 % is asked of both.
for settings in "" 64; do
    # shellcheck disable=SC2086
    "$bin/runtime_fog_reference" "$work/baked" "$reference/view_point_${fog}_direct.exr" \
        "$reference/view_point_${fog}_direct.error.exr" 0.02 $settings || exit $?
done
