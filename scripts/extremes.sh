#!/bin/sh
# Prints the table of extremes in docs/accuracy.md: each extreme of the list below, what was asked of what, what came out, double
# precision or a closed form, how far off it is and in brackets the bound; or the refusal. The rows come from the tests, which
# print them as they check them. Exit code 1, and which, where one misses its bound, a test fails, or an extreme has no row.
# usage: scripts/extremes.sh [FOLDER]   (default out/extremes: what the tests said, and tables.air, made if missing)
set -eu
cd "$(dirname "$0")/.."

scripts/build.sh >/dev/null
bin=build/bin
folder=${1:-out/extremes}
mkdir -p "$folder"
[ -f "$folder/tables.air" ] || "$bin/airlight-bake" --tables "$folder/tables.air" --quiet
failed=

# ask TEST ARGUMENTS...: what it says goes to FOLDER/TEST.txt.
ask() {
    name=$(basename "$1")
    echo "$name" >&2
    "$@" >"$folder/$name.txt" 2>"$folder/$name.errors" || failed="$failed $name (exit code $?: $folder/$name.errors)"
}
rm -f "$folder"/*.txt
ask "$bin/runtime_fog_test"
ask "$bin/runtime_extremes_test"
ask "$bin/runtime_analytic_test"
ask "$bin/runtime_scattering_extremes_test"
ask "$bin/runtime_bounce_extremes_test"
ask "$bin/gather_extremes_test" "$folder/tables.air"
ask "$bin/tables_oracle_test" "$folder/tables.air"
ask "$bin/reference_scatter_test"
ask tests/bake/extremes_test.sh "$bin"
mv "$folder/extremes_test.sh.txt" "$folder/bake.txt"
ask tests/programs/extremes_test.sh "$bin"

# In the list's order; of rows that differ by the kind of walls alone the one that is off by most.
cat "$folder"/*.txt | awk -v failed="$failed" '
    BEGIN {
        FS = " \\| "
        count = split("sigma_t times size 1e-6|sigma_t times size 1e-3|sigma_t times size 1 to 100|sigma_t times size 1e4|albedo 0|" \
            "albedo 1 - 1e-6|albedo 1|g 0.99|g -0.99|table distance 1e-6|table distance 1e3|one voxel|one triangle|" \
            "triangles without area|scene of 1e-4 m|scene of 1e4 m|density 0|one voxel of 1e6|radiosity 1e-6|radiosity 1e6|" \
            "camera inside the medium|camera inside a sample|light on a surface|0 lights|64 lights|1 x 1 pixels|" \
            "8192 x 8192 pixels|0 samples|1 sample|1e6 samples", list, "|")
        for (i = 1; i <= count; i++) known[list[i]] = 1
        print "| extreme | asked | came out | double precision | off by (bound) |"
        print "| --- | --- | --- | --- | --- |"
    }
    sub(/^extreme: \| /, "") {
        if (!($1 in known)) problems = problems "\nno such extreme: " $0
        if (/MISSED$/) problems = problems "\nmissed: " $0
        gsub(/[a-z_]*of_test_[0-9]*.json: /, "")
        worst = /gathered, [a-z]* walls/ && !/exit code/
        if (worst) sub(/gathered, [a-z]* walls/, "gathered, the worst of three kinds of walls")
        key = worst ? $1 "|" $2 : NR
        if (!(key in row)) order[$1, ++rows[$1]] = key
        if (!(key in row) || $5 + 0 > off[key]) { row[key] = $0; off[key] = $5 + 0 }
    }
    END {
        for (i = 1; i <= count; i++) {
            for (k = 1; k <= rows[list[i]]; k++) print "| " row[order[list[i], k]]
            if (!rows[list[i]]) problems = problems "\nno row: " list[i]
        }
        if (failed) problems = problems "\nfailed:" failed
        if (problems) { print substr(problems, 2) | "cat >&2"; exit 1 }
    }'
