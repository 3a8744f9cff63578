#!/bin/sh
# Makes the pictures of docs/looks.md (docs/images/look_*.png) and prints its figures: for each picture the bake's seconds, the
# baked bytes and the median frame in milliseconds.
# usage: scripts/looks.sh [FOLDER]   (default out/looks; scenes, bakes and what stays of them; an empty one makes all anew)
set -eu
cd "$(dirname "$0")/.."

scripts/build.sh >/dev/null
bin=build/bin
folder=${1:-out/looks}
images=docs/images
mkdir -p "$folder"

# bake SCENE OPTIONS...: FOLDER/SCENE.json into FOLDER/SCENE, if it is not there.
bake() {
    name=$1
    shift
    [ -f "$folder/$name/report.json" ] || "$bin/airlight-bake" "$folder/$name.json" -o "$folder/$name" --quiet "$@"
}

# picture PICTURE SCENE FRAMES OPTIONS...: docs/images/look_PICTURE.png.
picture() {
    png=$images/look_$1.png name=$1 scene=$2 frames=$3
    shift 3
    [ ! -f "$folder/$name.stats" ] || [ ! -f "$png" ] || return 0
    "$bin/airlight-play" "$folder/$scene" --headless --size 224x224 --frames "$frames" --accumulate --quiet --out "$png" \
        --stats "$folder/$name.stats" "$@"
}

# cost PICTURE SCENE: a line of figures; ms of a frame, seconds of the bake, bytes of its assets.
cost() {
    awk -v name="$1" '
        /"frame_ms_median"/ { gsub(/[^0-9.]/, ""); ms = $0 }
        /"steps"/ { steps = 1 }
        /"assets"|"inputs"/ { steps = 0 }
        /"seconds"/ && steps { split($0, part, /"seconds": */); seconds += part[2] + 0 }
        /"kind"/ { kind = $0 }
        match($0, /"bytes": *[0-9]+/) && !steps && kind != "" {
            text = substr($0, RSTART, RLENGTH); sub(/.*: */, "", text); if (kind !~ /"scene"/) bytes += text; kind = "" }
        END { printf "| %s | %.0f ms | %.1f s | %.0f KB |\n", name, ms, seconds, bytes / 1000 }' \
        "$folder/$1.stats" "$folder/$2/report.json"
}

# --- wax, marble, jelly: a bear in the light of a lamp behind it ---

# object NAME MEDIUM BAKE
object() {
    cat >"$folder/$1.json" <<SCENE
{
  "meshes": [
    {"name": "bear", "file": "$PWD/assets/bear.ply", "material": "skin", "transform": {"rotate_degrees": [0, -14, 0]}},
    {"name": "backdrop", "file": "$PWD/assets/backdrop.ply", "material": "paper"}
  ],
  "materials": [
    {"name": "skin", "base_color": 0, "roughness": 0.3, "ior": 1.4},
    {"name": "paper", "base_color": [0.07, 0.08, 0.1], "ior": 1.3, "double_sided": true}
  ],
  "media": [{"name": "inside", $2}],
  "translucents": [{"name": "bear", "mesh": "bear", "medium": "inside"}],
  "lights": [
    {"name": "back", "type": "point", "position_m": [0.34, 0.6, -0.5], "intensity_w_sr": [4.2, 3.6, 3]},
    {"name": "key", "type": "directional", "direction": [0.6, -0.6, -0.5], "irradiance_w_m2": [2, 2.2, 2.5]}
  ],
  "environment": {"radiance_w_m2_sr": [0.04, 0.05, 0.07]},
  "cameras": [{"name": "front", "position_m": [-0.15, 0.4, 1.3], "target_m": [0, 0.245, 0], "fov_y_degrees": 26}],
  "bake": {$3},
  "play": {"exposure_ev": 0.8}
}
SCENE
}
plain='"samples": 20000, "directions": 128, "grid_resolution": 64, "sh_order": 6'
jelly='"sigma_s_per_m": [5, 2, 1.6], "sigma_a_per_m": [0.4, 7, 9], "g": 0.6'
wax='"sigma_s_per_m": [36, 30, 22], "sigma_a_per_m": [0.5, 4, 14], "g": 0.2'
marble='"sigma_s_per_m": [46, 45, 44], "sigma_a_per_m": [3, 1.4, 0.9],
    "density": {"type": "layers", "axis": [0.5, 1, 0.3], "period_m": 0.07, "thickness_m": 0.05, "low": 0.1, "high": 1}'
