#!/bin/sh
# Prints the table of docs/performance.md: the bake's steps and the player's frames, as ratios inside one run.
# usage: scripts/bench.sh [FOLDER]   (default out/bench; bakes stay there)
set -eu
cd "$(dirname "$0")/.."

scripts/build.sh >/dev/null
bin=build/bin
folder=${1:-out/bench}
mkdir -p "$folder"

# scene LIGHTS SAMPLES DIRECTIONS: a jelly sphere under a ring of point lights.
scene() {
    awk -v lights="$1" -v samples="$2" -v directions="$3" 'BEGIN {
        print "{\"meshes\": [{\"name\": \"ball\", \"shape\": {\"type\": \"sphere\", \"radius_m\": 0.5, \"subdivisions\": 5}}],"
        print "\"cameras\": [{\"name\": \"front\", \"position_m\": [0.9, 0.7, 2.2], \"target_m\": [0, 0, 0], \"fov_y_degrees\": 36}],"
        print "\"media\": [{\"name\": \"jelly\", \"sigma_s_per_m\": 3.6, \"sigma_a_per_m\": 0.4}],"
        print "\"translucents\": [{\"name\": \"object\", \"mesh\": \"ball\", \"medium\": \"jelly\"}],"
        printf "\"bake\": {\"directions\": %d, \"grid_resolution\": 128, \"samples\": %d, \"sh_order\": 5},\n", directions, samples
        print "\"lights\": ["
        for (i = 0; i < lights; i++)
            printf "{\"name\": \"lamp %d\", \"type\": \"point\", \"position_m\": [%f, 1, %f], \"intensity_w_sr\": 2}%s\n", i,
                2 * cos(6.2832 * i / lights), 2 * sin(6.2832 * i / lights), i + 1 < lights ? "," : ""
        print "]}" }'
}
number() { # KEY FILE: the first number of that key
    sed -n "s/.*\"$1\": *\([0-9.e+-]*\).*/\1/p" "$2" | head -n 1
}
seconds() { # REPORT STEP
    tr -d '\n' <"$1" | sed "s/.*\"name\": \"$2\", *\"seconds\": \([0-9.e-]*\).*/\1/" | awk '{ printf "%.1f", $1 }'
}

echo "## Sweep against memory"
"$bin/airlight-bench-bake"

echo "## Build time by step, 128^3 voxels, 50 000 samples, order 5 (seconds)"
echo "| directions | optical depth | moment | divergence | sample | Gaussians | project | peak MiB |"
echo "| --- | --- | --- | --- | --- | --- | --- | --- |"
for directions in 32 128 512; do
    scene 2 50000 $directions >"$folder/scene.json"
    rm -rf "$folder/steps"
    "$bin/airlight-bake" "$folder/scene.json" -o "$folder/steps" --quiet
    report=$folder/steps/report.json
    row="| $directions |"
    for step in "optical depth" moment divergence sample gaussians project; do row="$row $(seconds "$report" "$step") |"; done
    echo "$row $(($(number peak_memory_bytes "$report") / 1048576)) |"
done

echo "## Fog in gathered light"
if [ -f "${AIRLIGHT_SHARED:-../shared}/data/scenes/sponza/atrium.obj" ]; then
    [ -f "$folder/tables.air" ] || "$bin/airlight-bake" --tables "$folder/tables.air" --quiet
    for name in atrium_fog room_area_mid room_area_grid; do
        "$bin/airlight-bench-gather" "build/tests/scenes/$name.json" "$folder/tables.air"
    done
else
    echo "SKIP: no atrium"
fi

echo "## Frames: lights and samples"
"$bin/runtime_cost_bench" 192 5

echo "## Streaming, a million samples"
scene 2 1000000 32 >"$folder/scene.json"
"$bin/airlight-bake" "$folder/scene.json" -o "$folder/million" --quiet
"$bin/airlight-play" "$folder/million" --headless --quiet --size 192x192 --first-picture --frames 2 --no-lod \
    --stats "$folder/stats.json"
echo "| first picture | $(number first_picture_ms "$folder/stats.json") ms |"
echo "| last sample | $(number last_sample_ms "$folder/stats.json") ms |"

echo "## Surfaces into fog: a switch's frame over the default's, 400 x 300"
if [ -f "${AIRLIGHT_SHARED:-../shared}/data/scenes/tim_cornell/cornell.obj" ]; then
    "$bin/airlight-bake" build/tests/scenes/cornell_smoke.json -o "$folder/smoke" --quiet
    frame() { # OPTIONS...: median ms of a frame
        "$bin/airlight-play" "$folder/smoke" --headless --quiet --size 400x300 --frames 4 --pass surface-scattering \
            --stats "$folder/stats.json" "$@"
        number frame_ms_median "$folder/stats.json"
    }
    for options in --no-second-leg "--second-leg-steps 16" "--interval-weights coloured" "--interval-weights coefficients" \
        --visibility "--visibility --bounce-samples 1" "--visibility --no-second-leg"; do
        default=$(frame)
        # shellcheck disable=SC2086
        echo "| $options | $(awk "BEGIN { printf \"%.2f\", $(frame $options) / $default }") |"
    done
    "$bin/airlight-bench-scattering" "$folder/smoke" tests/runtime 400 300 1 20
else
    echo "SKIP: no Cornell box"
fi

echo "## Bounced z-buffer, 768 x 512: surfels kept, near the view; bytes held"
if [ -f "${AIRLIGHT_SHARED:-../shared}/data/meshes/c3d_spot.obj" ]; then
    "$bin/make_bounce_scenes" build/tests/scenes
    play() { # SCENE OPTIONS...: into stats.json
        name=$folder/bounce_$1
        [ -d "$name" ] || "$bin/airlight-bake" "build/tests/scenes/bounce_$1.json" -o "$name" --quiet
        shift
        "$bin/airlight-play" "$name" --headless --quiet --size 768x512 --stats "$folder/stats.json" "$@"
    }
    bytes() { # STEP: of the plan
        tr -d '\n' <"$folder/stats.json" | sed "s/.*\"step\": \"$1\"[^}]*\"bytes\": *\([0-9]*\).*/\1/"
    }
    while read -r scene size margin; do
        for pixels in "$size" 4.6; do
            play "$scene" --pass surfels --surfel-size "$pixels"
            kept=$(number surfels "$folder/stats.json")
            play "$scene" --pass surfels --surfel-size "$pixels" --surfel-margin "$margin"
            echo "| $scene | $pixels | $kept | $(number surfels "$folder/stats.json") |"
        done
        for pass in indirect ambient-occlusion; do
            play "$scene" --pass "$pass" --surfel-size 200 --bounce-samples 1
            echo "| $scene | $pass | $(bytes "$pass") bytes, the picture $(bytes surface) |"
        done
    done <<END
dominoes 2.29 0.5
still_life 2.28 0.1
yard 2.17 0.25
END
else
    echo "SKIP: no meshes"
fi
