#!/usr/bin/env bash
# Where every host program's files go: a full disk, the input as output, links. What was there stays when it cannot be replaced.
SCENES=$PWD/host_tools/scenes
. tests/e2e/gtlut_common.sh
S=$B/gtscene
M=$B/gtsim

"$G" measure gold -o gold.csv && "$G" build gold.csv --size 32x8x3 --kind half_vector -o gold.ktx2 2>/dev/null || exit 1
"$S" build "$SCENES/oled.json" -o oled.blob || exit 1

# kept file command...: exit code 3 with one message about the file, whose old content stays
kept() {
    local file=$1 code
    shift
    echo keep >"$file"
    "$@" >kept_out 2>kept_err
    code=$?
    [ $code = 3 ] && [ "$(wc -l <kept_err)" = 1 ] && grep -q ": $file: " kept_err || { echo "exit code $code: $*"; cat kept_err; return 1; }
    [ "$(cat "$file")" = keep ] || { echo "$file was changed by: $*"; return 1; }
    ! ls -A | grep '\.tmp\.' || { echo "left by: $*"; return 1; }
}
# No file may be longer than 1 KB: a disk that fills up.
full_disk() {
    trap '' XFSZ
    ulimit -f 1
    kept out.png "$G" export gold.ktx2 -o out.png && kept out.exr "$G" export gold.ktx2 -o out.exr || return 1
    kept out.png "$G" preview gold.ktx2 --what lobe -o out.png && kept out.svg "$G" preview gold.ktx2 --what plots -o out.svg || return 1
    kept out.exr "$G" preview gold.ktx2 --what sphere --size 16 -o out.exr || return 1
    kept out.svg "$G" check gold.csv --plot out.svg || return 1
    kept out.ktx2 "$G" build gold.csv -o out.ktx2 && kept out.blob "$S" build "$SCENES/oled.json" -o out.blob || return 1
    kept out.png "$M" render oled.blob --table 0=gold.ktx2 -o out.png
}
on_a_full_disk() { (full_disk); }
check "on a full disk every picture, table and scene fails with exit code 3 and the old file stays" on_a_full_disk

fails_in_gnuplot() { # script of a gnuplot, pattern
    mkdir -p fake && printf '#!/bin/sh\n%s\n' "$1" >fake/gnuplot && chmod +x fake/gnuplot || return 1
    PATH=$PWD/fake:$PATH kept out.svg "$G" preview gold.ktx2 --what plots -o out.svg && grep -qE "$2" kept_err || { cat kept_err; return 1; }
}
gnuplot_failures() {
    fails_in_gnuplot 'cat >/dev/null; echo "bad command" >&2; exit 1' 'gnuplot failed .*: bad command' || return 1
    fails_in_gnuplot 'cat >/dev/null; echo "<svg>"' 'no end after 6 bytes' || return 1
    fails_in_gnuplot 'exit 1' 'gnuplot failed' || return 1
    rm -r fake
    mkdir none
    PATH=$PWD/none kept_without_path || { cat kept_err; return 1; }
}
kept_without_path() { # PATH holds no program, not even those of kept()
    echo keep >out.svg
    "$G" preview gold.ktx2 --what plots -o out.svg 2>kept_err
    [ $? = 3 ] && [[ "$(<kept_err)" = *'install gnuplot-nox'* ]] && [ "$(<out.svg)" = keep ]
}
check "a gnuplot that fails, stops half-way or is not there: the message says which, the old file stays" gnuplot_failures

few_samples() {
    printf 'theta_in,theta_out,phi_out,R,G,B\n0,0,0,1,1,1\n' >one.csv
    quiet "$G" preview one.csv -o one && [ "$(ls one | wc -l)" = 5 ]
}
check "a measurement of one sample has all its pictures" few_samples

# itself file command...: exit code 2, the file as it was
itself() {
    local file=$1 sum code
    shift
    sum=$(cksum <"$file")
    "$@" >itself_out 2>itself_err
    code=$?
    [ $code = 2 ] && grep -q 'is the input, too' itself_err || { echo "exit code $code: $*"; cat itself_err; return 1; }
    [ "$sum" = "$(cksum <"$file")" ] || { echo "$file was changed by: $*"; return 1; }
}
inputs_stay() {
    ln -s gold.csv link.csv && cp "$SCENES/oled.json" scene.json && "$G" import gold.csv -o gold.gtm || return 1
    itself gold.csv "$G" build gold.csv -o gold.csv && itself gold.csv "$G" build link.csv -o ./gold.csv || return 1
    itself gold.csv "$G" import gold.csv -o link.csv && itself gold.csv "$G" check gold.csv --repair -o gold.csv || return 1
    itself gold.ktx2 "$G" build gold.ktx2 --size 1K -o gold.ktx2 && itself gold.ktx2 "$G" atlas gold.ktx2 -o gold.ktx2 || return 1
    itself scene.json "$S" build scene.json -o scene.json || return 1
    printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >mesh.obj
    cat >mesh.json <<'JSON'
{"meshes": [{"name": "m", "file": "mesh.obj"}], "materials": [{"name": "m", "model": "measured", "slot": 0}],
 "objects": [{"mesh": "m", "material": "m"}], "lights": [{"direction": [0, 0, 1], "irradiance": [3, 3, 3]}],
 "camera": {"eye": [0, 0, 5], "target": [0, 0, 0], "fov_y": 40}}
JSON
    itself mesh.obj "$S" build mesh.json -o mesh.obj
}
check "no command writes over a file that it reads, by whatever name" inputs_stay

png_only() {
    local option
    for option in "-o out.jpg" "-o out" "-o out.png -h heat.exr" "-o out.png -h out.png"; do
        "$M" render oled.blob --table 0=gold.ktx2 $option 2>err
        [ $? = 2 ] && [ "$(wc -l <err)" = 1 ] || { echo "$option"; cat err; return 1; }
    done
    [ ! -e out.jpg ]
}
check "gtsim render writes PNG and refuses other names, and one name for two pictures" png_only

echo 1..$n
