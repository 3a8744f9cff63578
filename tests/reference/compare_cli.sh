#!/bin/sh
# airlight-compare as a product: output and exit codes. Usage: compare_cli.sh PROGRAM, where compare_*.exr lie.
set -u
program=$1
failed=0

# expect CODE WORDS... -- ARGUMENTS...: the exit code, and a string that output or message must hold
expect() {
    code=$1 text=$2
    shift 2
    answer=$("$program" "$@" 2>&1)
    got=$?
    if [ $got -ne "$code" ]; then
        echo "exit code $got, expected $code: $*"; failed=1
    fi
    case $answer in
    *"$text"*) ;;
    *) echo "'$text' is not in: $answer"; failed=1 ;;
    esac
}

whole='{
  "rmse": 1.87082869,
  "relative_rmse": 1.87082869,
  "psnr_db": -5.44068044,'
expect 0 "$whole" compare_a.exr compare_b.exr --json
expect 0 'mean_ratio 2.5' compare_a.exr compare_b.exr
expect 0 '"relative_rmse_without_noise": 1.58113883' compare_a.exr compare_b.exr --json --error compare_b.exr
expect 0 '"chi2_mean": 1.75' compare_a.exr compare_b.exr --json --error compare_b.exr --noise-a compare_b.exr
expect 0 '"psnr_db": null' compare_a.exr compare_a.exr --json
expect 0 'nan_count 1' compare_special.exr compare_b.exr
expect 0 'inf_count 1' compare_special.exr compare_b.exr
expect 0 'rmse 1.87' compare_a.exr compare_b.exr --fail-above rmse=1.9 --fail-above max_abs=3
expect 1 'max_abs is 3' compare_a.exr compare_b.exr --fail-above rmse=1.9 --fail-above max_abs=2.9
expect 1 'nan_count is 1' compare_special.exr compare_b.exr --fail-above nan_count=0
expect 1 'psnr_db' compare_a.exr compare_a.exr --fail-above psnr_db=100
expect 2 'no metric' compare_a.exr compare_b.exr --fail-above loudness=1
expect 2 'METRIC=VALUE' compare_a.exr compare_b.exr --fail-above rmse
expect 2 'takes a number' compare_a.exr compare_b.exr --fail-above rmse=big
expect 2 'needs --error' compare_a.exr compare_b.exr --fail-above relative_rmse_without_noise=1
expect 2 'needs --error' compare_a.exr compare_b.exr --noise-a compare_b.exr
expect 2 'argument is missing' compare_a.exr
expect 3 'compare_wide.exr: 3 x 1 pixels' compare_wide.exr compare_b.exr
expect 3 'compare_wide.exr' compare_a.exr compare_b.exr --error compare_wide.exr
expect 3 'missing.exr: cannot open' missing.exr compare_b.exr
expect 3 'not a readable OpenEXR file' "$0" compare_b.exr
expect 4 'no/such/folder' compare_a.exr compare_b.exr --diff no/such/folder/diff.png
expect 0 'usage:' --help
rm -f compare_diff.png
expect 0 'flip_hdr' compare_a.exr compare_b.exr --diff compare_diff.png
[ -s compare_diff.png ] || { echo "no compare_diff.png"; failed=1; }
exit $failed
