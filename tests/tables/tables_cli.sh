#!/bin/sh
# Impulse tables from the command line: small ones made twice, other settings, answers in the contract's form,
# pictures, and wrong questions. usage: tables_cli.sh FOLDER_OF_PROGRAMS DEFAULT_TABLES
set -u
bin=$1
default=$2
. "$(dirname "$0")/../programs/expect.sh"

[ -e "$default" ] || skip "there are no tables: tables.bake found no OpenCL device"

small="--table-events 2 --table-distances 24 --table-cosines 7 --table-bands 4"
# shellcheck disable=SC2086
make() {
    to=$1
    shift
    "$bin/airlight-bake" --tables "$work/$to.air" $small "$@"
}

# Same bytes for any number of threads; nothing is done twice; another setting is another key.
run 0 make one --threads 1
grep -q "wrote $work/one.air" "$work/stderr" || wrong "says $(cat "$work/stderr")"
run 0 make three --threads 3
cmp "$work/one.air" "$work/three.air" || wrong "threads change the tables"
run 0 make one --threads 2
grep -q "one.air is up to date" "$work/stderr" || wrong "made again: $(cat "$work/stderr")"
run 0 make one --table-g 0.3 --quiet
cmp -s "$work/one.air" "$work/three.air" && wrong "--table-g changes nothing"
run 0 "$bin/airlight-inspect" --check "$work/one.air"
run 0 "$bin/airlight-inspect" --json "$work/one.air"
grep -q '"bands": 4' "$work/stdout" || wrong "not 4 bands"
grep -q '"g": 0.3' "$work/stdout" || wrong "no table of g = 0.3"
grep -q '"kind": "impulse-tables"' "$work/stdout" || wrong "another kind"

# The published single table answers what beam and events give together: both are interpolated between 24 distances,
# a decade in 2.6 steps, so that a few percent remain.
run 0 make single --table-all-in-one
run 0 "$bin/airlight-inspect" --json "$work/single.air"
tr -d ' \n' <"$work/stdout" | grep -q '"events":\[0,2\]' || wrong "no table of all in one"
for emitter in point directional area; do
    for variant in best published; do
        run 0 "$bin/airlight-inspect" "$work/single.air" --eval \
            "{\"emitter\": \"$emitter\", \"distance\": 0.8, \"cos_normal\": 0.6, \"sigma_s\": 1, \"events\": [0, 1, 2], \"variant\": \"$variant\"}"
        sed 's/{"zh": \[\([^,]*\),.*/\1/' "$work/stdout" >"$work/$variant"
    done
    paste "$work/best" "$work/published" | awk '{ exit !($1 != $2 && $1 / $2 > 0.95 && $1 / $2 < 1.05) }' ||
        wrong "all in one of $emitter: $(paste "$work/best" "$work/published")"
done

# A damaged file is made again; one of another kind or a folder is not taken for tables.
printf x >>"$work/three.air"
run 0 make three --threads 3
grep -q "wrote $work/three.air" "$work/stderr" || wrong "a damaged file is up to date"
fails 4 "$work/absent/t.air" make absent/t --quiet
fails 2 "--tables" "$bin/airlight-bake" scene.json --tables "$work/t.air"
fails 2 "--table-cosines" "$bin/airlight-bake" --tables "$work/t.air" --table-cosines 8
fails 2 "--table-bands" "$bin/airlight-bake" --tables "$work/t.air" --table-bands 2
fails 2 "--table-events" "$bin/airlight-bake" --tables "$work/t.air" --table-events 0
fails 2 "--table-g" "$bin/airlight-bake" --tables "$work/t.air" --table-g 1
[ ! -e "$work/t.air" ] || wrong "wrong usage leaves a file"

# Stopped on the way: nothing is left behind.
fails 130 "cancelled" timeout --preserve-status -s INT 2 "$bin/airlight-bake" --tables "$work/cancelled.air" --quiet
[ -z "$(find "$work" -name 'cancelled*')" ] || wrong "left behind: $(find "$work" -name 'cancelled*')"

# A scene takes the tables that lie in its folder, of whatever settings, else makes them there; one whose walls are not
# as published has no use for them.
cat >"$work/foggy.json" <<'SCENE'
{
  "meshes": [{"name": "floor", "shape": {"type": "plane", "width_m": 2, "depth_m": 2}, "lighting": "lightmap"}],
  "lights": [{"name": "lamp", "type": "point", "position_m": [0, 1, 0], "intensity_w_sr": 5}],
  "media": [{"name": "fog", "sigma_s_per_m": 0.5}],
  "fogs": ["fog"],
  "lightmap": {"texel_m": 0.5, "samples": 4, "bounces": 1, "walls": "published"}
}
SCENE
# shellcheck disable=SC2086
run 0 "$bin/airlight-bake" "$work/foggy.json" -o "$work/foggy" $small
grep -q "wrote $work/foggy/impulse-tables.air" "$work/stderr" || wrong "makes no tables: $(cat "$work/stderr")"
tr -d ' \n' <"$work/foggy/report.json" | grep -q '"path":"impulse-tables.air","kind":"impulse-tables"' || wrong "no tables in the report"
tr -d ' \n' <"$work/foggy/report.json" | grep -q '"step":"impulsetables","needed":true' || wrong "no tables in the plan"
run 0 "$bin/airlight-bake" "$work/foggy.json" -o "$work/foggy"
grep -q "impulse-tables" "$work/stderr" && wrong "does not take the tables that are there: $(cat "$work/stderr")"
# Tables that are gone are made again, to the same bytes, and the lightmap that they served stays.
mv "$work/foggy/impulse-tables.air" "$work/gone.air"
# shellcheck disable=SC2086
run 0 "$bin/airlight-bake" "$work/foggy.json" -o "$work/foggy" $small
cmp "$work/gone.air" "$work/foggy/impulse-tables.air" || wrong "other tables"
grep -q "foggy.lightmap.air is up to date" "$work/stderr" || wrong "a lightmap is baked again for missing tables"
sed 's/"published"/"bounded"/' "$work/foggy.json" >"$work/bounded.json"
run 0 "$bin/airlight-bake" "$work/bounded.json" -o "$work/bounded"
[ ! -e "$work/bounded/impulse-tables.air" ] || wrong "tables that nobody needs"
tr -d ' \n' <"$work/bounded/report.json" | grep -q '"step":"impulsetables","needed":false' || wrong "unneeded tables in the plan"