object wax "$wax" "$plain"
object marble "$marble" "$plain"
object jelly "$jelly" "$plain"
object thin '"sigma_s_per_m": [9, 7.5, 5.5], "sigma_a_per_m": [0.12, 1, 3.5], "g": 0.2' "$plain"
object forward '"sigma_s_per_m": [36, 30, 22], "sigma_a_per_m": [0.5, 4, 14], "g": 0.8' "$plain"
object few "$marble" '"samples": 150, "directions": 128, "grid_resolution": 64, "sh_order": 6, "too_dense": "bake"'
object low "$marble" '"samples": 20000, "directions": 128, "grid_resolution": 64, "sh_order": 2'
object alias "$wax" '"samples": 20000, "directions": 16, "grid_resolution": 64, "sh_order": 6'
objects='wax marble jelly thin forward few low alias'
for name in $objects; do
    bake $name
    picture $name $name 4
done

# --- fog and smoke: a room with slats before the sun ---

# slats: boards before the sun, and a wall above them.
slats() {
    for y in 0.15 0.7 1.25 1.8 3.45; do
        printf '{"name": "slat%s", "shape": {"type": "box", "size_m": [0.06, %s, 4]}, "material": "wall", "transform": {"translate_m": [-1.6, %s, 0]}},\n' \
            $y "$(awk -v y=$y 'BEGIN { print (y > 2 ? 2.6 : 0.3) }')" $y
    done
}
# fog NAME SIGMA_PER_M G
fog() {
    cat >"$folder/$1.json" <<SCENE
{
  "meshes": [
    $(slats)
    {"name": "floor", "shape": {"type": "plane", "width_m": 4, "depth_m": 4}, "material": "floor"},
    {"name": "back", "shape": {"type": "box", "size_m": [4, 2.6, 0.1]}, "material": "wall", "transform": {"translate_m": [0, 1.3, -1.6]}},
    {"name": "bear", "file": "$PWD/assets/bear.ply", "material": "clay",
     "transform": {"scale": 2.2, "translate_m": [-0.1, 0, -0.5], "rotate_degrees": [0, -10, 0]}}
  ],
  "materials": [
    {"name": "wall", "base_color": [0.3, 0.29, 0.28]},
    {"name": "floor", "base_color": [0.32, 0.22, 0.15]},
    {"name": "clay", "base_color": [0.55, 0.3, 0.2]}
  ],
  "media": [{"name": "air", "sigma_s_per_m": $2, "g": $3, "density": {"type": "constant",
    "bounds_min_m": [-1.57, 0, -1.55], "bounds_max_m": [1.8, 2.6, 1.6]}}],
  "fogs": ["air"],
  "lights": [{"name": "sun", "type": "directional", "direction": [1, -0.5, 0.05], "irradiance_w_m2": [9, 7.6, 6]}],
  "environment": {"radiance_w_m2_sr": [0.02, 0.025, 0.035]},
  "cameras": [{"name": "in", "position_m": [1.75, 1.3, 2.3], "target_m": [-0.7, 0.85, -0.6], "fov_y_degrees": 46}],
  "play": {"exposure_ev": 0.6}
}
SCENE
}
fog clear 0.03 0
fog haze 0.25 0
fog thick 2 0
fog towards 0.25 0.6
for name in clear haze thick towards; do
    bake $name
    picture $name $name 4 --no-surface-scattering
done
picture cells haze 1 --no-surface-scattering --fog-steps 4

# --- smoke lit by surfaces ---

