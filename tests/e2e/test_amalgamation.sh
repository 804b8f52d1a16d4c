#!/usr/bin/env bash
# The library in two files: what it defines and asks for, and that its pictures are those of lut/ and raster/, on the host and on three
# emulated boards. `make boards-build` compiles it, with one command and no include path, for five targets.
B=${B:-build}
. tests/tap.sh
. tests/targets.sh
files=$B/amalgamation

echo 1..16
# Functions and constants that goniotile.h declares; loops in assembly cannot be hidden.
sed -nE '/^(static|typedef)/!s/^[a-z][a-z0-9_ ]*[ *]([a-z0-9_]+)\(.*/\1/p; s/^extern const .* ([a-z0-9_]+);$/\1/p' "$files/goniotile.h" | sort >"$work/declared"
for t in cortex-m0 cortex-m3 cortex-m7 rv32imac x86-64; do
    object=$files/$t.o nm=$(target_binutils $t)nm
    problems=$($nm -g --defined-only "$object" | awk '{ print $3 }' | grep -vE '^raster_.*_loop(_four|_one)?$' | sort | diff - "$work/declared" 2>&1)
    claim "only_what_the_header_declares_is_visible_on_$t" "$problems"
    problems=$({ $nm -u "$object" || echo no object; } | awk '{ print $NF }' | grep -vxE "$(target_allowed $t)")
    claim "undefined_symbols_are_on_the_list_on_$t" "$problems"
done

host_hash() { # program model
    local scene=$B/demo/six_models.blob
    [ "$2" = measured ] || scene=$B/board/six_models_lafortune.blob
    "$1" 320 240 rgb888 "$scene" "$B"/demo/{matte_white,plastic_red,gold,plastic_blue_rough,copper_satin,satin_green}.ktx2
}
declare -A picture # of lut/ and raster/
for model in measured lafortune_phong; do
    picture[$model]=$(host_hash "$B/board/host_hash-gcc-O2" $model)
done

embed() { # output compiler_options: a program that knows nothing but the header
    sed 's/"raster.h"/"goniotile.h"/' tests/board/host_hash.c >"$work/host_hash.c"
    ${CC:-cc} -std=gnu11 $2 -Wall -Wextra -Werror -I"$files" "$work/host_hash.c" "$files/goniotile.c" -o "$work/$1" 2>&1
}
for options in "-O1 -fsanitize=address,undefined -fno-sanitize-recover=all" "-O3 -march=native"; do
    problems=$(embed program "$options") &&
        for model in measured lafortune_phong; do
            got=$(host_hash "$work/program" $model 2>&1)
            [ -n "$got" ] && [ "$got" = "${picture[$model]}" ] || problems+="$model: $got, not ${picture[$model]}"$'\n'
        done
    claim "pictures_on_the_host_are_those_of_the_folders_with_${options%% *}" "$problems"
done
cat >"$work/twice.c" <<'C'
#include "goniotile.h"
#include "goniotile.h"
const char *version(void)
{
    return raster_status_text(RASTER_OK) ? GONIOTILE_VERSION : lut_status_text(LUT_OK);
}
C
claim the_header_stands_alone_and_may_be_included_twice \
    "$(${CC:-cc} -std=c11 -ffreestanding -Wall -Wextra -Werror -I"$files" -fsyntax-only "$work/twice.c" 2>&1)"

for t in cortex-m3 cortex-m7 rv32imac; do
    problems=
    for model in measured lafortune_phong; do
        line=$(tests/board/run.sh $t "$B/board/$t/amalgamated.elf" "$B/board/$model.img" 2>&1)
        [[ $line == "frame hash ${picture[$model]##* } "* ]] || problems+="$model: $line, not ${picture[$model]}"$'\n'
        echo "# $t $model: $line"
    done
    claim "pictures_are_those_of_the_folders_on_$t" "$problems"
done
