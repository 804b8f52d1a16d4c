#!/usr/bin/env bash
# Prints the size of code and constants per folder and target, in bytes, then of products. Nothing has data or bss (tests/cross.sh).
set -eu
cd "$(dirname "$0")/../.."
. tests/targets.sh
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

printf '%-12s %8s %8s %9s %11s %8s\n' target lut raster firmware lut+raster all
for t in $TARGETS; do
    for folder in lut raster firmware; do
        target_compile "$t" "$work/$t/$folder" "" $folder/*.c
        target_link "$t" "$work/$t/$folder.o" "$work/$t/$folder"/*.o
    done
    target_link "$t" "$work/$t/both.o" "$work/$t"/{lut,raster}.o
    target_link "$t" "$work/$t/all.o" "$work/$t"/{lut,raster,firmware}.o
    printf '%-12s' "$t"
    printf ' %8d %8d %9d %11d %8d\n' $(for part in lut raster firmware both all; do
        target_text_bytes "$t" "$work/$t/$part.o"
    done)
done
printf '\n'
tests/bench/products.sh | tr , ' ' | awk '{ printf "%-12s %-26s %8d\n", $2, $3, $6 }'
