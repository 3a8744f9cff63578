#!/bin/sh
# airlight-inspect from the command line: exact output and exit codes, on the golden files.
# inspect_test.sh PROGRAM GOLDEN_FOLDER EXPECTED_FOLDER
set -u
inspect=$1
golden=$2
expected=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
checks=0
failures=0

wrong() {
    failures=$((failures + 1))
    echo "failed: $*" >&2
}

# run EXIT_CODE ARGUMENTS...: output in $work/out and $work/err.
run() {
    wanted=$1
    shift
    checks=$((checks + 1))
    "$inspect" "$@" >"$work/out" 2>"$work/err"
    code=$?
    [ "$code" = "$wanted" ] || wrong "exit code $code, not $wanted: $* ($(cat "$work/err"))"
}

# One line on standard error that holds the words, nothing on standard output.
fails() {
    words=$2
    code=$1
    shift 2
    run "$code" "$@"
    [ "$(wc -l <"$work/err")" = 1 ] || wrong "not one line of error: $*"
    grep -qF -- "$words" "$work/err" || wrong "no '$words' in: $(cat "$work/err")"
    [ ! -s "$work/out" ] || wrong "output on failure: $*"
}

same() {
    checks=$((checks + 1))
    diff "$expected/$1" "$work/out" >&2 || wrong "other output than $1"
}

cd "$golden" || exit 1

for kind in translucent_byte scene scene_lit scene_moving impulse_tables lightmap_half medium probes translucent_measured; do
    run 0 ${kind}_1_0.air
    same $kind.txt
    run 0 --json ${kind}_1_0.air
    same $kind.json
    run 0 --check ${kind}_1_0.air
    [ "$(cat "$work/out")" = "${kind}_1_0.air: valid" ] || wrong "says $(cat "$work/out")"
    run 0 --image "$work/$kind.png" ${kind}_1_0.air
    [ "$(head -c 4 "$work/$kind.png" | tail -c 3)" = PNG ] || wrong "no picture of $kind"
done

