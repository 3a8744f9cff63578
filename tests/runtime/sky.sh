#!/bin/sh
# Fog that scatters a sky towards the eye, baked and drawn: sky.sh BIN SHARED CASE. Limits are about twice what
# was measured, which docs/accuracy.md states.
set -u
bin=$1
shared=$2
case=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# A map of 16 x 8: sky, a sun of 32 times its radiance, ground. RGBE, flat; all bytes below 128.
{
    printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n'
    awk 'BEGIN { for (y = 0; y < 8; y++) for (x = 0; x < 16; x++)
        if (y == 2 && x == 5) printf "%c%c%c%c", 120, 110, 90, 127
        else if (y < 4) printf "%c%c%c%c", 60 + 10 * y, 80 + 8 * y, 120, 122
        else printf "%c%c%c%c", 40, 35, 30, 121 }'
} >"$work/sky.hdr"

# scene FOG MESHES EYE [ENVIRONMENT]: walls are black; the camera looks at the middle.
scene() {
    cat >"$work/sky.json" <<END
{"environment": ${4:-{\"file\": \"sky.hdr\"\}},
 "meshes": [$2],
 "materials": [{"name": "black", "base_color": 0, "ior": 1, "double_sided": true}],
 "media": [{"name": "fog", $1}],
 "fogs": ["fog"],
 "cameras": [{"name": "eye", "position_m": $3, "target_m": [0, 0, 0], "fov_y_degrees": 60}]}
END
    "$bin/airlight-bake" --quiet "$work/sky.json" -o "$work/baked" || exit 1
    "$bin/airlight-inspect" --check "$work/baked/fog.medium.air" >/dev/null || exit 1
}
box() {
    printf '"bounds_min_m": [-%s, -%s, -%s], "bounds_max_m": [%s, %s, %s]}' "$1" "$1" "$1" "$1" "$1" "$1"
}
wall() {
    printf '{"name": "%s", "shape": {"type": "plane", "width_m": 2, "depth_m": 2}, "material": "black",
        "transform": {"rotate_degrees": %s, "translate_m": %s}}' "$1" "$2" "$3"
}
check() {
    "$bin/runtime_sky_check" "$work/baked" "$@"
    exit $?
}
# uniform SIGMA_S SIGMA_A G LIMIT
uniform() {
    scene "\"sigma_s_per_m\": $1, \"sigma_a_per_m\": $2, \"g\": $3, \"density\": {\"type\": \"constant\", $(box 1)" "" \
        '[0, 0, 5]' '{"radiance_w_m2_sr": 1}'
    check uniform "$1" "$2" "$3" 0 "$4"
}
reference() {
    "$bin/airlight-reference" --quiet "$work/sky.json" --mode volume-path --min-events 1 --max-events 1 \
        --max-bounces 0 --size 40x40 --spp 1024 -o "$work/reference.exr" || exit 1
    check reference "$work/reference.exr" "$work/reference.error.exr" "$1"
}

fog='"sigma_s_per_m": 0.3, "sigma_a_per_m": [0, 0.02, 0.05]'
room="$(wall floor '[0, 0, 0]' '[0, -1, 0]'), $(wall left '[0, 0, -90]' '[-1, 0, 0]'),
    $(wall right '[0, 0, 90]' '[1, 0, 0]'), $(wall back '[90, 0, 0]' '[0, 0, -1]')"
closed="$room, $(wall top '[180, 0, 0]' '[0, 1, 0]'), $(wall front '[-90, 0, 0]' '[0, 0, 1]')"
case $case in
thin) uniform 0.001 0 0 0.001 ;;
mid) uniform 0.5 0.1 0 0.006 ;;
forward) uniform 0.5 0 0.8 0.02 ;;
thick) uniform 50 0 0 0.016 ;;
opaque) uniform 5000 0 0 0.05 ;;
layers)
    scene "\"sigma_s_per_m\": 1, \"density\": {\"type\": \"layers\", \"period_m\": 0.5, \"thickness_m\": 0.25, \"low\": 0.2, $(box 1)" \
        "" '[0, 0, 5]' '{"radiance_w_m2_sr": 1}'
    check uniform 1 0 0 1 0.03
    ;;
grid)
    [ -r "$shared/reference/fog.vdb" ] || {
        echo "SKIP: the shared reference folder is not here (AIRLIGHT_SHARED)"
        exit 77
    }
    scene "\"sigma_s_per_m\": 0.9, \"sigma_a_per_m\": 0.1, \"density\": {\"type\": \"grid\", \"file\": \"$shared/reference/fog.vdb\", $(box 1.2)" \
        "" '[0.5, 1, 5]'
    reference 0.03 # noise of 0.04
    ;;
sky)
    scene "$fog, \"g\": 0.5, \"density\": {\"type\": \"constant\", $(box 2)" "" '[0.5, 0.3, 0.9]'
    reference 0.06
    ;;
open)
    scene "$fog, \"density\": {\"type\": \"constant\", $(box 1.6)" "$room" '[0.3, 0.4, 4]'
    reference 0.03
    ;;
closed) # up to how exactly textures are filtered
    scene "$fog, \"density\": {\"type\": \"constant\", $(box 1.6)" "$closed" '[0.5, 0.4, 0.9]'
    check dark 1e-6
    ;;
esac