# Tables that cannot be used are refused, not replaced: of a newer version, cut off.
for damage in newer cut; do
    rm -f "$work/foggy"/*.lightmap.air
    cp "$work/foggy/impulse-tables.air" "$work/kept.air"
    case $damage in
    newer) printf '\002' | dd of="$work/foggy/impulse-tables.air" bs=1 seek=8 conv=notrunc 2>/dev/null ;;
    cut) head -c 5000 "$work/kept.air" >"$work/foggy/impulse-tables.air" ;;
    esac
    sum=$(cksum <"$work/foggy/impulse-tables.air")
    fails 3 "impulse-tables.air" "$bin/airlight-bake" "$work/foggy.json" -o "$work/foggy" --quiet
    [ "$sum" = "$(cksum <"$work/foggy/impulse-tables.air")" ] || wrong "tables that are $damage were replaced"
    [ ! -e "$work/foggy/foggy.lightmap.air" ] || wrong "a lightmap from tables that are $damage"
    mv "$work/kept.air" "$work/foggy/impulse-tables.air"
done

# Answers.
ask() {
    run 0 "$bin/airlight-inspect" "$default" --eval "$1"
}
says() {
    grep -q "$1" "$work/stdout" || wrong "no '$1' in $(cat "$work/stdout")"
}
ask '{"emitter": "point", "distance": 1, "sigma_s": 1, "sigma_a": 0, "g": 0, "events": [1]}'
says '^{"zh": \[0.12243' && says '"axis_angle": 0.0}$'
ask '{"emitter": "point", "distance": 1, "sigma_s": 1, "events": "direct"}'
says '^{"zh": \[0.103776874,'
ask '{"emitter": "point", "distance": 1, "sigma_s": 1, "events": [1, 2, 3], "cos_normal": "ignored"}'
says '^{"zh": \[0.3105'
ask '{"emitter": "directional", "distance": 3, "sigma_s": 1, "events": "all", "variant": "published"}'
ask '{"emitter": "area", "distance": 1, "cos_normal": 0.5, "sigma_s": 1, "events": [1]}'
says '"sh_m": \[\[' && says '"axis_angle": 0.40'
ask '{"emitter": "area", "distance": 1, "cos_normal": 0.5, "sigma_s": 1, "events": [1], "variant": "published"}'
grep -q sh_m "$work/stdout" && wrong "the published variant has no sh_m"
ask '{"emitter": "point", "distance": 1000, "sigma_s": 1, "events": [10]}'

# Wrong questions.
refuses() {
    fails 2 "$1" "$bin/airlight-inspect" "$default" --eval "$2"
}
refuses 'unknown key "sigma"' '{"emitter": "point", "distance": 1, "sigma": 1, "events": [1]}'
refuses '"emitter" should be "point", "directional" or "area"' '{"emitter": "lamp", "distance": 1, "sigma_s": 1, "events": [1]}'
refuses '"emitter" should be' '{"distance": 1, "sigma_s": 1, "events": [1]}'
refuses '"distance" should be a number' '{"emitter": "point", "distance": "1", "sigma_s": 1, "events": [1]}'
refuses '"distance" should be a number' '{"emitter": "point", "distance": 0, "sigma_s": 1, "events": [1]}'
refuses '"sigma_s" should be a number' '{"emitter": "point", "distance": 1, "sigma_s": -1, "events": [1]}'
refuses '"sigma_s" should be a number' '{"emitter": "point", "distance": 1, "events": [1]}'
refuses '"g" should be a number from -0.99 to 0.99' '{"emitter": "point", "distance": 1, "sigma_s": 1, "g": 1, "events": [1]}'
refuses '"cos_normal" should be a number from -1 to 1' '{"emitter": "area", "distance": 1, "sigma_s": 1, "events": [1]}'
refuses '"cos_normal" should be a number from -1 to 1' '{"emitter": "area", "distance": 1, "cos_normal": 2, "sigma_s": 1, "events": [1]}'
refuses '"events" should be' '{"emitter": "point", "distance": 1, "sigma_s": 1}'
for events in '[]' '[-1]' '[11]' '[1, 3]' '[2, 1]' '[1.5]' '"none"' '1'; do
    refuses '"events" should be "direct", "all" or numbers from 0 (the beam) to 10' \
        "{\"emitter\": \"point\", \"distance\": 1, \"sigma_s\": 1, \"events\": $events}"
done
refuses '"variant" should be "best" or "published"' '{"emitter": "point", "distance": 1, "sigma_s": 1, "events": [1], "variant": "new"}'

run 0 "$bin/airlight-inspect" "$default" --image "$work/tables.png"
[ "$(head -c 4 "$work/tables.png" | tail -c 3)" = PNG ] || wrong "no picture"
fails 4 "$work/absent/tables.png" "$bin/airlight-inspect" "$default" --image "$work/absent/tables.png"
finish
