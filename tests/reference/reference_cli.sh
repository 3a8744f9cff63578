#!/bin/sh
# airlight-reference as a product. Usage: reference_cli.sh PROGRAM
set -u
program=$1
failed=0
folder=reference_cli
rm -rf $folder && mkdir $folder && cd $folder || exit 1

# expect CODE WORDS ARGUMENTS...: the exit code, and a string that the message must hold
expect() {
    code=$1 text=$2
    shift 2
    answer=$("$program" "$@" 2>&1)
    got=$?
    [ $got -eq "$code" ] || { echo "exit code $got, expected $code: $*"; failed=1; }
    case $answer in
    *"$text"*) ;;
    *) echo "'$text' is not in: $answer"; failed=1 ;;
    esac
}
check() { "$@" || { echo "failed: $*"; failed=1; }; }

cat > scene.json <<END
{"meshes": [{"name": "ball", "shape": {"type": "sphere", "subdivisions": 3}}],
 "media": [{"name": "milk", "sigma_s_per_m": 4}],
 "translucents": [{"name": "object", "mesh": "ball", "medium": "milk"}],
 "lights": [{"type": "directional", "direction": [0, -1, -1], "irradiance_w_m2": 1}],
 "cameras": [{"name": "front", "position_m": [0, 0, 3], "target_m": [0, 0, 0]}]}
END
single="--mode single-scatter"
path="--mode volume-path"
bounce="--mode surface-to-volume"

expect 0 'single-scatter' --help
expect 2 '--mode is missing: one of single-scatter' scene.json -o a.exr
expect 2 "'sideways' is not a mode: one of single-scatter, surface-to-volume, volume-path, ambient-occlusion, indirect" scene.json --mode sideways -o a.exr
expect 2 '-o is missing' scene.json $single
expect 2 'ends in .exr' scene.json $single -o a.png
expect 2 'ends in .exr' scene.json $single -o .exr
expect 2 '--spp' scene.json $single -o a.exr --spp 1
expect 2 '--points goes with' scene.json $single -o a.csv --points none.csv
expect 2 '--max-bounces go with' scene.json $single -o a.exr --max-bounces 2
expect 2 '--no-attenuation go with --mode surface-to-volume and indirect' scene.json $path -o a.exr --no-visibility
expect 2 '--no-attenuation go with --mode surface-to-volume and indirect' scene.json $single -o a.exr --no-attenuation
expect 2 '--radius goes with --mode ambient-occlusion' scene.json $bounce -o a.exr --radius 1
expect 2 '--radius' scene.json --mode ambient-occlusion -o a.exr --radius 0
expect 2 '--points goes with' scene.json $bounce -o a.csv --points none.csv
expect 2 '--stats goes with' scene.json $path -o a.exr --stats a.json
expect 2 'ends in .csv' scene.json $path -o a.exr --points none.csv
expect 3 'none.csv: cannot open' scene.json $path -o a.csv --points none.csv
expect 2 '"front"' scene.json $single -o a.exr --camera back
expect 3 'none.json' none.json $single -o a.exr
expect 4 'no/such/folder/a.exr' scene.json $single -o no/such/folder/a.exr
check [ "$(ls)" = scene.json ]

expect 0 '' scene.json $single -o a.exr --size 20x10 --spp 4 --threads 1
expect 0 '' scene.json $single -o b.exr --size 20x10 --spp 4 --threads 3 --camera front
check [ "$(ls | tr '\n' ' ')" = 'a.error.exr a.exr b.error.exr b.exr scene.json ' ]
check cmp a.exr b.exr
check cmp a.error.exr b.error.exr

# Points: what is wrong with a list, in which line.
# refuse WORDS LINES: a list that is no good
refuse() {
    printf "$2" > list.csv
    expect 3 "$1" scene.json $path -o a.csv --points list.csv
}
refuse 'list.csv: holds no points' '# none\nx,y,z,nx,ny,nz\n\n'
refuse 'list.csv:2: column 2 (y) is not a number' 'x,y,z,nx,ny,nz\n1,two,3,0,1,0\n'
refuse 'list.csv:1: column 6 (nz)' '1,2,3,0,1\n'
refuse 'list.csv:1: column 3 (z)' '1,2,nan,0,1,0\n'
refuse 'list.csv:1: the normal has length 2' '1,2,3,0,2,0\n'
refuse 'list.csv:2: is a probe' '1,2,3,0,1,0\n1,2,3,0,0,0\n'
check [ ! -e a.csv ]
printf 'x,y,z,nx,ny,nz\n0,0,2,0,0,1\n0.6, 0,0, 1,0,0,extra\r\n' > list.csv
expect 0 '' scene.json $path -o a.csv --points list.csv --spp 100 --threads 1 --stats stats.json
expect 0 '' scene.json $path -o b.csv --points list.csv --spp 100 --threads 3
check cmp a.csv b.csv
check [ "$(wc -l < a.csv)" = 3 ]
check grep -q '^0.6,0,0,1,0,0,' a.csv
check grep -q cpu_seconds_per_point stats.json
printf '0,0,2,0,0,0\n' > list.csv
expect 0 '' scene.json $path -o a.csv --points list.csv --spp 2
check [ "$(wc -l < a.csv)" = 10 ]
expect 0 '' scene.json $path -o c.exr --size 20x10 --spp 4 --max-events 3 --min-events 1 --max-bounces 0
for mode in "$bounce --no-visibility --no-attenuation" "--mode indirect" "--mode ambient-occlusion --radius 0.5"; do
    expect 0 '' scene.json $mode -o d.exr --size 20x10 --spp 4 --threads 1
    expect 0 '' scene.json $mode -o e.exr --size 20x10 --spp 4 --threads 3
    check cmp d.exr e.exr
    check cmp d.error.exr e.error.exr
done
rm d.exr d.error.exr e.exr e.error.exr list.csv a.csv b.csv stats.json c.exr c.error.exr

# Stopped: exit code 130, the old picture stays, nothing else is left.
for signal in INT TERM; do
    "$program" scene.json $single -o b.exr --size 512x512 --spp 100000 --quiet 2> message &
    sleep 1
    kill -$signal $!
    wait $!
    got=$?
    [ $got -eq 130 ] || { echo "exit code $got after SIG$signal, expected 130"; failed=1; }
    check grep -q cancelled message
    rm message
    check cmp a.exr b.exr
done
check [ "$(ls | tr '\n' ' ')" = 'a.error.exr a.exr b.error.exr b.exr scene.json ' ]
exit $failed