# Every refused file: exit code 1 and its rule with --check, 3 and one line without.
for file in refuse_*.air; do
    rule=${file#refuse_}
    rule=${rule%%_*}
    run 1 --check "$file"
    grep -q "^rule $rule: " "$work/out" || wrong "$file: no rule $rule in $(cat "$work/out")"
    grep -q "^airlight-inspect: $file: not valid, [0-9]* finding" "$work/err" || wrong "$file: $(cat "$work/err")"
    fails 3 "(rule " "$file"
    run 3 --json "$file"
    grep -q '"valid": false' "$work/out" || wrong "$file: --json does not say that it is not valid"
done
run 1 --check --json refuse_132_g_of_one.air
same refused.json

# Questions. The sphere of influence of the only sample of translucent_float is 0.25 m about (-0.25, 0.125, 0);
# its one coefficient is 2.5, so psi is 2.5 sqrt(1/(4 pi)) = 0.70523698 in every direction.
run 0 translucent_float_1_0.air --eval '{"position": [-0.2, 0.1, 0.1], "direction": [0, -3, 1]}'
[ "$(cat "$work/out")" = '{"transmittance": [0.705236971, 0.705236971, 0.705236971], "samples_used": 1}' ] || wrong "answer: $(cat "$work/out")"
run 0 translucent_float_1_0.air --eval '{"position": [5, 0, 0], "direction": [0, 1, 0]}'
[ "$(cat "$work/out")" = '{"transmittance": [1.0, 1.0, 1.0], "samples_used": 0}' ] || wrong "answer: $(cat "$work/out")"
fails 2 '"direction" should be three finite numbers' translucent_float_1_0.air --eval '{"position": [0, 0, 0]}'
fails 2 '"position" should be three finite numbers' translucent_float_1_0.air --eval '{"position": [0, 0, "x"], "direction": [0, 1, 0]}'
fails 2 'has no length' translucent_float_1_0.air --eval '{"position": [0, 0, 0], "direction": [0, 0, 0]}'
fails 2 'unknown key "normal"' translucent_float_1_0.air --eval '{"position": [0, 0, 0], "direction": [0, 1, 0], "normal": [0, 1, 0]}'
fails 2 'is no JSON object' translucent_float_1_0.air --eval '[1]'
fails 2 'is no JSON object' translucent_float_1_0.air --eval 'x'
# Voxel (9, 1, 4) of the second frame of the golden medium: density 1 + 1/2 + 4/8 = 2 at (2.5, -0.75, 3.5).
run 0 medium_1_0.air --eval '{"position": [2.5, -0.75, 3.5], "time": 1}'
[ "$(cat "$work/out")" = '{"sigma_s_per_m": [2.0, 4.0, 8.0], "sigma_a_per_m": [1.0, 0.5, 0.0], "g": 0.75}' ] || wrong "answer: $(cat "$work/out")"
run 0 medium_1_0.air --eval '{"position": [0, 5, 0]}'
[ "$(cat "$work/out")" = '{"sigma_s_per_m": [0.0, 0.0, 0.0], "sigma_a_per_m": [0.0, 0.0, 0.0], "g": 0.75}' ] || wrong "answer: $(cat "$work/out")"
# Point 11 of the sky's light stands at the upper corner: number n of channel c is (n + c/4 - 11/16) exp(-11/4).
run 0 medium_sky_1_0.air --eval '{"position": [2.75, 0.5, 4.25]}'
grep -q '"sky_sh": \[\[0.0199' "$work/out" || wrong "answer: $(cat "$work/out")"
# Optical depths there, point 7: number n of the second frame is (n + 29/4) times its unit, 4 x 5.886 m / 4096.
run 0 medium_depth_1_0.air --eval '{"position": [2.75, 0.5, 4.25], "time": 0.8}'
grep -q '"depth_sh_m": \[0.0416[0-9]*, 0.0474[0-9]*, 0.0531[0-9]*, 0.0589[0-9]*\]' "$work/out" || wrong "answer: $(cat "$work/out")"
fails 2 '"time" should be a finite number' medium_1_0.air --eval '{"position": [0, 0, 0], "time": "now"}'
fails 2 'answers no questions' scene_1_0.air --eval '{}'
fails 3 '(rule 106)' refuse_106_header_checksum.air --eval '{"position": [0, 0, 0], "direction": [0, 1, 0]}'

# The centre of the floor of lightmap_float lies at page uv (0.5, 0.5): half way between the rows of the middle
# column, texels 1 and 4, so surface is the mean of 0.125 (2 and 5) + 0.25 c.
run 0 lightmap_float_1_0.air --eval '{"position": [0.5, 0.25, 0.5], "normal": [0, 3, 1]}'
[ "$(cat "$work/out")" = '{"surface": [0.4375, 0.6875, 0.9375], "attenuated": [0.875, 1.125, 1.375], "scattered": [1.3125, 1.5625, 1.8125], "distance_m": 0.25, "instance": 0}' ] || wrong "answer: $(cat "$work/out")"
fails 2 'no lightmapped surface faces' lightmap_float_1_0.air --eval '{"position": [0, 0, 0], "normal": [0, -1, 0]}'
fails 2 'the normal longer than 0' lightmap_float_1_0.air --eval '{"position": [0, 0, 0], "normal": [0, 0, 0]}'
fails 2 '"normal" should be three finite numbers' lightmap_float_1_0.air --eval '{"position": [0, 0, 0]}'

# The middle of the two tetrahedra's common face, moved half of the way to probe 4: weights 1/6, 1/6, 1/6, 1/2.
run 0 probes_1_0.air --eval '{"position": [0.66666667, 0.66666667, 0.66666667]}'
grep -q '"probes": \[1, 2, 3, 4\]' "$work/out" || wrong "answer: $(cat "$work/out")"
grep -q '"weights": \[0.1666666[0-9]*, 0.1666666[0-9]*, 0.1666666[0-9]*, 0.5[0-9]*\]' "$work/out" || wrong "answer: $(cat "$work/out")"
fails 2 'unknown key "normal"' probes_1_0.air --eval '{"position": [0, 0, 0], "normal": [0, 1, 0]}'

# Files that are not there or no files; what cannot be written.
fails 3 'absent.air' absent.air
fails 3 'absent.air' --check absent.air
fails 3 'no regular file' "$work"
fails 4 "$work/absent/picture.png" --image "$work/absent/picture.png" scene_1_0.air
if [ -w /dev/full ]; then
    checks=$((checks + 1))
    "$inspect" scene_1_0.air >/dev/full 2>"$work/err"
    [ $? = 4 ] || wrong "a full standard output is not seen"
fi

echo "$checks checks, $failures failed"
[ "$failures" = 0 ]
