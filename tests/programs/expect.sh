# What the command-line tests share. Sourced with bin=FOLDER of the programs; gives $work, a fresh folder that is
# removed at the end, and the functions below. The script ends with `finish`.

work=$(mktemp -d)
mounted=
clean_up() {
    for place in $mounted; do umount "$place"; done
    rm -rf "$work"
}
trap clean_up EXIT
failures=0

wrong() {
    echo "FAILED: $*" >&2
    failures=$((failures + 1))
}

skip() {
    echo "SKIP: $*"
    exit 77
}

# run CODE COMMAND...: the exit code must be CODE; output in $work/stdout and $work/stderr.
run() {
    wanted=$1
    shift
    code=0
    "$@" >"$work/stdout" 2>"$work/stderr" || code=$?
    [ "$code" = "$wanted" ] && return 0
    wrong "exit code $code, not $wanted: $*"
    cat "$work/stderr" >&2
}

# fails CODE WORDS COMMAND...: exits with CODE and says one line on standard error, which begins with a program's
# name and contains WORDS (a file's name, say); nothing on standard output.
fails() {
    fails_code=$1 fails_words=$2
    shift 2
    run "$fails_code" "$@"
    lines=$(wc -l <"$work/stderr")
    [ "$lines" = 1 ] || wrong "$lines lines on standard error, not 1: $*: $(cat "$work/stderr")"
    grep -Eq '^airlight-[a-z]+: ' "$work/stderr" || wrong "does not begin with the program: $(cat "$work/stderr")"
    grep -qF -e "$fails_words" "$work/stderr" || wrong "does not name '$fails_words': $(cat "$work/stderr")"
    [ ! -s "$work/stdout" ] || wrong "standard output is not empty: $*"
}

# extreme WHAT ASKED CAME_OUT EXPECTED LOW HIGH: a row of the table of extremes (scripts/extremes.sh) and its check: LOW to HIGH
# is right.
extreme() {
    awk -v what="$1" -v asked="$2" -v value="$3" -v expected="$4" -v low="$5" -v high="$6" 'BEGIN {
        off = value - expected; bound = high - expected > expected - low ? high - expected : expected - low
        unit = expected < 0 ? -expected : expected; if (bound >= 1000 * unit) unit = 1; missed = !(value != "" && value + 0 >= low + 0 && value + 0 <= high + 0)
        how = off == 0 && bound == 0 ? "exact" : sprintf("%.1e (%.1e)", (off < 0 ? -off : off) / unit, bound / unit)
        printf "extreme: | %s | %s | %.6g | %.6g | %s |%s\n", what, asked, value, expected, how, missed ? " MISSED" : ""
        exit missed }' || wrong "$1: $2: $3 where $4 is expected ($5 to $6)"
}

# refusal WHAT ASKED: a row for what the last fails() checked.
refusal() {
    echo "extreme: | $1 | $2 | exit code $fails_code: $(sed "s|$work/||g" "$work/stderr") | a refusal | |"
}

# full_output PROGRAM...: what it has to say does not fit on a full disk: exit code 4 and one line.
full_output() {
    [ -c /dev/full ] || return 0
    full_code=0
    "$@" >/dev/full 2>"$work/stderr" || full_code=$?
    [ "$full_code" = 4 ] || wrong "exit code $full_code, not 4, with a full standard output: $*"
    grep -q 'standard output: cannot write' "$work/stderr" || wrong "does not say so: $(cat "$work/stderr")"
}

# empty FOLDER: does not exist or holds no file.
empty() {
    [ -z "$(find "$1" ! -type d 2>/dev/null)" ] || wrong "left behind: $(find "$1" ! -type d)"
}

finish() {
    [ "$failures" = 0 ] || exit 1
    echo "all as expected"
}