cat >"$folder/neon.json" <<SCENE
{
  "meshes": [
    {"name": "floor", "shape": {"type": "plane", "width_m": 4, "depth_m": 4}, "material": "floor"},
    {"name": "back", "shape": {"type": "box", "size_m": [4, 2.6, 0.1]}, "material": "wall", "transform": {"translate_m": [0, 1.3, -1.3]}},
    {"name": "left", "shape": {"type": "box", "size_m": [0.06, 1.5, 0.5]}, "material": "red", "transform": {"translate_m": [-1.2, 0.95, -0.3]}},
    {"name": "right", "shape": {"type": "box", "size_m": [0.06, 1.5, 0.5]}, "material": "blue", "transform": {"translate_m": [1.2, 0.95, -0.3]}},
    {"name": "bear", "file": "$PWD/assets/bear.ply", "material": "clay",
     "transform": {"scale": 2.4, "translate_m": [-0.35, 0, -0.3], "rotate_degrees": [0, -20, 0]}}
  ],
  "materials": [
    {"name": "wall", "base_color": 0.4}, {"name": "floor", "base_color": 0.25}, {"name": "clay", "base_color": 0.4},
    {"name": "red", "base_color": 0, "emission_w_m2_sr": [3, 0.35, 0.2]},
    {"name": "blue", "base_color": 0, "emission_w_m2_sr": [0.15, 0.5, 3]}
  ],
  "media": [{"name": "air", "sigma_s_per_m": 0.35, "g": 0, "density": {"type": "constant",
    "bounds_min_m": [-1.9, 0, -1.25], "bounds_max_m": [1.9, 2.4, 1.2]}}],
  "fogs": ["air"],
  "environment": {"radiance_w_m2_sr": 0.02},
  "cameras": [{"name": "in", "position_m": [0, 1.15, 3.6], "target_m": [0, 0.95, -0.3], "fov_y_degrees": 42}],
  "play": {"exposure_ev": 1.2}
}
SCENE
bake neon
picture neon-off neon 2 --no-surface-scattering
picture neon neon 4
picture neon-hidden neon 4 --visibility
picture neon-raw neon 1 --visibility --bounce-samples 1 --blur 0

# --- bounce: a corner with a coloured wall, moving or baked ---

# corner NAME LIGHTING REST
corner() {
    cat >"$folder/$1.json" <<SCENE
{
  "meshes": [
    {"name": "floor", "shape": {"type": "plane", "width_m": 2, "depth_m": 2}, "material": "white", "lighting": "$2"},
    {"name": "back", "shape": {"type": "box", "size_m": [2, 1.4, 0.1]}, "material": "white", "lighting": "$2",
     "transform": {"translate_m": [0, 0.7, -1.05]}},
    {"name": "side", "shape": {"type": "box", "size_m": [0.1, 1.4, 2]}, "material": "red", "lighting": "$2",
     "transform": {"translate_m": [-1.05, 0.7, 0]}},
    {"name": "bear", "file": "$PWD/assets/bear.ply", "material": "white", "lighting": "$2",
     "transform": {"scale": 1.9, "translate_m": [-0.45, 0, -0.4], "rotate_degrees": [0, 20, 0]}},
    {"name": "block", "shape": {"type": "box", "size_m": [0.5, 0.35, 0.5]}, "material": "white", "lighting": "$2",
     "transform": {"translate_m": [0.45, 0.175, -0.45], "rotate_degrees": [0, 25, 0]}}
  ],
  "materials": [{"name": "white", "base_color": 0.75, "ior": 1}, {"name": "red", "base_color": [0.7, 0.08, 0.05], "ior": 1}],
  "lights": [{"name": "lamp", "type": "point", "position_m": [0.7, 1.5, 0.9], "intensity_w_sr": [3.2, 3, 2.7]}],
  "environment": {"radiance_w_m2_sr": [0.12, 0.14, 0.17]},
  "cameras": [{"name": "in", "position_m": [0.75, 0.95, 2.3], "target_m": [-0.1, 0.42, -0.4], "fov_y_degrees": 36}],
  $3"play": {"exposure_ev": 0.3}
}
SCENE
}
corner corner dynamic ''
bake corner
picture plain corner 2
screen="--occlusion-carrier screen --indirect-carrier screen"
# shellcheck disable=SC2086
picture occluded corner 4 --ambient-occlusion $screen
# shellcheck disable=SC2086
picture bounced corner 4 --ambient-occlusion --indirect $screen
# shellcheck disable=SC2086
picture bounced-raw corner 1 --ambient-occlusion --indirect $screen --bounce-samples 1 --bounce-filter 0
corner baked lightmap '"lightmap": {"texel_m": 0.05, "samples": 64, "bounces": 4}, '
corner grainy lightmap '"lightmap": {"texel_m": 0.05, "samples": 4, "bounces": 4}, '
corner direct lightmap '"lightmap": {"texel_m": 0.05, "samples": 64, "bounces": 0}, '
corner blocky lightmap '"lightmap": {"texel_m": 0.12, "samples": 64, "bounces": 4}, '
for name in baked grainy direct blocky; do
    bake $name
    picture $name $name 2
done

echo "| picture | frame | bake | baked |"
echo "| --- | --- | --- | --- |"
for name in $objects clear haze thick towards neon; do cost $name $name; done
cost cells haze
for name in neon-off neon-hidden neon-raw; do cost $name neon; done
for name in plain occluded bounced bounced-raw; do cost $name corner; done
for name in baked grainy direct blocky; do cost $name $name; done
