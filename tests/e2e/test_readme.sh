#!/usr/bin/env bash
# README.md does what it says: its C program builds from the amalgamation alone and shows what the simulated device shows; its
# shell lines run, in order, in one scratch folder; its table of exit codes is that of host_tools/common.h.
. tests/e2e/usb_common.sh

root=$PWD
DATA=${GONIOTILE_DATA:-../shared/data}
[ ! -d "$DATA" ] || DATA=$(cd "$DATA" && pwd)

blocks() { # language: README's code blocks of that language, to $work/LANGUAGE.1, .2, ...
    awk -v language="$1" -v out="$work/$1." '
        $0 == "```" language { file = out (++count); printf "" > file; next }
        $0 == "```" { file = "" }
        file != "" { print > file }' README.md
}
blocks c
blocks sh

# --- embedding ---
mkdir "$work/product" && cp "$B"/amalgamation/goniotile.[hc] "$work/product" && cp "$work/c.1" "$work/product/show.c"
program_builds() ( # by the command that the text gives, warnings being errors
    cd "$work/product" && command=$(grep -o '`cc [^`]* -o show`' "$root/README.md" | tr -d '`') &&
        ${CC:-cc} -Wall -Wextra -Werror ${command#cc}
)
check the_c_program_builds_from_the_two_files_alone program_builds

cat >"$work/knot.json" <<'JSON'
{"meshes": [{"name": "knot", "shape": "knot"}],
 "materials": [{"name": "gold", "model": "measured", "slot": 0}],
 "objects": [{"mesh": "knot", "material": "gold"}],
 "lights": [{"direction": [1, 1, 2], "irradiance": [3, 3, 3]}, {"direction": [-2, 1, 1], "irradiance": [1, 1, 2]}],
 "camera": {"eye": [0, 0, 5], "target": [0, 0, 0], "fov_y": 40},
 "output": {"background": "#102030"}}
JSON
program_shows() { # the same pixels as the simulated device's
    gtscene build "$work/knot.json" -o "$work/knot.blob" &&
        gtsim render "$work/knot.blob" --table 0="$DEMO/gold.ktx2" -o "$work/knot.png" &&
        "$work/product/show" "$work/knot.blob" "$DEMO/gold.ktx2" >"$work/knot.ppm" && [ "$(head -1 "$work/knot.ppm")" = "P6 320 240 255" ] &&
        tail -n +2 "$work/knot.ppm" | od -An -v -tu1 -w3 | awk '{ print $1, $2, $3 }' >"$work/shown" &&
        seq 0 76799 | awk '{ print $1 % 320 "," int($1 / 320) }' | xargs -s 2000000 node tests/e2e/read_image.mjs "$work/knot.png" \
            >"$work/rendered" && cmp "$work/shown" "$work/rendered" && [ "$(sort -u "$work/shown" | wc -l)" -gt 1000 ]
}
check it_shows_what_the_device_shows program_shows
truncated_is_refused() {
    head -c 1000 "$work/knot.blob" >"$work/short.blob"
    "$work/product/show" "$work/short.blob" "$DEMO/gold.ktx2"
    [ $? = 1 ]
}
check it_refuses_a_truncated_scene truncated_is_refused

# --- shell ---
mkdir "$work/user" && ln -s "$B" "$work/user/build" && ln -s "$root/host_tools" "$work/user/host_tools"
for block in "$work"/sh.*; do
    claim=shell_lines_run_${block##*.}
    if grep -q GONIOTILE_DATA "$block" && [ ! -d "$DATA" ]; then
        skip "$claim" "no real data (GONIOTILE_DATA)"
    else
        check "$claim" env -C "$work/user" GONIOTILE_DATA="$DATA" bash -e "$block"
    fi
done
png_written() { [ "$(od -An -tx1 -N8 "$1" | tr -d ' ')" = 89504e470d0a1a0a ]; }
check shell_lines_wrote_a_frame png_written "$work/user/frame.png"
if [ -d "$DATA" ]; then
    check shell_lines_wrote_a_frame_of_the_real_material png_written "$work/user/spot.png"
else
    skip shell_lines_wrote_a_frame_of_the_real_material "no real data (GONIOTILE_DATA)"
fi

# --- tables ---
exit_codes() { # numbers in the table are those of the enum in common.h
    grep -q '^## Exit codes' README.md && diff <(sed -n '/^## Exit codes/,/^## /s/^| \([0-9]*\) |.*/\1/p' README.md) \
        <(sed -nE 's/^ *EXIT_[A-Z_]+ = ([0-9]+).*/\1/p' host_tools/common.h)
}
check exit_codes_are_all_listed exit_codes
targets() { # each `make TARGET` of README is one of the Makefile's
    local t bad=1
    for t in $(grep -oE '`make [a-z][a-z-]*' README.md | awk '{ print $2 }' | sort -u); do
        grep -qE "^$t:" Makefile tests/*/*.mk || { echo "make $t"; return 1; }
        bad=0
    done
    return $bad
}
check make_targets_exist targets
links() { # relative links lead somewhere
    local f bad=1
    for f in $(grep -oE '\]\([^)#:]+\)' README.md | tr -d ']()'); do
        [ -e "$f" ] || { echo "$f"; return 1; }
        bad=0
    done
    return $bad
}
check links_lead_to_files links

echo 1..$n
