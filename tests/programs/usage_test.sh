#!/bin/sh
# usage_test.sh BIN PROGRAM ARGUMENTS: help, version and wrong usage of one program; ARGUMENTS is how many words it
# needs at least.
set -eu
bin=$1 program=$2 needed=$3
. "$(dirname "$0")/expect.sh"

run 0 "$bin/$program" --help
head -n 1 "$work/stdout" | grep -q "^usage: $program " || wrong "--help does not begin with the usage"
for option in --quiet --verbose --help --version; do
    grep -q -e "^  $option" "$work/stdout" || wrong "--help does not list $option"
done
[ ! -s "$work/stderr" ] || wrong "--help writes to standard error"

run 0 "$bin/$program" --version
grep -Eqx "$program [0-9]+\.[0-9]+\.[0-9]+" "$work/stdout" || wrong "--version says: $(cat "$work/stdout")"

full_output "$bin/$program" --help
full_output "$bin/$program" --version

fails 2 "'--no-such-option'" "$bin/$program" --no-such-option
fails 2 "--quiet=3" "$bin/$program" --quiet=3
fails 2 "'--two?lines'" "$bin/$program" "$(printf -- '--two\nlines')"
fails 2 "an argument is empty" "$bin/$program" ""
[ "$needed" = 0 ] || fails 2 "usage" "$bin/$program"
fails 2 "one argument too many" "$bin/$program" 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20
finish
