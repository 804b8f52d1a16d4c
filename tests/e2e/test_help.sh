#!/usr/bin/env bash
# Every program and command explains itself: --help on stdout, with examples, which do what they say. They are run in one scratch
# folder, in the order in which the programs list their commands.
. tests/e2e/usb_common.sh

DATA=${GONIOTILE_DATA:-../shared/data}
[ ! -d "$DATA" ] || DATA=$(cd "$DATA" && pwd)

walk() { # command line: it and the commands below it
    local name
    echo "$1"
    for name in $($1 --help | awk '/^Commands:/ { on = 1; next } /^$/ { on = 0 } on { print $1 }'); do
        walk "$1 $name"
    done
}
examples() { # command line
    $1 --help | sed -n '/^Examples:/,/^$/s/^  \$ //p'
}

explain_themselves() {
    local c bad=0
    while read -r c; do
        $c --help >"$work/help" 2>"$work/help.err" </dev/null && [ ! -s "$work/help.err" ] &&
            head -1 "$work/help" | grep -q "^Usage: $c " && ! grep -q '.\{121\}' "$work/help" &&
            examples "$c" | grep -qE "^$c( |\$)" && ! examples "$c" | grep -v "^${c%% *} " || { echo "$c --help"; bad=1; }
    done
    return $bad
}
for program in gtlut gtscene gtusb gtsim; do
    walk $program
done >"$work/commands"
check every_program_and_command_explains_itself_with_examples explain_themselves <"$work/commands"

mkdir "$work/user" && ln -s "$PWD"/host_tools/scenes/*.json "$work/user"
if [ -d "$DATA" ]; then
    ln -s "$DATA/meshes" "$work/user/meshes"
    ln -s "$DATA/envmaps/studio_256.exr" "$work/user/studio.exr"
    ln -s "$DATA/brdf/cc_ibiza_sunset_rgb.bsdf" "$work/user/blue.bsdf"
    ln -s "$DATA/brdf/merl_sgd.csv" "$work/user/merl_sgd.csv"
fi
gtscene build host_tools/scenes/oled.json -o "$work/user/oled.blob"

lines() { # program: its examples that can run, once each. A window has nobody to close it, a sheet of sixty
    # materials takes half a minute.
    grep "^$1" "$work/commands" | while read -r c; do examples "$c"; done | awk '!seen[$0]++' | grep -vE '^gtsim window|sheet\.png' |
        if [ -d "$DATA" ]; then cat; else grep -vE 'blue\.|merl_sgd|meshes'; fi
}
cat >"$work/run.sh" <<'SH'
cd "$work/user" || exit
while read -r line; do
    bash -c "$line" </dev/null >"$work/out" 2>&1 || { echo "status $?: $line"; cat "$work/out"; exit 1; }
done
SH
run() { # program, at least so many examples, command to run them by
    lines "$1" >"$work/lines"
    [ "$(wc -l <"$work/lines")" -ge "$2" ] && "${@:3}" bash "$work/run.sh" <"$work/lines"
}
tables() { # into the slots that six_models names
    local t slot=0
    for t in matte_white plastic_red gold plastic_blue_rough copper_satin satin_green; do
        gtsim run --flash "$work/flash.bin" -- gtusb push "$DEMO/$t.ktx2" --slot $((slot++)) || return
    done
}
check examples_of_gtlut_run run gtlut 14
check examples_of_gtscene_run run gtscene 2
check the_tables_are_pushed tables
check examples_of_gtusb_run run gtusb 14 gtsim run --flash "$work/flash.bin" --
check examples_of_gtsim_run run gtsim 4

echo 1..$n
