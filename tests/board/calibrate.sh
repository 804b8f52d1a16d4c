#!/usr/bin/env bash
# Measures what the steps of a tile take on an emulated board and fits the table of costs to it (tests/board/calibrate/main.c,
# tests/bench/calibrate.c). Needs the programs, the demo's scene and tables: make calibrate.
#   tests/board/calibrate.sh TARGET OUT.h
set -eu
cd "$(dirname "$0")/../.."
B=${B:-build}
target=$1 out=$2
input=$B/board/$target/calibrate.bin
parts=("$B/demo/six_models.blob" "$B/demo/gold.ktx2" "$B/board/gold_91x46.ktx2")
# Four bytes, the lowest first.
little() { printf "$(printf '\\x%02x\\x%02x\\x%02x\\x%02x' $(($1 & 255)) $(($1 >> 8 & 255)) $(($1 >> 16 & 255)) $(($1 >> 24)))"; }
for part in "${parts[@]}"; do little "$(stat -Lc %s "$part")"; done >"$input.new"
for part in "${parts[@]}"; do
    truncate -s %16 "$input.new"
    cat "$part" >>"$input.new"
done
mv "$input.new" "$input"
mkdir -p "$(dirname "$out")"
LIMIT=600 tests/board/run.sh "$target" "$B/board/$target/calibrate.elf" "$input" >"$B/board/$target/calibrate.txt"
"$B/bench/calibrate" "$target" "$B/board/$target/calibrate.txt" >"$out.new"
clang-format-14 -i --style=file "$out.new" 2>/dev/null || true
mv "$out.new" "$out"
